//! Calls a generated routine on many inputs; `ROUTINE` is replaced by its name. Arguments and results travel
//! as the bits of 32-bit words.

trait Word: Copy {
    fn of(bits: u32) -> Self;
}

impl Word for u16 {
    fn of(bits: u32) -> Self {
        bits as u16
    }
}

impl Word for u32 {
    fn of(bits: u32) -> Self {
        bits
    }
}

impl Word for i32 {
    fn of(bits: u32) -> Self {
        bits as i32
    }
}

impl Word for f32 {
    fn of(bits: u32) -> Self {
        f32::from_bits(bits)
    }
}

trait Outcome {
    fn bits(self) -> (u32, bool);
}

impl Outcome for i32 {
    fn bits(self) -> (u32, bool) {
        (self as u32, true)
    }
}

impl Outcome for f32 {
    fn bits(self) -> (u32, bool) {
        (self.to_bits(), true)
    }
}

impl<T: Outcome> Outcome for Result<T, T> {
    fn bits(self) -> (u32, bool) {
        match self {
            Ok(value) => (value.bits().0, true),
            Err(value) => (value.bits().0, false),
        }
    }
}

trait Routine<Arguments> {
    fn call(&self, first: u32, second: u32) -> (u32, bool);
}

impl<A: Word, R: Outcome, F: Fn(A) -> R> Routine<(A,)> for F {
    fn call(&self, first: u32, _: u32) -> (u32, bool) {
        self(A::of(first)).bits()
    }
}

impl<A: Word, R: Outcome, F: Fn(A, A) -> R> Routine<(A, A)> for F {
    fn call(&self, first: u32, second: u32) -> (u32, bool) {
        self(A::of(first), A::of(second)).bits()
    }
}

fn run<Arguments>(routine: impl Routine<Arguments>, first: u32, second: u32) -> (u32, bool) {
    routine.call(first, second)
}

/// # Safety
/// All four pointers lead to `count` elements.
#[no_mangle]
pub unsafe extern "C" fn batch(
    count: usize,
    first: *const u32,
    second: *const u32,
    result: *mut u32,
    inside: *mut u8,
) {
    for i in 0..count {
        let (bits, is_inside) = run(angle::ROUTINE, *first.add(i), *second.add(i));
        *result.add(i) = bits;
        *inside.add(i) = u8::from(is_inside);
    }
}
