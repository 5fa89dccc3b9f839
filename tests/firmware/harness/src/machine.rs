//! The emulated cores: runs firmware under QEMU.

use std::path::Path;
use std::process::Command;

use serde::{Deserialize, Serialize};

use crate::problem::Problem;
use crate::run::run;

/// A core that firmware is built for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Core {
    /// Cortex-M0: no long multiplication, no floating point. BBC micro:bit.
    M0,
    /// Cortex-M3: no floating point. MPS2 with AN385.
    M3,
    /// Cortex-M4 with a single-precision unit. MPS2 with AN386.
    M4f,
    /// Cortex-M7 with units of both precisions. MPS2 with AN500.
    M7,
    /// Cortex-M33 with the DSP extension and a single-precision unit. MPS2 with AN505.
    M33,
}

impl Core {
    /// All of them.
    pub const ALL: [Core; 5] = [Core::M0, Core::M3, Core::M4f, Core::M7, Core::M33];

    /// As in the Makefile and the table.
    pub fn name(self) -> &'static str {
        match self {
            Core::M0 => "m0",
            Core::M3 => "m3",
            Core::M4f => "m4f",
            Core::M7 => "m7",
            Core::M33 => "m33",
        }
    }

    /// Rust's name of the target.
    pub fn rust_target(self) -> &'static str {
        match self {
            Core::M0 => "thumbv6m-none-eabi",
            Core::M3 => "thumbv7m-none-eabi",
            Core::M4f | Core::M7 => "thumbv7em-none-eabihf",
            Core::M33 => "thumbv8m.main-none-eabihf",
        }
    }

    fn machine(self) -> &'static str {
        match self {
            Core::M0 => "microbit",
            Core::M3 => "mps2-an385",
            Core::M4f => "mps2-an386",
            Core::M7 => "mps2-an500",
            Core::M33 => "mps2-an505",
        }
    }
}

/// Inputs by their number: `first`, `first` + `stride`, …, `count` of them, modulo 2³².
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sweep {
    /// The first.
    pub first: u32,
    /// How many.
    pub count: u64,
    /// From one to the next.
    pub stride: u32,
}

impl Sweep {
    /// As the firmware reads it.
    pub fn words(&self) -> [String; 3] {
        [format!("{:x}", self.first), format!("{:x}", self.count), format!("{:x}", self.stride)]
    }
}

/// What the plugin saw of the calls of one function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Observed {
    /// Calls.
    pub calls: u64,
    /// Fewest instructions of one.
    pub fewest: u64,
    /// Most instructions of one.
    pub most: u64,
    /// Instructions of all.
    pub sum: u64,
}

/// Runs the firmware on `core` with a command and gives the number that it prints.
///
/// # Errors
/// [`Problem`] where it does not run to its end.
pub fn emulate(
    what: &str,
    core: Core,
    firmware: &Path,
    command: &str,
    sweeps: &[Sweep],
) -> Result<u64, Problem> {
    let text = run(what, &mut qemu(core, firmware, command, sweeps))?;
    number(what, &text)
}

/// The same on the host.
///
/// # Errors
/// [`Problem`] where it does not run to its end.
pub fn on_host(what: &str, program: &Path, sweeps: &[Sweep]) -> Result<u64, Problem> {
    let words = sweeps.iter().flat_map(Sweep::words);
    let text = run(what, Command::new(program).arg("sweep").args(words))?;
    number(what, &text)
}

/// Counts the calls of `routine`, a symbol of the firmware; the second is what a call costs by itself. The
/// number is the bytes of stack.
///
/// # Errors
/// [`Problem`] where the firmware or the plugin does not run to its end.
pub fn observe(
    what: &str,
    core: Core,
    firmware: &Path,
    plugin: &Path,
    routine: &str,
    sweeps: &[Sweep],
) -> Result<(Observed, Observed, u64), Problem> {
    let symbols = run(what, Command::new("arm-none-eabi-nm").arg(firmware))?;
    let address = |name: &str| {
        let line = symbols.lines().find(|l| l.split_whitespace().nth(2) == Some(name));
        line.and_then(|l| u64::from_str_radix(l.split_whitespace().next()?, 16).ok())
            .ok_or_else(|| Problem::Content { path: firmware.into(), message: format!("no symbol {name}") })
    };
    let report = firmware.with_extension("observed");
    let (entry, nothing, exit) = (address(routine)?, address("nothing")?, address("called_back")?);
    let mut command = qemu(core, firmware, "observe", sweeps);
    let plugin = plugin.display();
    command.arg("-plugin").arg(format!(
        "{plugin},entry={entry:#x},entry={nothing:#x},exit={exit:#x},report={}",
        report.display()
    ));
    let stack = number(what, &run(what, &mut command)?)?;
    let text = std::fs::read_to_string(&report).map_err(Problem::file(&report))?;
    let mut lines = text.lines().map(observed);
    match (lines.next().flatten(), lines.next().flatten()) {
        (Some(routine), Some(nothing)) if routine.calls > 0 && nothing.calls > 0 => {
            Ok((routine, nothing, stack))
        }
        _ => Err(Problem::Content { path: report, message: format!("no calls were counted:\n{text}") }),
    }
}

fn observed(line: &str) -> Option<Observed> {
    let mut numbers = line.split_whitespace().skip(1).map(|n| n.parse().ok());
    let mut next = || numbers.next().flatten();
    Some(Observed { calls: next()?, fewest: next()?, most: next()?, sum: next()? })
}

fn qemu(core: Core, firmware: &Path, command: &str, sweeps: &[Sweep]) -> Command {
    let words = sweeps.iter().flat_map(Sweep::words).map(|w| format!(",arg={w}")).collect::<String>();
    let mut qemu = Command::new("qemu-system-arm");
    qemu.args(["-M", core.machine(), "-nographic", "-monitor", "none", "-serial", "none"])
        .arg("-semihosting-config")
        .arg(format!("enable=on,target=native,arg=firmware,arg={command}{words}"))
        .arg("-kernel")
        .arg(firmware);
    qemu
}

fn number(what: &str, text: &str) -> Result<u64, Problem> {
    u64::from_str_radix(text.trim(), 16).map_err(|_| Problem::Content {
        path: what.into(),
        message: format!("the firmware printed {text:?}, not a number"),
    })
}
