//! From arguments to options.

use clap::ValueEnum;
use fitter::message::Message;
use fitter::text_safety;

use super::{Arguments, Result, source, terminal};
use crate::format::Format;
use crate::input::{Arity, Encoding, Input};
use crate::options::{Ends, Method, Options, OutOfRange};
use crate::physics::Further;
use crate::refused;
use crate::turn::Encoder;

/// The width of a converter unless one is given.
const USUAL_BITS: u32 = 16;

/// What the routines are given.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum InputName {
    /// The reading (s = x₂ − x₁ of a pair) as a float.
    F32,
    /// The reading as a Q31 word.
    Q31,
    /// The reading in counts.
    Counts,
    /// x₁ and x₂ as floats in millimetres.
    X1x2F32,
    /// x₁ and x₂ as Q31 words.
    X1x2Q31,
    /// x₁ and x₂ in counts.
    X1x2Counts,
}

/// What the arguments ask for; `unit` is that of the sensor's bounds.
pub fn options(arguments: &Arguments, unit: &str, terms: bool) -> Result<Options> {
    let bound = match (&arguments.bound_arcsec, &arguments.bound) {
        (Some(bound), _) if unit == "arcsec" => Some(*bound),
        (Some(_), _) => {
            return Err(refused!("this sensor's bound is in {unit}")
                .mend(format_args!("give --bound with its unit, 0.0001{unit}")));
        }
        (None, Some(text)) => Some(bound_with_unit(text, unit)?),
        (None, None) => None,
    };
    let ends = ends(arguments)?;
    let further: Result<Vec<_>, _> = arguments.further.iter().map(|f| Further::parse(f)).collect();
    let method = arguments.table.as_deref().map_or(Ok(Method::Fused), table)?;
    let formats = match &arguments.format[..] {
        // Terms of further physics need long products.
        [] if terms => vec![Format::Q31],
        [] => Options::default().routines.iter().map(|r| r.format.fused(arguments.fma)).collect(),
        named => named.iter().map(|format| format.fused(arguments.fma)).collect(),
    };
    if arguments.fma {
        Format::can_fuse(&formats, arguments.target)?;
    }
    let options = Options {
        routines: formats.into_iter().map(|format| ends.routine(method, format)).collect(),
        leave_out_unreachable: arguments.format.is_empty(),
        bound,
        terms_bound: None,
        degree: arguments.degree,
        range: arguments.from.zip(arguments.to),
        extrapolate: arguments.extrapolate,
        out_of_range: arguments.out_of_range,
        further: further?,
        period_s: arguments.period_s,
        without: arguments.without.clone(),
        keep: arguments.keep.clone(),
        accept_unexplained: arguments.accept_unexplained,
        c_shift: arguments.c_shift,
        name: arguments.name.clone(),
        command: recorded_command(terminal::words().into_iter(), &source::words_of(arguments)?),
        encoder: Encoder {
            bits: arguments.bits,
            counts: arguments.counts,
            output_bits: arguments.output_bits,
            core: arguments.target,
            flash_bytes: arguments.flash_bytes,
        },
    };
    options.within_limits()?;
    Ok(options)
}

/// What the arguments ask for of the routine of an encoder.
pub fn encoder_options(arguments: &Arguments, unit: &str) -> Result<Options> {
    if let Some(option) = of_other_sensors(arguments).first() {
        return Err(not_of_encoders(option));
    }
    options(arguments, unit, false)
}

/// The options that are given and that a correction of counts does not have.
pub fn of_other_sensors(arguments: &Arguments) -> Vec<&'static str> {
    let a = arguments;
    let beside = [
        ("--degree", a.degree.is_some()),
        ("--from and --to", a.from.is_some()),
        ("--extrapolate", a.extrapolate),
        ("--format", !a.format.is_empty()),
        ("--fma", a.fma),
        ("--table", a.table.is_some()),
        ("--input", a.input.is_some()),
        ("--full-scale", a.full_scale.is_some()),
        ("--gain", a.gain.is_some()),
        ("--offset", a.offset.is_some()),
        ("--output", a.output.is_some()),
        ("--out-of-range", a.out_of_range != OutOfRange::Clamp),
        ("--further", !a.further.is_empty()),
        ("--period-s", a.period_s.is_some()),
        ("--without", !a.without.is_empty()),
        ("--keep", !a.keep.is_empty()),
    ];
    given(&beside)
}

