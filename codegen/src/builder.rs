//! Generation from a build script: what the program does, as functions.
//!
//! A firmware's `build.rs` names the coefficients and what is wanted of the routine, and the firmware includes
//! the module that is written; `cargo build` fails where no routine meets the bound. On a coefficients file it needs
//! none of the features: with `default-features = false` little is compiled.
//!
//! ```no_run
//! // build.rs
//! fn main() -> Result<(), codegen::builder::BuildError> {
//!     let out_dir = std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
//!     codegen::Builder::new()
//!         .coefficients("coefficients.json")
//!         .target(codegen::cost::Core::CortexM4f)
//!         .bound_arcsec(0.01)
//!         .write_to(out_dir)?;
//!     Ok(())
//! }
//! ```
//!
//! ```ignore
//! // src/main.rs of the firmware
//! mod corrected_angle {
//!     include!(concat!(env!("OUT_DIR"), "/corrected_angle.rs"));
//! }
//! ```

use std::path::{Path, PathBuf};

use fitter::message::Message;
use fitter::output::OutputError;

use crate::accepted::{NotAccepted, accepted};
use crate::cost::Core;
use crate::explore::{self, Wanted};
use crate::files;
use crate::format::{Format, NotFused};
use crate::generate::{self, GenerateError, Generated};
use crate::language;
use crate::options::{CShift, Ends, Method, Options, OutOfRange};
use crate::routine::RoutineError;
use crate::source::Source;

fitter::errors! {
    /// Why a build script could not generate; each is a sentence that says what to change.
    #[derive(Debug)]
    pub enum BuildError {
        NoSource => says("nothing is named to generate from: call `coefficients` or `recording`");
    }
    from {
        NotAccepted(NotAccepted),
        NotFused(NotFused),
        Source(Message),
        Choose(RoutineError),
        Generate(GenerateError),
        Write(OutputError),
    }
}

/// What is to be generated; see the [module](self).
#[must_use]
#[derive(Debug, Clone)]
pub struct Builder {
    source: Option<Source>,
    target: Option<Core>,
    flash_bytes: Option<usize>,
    formats: Vec<Format>,
    fma: bool,
    method: Method,
    ends: Ends,
    options: Options,
}

impl Default for Builder {
    fn default() -> Self {
        let options = Options { command: "codegen::Builder".into(), ..Options::default() };
        Builder {
            source: None,
            target: None,
            flash_bytes: None,
            formats: Vec::new(),
            fma: false,
            method: Method::Fused,
            ends: Ends::default(),
            options,
        }
    }
}

impl Builder {
    /// A q31 and an f32 routine, of a mirror bounded by 0.01″; what of has to be said.
    pub fn new() -> Self {
        Self::default()
    }

    /// The embedded recording of a simulated mirror, to try it with.
    #[cfg(feature = "recordings")]
    pub fn demo(mut self) -> Self {
        self.source = Some(Source::Embedded);
        self
    }

    /// Coefficients as `fit` or `diagnose` wrote them.
    pub fn coefficients(mut self, path: impl Into<PathBuf>) -> Self {
        self.source = Some(Source::Coefficients(path.into()));
        self
    }

    /// A recording with its nominal mirror, fitted on the way.
    #[cfg(feature = "recordings")]
    pub fn recording(mut self, recording: impl Into<PathBuf>, mirror: impl Into<PathBuf>) -> Self {
        self.source = Some(Source::Recording { recording: recording.into(), mirror: mirror.into() });
        self
    }

    /// Take coefficients of which the diagnosis left more than it named: the generated files then say so.
    pub fn accept_unexplained(mut self) -> Self {
        self.options.accept_unexplained = true;
        self
    }

    /// Choose format and method: what meets the bound at the least cost on this core
    /// ([`Cost::worth`](crate::cost::Cost::worth)).
    pub fn target(mut self, core: Core) -> Self {
        self.target = Some(core);
        self
    }

    /// Bytes of flash that the chosen routine may take; only with [`Builder::target`].
    pub fn flash_bytes(mut self, bytes: usize) -> Self {
        self.flash_bytes = Some(bytes);
        self
    }

