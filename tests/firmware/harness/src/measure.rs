//! Every case on every core in every variant: digests against the host's, figures for the table.

use std::collections::BTreeMap;
use std::iter;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use indicatif::ProgressBar;
use rayon::prelude::*;

use crate::build::{self, Variant};
use crate::cases::Case;
use crate::machine::{self, Core, Sweep};
use crate::problem::Problem;
use crate::subject::{self, Shift, Subject};
use crate::table::{Figures, Table};

/// How much is swept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Nothing: only figures.
    None,
    /// A part of the 2³² inputs, spread evenly, and all near the ends.
    Quick,
    /// All of them, or a part.
    Exhaustive(Part),
}

/// A part of all inputs: number `which`, from 1, of `of` parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// 1 … `of`.
    pub which: u32,
    /// A power of two up to 2¹⁶.
    pub of: u32,
}

impl FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        match numbers {
            Some((which, of)) if (1..=of).contains(&which) && of <= 1 << 16 && u32::is_power_of_two(of) => {
                Ok(Part { which, of })
            }
            _ => {
                Err("give a part as 1/64: its number, and how many parts, a power of two up to 65536".into())
            }
        }
    }
}

/// Strides of the quick sweep, primes, so that all low bits occur: 1.07·10⁷ inputs, and 1.04·10⁶.
const STRIDE: u32 = 401;
const LONG_STRIDE: u32 = 4133;
/// Inputs on each side of an end that the quick sweep takes in.
const NEAR_AN_END: u32 = 512;

impl Extent {
    /// Its sweeps of `subject` on `core`.
    ///
    /// The quick one takes long strides where a call runs through a library of floating point or of long
    /// products, a hundred and more instructions for each operation: what is tried there is whether that library
    /// and the compiler for this core agree with the host's arithmetic, and Cortex-M4F, where the same source
    /// becomes single instructions, is given ten times as many inputs.
    pub fn sweeps(self, subject: &Subject, core: Core) -> Vec<Sweep> {
        match self {
            Extent::None => Vec::new(),
            Extent::Exhaustive(Part { which, of }) => {
                let count = (1u64 << 32) / u64::from(of);
                vec![Sweep { first: (u64::from(which - 1) * count) as u32, count, stride: 1 }]
            }
            Extent::Quick => {
                let by_library = match core {
                    Core::M4f | Core::M7 | Core::M33 => false,
                    Core::M3 => subject.argument == "f32" || subject.result == "f32" || subject.in_floats,
                    Core::M0 => true,
                };
                let stride = if by_library { LONG_STRIDE } else { STRIDE };
                let all = Sweep { first: 0, count: (1u64 << 32).div_ceil(stride.into()), stride };
                let near = |end: u32| Sweep {
                    first: end.wrapping_sub(NEAR_AN_END),
                    count: 2 * u64::from(NEAR_AN_END),
                    stride: 1,
                };
                iter::once(all).chain(subject.ends().into_iter().map(near)).collect()
            }
        }
    }
}

/// One firmware to be built and run.
struct Job<'a> {
    subject: &'a Subject,
    core: Core,
    variant: Variant,
    sweeps: Vec<Sweep>,
    expected: Option<u64>,
}

/// Measures `cases` on `cores`. `work` is a folder for everything that is built.
///
/// # Errors
/// The first [`Problem`] that was met.
pub fn all(
    cases: &[Case],
    cores: &[Core],
    extent: Extent,
    work: &Path,
    bar: &ProgressBar,
) -> Result<Table, Problem> {
    let codegen = subject::codegen()?;
    let plugin = build::plugin(work)?;
    bar.set_message("generating");
    let generated = |case: &Case| -> Result<[Subject; 2], Problem> {
        let of = |shift: Shift| {
            subject::generate(&codegen, case, shift, &work.join(format!("{}-{}", case.name, shift.name())))
        };
        Ok([of(Shift::Strict)?, of(Shift::Arithmetic)?])
    };
    let subjects: Vec<[Subject; 2]> = cases.par_iter().map(generated).collect::<Result<_, _>>()?;

    bar.set_message("sweeping on the host");
    let hosts = |pair: &[Subject; 2]| build::host(&pair[0], &work.join(format!("{}-host", pair[0].case)));
    let hosts: Vec<PathBuf> = subjects.par_iter().map(hosts).collect::<Result<_, _>>()?;
    // Of cores that are swept alike the host's digest is the same.
    let mut digests: BTreeMap<(usize, Vec<[String; 3]>), u64> = BTreeMap::new();
    let words = |sweeps: &[Sweep]| sweeps.iter().map(Sweep::words).collect::<Vec<_>>();
    let mut wanted: Vec<(usize, Vec<Sweep>)> = Vec::new();
    // The slow core first, so that none is left alone at the end.
    let runs: Vec<(Core, usize)> = (cores.iter())
        .flat_map(|core| (0..cases.len()).filter(|i| cases[*i].is_for(*core)).map(|i| (*core, i)))
        .collect();
    for (core, index) in &runs {
        let sweeps = extent.sweeps(&subjects[*index][0], *core);
        if !sweeps.is_empty() && !wanted.contains(&(*index, sweeps.clone())) {
            wanted.push((*index, sweeps));
        }
    }
    let found: Vec<u64> = wanted
        .par_iter()
        .map(|(index, sweeps)| machine::on_host(&subjects[*index][0].case, &hosts[*index], sweeps))
        .collect::<Result<_, _>>()?;
    digests.extend(wanted.iter().map(|(index, sweeps)| (*index, words(sweeps))).zip(found));

    let mut jobs = Vec::new();
    for (core, index) in runs {
        for variant in Variant::ALL {
            let arithmetic = matches!(variant, Variant::C { shift: Shift::Arithmetic, .. });
            let subject = &subjects[index][usize::from(arithmetic)];
            let sweeps = if is_swept(variant) { extent.sweeps(subject, core) } else { Vec::new() };
            let expected = digests.get(&(index, words(&sweeps))).copied();
            jobs.push(Job { subject, core, variant, sweeps, expected });
        }
    }
    empties(&jobs, work)?;
    bar.set_length(jobs.len() as u64);
    bar.set_message("building, sweeping and counting");
    let figures: Vec<Figures> = jobs
        .par_iter()
        .map(|job| {
            let figures = one(job, &plugin, work);
            bar.inc(1);
            figures
        })
        .collect::<Result<_, _>>()?;
    let mut table = Table::empty()?;
    for (job, figures) in jobs.iter().zip(figures) {
        table.insert(&job.subject.case, job.core, &job.variant.name(), figures);
    }
    Ok(table)
}

