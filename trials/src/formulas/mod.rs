//! The published table of effects as formulas on what a recording holds, and the simple best fit by them:
//! what a model achieves that knows the effects, and whether another effect could pass for the one that was
//! concealed. Neither the physics of `twin` nor the signatures of `diagnosis` are used here.

mod best;
mod columns;
mod table;

pub use best::{SEVERAL, Search, Shaped};
pub use columns::Columns;
pub use table::{FORMULAS, Formula, find};
