//! What happened at one time of one recording: it belongs to that recording, and is no change of the device.

use numerics::Basis;

use crate::calibrate::log_tail;
use crate::diagnosis::Outcome;
use crate::noise::Noise;
use crate::thresholds::compare::{FALSE_ALARMS, MAY_BE_AN_EVENT};

use super::design::explained_by;
use super::joined::Joined;
use super::shared::Shared;

/// The columns of an event over its recording's rows, in the recording's unit.
pub type Event = Vec<Vec<f64>>;

/// What happened at one time in a recording, or may have, where it is not shared with the other one.
pub fn of(outcome: &Outcome, shared: &[Shared]) -> Vec<Event> {
    let once = outcome.found.iter().filter_map(|term| {
        let effect = term.effect.as_ref()?;
        let is_shared = || shared.iter().any(|s| s.effect.as_ref().is_some_and(|e| e.id == effect.id));
        let once = effect.of_one_time || term.reach < MAY_BE_AN_EVENT && !is_shared();
        once.then(|| effect.signature(&outcome.rows, &term.shape))
    });
    once.collect()
}

/// The events that a recording shows beside its common model (columns over its rows): effects of the other recording may explain
/// them as well.
pub fn needed(events: &[Event], noise: &Noise, model: &[Vec<f64>]) -> Vec<Event> {
    let whitener = noise.whitener();
    let mut basis = Basis::new(noise.clean.len());
    for column in model {
        basis.add(&whitener.whiten(column));
    }
    let mut left = whitener.whiten(&noise.clean);
    basis.project_off(&mut left);
    let is_needed = |event: &&Event| {
        let columns = event.iter().map(|column| whitener.whiten(column));
        let (explained, freedom) = explained_by(&mut basis, columns, &left);
        (-log_tail(explained, freedom)).exp() <= FALSE_ALARMS
    };
    events.iter().filter(is_needed).cloned().collect()
}

/// What each recording has for itself over its rows: an offset, and its events.
pub fn own(both: &Joined, events: &[Vec<Event>; 2]) -> [Vec<Vec<f64>>; 2] {
    let rows = [both.split, both.rows.len() - both.split];
    [0, 1].map(|r| std::iter::once(vec![1.0; rows[r]]).chain(events[r].iter().flatten().cloned()).collect())
}