/// Both languages and both C compilers; not every variant again.
fn is_swept(variant: Variant) -> bool {
    matches!(
        variant,
        Variant::C { compiler: "gcc", shift: Shift::Strict }
            | Variant::C { compiler: "clang", shift: Shift::Arithmetic }
            | Variant::Rust { level: "3" }
    )
}

/// Builds the firmware without a routine for every signature.
fn empties(jobs: &[Job], work: &Path) -> Result<(), Problem> {
    let place = |job: &Job| build::place(work, job.subject, job.core, job.variant, true);
    let mut once: Vec<&Job> = jobs.iter().collect();
    once.sort_by_key(|job| place(job));
    once.dedup_by_key(|job| place(job));
    once.par_iter().try_for_each(|job| {
        build::firmware(job.subject, job.core, job.variant, true, &place(job)).map(|_| ())
    })
}

fn one(job: &Job, plugin: &Path, work: &Path) -> Result<Figures, Problem> {
    let Job { subject, core, variant, expected, .. } = *job;
    let what = format!("{} on {} as {}", subject.case, core.name(), variant.name());
    let firmware =
        build::firmware(subject, core, variant, false, &build::place(work, subject, core, variant, false))?;
    let empty =
        build::firmware(subject, core, variant, true, &build::place(work, subject, core, variant, true))?;
    if let Some(expected) = expected {
        let found = machine::emulate(&what, core, &firmware, "sweep", &job.sweeps)?;
        if found != expected {
            return Err(Problem::Digest {
                what,
                inputs: job.sweeps.iter().map(|s| s.count).sum(),
                found: format!("{found:016x}"),
                expected: format!("{expected:016x}"),
            });
        }
    }
    let (with, without) = (build::bytes(&firmware)?, build::bytes(&empty)?);
    let symbol = variant.symbol(subject);
    let count = |sweeps: &[Sweep]| machine::observe(&what, core, &firmware, plugin, &symbol, sweeps);
    let (inside, call, stack) = count(&inside(subject))?;
    let (anywhere, _, deeper) = count(&[Sweep { first: 0, count: 1021, stride: u32::MAX / 1021 }])?;
    // A call's own instructions and the one of the function that does nothing, which is its return.
    let body = |instructions: u64| instructions - call.fewest;
    Ok(Figures {
        inside: [body(inside.fewest), body(inside.most)],
        anywhere: [body(anywhere.fewest.min(inside.fewest)), body(anywhere.most.max(inside.most))],
        flash_bytes: with.0 - without.0,
        // Without a state nothing is kept: what differs is how the linker aligns.
        ram_bytes: if subject.state { with.1 - without.1 } else { 0 },
        stack_bytes: stack.max(deeper),
    })
}

/// Inputs inside the range of every case: the middle half of an integer's range, floats up to 1/4 mm (the least
/// of them 2⁻⁸ mm, so that nothing becomes subnormal).
fn inside(subject: &Subject) -> Vec<Sweep> {
    let spread = |first: u32, last: u32, count: u32| Sweep {
        first,
        count: count.into(),
        stride: (last - first) / count,
    };
    match (subject.argument.as_str(), subject.arguments) {
        // The reading is to and fro by 2²⁷ more.
        _ if subject.state => vec![Sweep { first: 0xe000_0000, count: 509, stride: 0x001f_ffff }],
        ("f32", _) => vec![spread(0x3b80_0000, 0x3e80_0000, 257), spread(0xbb80_0000, 0xbe80_0000, 257)],
        // The difference of the halves is half of a count's range at most.
        ("u16", 1) => vec![spread(0x4000, 0xc000, 509)],
        ("u16", _) => vec![Sweep { first: 0x6000_6000, count: 509, stride: 0x0020_003d }],
        ("u32", _) => vec![spread(0x60_0000, 0xa0_0000, 509)],
        ("i32", 1) => vec![
            Sweep { first: 0, count: 257, stride: 0x003f_ffff },
            Sweep { first: 0xc000_0000, count: 257, stride: 0x003f_ffff },
        ],
        // Two words: the first is scattered, and half of the differences lie inside whatever is done.
        _ => vec![Sweep { first: 0, count: 509, stride: 0x0081_0001 }],
    }
}
