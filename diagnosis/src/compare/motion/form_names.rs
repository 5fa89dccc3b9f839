//! Forms without a name are numbered in each recording by itself. Compared, they need one name for both.

use crate::dynamic::diagnose::Identified;

/// See the module.
pub struct FormNames {
    /// Of each recording the ids of its forms and the names that they have there, in the order of their numbers.
    own: [Vec<(String, String)>; 2],
}

impl FormNames {
    /// Of the earlier and the later recording.
    pub fn of(then: &Identified, now: &Identified) -> FormNames {
        let names = |identified: &Identified| match identified {
            Identified::Equations(identified) => identified.names.clone(),
            _ => Vec::new(),
        };
        FormNames { own: [names(then), names(now)] }
    }

    /// The name that an effect has in a recording.
    pub fn within<'a>(&'a self, recording: usize, id: &'a str) -> &'a str {
        self.own[recording].iter().find(|(own, _)| own == id).map_or(id, |(_, name)| name)
    }

    /// The one that it has for both: that of the earlier recording, or a number after all of these.
    pub fn for_both(&self, id: &str) -> String {
        let [then, now] = &self.own;
        if then.iter().any(|(own, _)| own == id) {
            return self.within(0, id).into();
        }
        let new = now.iter().filter(|(own, _)| then.iter().all(|(other, _)| other != own));
        match new.map(|(own, _)| own).position(|own| own == id) {
            Some(k) => format!("empirical_{}", then.len() + k + 1),
            None => id.into(),
        }
    }
}
