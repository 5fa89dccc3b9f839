//! Whether the residual depends on something else that was recorded.

use crate::basis::Basis;
use crate::fit::Calibrated;
use crate::mirror::Mirror;
use crate::recording::Recording;

/// A column that the residual depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct Dependence {
    /// The column's name.
    pub variable: String,
    /// Probability of so strong a dependence by chance, corrected for the number of columns (Holm).
    pub p_value: f64,
}

pub(crate) fn of_residual(
    _recording: &Recording,
    _calibrated: &Calibrated,
    _residual: &[f64],
    _basis: &Basis,
    _order: usize,
    _mirror: &Mirror,
) -> Vec<Dependence> {
    Vec::new()
}

/// The line that points to `diagnose`, if there is something to point to.
pub fn pointer(dependences: &[Dependence], file: &str) -> Option<String> {
    if dependences.is_empty() {
        return None;
    }
    let list: Vec<String> =
        dependences.iter().map(|found| format!("{} (p = {:.1e})", found.variable, found.p_value)).collect();
    Some(format!("the residual depends on {}: run `diagnose {file}` to find out why", list.join(", ")))
}
