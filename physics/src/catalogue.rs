//! The effects of calibrations that are known: a file of declarations, of which `diagnosis` makes its catalogue.

use crate::declaration::File;

/// The file, in the format that [`crate::declared`] reads.
pub const CATALOGUE: &str = include_str!("catalogue.toml");

/// The id of the effect that a fit of a whole turn finds under this name: `harmonics`, `slope` or `lag`.
///
/// # Example
/// ```
/// assert_eq!(physics::found_by_fit("lag"), "read_lag");
/// ```
///
/// # Panics
/// No effect of the catalogue is found under that name.
pub fn found_by_fit(name: &str) -> String {
    let read = toml::from_str::<File>(CATALOGUE).map_or_else(|_| Vec::new(), |file| file.effect);
    let found = read.into_iter().find(|effect| effect.known.found_by_fit.as_deref() == Some(name));
    found.unwrap_or_else(|| unreachable!("the catalogue has no effect found as `{name}`")).id
}