    /// The largest acceptable bound: in arcseconds, for a direct sensor in its unit.
    pub fn bound_arcsec(mut self, bound: f64) -> Self {
        self.options.bound = Some(bound);
        self
    }

    /// The number formats, one routine each; with a target, those to choose from.
    pub fn formats(mut self, formats: impl IntoIterator<Item = Format>) -> Self {
        self.formats = formats.into_iter().collect();
        self
    }

    /// Products and sums of floats rounded once together, by cores that do so in one instruction
    /// ([`Core::fuses`]), in place of format f32. Refused for a target without it, and where no format is one of floats.
    pub fn fma(mut self) -> Self {
        self.fma = true;
        self
    }

    /// One polynomial or a table; not with a target, which chooses.
    pub fn method(mut self, method: Method) -> Self {
        self.method = method;
        self
    }

    /// What the routine is given and returns.
    pub fn ends(mut self, ends: Ends) -> Self {
        self.ends = ends;
        self
    }

    /// Bits of an encoder's word, and of its corrected word; for coefficients of a whole turn. Bits of `None` are
    /// those of a revolution in counts.
    pub fn encoder(mut self, bits: Option<u32>, output_bits: Option<u32>) -> Self {
        (self.options.encoder.bits, self.options.encoder.output_bits) = (bits, output_bits);
        self
    }

    /// What happens outside the range.
    pub fn out_of_range(mut self, rule: OutOfRange) -> Self {
        self.options.out_of_range = rule;
        self
    }

    /// How C shifts negative numbers.
    pub fn c_shift(mut self, shift: CShift) -> Self {
        self.options.c_shift = shift;
        self
    }

