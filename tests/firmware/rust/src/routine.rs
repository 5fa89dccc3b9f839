//! The routine under test as functions of one signature, whatever its own.

include!(concat!(env!("OUT_DIR"), "/named.rs"));

#[cfg(one_argument)]
pub type Arguments = (Argument,);
#[cfg(not(one_argument))]
pub type Arguments = (Argument, Argument);

#[cfg(flag)]
pub type Returned = Result<Value, Value>;
#[cfg(not(flag))]
pub type Returned = Value;

#[cfg(one_argument)]
pub type Called = fn(Argument) -> Returned;
#[cfg(not(one_argument))]
pub type Called = fn(Argument, Argument) -> Returned;

/// The generated function, with a name that an observer finds.
#[cfg(all(one_argument, not(empty)))]
#[unsafe(no_mangle)]
#[inline(never)]
fn routine(first: Argument) -> Returned {
    generated_routine(first)
}

#[cfg(all(not(one_argument), not(empty)))]
#[unsafe(no_mangle)]
#[inline(never)]
fn routine(first: Argument, second: Argument) -> Returned {
    generated_routine(first, second)
}

/// One instruction, whatever the signature: its count is what a call costs by itself.
#[unsafe(no_mangle)]
#[unsafe(naked)]
extern "C" fn nothing() {
    core::arch::naked_asm!("bx lr")
}

/// The function that does nothing, as if it were the routine. Its result means nothing.
pub fn empty() -> Called {
    // SAFETY: it returns at once; what it leaves in the register or memory of the result is not looked at.
    unsafe { core::mem::transmute(nothing as *const ()) }
}

/// The routine, through a pointer that the compiler does not see through: all else is the same for every one.
pub fn under_test() -> Called {
    #[cfg(not(empty))]
    static UNDER_TEST: Called = routine;
    #[cfg(empty)]
    static UNDER_TEST: extern "C" fn() = nothing;
    // SAFETY: a static, properly aligned; of the same size, as in `empty`.
    unsafe { core::ptr::read_volatile((&raw const UNDER_TEST).cast()) }
}

/// Calls `function`.
#[inline(always)]
pub fn call(function: Called, arguments: Arguments) -> Returned {
    #[cfg(one_argument)]
    return function(arguments.0);
    #[cfg(not(one_argument))]
    return function(arguments.0, arguments.1);
}
