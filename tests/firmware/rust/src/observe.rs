//! Calls for an observer outside, and how deep they go into the stack; the same as `../c/observe.c`.

use core::arch::asm;

use crate::inputs::arguments;
use crate::routine::{Called, call, empty, under_test};

const PAINT: u32 = 0xa5c3_3c5a;

unsafe extern "C" {
    static mut stack_limit: u32;
}

/// Where the count of a call ends.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn called_back() {
    // SAFETY: nothing.
    unsafe { asm!("") }
}

#[inline(never)]
fn call_all(function: Called, first: u32, count: u32, stride: u32) {
    #[cfg(state)]
    crate::routine::begin(arguments(first));
    for i in 0..count {
        let _ = call(function, arguments(first.wrapping_add(i.wrapping_mul(stride))));
        called_back();
    }
}

/// Calls the routine, or a function that does nothing, on `count` inputs: `first`, `first` + `stride`, …, and
/// gives the number of bytes of stack that this took.
#[inline(never)]
pub fn observe(nothing: bool, first: u32, count: u32, stride: u32) -> u32 {
    let top: *mut u32;
    // SAFETY: reads a register.
    unsafe { asm!("mov {}, sp", out(reg) top) }
    let limit = &raw mut stack_limit;
    // SAFETY: from the end of the data to the stack pointer there is memory that nothing uses.
    let free = unsafe { top.offset_from(limit) } as usize;
    for i in 0..free {
        // SAFETY: as above.
        unsafe { limit.add(i).write_volatile(PAINT) }
    }
    call_all(if nothing { empty() } else { under_test() }, first, count, stride);
    // SAFETY: as above.
    let untouched = (0..free).take_while(|i| unsafe { limit.add(*i).read_volatile() } == PAINT).count();
    4 * (free - untouched) as u32
}
