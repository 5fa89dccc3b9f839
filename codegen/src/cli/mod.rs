//! The command line of `generate`, `check` and `verify`, for `arcsmith` and for this package's own program, and what all
//! commands share with a terminal ([`terminal`]).

mod arguments;
mod check;
mod devices;
mod encoder;
mod generate;
pub mod options;
pub mod source;
mod tables;
pub mod terminal;
mod verify;

use fitter::coefficients::Coefficients;
use indicatif::ProgressBar;

use crate::accepted::accepted;
use crate::explore::{self, Wanted};
use crate::format::Format;
use crate::generate::{Generated, generate};
use crate::options::Options;
use crate::quantity::Quantity;

pub use arguments::{Arguments, recording};
pub use check::{Check, EXAMPLES as CHECK};
pub use generate::EXAMPLES as GENERATE;
pub use terminal::{Common, Result};
pub use verify::{EXAMPLES as VERIFY, Verify};

impl Arguments {
    /// The coefficients that are named or found, and the SHA-256 of their file.
    ///
    /// # Errors
    /// They cannot be read, or leave more unexplained than is accepted.
    pub fn load(&self) -> Result<(Coefficients, String)> {
        let (coefficients, sha256) = source::source(self)?.load()?;
        // Before anything else is said of what was asked for.
        let options = Options { accept_unexplained: self.accept_unexplained, ..Options::default() };
        accepted(&coefficients, &options)?;
        Ok((coefficients, sha256))
    }

    /// The formats that the user named, or all that both languages have.
    pub fn formats(&self) -> Vec<Format> {
        let named = match &self.format[..] {
            [] => &Format::ALL[..],
            named => named,
        };
        named.iter().map(|format| format.fused(self.fma)).collect()
    }

    /// Progress on standard error, where someone watches.
    pub fn progress(&self) -> ProgressBar {
        let bar = self.common.progress(0, "{msg} {bar:40} {percent}% {per_sec} {eta}");
        bar.set_message("reading");
        bar
    }

    /// Designs, bounds and renders; writes nothing.
    fn prepare(&self) -> Result<(Generated, Options)> {
        let (coefficients, sha256) = self.load()?;
        self.of(&coefficients, &sha256)
    }

    /// The same for these coefficients, whose file has the hash `sha256`, whatever the arguments name.
    ///
    /// # Errors
    /// No routine meets what is asked.
    pub fn of(&self, coefficients: &Coefficients, sha256: &str) -> Result<(Generated, Options)> {
        if let Some(firmware) = self.firmware {
            return tables::prepare(self, firmware, coefficients, sha256);
        }
        let bar = self.progress();
        if coefficients.whole_turn() {
            return encoder::prepare(self, coefficients, sha256);
        }
        options::no_encoder(self)?;
        let unit = Quantity::of(&coefficients.error_model()).bound_unit;
        let mut options = options::options(self, &unit, !coefficients.terms.is_empty())?;
        if let Some(target) = self.target {
            let (formats, ends) = (&self.formats()[..], options::ends(self)?);
            let wanted = Wanted { core: target, formats, ends, flash_bytes: self.flash_bytes };
            explore::choose(coefficients, &mut options, &wanted, &designing(&bar))?;
        }
        bar.set_message("approximating and bounding");
        let generated = generate(coefficients, sha256, &options)?;
        bar.finish_and_clear();
        Ok((generated, options))
    }
}

/// Shows on the bar how many candidates of how many are through.
pub fn designing(bar: &ProgressBar) -> impl Fn(usize, usize) + Sync {
    bar.set_message("designing");
    move |through: usize, total: usize| {
        bar.set_length(total as u64);
        bar.set_position(through as u64);
    }
}
