//! Effects that a recording cannot distinguish are alternatives of one another also where one of them changed.

use crate::verdict::{EMPIRICAL, NamedEffect};

use super::Change;

/// Adds to the alternatives of every change the effects that every recording which names it lists as its alternatives. What is
/// named or changed itself is none. Forms are left out: each recording numbers its own.
pub fn add_alternatives(changes: &mut [Change], effects: [&[NamedEffect]; 2]) {
    let changed: Vec<String> = changes.iter().map(|change| change.id.clone()).collect();
    let is_named = |id: &String| changed.contains(id) || effects.concat().iter().any(|known| known.id == *id);
    for change in changes {
        let of_change = |known: &&NamedEffect| known.id == change.id && known.kind != EMPIRICAL;
        let lists: Vec<&NamedEffect> = effects.iter().flat_map(|all| all.iter().find(of_change)).collect();
        let Some(first) = lists.first() else { continue };
        let in_all = |id: &&String| lists.iter().all(|known| known.alternatives.contains(id));
        let known = &change.alternatives;
        let new = first.alternatives.iter().filter(in_all).filter(|id| !is_named(id) && !known.contains(id));
        let new: Vec<String> = new.cloned().collect();
        change.alternatives.extend(new);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::Kind;
    use crate::verdict::Form;

    fn effect(id: &str, alternatives: &[&str]) -> NamedEffect {
        let alternatives = alternatives.iter().map(|id| (*id).into()).collect();
        NamedEffect {
            id: id.into(),
            kind: "catalogued",
            title: id.into(),
            formula: String::new(),
            p_value: 0.0,
            share: 1.0,
            parameters: Vec::new(),
            alternatives,
            runtime_correctable: true,
            form: Form::default(),
        }
    }

    #[test]
    fn what_no_recording_tells_from_an_effect_is_an_alternative_of_its_change() {
        let alternatives = |then: &[NamedEffect], now: &[NamedEffect]| {
            let lag = Change {
                id: "drive_lag".into(),
                title: "a lag".into(),
                kind: Kind::Came,
                place: None,
                p_value: 0.0,
                rms: None,
                parameters: Vec::new(),
                alternatives: vec!["gain".into()],
                held_out: None,
            };
            let mut changes = [lag];
            add_alternatives(&mut changes, [then, now]);
            changes[0].alternatives.clone()
        };
        let lag = |alternatives: &[&str]| effect("drive_lag", alternatives);
        let now = [lag(&["transport_delay", "sensor_lag"])];
        assert_eq!(alternatives(&[], &now), ["gain", "transport_delay", "sensor_lag"]);
        assert_eq!(alternatives(&[lag(&["sensor_lag"])], &now), ["gain", "sensor_lag"]);
        assert_eq!(alternatives(&[effect("sensor_lag", &[])], &now), ["gain", "transport_delay"]);
        assert_eq!(alternatives(&[], &[]), ["gain"]);
    }
}
