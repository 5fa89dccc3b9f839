//! An effect as an operator of the coefficients file, read off the root of its expression: a product of columns, a lag, a
//! play, a bump, … What has no such form is handed on as an expression.

use fitter::terms::{
    Exponential, Factor, Gaussian, Hinge, Lag, Operator, Periodic, Play, Product, Rate, Side, Step,
};
use physics::{Columns, Formula, Node};

use super::read::Read;
use super::{Effect, Handed};
use crate::rows::Rows;

/// One form of an effect at a shape in a recording.
pub struct Terms<'a> {
    effect: &'a Effect,
    form: &'a Formula,
    rows: &'a Rows,
    shape: &'a [f64],
    /// Values of the form's own parameters, the factors being 1 and what is added up the first.
    values: Vec<f64>,
}

/// slope·column + offset.
#[derive(Clone, Copy)]
struct Line<'a> {
    column: &'a str,
    slope: f64,
    offset: f64,
}

impl Line<'_> {
    /// Where it is zero.
    fn at_zero(self) -> f64 {
        // No −0, which would stand in the file.
        0.0 - self.offset / self.slope
    }
}

/// A sine or cosine of the true angle: `size` times it, of slope·Θ + offset.
struct Wave {
    factor: usize,
    sine: bool,
    size: f64,
    slope: f64,
    offset: f64,
}

/// An operator with its arguments, each with the factor that brings it to the unit that is needed.
fn parts(node: &Node) -> Option<(&str, &[(Node, f64)])> {
    match node {
        Node::Apply(physics::Applied { operator, arguments, .. }) => Some((operator.name(), arguments)),
        _ => None,
    }
}

/// Whether its value differs from row to row.
fn reads_rows(node: &Node) -> bool {
    match node {
        Node::Column(_) => true,
        Node::Apply(physics::Applied { operator, arguments, .. }) => {
            !operator.of_recording() && arguments.iter().any(|(argument, _)| reads_rows(argument))
        }
        _ => false,
    }
}

