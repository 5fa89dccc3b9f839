//! Vector table and reset of a Cortex-M without an operating system.

use crate::semihosting;

unsafe extern "C" {
    static data_load: u32;
    static mut data_start: u32;
    static mut data_end: u32;
    static mut bss_start: u32;
    static mut bss_end: u32;
    static mut stack_top: u32;
}

#[repr(C)]
struct Vectors {
    stack: *mut u32,
    handlers: [Option<extern "C" fn() -> !>; 15],
}

// SAFETY: read by the processor only.
unsafe impl Sync for Vectors {}

#[used]
#[unsafe(link_section = ".vectors")]
static VECTORS: Vectors = {
    let mut handlers: [Option<extern "C" fn() -> !>; 15] = [None; 15];
    handlers[0] = Some(reset);
    let mut i = 1;
    while i < 6 {
        handlers[i] = Some(fault);
        i += 1;
    }
    Vectors { stack: &raw mut stack_top, handlers }
};

#[unsafe(no_mangle)]
extern "C" fn reset() -> ! {
    // SAFETY: before anything else runs; the linker script gives the ends. CPACR: full access to coprocessors
    // 10 and 11, the floating-point unit.
    unsafe {
        #[cfg(target_abi = "eabihf")]
        {
            let cpacr = 0xe000_ed88 as *mut u32;
            cpacr.write_volatile(cpacr.read_volatile() | 0xf << 20);
            core::arch::asm!("dsb", "isb");
        }
        let (mut from, mut to) = (&raw const data_load, &raw mut data_start);
        while to < &raw mut data_end {
            to.write_volatile(from.read_volatile());
            (from, to) = (from.add(1), to.add(1));
        }
        let mut to = &raw mut bss_start;
        while to < &raw mut bss_end {
            to.write_volatile(0);
            to = to.add(1);
        }
    }
    crate::firmware()
}

/// Any fault ends the run with a code that no check gives.
extern "C" fn fault() -> ! {
    semihosting::exit(99)
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    semihosting::exit(98)
}
