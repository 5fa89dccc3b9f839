//! Commands: `sweep FIRST COUNT STRIDE …` prints the digest over all the sweeps, 16 hexadecimal digits;
//! `observe FIRST COUNT STRIDE …` prints the bytes of stack that the routine takes. Numbers are hexadecimal
//! without 0x.
#![no_std]
#![no_main]

mod inputs;
mod observe;
mod routine;
mod semihosting;
mod start;

use inputs::{arguments, contribution, key};

#[inline(never)]
fn firmware() -> ! {
    let mut line = [0; 256];
    // The first word is the firmware's own name.
    let mut words = semihosting::command_line(&mut line).split(|c| *c == b' ').skip(1);
    let command = words.next().unwrap_or(&[]);
    let (mut digest, mut deepest, mut empty) = (0u64, 0, 0);
    loop {
        let (Some(first), Some(count), Some(stride)) = (words.next(), words.next(), words.next()) else {
            break;
        };
        let (first, count, stride) = (number(first) as u32, number(count), number(stride) as u32);
        match command {
            b"sweep" => digest = digest.wrapping_add(sweep(first, count, stride)),
            b"observe" => {
                deepest = observe::observe(false, first, count as u32, stride).max(deepest);
                empty = observe::observe(true, first, 1, stride);
            }
            _ => semihosting::exit(2),
        }
    }
    print(if command == b"sweep" { digest } else { u64::from(deepest - empty) });
    semihosting::exit(0)
}

/// The digest of the routine's outputs over `count` inputs: `first`, `first` + `stride`, … modulo 2³².
#[inline(never)]
fn sweep(first: u32, count: u64, stride: u32) -> u64 {
    #[cfg(state)]
    routine::begin(arguments(first));
    let routine = routine::under_test();
    let (mut digest, mut index) = (0u64, first);
    for _ in 0..count {
        let arguments = arguments(index);
        digest = digest.wrapping_add(contribution(key(arguments), routine::call(routine, arguments)));
        index = index.wrapping_add(stride);
    }
    digest
}

fn number(word: &[u8]) -> u64 {
    word.iter().fold(0, |value, c| {
        let digit = if *c <= b'9' { c - b'0' } else { c - b'a' + 10 };
        value << 4 | u64::from(digit & 0xf)
    })
}

fn print(value: u64) {
    let mut text = [b'\n'; 17];
    for (i, c) in text[..16].iter_mut().enumerate() {
        *c = b"0123456789abcdef"[(value >> (60 - 4 * i)) as usize & 0xf];
    }
    semihosting::write(&text);
}