/// The options that are given, of these.
pub fn given(options: &[(&'static str, bool)]) -> Vec<&'static str> {
    options.iter().filter(|(_, given)| *given).map(|(option, _)| *option).collect()
}

/// The refusal of an option of other sensors.
pub fn not_of_encoders(option: &str) -> Message {
    refused!("{option} does not apply to an encoder's counts").mend("leave it out")
}

/// Options that belong to encoders only.
pub fn no_encoder(arguments: &Arguments) -> Result<()> {
    let of_encoders =
        [("--output-bits", arguments.output_bits.is_some()), ("--counts", arguments.counts.is_some())];
    if let Some((option, _)) = of_encoders.into_iter().find(|(_, given)| *given) {
        return Err(refused!("{option} belongs to an encoder, whose coefficients hold on a whole turn")
            .mend("leave it out"));
    }
    if arguments.flash_bytes.is_some() && arguments.target.is_none() {
        return Err(refused!("--flash-bytes belongs to a choice")
            .mend("add --target, the core that the routine is for"));
    }
    Ok(())
}

/// The input and output that the user named.
pub fn ends(arguments: &Arguments) -> Result<Ends> {
    let Arguments { gain, offset, full_scale, output, .. } = *arguments;
    let encoding = |name, arity| -> Result<Encoding> {
        Ok(match name {
            InputName::F32 | InputName::X1x2F32 => Encoding::F32,
            InputName::Q31 | InputName::X1x2Q31 => Encoding::Q31 { full_scale },
            InputName::Counts | InputName::X1x2Counts => {
                let of = if arity == Arity::Probes { "displacement" } else { "reading" };
                let gain =
                    gain.ok_or_else(|| refused!("counts need --gain, the change of the {of} by one count"))?;
                let bits = arguments.bits.unwrap_or(USUAL_BITS);
                let middle = f64::from(1u32 << bits.clamp(1, 31).saturating_sub(1));
                Encoding::Counts { bits, gain, offset: offset.unwrap_or(middle) }
            }
        })
    };
    let input = |name| -> Result<Input> {
        let probes = matches!(name, InputName::X1x2F32 | InputName::X1x2Q31 | InputName::X1x2Counts);
        let arity = if probes { Arity::Probes } else { Arity::Reading };
        Ok(Input { arity, encoding: encoding(name, arity)? })
    };
    let input = arguments.input.map(input).transpose()?;
    let counts = matches!(input, Some(Input { encoding: Encoding::Counts { .. }, .. }));
    if !counts && (gain.is_some() || offset.is_some()) {
        return Err(refused!("--gain and --offset belong to a converter's counts")
            .mend("add --input counts or x1x2-counts, or leave them out"));
    }
    Ok(Ends { input, output, full_scale })
}

/// `2x32`: the degree and the number of segments, a power of two; `2x32-padded` with rows of a power of two of words.
fn table(text: &str) -> Result<Method> {
    let form = text.strip_suffix("-padded");
    let padded = form.is_some();
    let parts = form
        .unwrap_or(text)
        .split_once('x')
        .and_then(|(d, n)| Some((d.parse().ok()?, n.parse::<u32>().ok()?)));
    match parts {
        Some((degree, segments)) if segments.is_power_of_two() => {
            Ok(Method::Piecewise { degree, segments_log2: segments.trailing_zeros(), padded, place: None })
        }
        _ => Err(refused!("--table {text} is no table")
            .mend("give degree and number of segments, a power of two: for example 2x32")),
    }
}

/// `0.01mm`: a number and the unit that the sensor has.
fn bound_with_unit(text: &str, unit: &str) -> Result<f64> {
    let digits = text.trim_end_matches(|c: char| c.is_alphabetic() || c == 'µ');
    let found = text[digits.len()..].trim();
    // An exponent's `e` belongs to the number.
    let value = digits.trim().parse::<f64>();
    match value {
        Ok(value) if found == unit => Ok(value),
        Ok(_) => Err(refused!("--bound {text}: the unit is {found:?}, this sensor's is {unit:?}")
            .mend(format_args!("give for example {digits}{unit}"))),
        Err(_) => Err(refused!("--bound {text}: not a number with a unit")
            .mend(format_args!("give for example 0.01{unit}"))),
    }
}

/// The command as it stands in the heads: without what does not change the files, and the same whichever program
/// and command it was that generated them; `source` is what they were generated from where no argument names it.
fn recorded_command(arguments: impl Iterator<Item = String>, source: &[String]) -> String {
    let mut words = vec!["codegen".to_string()];
    let mut arguments = arguments.skip_while(|word| HOW_MUCH.contains(&word.as_str())).peekable();
    if arguments.peek().is_some_and(|word| COMMANDS.contains(&word.as_str())) {
        arguments.next();
    }
    let mut arguments = source.iter().cloned().chain(arguments);
    while let Some(word) = arguments.next() {
        match word.as_str() {
            "--check" | "--sweep" | "--exhaustive" | "--sanitize" | "--gappa" | "--frama-c" | "--misra"
            | "--objects" | "--mutants" => {}
            how_much if HOW_MUCH.contains(&how_much) => {}
            "--out" => {
                arguments.next();
            }
            other if other.starts_with("--out=") => {}
            // A star beside a slash would begin or end a comment of C: quoted, it is the same to a shell.
            other if other.contains(char::is_whitespace) => {
                words.push(format!("'{}'", other.replace('*', "'\\*'")));
            }
            other => words.push(other.replace('*', "'*'")),
        }
    }
    text_safety::shown(&words.join(" "))
}

const HOW_MUCH: [&str; 5] = ["--json", "-q", "--quiet", "-v", "--verbose"];
const COMMANDS: [&str; 5] = ["generate", "check", "verify", "explore", "budget"];

#[cfg(test)]
mod tests {
    use super::recorded_command;

    #[test]
    fn the_head_holds_what_changes_the_files_whoever_generated_them() {
        let recorded = |line: &str| recorded_command(line.split(' ').map(str::to_string), &[]);
        let expected = "codegen --coefficients check --format q31";
        for line in [
            "--coefficients check --format q31 --out a",
            "check --coefficients check --out=a --format q31 -q",
            "-v --json generate --coefficients check --format q31",
            "verify --exhaustive --coefficients check --format q31 --quiet",
            "budget --coefficients check --format q31 --out a.html",
        ] {
            assert_eq!(recorded(line), expected, "{line}");
        }
        // What was found without being named is named.
        let found = ["--coefficients".to_string(), "my axis.coefficients.json".to_string()];
        let command = recorded_command("check -q --out a".split(' ').map(str::to_string), &found);
        assert_eq!(command, "codegen --coefficients 'my axis.coefficients.json'");
    }
}
