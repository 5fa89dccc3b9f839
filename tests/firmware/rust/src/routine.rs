//! The routine under test as functions of one signature, whatever its own.

include!(concat!(env!("OUT_DIR"), "/named.rs"));

#[cfg(one_argument)]
pub type Arguments = (Argument,);
#[cfg(not(one_argument))]
pub type Arguments = (Argument, Second);

#[cfg(flag)]
pub type Returned = Result<Value, Value>;
#[cfg(not(flag))]
pub type Returned = Value;

#[cfg(one_argument)]
pub type Called = fn(Argument) -> Returned;
#[cfg(not(one_argument))]
pub type Called = fn(Argument, Second) -> Returned;

/// The generated function, with a name that an observer finds.
#[cfg(all(one_argument, not(empty), not(state)))]
#[unsafe(no_mangle)]
#[inline(never)]
fn routine(first: Argument) -> Returned {
    generated_routine(first)
}

#[cfg(all(not(one_argument), not(empty), not(state)))]
#[unsafe(no_mangle)]
#[inline(never)]
fn routine(first: Argument, second: Second) -> Returned {
    generated_routine(first, second)
}

#[cfg(all(state, not(empty)))]
static mut STATE: GeneratedRoutine = GeneratedRoutine::new(0, 0);

/// The same of a routine that keeps a state, which the caller has.
#[cfg(all(state, not(empty)))]
#[unsafe(no_mangle)]
#[inline(never)]
fn routine(state: &mut GeneratedRoutine, first: Argument, second: Second) -> Returned {
    state.update(first, second)
}

#[cfg(all(state, not(empty)))]
fn next(first: Argument, second: Second) -> Returned {
    // SAFETY: there is one thread, and nothing else holds the state.
    routine(unsafe { &mut *(&raw mut STATE) }, first, second)
}

/// Begins a sequence of calls.
#[cfg(state)]
#[inline(never)]
pub fn begin(_arguments: Arguments) {
    // SAFETY: as above.
    #[cfg(not(empty))]
    unsafe {
        STATE = GeneratedRoutine::new(_arguments.0, _arguments.1);
    }
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
    #[cfg(all(state, not(empty)))]
    static UNDER_TEST: Called = next;
    #[cfg(all(not(state), not(empty)))]
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
