//! The choice for a core: the cheapest routine that is proven within the bound and fits the flash.

use fitter::coefficients::Coefficients;

use crate::cost::Core;
use crate::explore::{self, ChoiceError};
use crate::format::Format;
use crate::options::{Ends, Options};
use crate::quantity::Quantity;
use crate::routine::RoutineError;

/// All formats that both languages have.
pub const FORMATS: [Format; 4] = [Format::Q31, Format::Q31Split, Format::Q15, Format::F32 { fused: false }];

/// What a routine is chosen for.
#[derive(Debug, Clone, Copy)]
pub struct Wanted<'a> {
    /// Core whose instructions count.
    pub core: Core,
    /// Formats to choose from; empty: [`FORMATS`].
    pub formats: &'a [Format],
    /// Input and output as far as the user named them.
    pub ends: Ends,
    /// Bytes of flash, code and table together.
    pub flash_bytes: Option<usize>,
}

/// Why nothing was chosen.
#[derive(Debug, thiserror::Error)]
pub enum ChooseError {
    /// No candidate could be designed at all.
    #[error(transparent)]
    Routine(#[from] RoutineError),
    /// None of them is good or small enough.
    #[error(transparent)]
    Choice(#[from] ChoiceError),
}

/// Puts the chosen routine and its degree into `options`; `done` is told how many candidates of how many are
/// through.
///
/// # Errors
/// [`ChooseError`], which names the nearest that can be had.
pub fn choose(
    coefficients: &Coefficients,
    options: &mut Options,
    wanted: &Wanted,
    done: &(dyn Fn(usize, usize) + Sync),
) -> Result<(), ChooseError> {
    let quantity = Quantity::of(&coefficients.error_model());
    let range = options.range.unwrap_or((coefficients.valid_range.from, coefficients.valid_range.to));
    let bound =
        options.bound.unwrap_or_else(|| quantity.default_bound(range.0, range.1, coefficients.noise()));
    let formats = if wanted.formats.is_empty() { &FORMATS } else { wanted.formats };
    let candidates = explore::candidates(coefficients, options, wanted.ends, formats, f64::MAX, done)?;
    let best = explore::cheapest(&candidates, wanted.core, bound, wanted.flash_bytes, &quantity.bound_unit)?;
    options.degree = Some(best.routine.design.degree);
    options.routines = vec![best.options.clone()];
    Ok(())
}
