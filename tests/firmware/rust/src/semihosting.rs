//! Arm's semihosting, IHI 0100: an operation in r0, its argument block in r1, `bkpt 0xab`.

use core::arch::asm;

const SYS_OPEN: usize = 0x01;
const SYS_WRITE: usize = 0x05;
const SYS_GET_CMDLINE: usize = 0x15;
const SYS_EXIT_EXTENDED: usize = 0x20;
/// ADP_Stopped_ApplicationExit.
const APPLICATION_EXIT: usize = 0x2_0026;

fn call(operation: usize, block: &[usize]) -> usize {
    let result;
    // SAFETY: the host reads the block and what it points at.
    unsafe { asm!("bkpt 0xab", inout("r0") operation => result, in("r1") block.as_ptr(), options(nostack)) }
    result
}

/// Writes to the host's standard output.
pub fn write(text: &[u8]) {
    // ":tt", opened for writing, is standard output.
    let output = call(SYS_OPEN, &[c":tt".as_ptr() as usize, 4, 3]);
    call(SYS_WRITE, &[output, text.as_ptr() as usize, text.len()]);
}

/// The command line; empty where there is none.
pub fn command_line(line: &mut [u8; 256]) -> &[u8] {
    if call(SYS_GET_CMDLINE, &[line.as_mut_ptr() as usize, line.len()]) != 0 {
        return &[];
    }
    let length = line.iter().position(|c| *c == 0).unwrap_or(0);
    &line[..length]
}

/// Ends the run.
pub fn exit(code: usize) -> ! {
    call(SYS_EXIT_EXTENDED, &[APPLICATION_EXIT, code]);
    loop {}
}