    /// Base name of module, files and functions.
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.options.name = Some(name.into());
        self
    }

    /// Designs, bounds and renders; writes nothing.
    ///
    /// # Errors
    /// [`BuildError`]: the source cannot be read, or no routine meets what is asked.
    pub fn generate(&self) -> Result<Generated, BuildError> {
        let source = self.source.as_ref().ok_or(BuildError::NoSource)?;
        let (coefficients, sha256) = source.load()?;
        let mut options = self.options.clone();
        accepted(&coefficients, &options)?;
        if coefficients.whole_turn() {
            options.encoder.core = self.target;
            options.encoder.flash_bytes = self.flash_bytes;
            return Ok(generate::generate(&coefficients, &sha256, &options)?);
        }
        let formats = self.fused_formats()?;
        match self.target {
            Some(core) => {
                let (formats, flash_bytes) = (&formats[..], self.flash_bytes);
                let wanted = Wanted { core, formats, ends: self.ends, flash_bytes };
                explore::choose(&coefficients, &mut options, &wanted, &|_, _| {})?;
            }
            None => {
                options.leave_out_unreachable = self.formats.is_empty();
                options.routines =
                    formats.into_iter().map(|format| self.ends.routine(self.method, format)).collect();
            }
        }
        Ok(generate::generate(&coefficients, &sha256, &options)?)
    }

    /// The formats that are named, or the usual ones, with fused multiply-adds where they are wanted.
    fn fused_formats(&self) -> Result<Vec<Format>, NotFused> {
        let usual = self.options.routines.iter().map(|routine| routine.format);
        let named: Vec<Format> = match (&self.formats[..], self.target) {
            ([], Some(_)) => Format::ALL.to_vec(),
            ([], None) => usual.collect(),
            (named, _) => named.to_vec(),
        };
        if self.fma {
            Format::can_fuse(&named, self.target)?;
        }
        Ok(named.into_iter().map(|format| format.fused(self.fma)).collect())
    }

    /// Generates and writes `<name>.rs` (a module to include), the C pair in `c/`, the Gappa scripts and
    /// `certificate.json`; tells cargo to run the build script again when the sources change.
    ///
    /// # Errors
    /// Those of [`Builder::generate`], and where the folder cannot be written; then nothing is changed.
    pub fn write_to(&self, folder: impl AsRef<Path>) -> Result<Generated, BuildError> {
        let generated = self.generate()?;
        let (module, mut written) =
            language::module(&generated.name, &generated.files).map_err(GenerateError::Render)?;
        written.insert(PathBuf::from(format!("{}.rs", generated.name)), module);
        files::write(folder.as_ref(), &written)?;
        // Outside a build script this is a line that nobody reads; inside, cargo's protocol.
        if std::env::var_os("OUT_DIR").is_some() {
            for path in self.source.iter().flat_map(Source::files) {
                println!("cargo::rerun-if-changed={}", path.display());
            }
        }
        Ok(generated)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fitter::coefficients::Diagnosed;

    #[test]
    fn a_target_gets_one_routine_within_the_bound() {
        let folder = tempfile::tempdir().unwrap();
        let builder = Builder::new().demo().target(Core::CortexM3).bound_arcsec(0.001);
        let generated = builder.write_to(folder.path()).unwrap();
        assert_eq!(generated.routines.len(), 1);
        assert!(generated.certificate.routines.iter().all(|entry| entry.bound <= 0.001));
        let module = std::fs::read_to_string(folder.path().join("corrected_angle.rs")).unwrap();
        assert!(module.contains("pub use corrected_angle_q31"), "{module}");
        assert!(folder.path().join("c/corrected_angle.c").exists());
        assert!(!folder.path().join("Cargo.toml").exists());
    }

    #[test]
    fn an_unreachable_bound_says_what_can_be_had_and_writes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let builder = Builder::new().demo().target(Core::CortexM0).bound_arcsec(1e-9).formats([Format::Q15]);
        let error = builder.write_to(folder.path()).unwrap_err();
        assert!(
            matches!(
                error,
                BuildError::Choose(RoutineError::NoneFits { .. } | RoutineError::NoneWithin { .. })
            ),
            "{error}"
        );
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn floats_are_fused_where_the_core_has_that() {
        let builder = Builder::new().demo().formats([Format::F32]).bound_arcsec(0.001).fma();
        for builder in [builder.clone(), builder.clone().target(Core::CortexM4f)] {
            let generated = builder.generate().unwrap();
            let sources = [
                ("c/corrected_angle.c", "= fused(y, x, "),
                ("src/corrected_angle_f32_fma.rs", "= fused(y, x, "),
            ];
            for (path, call) in sources {
                assert!(generated.files[Path::new(path)].contains(call), "{path}");
            }
        }
        for core in [Core::CortexM0, Core::CortexM3] {
            let error = builder.clone().target(core).generate().unwrap_err();
            assert!(matches!(error, BuildError::NotFused(NotFused::NoInstruction { .. })), "{error}");
        }
        let error = builder.formats([Format::Q31]).generate().unwrap_err();
        assert!(matches!(error, BuildError::NotFused(NotFused::NoFloats)), "{error}");
    }

    #[test]
    fn nothing_is_generated_of_nothing() {
        let error = Builder::new().generate().unwrap_err();
        assert!(matches!(error, BuildError::NoSource), "{error}");
    }

    #[test]
    fn what_is_left_unexplained_has_to_be_accepted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.json");
        let verdict = "unexplained".to_string();
        let mut file = crate::fixtures::paper_coefficients();
        file.diagnosis = Some(Diagnosed { verdict, before_rms: 12.0, after_rms: 12.0, noise_floor: 0.2 });
        std::fs::write(&path, file.to_sealed_json()).unwrap();
        let builder = Builder::new().coefficients(&path).formats([Format::Q31]);
        let error = builder.generate().unwrap_err();
        assert!(matches!(error, BuildError::NotAccepted(NotAccepted::Unexplained(_))), "{error}");
        assert!(error.to_string().contains("leaves 12.0 arcsec rms at a noise of 0.200 arcsec"), "{error}");
        let generated = builder.accept_unexplained().generate().unwrap();
        let open = generated.certificate.reservation.unwrap();
        assert!(open.contains("ended `unexplained`") && open.contains("as was asked for"), "{open}");
        for path in ["c/corrected_angle.h", "c/corrected_angle.c", "src/corrected_angle_q31.rs"] {
            let head = generated.files[Path::new(path)].lines().take(20).collect::<Vec<_>>().join(" ");
            assert!(
                head.contains("UNEXPLAINED: the diagnosis of the recording ended `unexplained`"),
                "{head}"
            );
        }
    }
}