impl<'a> Terms<'a> {
    /// A form of an effect at a shape in a recording.
    pub fn of(effect: &'a Effect, form: &'a Formula, rows: &'a Rows, shape: &'a [f64]) -> Terms<'a> {
        let factors = vec![1.0; effect.made.factors.len()];
        let values = form.own(&effect.numbered(effect.values(rows, shape, &factors), 1));
        Terms { effect, form, rows, shape, values }
    }

    /// The operator; none where it has no such form.
    pub fn read(&self) -> Option<Handed> {
        let root = &self.form.sentence.root;
        if self.effect.made.factors.len() > 1 || self.effect.of_true_angle() {
            return self.periodic(root);
        }
        let mut scale = 1.0;
        let mut factors = Vec::new();
        self.factors(root, &mut scale, &mut factors)?;
        let lines: Option<Vec<(Line, u8)>> =
            factors.iter().map(|(node, power)| Some((self.line(node)?, *power))).collect();
        match (lines, &factors[..]) {
            (Some(lines), [_, ..]) => {
                let factor = |(line, power): &(Line, u8)| Factor {
                    observable: self.observable(line.column),
                    mean: line.at_zero(),
                    power: *power,
                };
                let slopes = lines.iter().map(|(line, power)| line.slope.powi(i32::from(*power)));
                let product = Product { factors: lines.iter().map(factor).collect() };
                Some(scaled(Operator::Product(product), scale * slopes.product::<f64>()))
            }
            (None, [(node, 1)]) => {
                let (operator, own) = self.shape(node)?;
                let own = scale * own;
                match operator {
                    // A mean of plays is a sum of them, each with its part of the coefficient.
                    Operator::Play(play) => {
                        let part = own / play.elements.len() as f64;
                        let map = vec![vec![part]; play.elements.len()];
                        Some(Handed { operator: Operator::Play(play), map })
                    }
                    operator => Some(scaled(operator, own)),
                }
            }
            _ => None,
        }
    }

    /// A value that is the same at every row.
    fn number(&self, node: &Node) -> Option<f64> {
        if reads_rows(node) {
            return None;
        }
        Some(node.value(&Read(self.rows), &self.values, false).ok()?.at(0))
    }

    /// The value of an argument that is the same at every row, in the unit that its operator needs.
    fn argument(&self, (node, factor): &(Node, f64)) -> Option<f64> {
        Some(self.number(node)? * factor)
    }

    fn line_of(&self, (node, factor): &'a (Node, f64)) -> Option<Line<'a>> {
        let Line { column, slope, offset } = self.line(node)?;
        Some(Line { column, slope: slope * factor, offset: offset * factor })
    }

    fn line(&self, node: &'a Node) -> Option<Line<'a>> {
        if let Node::Column(column) = node {
            return Some(Line { column, slope: 1.0, offset: 0.0 });
        }
        let (operator, arguments) = parts(node)?;
        let times =
            |line: Line<'a>, by: f64| Line { slope: line.slope * by, offset: line.offset * by, ..line };
        let plus = |line: Line<'a>, by: f64| Line { offset: line.offset + by, ..line };
        match (operator, arguments) {
            ("-", [a]) => Some(times(self.line_of(a)?, -1.0)),
            ("+" | "-", [a, b]) => {
                let sign = if operator == "-" { -1.0 } else { 1.0 };
                match (self.argument(a), self.argument(b)) {
                    (None, Some(b)) => Some(plus(self.line_of(a)?, sign * b)),
                    (Some(a), None) => Some(plus(times(self.line_of(b)?, sign), a)),
                    _ => None,
                }
            }
            ("*", [a, b]) => match (self.argument(a), self.argument(b)) {
                (None, Some(b)) => Some(times(self.line_of(a)?, b)),
                (Some(a), None) => Some(times(self.line_of(b)?, a)),
                _ => None,
            },
            ("/", [a, b]) => Some(times(self.line_of(a)?, 1.0 / self.argument(b)?)),
            _ => None,
        }
        .filter(|line| line.slope != 0.0)
    }

    /// What a product is made of: numbers, multiplied, and what differs from row to row, with its power.
    fn factors(&self, node: &'a Node, scale: &mut f64, found: &mut Vec<(&'a Node, u8)>) -> Option<()> {
        if let Some(number) = self.number(node) {
            *scale *= number;
            return Some(());
        }
        match (self.line(node), parts(node)) {
            (None, Some(("*", [a, b]))) => {
                *scale *= a.1 * b.1;
                self.factors(&a.0, scale, found)?;
                self.factors(&b.0, scale, found)?;
            }
            (None, Some(("/", [a, b]))) => {
                *scale *= a.1 / self.argument(b)?;
                self.factors(&a.0, scale, found)?;
            }
            (None, Some(("-", [a]))) => {
                *scale *= -a.1;
                self.factors(&a.0, scale, found)?;
            }
            (None, Some(("^", [a, b]))) if self.line(&a.0).is_some() => {
                let power =
                    self.argument(b).filter(|power| power.fract() == 0.0 && (1.0..=9.0).contains(power))?;
                *scale *= a.1.powf(power);
                found.push((&a.0, power as u8));
            }
            _ => found.push((node, 1)),
        }
        Some(())
    }

    /// What is no product, with the factor of its coefficient.
    fn shape(&self, node: &'a Node) -> Option<(Operator, f64)> {
        let (operator, arguments) = parts(node)?;
        match (operator, arguments) {
            ("rate", [a]) => {
                let line = self.line_of(a)?;
                Some((Operator::Rate(Rate::of(&self.observable(line.column))), line.slope))
            }
            ("lowpass", _) => self.lag(arguments, 0.0),
            ("hinge", [a, b]) => self.hinge(self.line_of(a)?, self.argument(b)?, 1.0),
            ("max" | "min", [a, b]) => {
                let line = self.line_of(a).or_else(|| self.line_of(b))?;
                let other = self.argument(a).or_else(|| self.argument(b)).filter(|other| *other == 0.0)?;
                self.hinge(line, other, if operator == "max" { 1.0 } else { -1.0 })
            }
            ("bump", [a, centre, width]) => {
                let Line { column, slope, offset } = self.line_of(a)?;
                let (centre, width) = (self.argument(centre)?, self.argument(width)?.abs());
                let (centre, width) = ((centre - offset) / slope, width / slope.abs());
                Some((Operator::Gaussian(Gaussian::of(&self.observable(column), centre, width)), 1.0))
            }
            ("step", [a, at]) => {
                let Line { column, slope, offset } = self.line_of(a).filter(|line| line.slope > 0.0)?;
                let at = (self.argument(at)? - offset) / slope;
                Some((Operator::Step(Step { observable: self.observable(column), at }), 1.0))
            }
            ("-", [a, b]) => match (parts(&a.0), parts(&b.0)) {
                (Some(("lowpass", of)), _) if a.1 == 1.0 => self.lag(of, self.argument(b)?),
                (_, Some(("exp", of))) if self.argument(a)? == b.1 => {
                    self.exponential(self.line_of(&of[0])?, b.1)
                }
                (_, Some(("play", of))) => self.play(self.line_of(a)?, of, 1, b.1),
                (_, Some(("plays", of))) => self.play(self.line_of(a)?, of, physics::ELEMENTS, b.1),
                _ => None,
            },
            _ => None,
        }
    }

    /// `sign`·max(0, sign·(line − at)).
    fn hinge(&self, line: Line, at: f64, sign: f64) -> Option<(Operator, f64)> {
        let side = if sign * line.slope > 0.0 { Side::Above } else { Side::Below };
        let threshold = (at - line.offset) / line.slope;
        let hinge = Hinge::of(&self.observable(line.column), threshold, side);
        Some((Operator::Hinge(hinge), sign * line.slope.abs()))
    }

    /// A column as it stands in the recording.
    fn plain(&self, of: &'a (Node, f64)) -> Option<&'a str> {
        self.line_of(of).filter(|line| line.slope == 1.0 && line.offset == 0.0).map(|line| line.column)
    }

    /// The state before the first row, where it is not the first value.
    fn initial(&self, column: &str, start: Option<&(Node, f64)>) -> Option<Option<f64>> {
        let Some(start) = start else { return Some(None) };
        let start = self.argument(start)?;
        let first = *Read(self.rows).column(column)?.first()?;
        Some((start != first).then_some(start))
    }

    fn lag(&self, of: &'a [(Node, f64)], mean: f64) -> Option<(Operator, f64)> {
        let column = self.plain(&of[0])?;
        let initial = self.initial(column, of.get(2))?;
        let lag = Lag { initial, ..Lag::of(&self.observable(column), self.argument(&of[1])?, mean) };
        Some((Operator::Lag(lag), 1.0))
    }

    /// `size`·(1 − exp(line)), which is nothing where the column begins and is never below it.
    fn exponential(&self, line: Line, size: f64) -> Option<(Operator, f64)> {
        let (start, scale) = (line.at_zero(), -1.0 / line.slope);
        let begins = Read(self.rows).column(line.column)?.iter().all(|value| *value >= start);
        let exponential = Exponential { observable: self.observable(line.column), start, scale };
        (scale > 0.0 && begins).then_some((Operator::Exponential(exponential), size))
    }

    /// line − `factor`·play of the same, of `usual` elements unless it says otherwise.
    fn play(&self, line: Line, of: &'a [(Node, f64)], usual: usize, factor: f64) -> Option<(Operator, f64)> {
        let column = self.plain(&of[0]).filter(|column| *column == line.column)?;
        if line.slope != factor || line.offset != 0.0 {
            return None;
        }
        let count = of.get(3).map_or(Some(usual), |count| Some(self.argument(count)? as usize))?;
        let gap = self.argument(&of[1])?;
        let gaps: Vec<f64> = (1..=count).map(|k| gap * k as f64 / count as f64).collect();
        let mut play = Play::of(&self.observable(column), &gaps);
        let initial = self.initial(column, of.get(2))?;
        play.elements.iter_mut().for_each(|element| element.initial = initial);
        Some((Operator::Play(play), factor))
    }

    /// a·sin(e) + b·cos(e), e in proportion to the true angle and to the number of the harmonic.
    fn periodic(&self, root: &'a Node) -> Option<Handed> {
        let ("+", [first, second]) = parts(root)? else { return None };
        let waves = [self.wave(first)?, self.wave(second)?];
        let [a, b] = &waves;
        if a.slope != b.slope || a.offset != b.offset || a.factor == b.factor || a.sine == b.sine {
            return None;
        }
        let count = self.effect.count(self.shape);
        let period = std::f64::consts::TAU / a.slope;
        let mut map = vec![vec![0.0; 2 * count]; 2 * count];
        for harmonic in 0..count {
            let (sine, cosine) = ((harmonic + 1) as f64 * a.offset).sin_cos();
            for wave in &waves {
                // sin(x + φ) = sin φ cos x + cos φ sin x, cos(x + φ) = cos φ cos x − sin φ sin x
                let (of_cosine, of_sine) = if wave.sine { (sine, cosine) } else { (cosine, -sine) };
                map[2 * harmonic][2 * harmonic + wave.factor] = wave.size * of_cosine;
                map[2 * harmonic + 1][2 * harmonic + wave.factor] = wave.size * of_sine;
            }
        }
        Some(Handed { operator: Operator::Periodic(Periodic::of(period, count as u16)), map })
    }

    fn wave(&self, (node, factor): &'a (Node, f64)) -> Option<Wave> {
        let mut size = *factor;
        let mut found = Vec::new();
        self.factors(node, &mut size, &mut found)?;
        let [(wave, 1)] = found[..] else { return None };
        let (operator, [of]) = parts(wave)? else { return None };
        let sine = match operator {
            "sin" => true,
            "cos" => false,
            _ => return None,
        };
        let Line { slope, offset, .. } = self.line_of(of).filter(|line| line.column == "true_angle")?;
        let is_factor = |k: &usize| mentions(node, self.form.of.iter().position(|own| own == k));
        let factor = self.effect.made.factors.iter().position(is_factor)?;
        Some(Wave { factor, sine, size, slope, offset })
    }

    /// The name under which the terms know a column.
    fn observable(&self, column: &str) -> String {
        let name = match column {
            "angle" if self.rows.pair => "angle_arcsec",
            "angle" => "measured",
            "common_mode" => "common_mode_um",
            column => column,
        };
        name.to_string()
    }
}

/// Whether a parameter is in it.
fn mentions(node: &Node, parameter: Option<usize>) -> bool {
    match node {
        Node::Parameter(index) => Some(*index) == parameter,
        Node::Apply(physics::Applied { arguments, .. }) => {
            arguments.iter().any(|(argument, _)| mentions(argument, parameter))
        }
        _ => false,
    }
}

/// One column, one coefficient, `factor` times the amplitude.
fn scaled(operator: Operator, factor: f64) -> Handed {
    Handed { operator, map: vec![vec![factor]] }
}
