//! What is subtracted, in words for the head of a file.

use fitter::terms::{Operator, Term};

use super::Physics;
use super::selection::by_time;

impl Physics {
    /// What is subtracted, term by term, for the head of a file.
    pub fn terms_in_words(&self) -> Vec<String> {
        let factor = |f: &fitter::terms::Factor| {
            let power = if f.power > 1 { format!("^{}", f.power) } else { String::new() };
            if f.mean == 0.0 {
                format!("{}{power}", f.observable)
            } else {
                format!("({} − {:?}){power}", f.observable, f.mean)
            }
        };
        let in_words = |term: &Term| match &term.operator {
            Operator::Product(p) => {
                let factors: Vec<String> = p.factors.iter().map(factor).collect();
                format!("{}: {:?}·{}", term.effect, term.coefficients[0], factors.join("·"))
            }
            Operator::Play(p) => {
                let elements: Vec<String> = (p.elements.iter().zip(&term.coefficients))
                    .map(|(e, w)| format!("{w:?}·(v − play of half-width {:?})", e.half_width))
                    .collect();
                format!("{}: v = {}; {}", term.effect, p.observable, elements.join(" + "))
            }
            Operator::Periodic(p) => format!(
                "{}: {} harmonics of period {:?} of the corrected result itself",
                term.effect,
                p.harmonics.len(),
                p.period
            ),
            Operator::Lag(l) => format!(
                "{}: {:?}·({} lagged by {:?} s − {:?}), a call every {:?} s",
                term.effect, term.coefficients[0], l.observable, l.time_constant_s, l.mean, self.period_s
            ),
            Operator::Rate(r) => format!(
                "{}: {:?}·d({})/dt by the difference to the call before, {:?} s ago; 0 at the first call",
                term.effect, term.coefficients[0], r.observable, self.period_s
            ),
            Operator::Hinge(h) => format!(
                "{}: {:?}·how far {} is {} {:?}",
                term.effect,
                term.coefficients[0],
                h.observable,
                if h.side == fitter::terms::Side::Above { "above" } else { "below" },
                h.threshold
            ),
            Operator::Expression(expression) => {
                let factors = expression.factors.iter().zip(&term.coefficients);
                let factors = factors.map(|(factor, c)| format!(", {} = {c:?} {}", factor.name, factor.unit));
                let fixed = expression.parameters.iter();
                let fixed = fixed.map(|fixed| format!(", {} = {:?} {}", fixed.name, fixed.value, fixed.unit));
                let calls = match self.tree(term).is_some_and(|tree| tree.remembers()) {
                    true => format!(", a call every {:?} s", self.period_s),
                    false => String::new(),
                };
                let stated: String = factors.chain(fixed).chain([calls]).collect();
                format!("{}: {}{stated}", term.effect, expression.text)
            }
            Operator::Gaussian(g) => format!(
                "{}: {:?}·exp(−z²/2), z = ({} − {:?})/{:?}",
                term.effect, term.coefficients[0], g.observable, g.centre, g.width
            ),
            Operator::Exponential(e) => {
                let since = match by_time(e, &self.further) {
                    true => format!("time since the start, a call every {:?} s", self.period_s),
                    false => format!("{} − {:?}, 0 below", e.observable, e.start),
                };
                let weight = term.coefficients[0];
                format!("{}: {weight:?}·(1 − exp(−v/{:?})), v = {since}", term.effect, e.scale)
            }
            Operator::Step(s) => {
                format!("{}: {:?} from {} = {:?} on", term.effect, term.coefficients[0], s.observable, s.at)
            }
        };
        self.terms.iter().map(in_words).collect()
    }
}
