//! What a user can ask for.

use fitter::limits;

use crate::accepted::NotAccepted;
use crate::format::Format;
use crate::input::{Arity, Encoding, Input};
use crate::output::Output;
use crate::physics::{Further, FurtherEncoding};
use crate::turn::Encoder;

/// What happens to a reading outside the valid range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
pub enum OutOfRange {
    /// The value at the nearest end of the range.
    #[default]
    Clamp,
    /// The same, and the caller is told.
    Flag,
    /// The formula continues, without a bound; no operation overflows for any input.
    Continue,
}

/// How C takes the high word of a negative product.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
pub enum CShift {
    /// Fully defined by C99.
    #[default]
    Strict,
    /// Right shift of negatives, checked at compile time.
    Arithmetic,
}

/// What the polynomial of a table's row is one of, the cheapest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The variable; segments begin at multiples of their width.
    Whole,
    /// The variable; segments are centred there.
    Centred,
    /// The place in a segment that is centred there.
    Segment,
}

impl Place {
    /// All of them.
    pub const ALL: [Place; 3] = [Place::Whole, Place::Centred, Place::Segment];
}

/// How the function is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// One polynomial for the whole range.
    Fused,
    /// A table of polynomials.
    Piecewise {
        /// Degree of each, 1 to 3.
        degree: usize,
        /// Their number as a power of two.
        segments_log2: u32,
        /// Whether rows of three words are padded to four, so that their address is one shift.
        padded: bool,
        /// What its polynomials are of; `None`: the one that is proven closest.
        place: Option<Place>,
    },
}

/// One routine.
#[derive(Debug, Clone, PartialEq)]
pub struct RoutineOptions {
    /// How it is evaluated.
    pub method: Method,
    /// Number format of the evaluation.
    pub format: Format,
    /// What it is given.
    pub input: Input,
    /// What it returns.
    pub output: Output,
}

impl RoutineOptions {
    /// What tells it from the other routines of a generation: the format, and the table if there is one.
    pub fn suffix(&self) -> String {
        let format = self.format.name().replace('-', "_");
        match self.method {
            Method::Fused => format,
            Method::Piecewise { degree, segments_log2, .. } => {
                format!("{format}_{degree}x{}", 1 << segments_log2)
            }
        }
    }

    /// The usual input and output of a format: the reading as a word of the same kind.
    pub fn of(format: Format) -> Self {
        let (encoding, output) = match format {
            Format::F32 | Format::F32Fma => (Encoding::F32, Output::F32),
            _ => (Encoding::Q31 { full_scale: None }, Output::PowerOfTwo),
        };
        RoutineOptions {
            method: Method::Fused,
            format,
            input: Input { arity: Arity::Reading, encoding },
            output,
        }
    }
}

/// The ends of a routine as far as the user named them; the rest is usual for the format.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Ends {
    /// The input.
    pub input: Option<Input>,
    /// The output.
    pub output: Option<Output>,
    /// What 2³¹ of the usual Q31 word stands for.
    pub full_scale: Option<f64>,
}

impl Ends {
    /// The routine of a method and format with these ends.
    pub fn routine(&self, method: Method, format: Format) -> RoutineOptions {
        let mut usual = RoutineOptions::of(format);
        if let Encoding::Q31 { full_scale } = &mut usual.input.encoding {
            *full_scale = self.full_scale;
        }
        let (input, output) = (self.input.unwrap_or(usual.input), self.output.unwrap_or(usual.output));
        RoutineOptions { method, format, input, output }
    }
}

