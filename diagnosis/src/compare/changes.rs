//! What is said of the parts that differ, and of how small a difference would have been seen.

use numerics::{centred, rms};

use crate::intervals::widening;
use crate::noise::Noise;
use crate::rows::Rows;
use crate::thresholds::calibrate::HALF_SEEN;
use crate::thresholds::compare::{FALSE_ALARMS, POWER, PRESENT};
use crate::verdict::locate;

use super::choose::{Chosen, noise_ratio, visible};
use super::design::{Design, Fitted, What, White};
use super::quantity::{add_shapes, presence, quantities, smallest};
use super::{Change, HeldOut, Kind, Quantity, Visible};

/// A fitted model in which parts differ.
pub struct Differences<'a> {
    /// The model.
    pub design: &'a Design<'a>,
    /// Its fit, with the parts differing.
    pub fitted: &'a Fitted,
    /// The later recording.
    pub now: &'a Rows,
    /// Degrees of freedom of the noise.
    pub freedom: f64,
    /// How many differences were tested.
    pub tests: usize,
}

impl Differences<'_> {
    /// The changes, one of every effect, the strongest first.
    pub fn changes(&self, chosen: Vec<Chosen>) -> Vec<Change> {
        let mut changes: Vec<Change> = Vec::new();
        let mut taken: Vec<What> = Vec::new();
        for c in chosen {
            if !taken.iter().any(|what| what.belongs_to(c.what)) {
                taken.push(c.what);
                changes.push(self.change(c));
            }
        }
        changes.sort_by(|a, b| b.rms.unwrap_or(0.0).total_cmp(&a.rms.unwrap_or(0.0)));
        changes
    }

    fn change(&self, Chosen { what, p_value, alternatives, proof }: Chosen) -> Change {
        let (design, id) = (self.design, self.design.id(what));
        let mut difference = vec![0.0; design.both.rows.len()];
        for part in self.fitted.changed.iter().filter(|part| design.parts[**part].what.belongs_to(what)) {
            let more = self.fitted.difference(design, *part);
            difference.iter_mut().zip(more).for_each(|(d, m)| *d += m);
        }
        if let Some(k) = what.effect() {
            add_shapes(design, self.fitted, k, &mut difference);
        }
        let later = difference.split_off(design.both.split);
        let mut others: Vec<String> = alternatives.iter().map(|other| design.id(*other)).collect();
        others.dedup();
        others.retain(|other| *other != id);
        Change {
            kind: self.kind(what),
            title: design.title(what),
            place: Some(locate(self.now, &design.place(what), &later, 1.0, p_value)),
            p_value,
            rms: Some(rms(&centred(&later))),
            parameters: quantities(design, self.fitted, what, widening(self.freedom)),
            alternatives: others,
            held_out: proof.map(|p| HeldOut { same: p.without, changed: p.with, gain: p.gain }),
            id,
        }
    }

    /// Whether an effect came, went, or moved: by whether each recording has it. Of what they show together the difference alone
    /// is known: the base takes up how much of it each has.
    pub fn kind(&self, what: What) -> Kind {
        let Some(k) = what.effect() else { return Kind::Base };
        if self.design.shared[k].together.is_some() {
            return Kind::Moved;
        }
        let Some(part) = self.design.part(What::Amplitude(k)) else { return Kind::Moved };
        let present = |recording: usize| {
            self.design.shared[k].found[recording].is_some()
                || presence(self.design, self.fitted, part, recording) < PRESENT
        };
        match (present(0), present(1)) {
            (false, _) => Kind::Came,
            (true, false) => Kind::Went,
            (true, true) => Kind::Moved,
        }
    }

    /// How large a change of each part would have been seen, and how strong a new effect. `level` is the noise of a row of the
    /// later recording.
    pub fn would_have_seen(&self, white: &White, level: f64) -> Vec<Visible> {
        let parts = (0..self.design.parts.len()).filter_map(|part| {
            let what = self.design.parts[part].what;
            let wanted = !matches!(what, What::Shape(..));
            let (rms, parameter) = wanted.then(|| {
                smallest(self.design, self.fitted, white, part, |rank| visible(rank, self.tests))
            })??;
            Some(Visible { id: self.design.id(what), rms: Some(rms), parameter })
        });
        let new = (HALF_SEEN + POWER) * level / (self.now.len() as f64).sqrt();
        let new = Visible { id: "new effect".into(), rms: Some(new), parameter: None };
        parts.chain([new]).collect()
    }
}

/// A change of the noise, where there is one.
pub fn noise_change(noise: &[Noise; 2], tests: usize) -> Option<Change> {
    let (ratio, ci95, p) = noise_ratio(noise);
    let p_value = (tests as f64 * p).min(1.0);
    (p_value <= FALSE_ALARMS).then(|| Change {
        id: "noise".into(),
        title: if ratio > 1.0 { "more noise".into() } else { "less noise".into() },
        kind: Kind::Noise,
        place: None,
        p_value,
        rms: None,
        parameters: vec![Quantity::ratio("noise now / then", ratio, ci95)],
        alternatives: Vec::new(),
        held_out: None,
    })
}
