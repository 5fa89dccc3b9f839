//! The choice: the fewest instructions on the core, by the estimate of [`crate::cost`], of what is proved within the
//! bound and fits the flash.

use fitter::coefficients::Coefficients;

use super::fit::{self, Targets};
use super::proof::{Proof, prove};
use super::shape::{Filling, Shape, Words};
use super::truth::Truth;
use super::{MOST_FLASH_BYTES, TurnError, USUAL_BOUND, USUAL_FLASH_BYTES};
use crate::cost::{Core, Cost};
use crate::options::Options;
use crate::program::Program;

/// A routine that was chosen and proved.
#[derive(Debug, Clone)]
pub struct TurnRoutine {
    /// How it is written.
    pub shape: Shape,
    /// The program that was run on every count.
    pub program: Program,
    /// Widths of the counts.
    pub words: Words,
    /// What was found.
    pub proof: Proof,
    /// The core that it was chosen for.
    pub core: Core,
    /// Its cost there, estimated.
    pub cost: Cost,
    /// The sensor's unit in a count of the result.
    pub unit_per_count: f64,
}

impl TurnRoutine {
    /// The bound in the sensor's unit, rounded up.
    pub fn bound(&self) -> f64 {
        (self.proof.bound * self.unit_per_count).next_up()
    }
}

/// Chooses the routine for coefficients of a whole turn.
///
/// # Errors
/// [`TurnError`], which says what to change.
pub fn choose(coefficients: &Coefficients, options: &Options) -> Result<TurnRoutine, TurnError> {
    let wanted = &options.encoder;
    let words = wanted.words(coefficients)?;
    let truth = Truth::new(coefficients)?;
    let revolution = coefficients.turn.as_ref().map_or(1.0, |turn| turn.revolution);
    let unit_per_count = revolution / f64::from(words.result_counts());
    let unit = coefficients.sensor.error_unit().to_string();
    let bound = options.bound.unwrap_or(USUAL_BOUND * unit_per_count);
    let in_counts = bound / unit_per_count;
    if !(in_counts.is_finite() && in_counts > 0.5) {
        let (half, output) = (0.5 * unit_per_count, words.output());
        return Err(TurnError::Bound { wanted: bound, half, unit, output });
    }
    let core = wanted.core.unwrap_or(Core::CortexM4f);
    let targets = Targets::new(&truth, words);
    let mut candidates: Vec<(Shape, Cost)> =
        Shape::all(words).into_iter().map(|shape| (shape, rough_cost(shape, words, core))).collect();
    candidates.sort_by(|(_, a), (_, b)| {
        a.instructions.total_cmp(&b.instructions).then(a.flash_bytes.cmp(&b.flash_bytes))
    });
    // Where the user set no limit, what does not fit the usual one may take as much as a table of anything else.
    let limits = match wanted.flash_bytes {
        Some(given) => vec![given],
        None => vec![USUAL_FLASH_BYTES, MOST_FLASH_BYTES],
    };
    let mut least = 0;
    for flash in &limits {
        for (shape, _) in candidates.iter().filter(|(_, cost)| (least..=*flash).contains(&cost.flash_bytes)) {
            let (shape, words) = (*shape, words);
            let Ok((filling, off)) = fit::fill(shape, &targets) else { continue };
            // Before rounding they are already too far away.
            if 0.5 + off > in_counts + 0.5 {
                continue;
            }
            let program = shape.program(words, &filling);
            let cost = cost(&program, shape, core);
            let Ok(proof) = prove(&program, words, &targets.exact) else { continue };
            if proof.bound <= in_counts && cost.flash_bytes <= *flash {
                return Ok(TurnRoutine { shape, program, words, proof, core, cost, unit_per_count });
            }
        }
        least = flash + 1;
    }
    let filling = fit::fill(Shape::PerCount, &targets)?.0;
    let program = Shape::PerCount.program(words, &filling);
    let table = cost(&program, Shape::PerCount, core).flash_bytes;
    let flash = limits.last().copied().unwrap_or(USUAL_FLASH_BYTES);
    Err(TurnError::Nothing { wanted: bound, unit, flash, table })
}

fn cost(program: &Program, shape: Shape, core: Core) -> Cost {
    let cost = core.cost(program);
    // The table's own address and that of the row, which other tables have in their index: as counted in what
    // arm-none-eabi-gcc 12.2 makes of such routines at -O2.
    let more: f64 = match (shape, core) {
        (Shape::PerCount, Core::CortexM0) => 1.0,
        (Shape::Segments { segments_log2: 1.., .. }, Core::CortexM0) => 6.0,
        (Shape::Segments { segments_log2: 1.., .. }, _) => 2.0,
        _ => 0.0,
    };
    Cost { instructions: cost.instructions + more, flash_bytes: cost.flash_bytes + (2.0 * more) as usize }
}

/// The cost before the constants are known: of a table of every count, with entries of a byte.
fn rough_cost(shape: Shape, words: Words, core: Core) -> Cost {
    let (rows, columns) = match shape {
        Shape::PerCount => (words.counts as usize, 1),
        Shape::Segments { degree, .. } => (shape.segments(words), degree + 1),
    };
    let filling = Filling {
        // Constants that no operation can leave out.
        table: vec![vec![1; columns]; rows],
        shifts: vec![8; columns],
        fraction: 8,
        zero: 1,
    };
    cost(&shape.program(words, &filling), shape, core)
}