/// A whole generation.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The routines, at least one; all for the same coefficients, each of another format.
    pub routines: Vec<RoutineOptions>,
    /// Whether a routine that no degree brings within the bound is left out as long as another remains: where the user
    /// named no formats.
    pub leave_out_unreachable: bool,
    /// The largest bound that is acceptable, in arcsec (direct sensor: its unit); `None`: see
    /// [`crate::quantity::Quantity::default_bound`].
    pub bound: Option<f64>,
    /// The bound for which terms of further physics are approximated; `None`: the one that is acceptable.
    pub terms_bound: Option<f64>,
    /// The polynomial's degree; `None`: the lowest that meets the bound.
    pub degree: Option<usize>,
    /// Readings from and to, in mm (direct sensor: its unit); `None`: what the recording covers.
    pub range: Option<(f64, f64)>,
    /// Whether `range` may exceed what the recording covers.
    pub extrapolate: bool,
    /// Outside the range.
    pub out_of_range: OutOfRange,
    /// The further inputs of terms that the coefficients file has.
    pub further: Vec<Further>,
    /// Seconds between two calls of a routine with terms that depend on time.
    pub period_s: Option<f64>,
    /// Effects of which the terms are left out.
    pub without: Vec<String>,
    /// Effects of which the terms hold on the recording they were found in only, and that are generated nevertheless,
    /// since the routine begins as that recording did: a warm-up since switch-on.
    pub keep: Vec<String>,
    /// Whether coefficients are taken of which the diagnosis left more than it named.
    pub accept_unexplained: bool,
    /// Right shifts in C.
    pub c_shift: CShift,
    /// Base name of crate, files and functions; `None`: after the quantity.
    pub name: Option<String>,
    /// The command that reproduces the result, for the heads of the files.
    pub command: String,
    /// What is wanted of the routine of a sensor that turns, in place of `routines`.
    pub encoder: Encoder,
}

impl Options {
    /// Whether all numbers that are asked for can be computed with, see [`fitter::limits`].
    ///
    /// # Errors
    /// [`NotAccepted::Number`], the first that cannot.
    pub fn within_limits(&self) -> Result<(), NotAccepted> {
        let named = |of: &str, value, checked: Result<(), String>| {
            checked.map_err(|reason| NotAccepted::Number { of: of.into(), reason, value })
        };
        // No bound is too large: it is met at once.
        named(
            "the bound",
            "bound",
            self.bound.map_or(Ok(()), |bound| above_zero(bound.min(limits::LARGEST))),
        )?;
        named("the range", "range", self.range.map_or(Ok(()), |(from, to)| ends(from, to)))?;
        named("the time between two calls", "period_s", self.period_s.map_or(Ok(()), above_zero))?;
        for routine in &self.routines {
            match routine.input.encoding {
                Encoding::F32 => {}
                Encoding::Q31 { full_scale } => {
                    named("the full scale", "full_scale", full_scale.map_or(Ok(()), above_zero))?;
                }
                Encoding::Counts { gain, offset, .. } => {
                    named("the gain", "gain", above_zero(gain))?;
                    named("the count of zero", "offset", limits::place(offset))?;
                }
            }
        }
        for input in &self.further {
            let named = |what: &str, checked| {
                named(&format!("the {what} of {}", input.observable), "further", checked)
            };
            named("range", ends(input.from, input.to))?;
            if let FurtherEncoding::Counts { gain, offset, .. } = input.encoding {
                named("gain", above_zero(gain))?;
                named("count of zero", limits::place(offset))?;
            }
        }
        Ok(())
    }
}

/// A scale; what is zero, negative or no number is refused where it is used, in words of its own.
fn above_zero(value: f64) -> Result<(), String> {
    if value.is_finite() && value > 0.0 { limits::scale(value) } else { Ok(()) }
}

/// A range; what is empty or has an end that is no number is refused as in [`above_zero`].
fn ends(from: f64, to: f64) -> Result<(), String> {
    if from < to && from.is_finite() && to.is_finite() { limits::range(from, to) } else { Ok(()) }
}

impl Default for Options {
    fn default() -> Self {
        Options {
            routines: vec![RoutineOptions::of(Format::Q31), RoutineOptions::of(Format::F32)],
            leave_out_unreachable: false,
            bound: None,
            terms_bound: None,
            degree: None,
            range: None,
            extrapolate: false,
            out_of_range: OutOfRange::Clamp,
            further: Vec::new(),
            period_s: None,
            without: Vec::new(),
            keep: Vec::new(),
            accept_unexplained: false,
            c_shift: CShift::Strict,
            name: None,
            command: "codegen".into(),
            encoder: Encoder::default(),
        }
    }
}
