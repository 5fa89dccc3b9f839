//! Why the terms of a coefficients file cannot be generated.

use crate::bound::Overflows;
use crate::design::DesignError;
use crate::reference::TooSteep;

/// See the module.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // the messages say what the fields are
pub enum PhysicsError {
    /// A further input that is not understood.
    #[error(
        "--further {0}: give the column, its valid range and how it arrives, for example temperature_c=15..35 \
         (a Q31 word) or temperature_c=15..35:counts:12:0.05:-400 (bits, gain, the count that stands for zero)"
    )]
    Further(String),
    /// A box that the words do not reach.
    #[error("`{observable}` as described reaches {}…{} only, its box is {from}…{to}", reaches.0, reaches.1)]
    Box { observable: String, from: f64, to: f64, reaches: (f64, f64) },
    /// A further input that is described twice.
    #[error("--further {0} is given twice: describe each input once")]
    GivenTwice(String),
    /// A further input that would have the name of another argument.
    #[error(
        "--further {0}: the routine has an argument of the name that this column gives: give the column another name"
    )]
    Taken(String),
    /// A box wider than what was recorded.
    #[error(
        "--further {observable}={from}..{to} is wider than the recording, in which `{observable}` covers {}…{}: nothing \
         is known of the effects beyond; narrow it, or give --extrapolate", recorded.0, recorded.1
    )]
    BeyondRecorded { observable: String, from: f64, to: f64, recorded: (f64, f64) },
    /// A further input that is not described.
    #[error(
        "the term `{kind}` of {effect} needs `{observable}` at run time: describe that input, for example \
         --further {observable}=FROM..TO, or leave the effect out with --without {effect}"
    )]
    Needs { effect: String, kind: &'static str, observable: String },
    /// A further input that no term reads.
    #[error("--further {0}: no term of the coefficients reads `{0}`")]
    Unread(String),
    /// An effect that is not there.
    #[error("--{option} {effect}: the coefficients have no term of that effect{there}")]
    NoSuchEffect { option: &'static str, effect: String, there: String },
    /// An effect that is both kept and left out.
    #[error("{0} is named by --keep and by --without: one of them contradicts the other")]
    KeptAndLeftOut(String),
    /// An effect that cannot be kept.
    #[error("--keep {effect}: {why}")]
    NotKept { effect: String, why: &'static str },
    /// The same term twice.
    #[error(
        "the coefficients have two terms `{kind}` of {effect} with the same parameters: they correct the same error \
         twice; take one of them out"
    )]
    Twice { effect: String, kind: &'static str },
    /// Terms of different recordings.
    #[error(
        "{first} counts `{observable}` from {}, {second} from {}: terms of one recording have one reference, so these \
         contradict each other; diagnose again, or leave one out with --without", means.0, means.1
    )]
    Means { observable: String, first: String, second: String, means: (f64, f64) },
    /// A term that is not generated.
    #[error(
        "the term `{kind}` of {effect} cannot be generated{why}: leave it out with --without {effect}, and the heads \
         of the files will say so"
    )]
    NotGenerated { effect: String, kind: &'static str, why: String },
    /// A format without long products.
    #[error("terms of further physics need the format q31 or q31-split, not {0}: add --format q31")]
    Format(&'static str),
    /// A play too narrow for a word.
    #[error("a play of half-width {0} is too narrow for words of 32 bits")]
    NarrowPlay(f64),
    /// A coefficient too large.
    #[error("a coefficient of a term is too large for words of 32 bits")]
    TooLarge,
    /// A period that is none.
    #[error("--period-s {0}: give the time between two calls of the routine in seconds, above zero")]
    Period(f64),
    /// A term that needs the period.
    #[error(
        "the term `{kind}` of {effect} needs the time between two calls of the routine: give --period-s, or leave the \
         effect out with --without {effect}"
    )]
    NeedsPeriod { effect: String, kind: &'static str },
    /// The range is too wide.
    #[error(transparent)]
    TooSteep(#[from] TooSteep),
    #[error(transparent)]
    Overflows(#[from] Overflows),
}

impl From<PhysicsError> for DesignError {
    fn from(cause: PhysicsError) -> Self {
        match cause {
            PhysicsError::Overflows(cause) => DesignError::Overflows(cause),
            cause => DesignError::Physics(cause),
        }
    }
}
