//! How the order was chosen, as the file says it.

use serde::{Deserialize, Serialize};

/// Errors of one candidate order, in the unit of the errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrderScore {
    /// The order n.
    pub order: usize,
    /// J_training of Eq. 9, root mean square over the splits.
    pub training: f64,
    /// J_testing of Eq. 10, root mean square over the splits.
    pub testing: f64,
    /// Mean squared testing error less that of the best order, and its standard error, in the squared unit.
    pub excess: f64,
    /// See `excess`.
    pub excess_standard_error: f64,
    /// Testing error with one pass held out at a time; none with a single pass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub leave_one_pass_out: Option<f64>,
}

/// How the order was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrderSelection {
    /// The order that was chosen.
    pub chosen: usize,
    /// The rule of [`crate::order`] by its name, or `given` where the user gave it.
    pub rule: String,
    /// The order with the smallest testing error.
    pub smallest_testing_error: usize,
    /// What was held out together: `commanded angle`, `angle, by reading`, `contiguous block`.
    pub held_out_by: String,
    /// Number of such groups, and how many of them each split holds out.
    pub groups: usize,
    /// See `groups`.
    pub held_out_groups: usize,
    /// Number of splits.
    pub splits: usize,
    /// Seed of the splits.
    pub seed: u64,
    /// Unit of the errors in `curve`.
    pub unit: String,
    /// Both curves of the paper's Figure 6, one entry per order that the recording determines.
    pub curve: Vec<OrderScore>,
}
