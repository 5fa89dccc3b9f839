//! One run of the program: a process of its own, with limits, and what it used.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Read, Seek};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

/// What a process may use; it ends by a signal where it wants more.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Address space in bytes; an allocation beyond it fails.
    pub memory: u64,
    /// Seconds of processor time: other load on the machine does not count.
    pub seconds: u64,
}

impl Limits {
    /// Of a case.
    pub const CASE: Limits = Limits { memory: 2 << 30, seconds: 10 };
    /// Of a search through all routines.
    pub const SEARCH: Limits = Limits { seconds: 60, ..Limits::CASE };
    /// A file larger than this is none that a case should write, in bytes.
    const FILE: u64 = 256 << 20;
    /// A process that neither computes nor ends is stuck after so many seconds.
    const STUCK: u32 = 600;
}

/// How a process ended.
#[derive(Debug)]
pub struct Outcome {
    /// Its exit code, unless a signal ended it.
    pub code: Option<i32>,
    /// The signal that ended it.
    pub signal: Option<i32>,
    /// What it printed.
    pub stdout: Vec<u8>,
    /// What it said.
    pub stderr: Vec<u8>,
    /// Seconds until it ended.
    pub seconds: f64,
    /// Largest resident memory in bytes.
    pub memory: u64,
}

/// Runs `program` in `folder`, with nothing on its standard input and one thread unless it is told otherwise;
/// `full`: its standard output is a full device.
///
/// # Errors
/// Where the process could not be started or watched.
pub fn run(
    program: &Path,
    folder: &Path,
    arguments: &[OsString],
    limits: Limits,
    full: bool,
) -> io::Result<Outcome> {
    let (mut stdout, mut stderr) = (tempfile::tempfile()?, tempfile::tempfile()?);
    let mut command = Command::new(program);
    command.current_dir(folder).args(arguments).env("RAYON_NUM_THREADS", "1").stdin(Stdio::null());
    command.stdout(if full { File::options().write(true).open("/dev/full")? } else { stdout.try_clone()? });
    command.stderr(stderr.try_clone()?);
    // SAFETY: between fork and exec only system calls that are safe in signal handlers; no memory is touched.
    unsafe { command.pre_exec(move || confine(limits)) };
    let begun = Instant::now();
    let child = command.spawn()?;
    let mut status = 0;
    // SAFETY: `rusage` is plain integers, for which zeros are a value.
    let mut used: libc::rusage = unsafe { std::mem::zeroed() };
    // SAFETY: both pointers are to living variables; the child is waited for nowhere else.
    if unsafe { libc::wait4(child.id() as libc::pid_t, &mut status, 0, &mut used) } < 0 {
        return Err(io::Error::last_os_error());
    }
    let seconds = begun.elapsed().as_secs_f64();
    let text = |file: &mut File| -> io::Result<Vec<u8>> {
        let mut text = Vec::new();
        file.rewind()?;
        file.read_to_end(&mut text)?;
        Ok(text)
    };
    Ok(Outcome {
        code: libc::WIFEXITED(status).then(|| libc::WEXITSTATUS(status)),
        signal: libc::WIFSIGNALED(status).then(|| libc::WTERMSIG(status)),
        stdout: text(&mut stdout)?,
        stderr: text(&mut stderr)?,
        seconds,
        memory: used.ru_maxrss as u64 * 1024,
    })
}

/// Sets the limits of this process, which the program inherits.
fn confine(limits: Limits) -> io::Result<()> {
    let set = |resource, value| {
        let limit = libc::rlimit { rlim_cur: value, rlim_max: value };
        // SAFETY: the pointer is to a living variable.
        match unsafe { libc::setrlimit(resource, &limit) } {
            0 => Ok(()),
            _ => Err(io::Error::last_os_error()),
        }
    };
    set(libc::RLIMIT_AS, limits.memory)?;
    set(libc::RLIMIT_CPU, limits.seconds)?;
    set(libc::RLIMIT_FSIZE, Limits::FILE)?;
    set(libc::RLIMIT_CORE, 0)?;
    // SAFETY: no pointers.
    unsafe { libc::alarm(Limits::STUCK) };
    Ok(())
}
