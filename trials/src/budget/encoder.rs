//! Encoders of 14 bits: harmonics of the turn, play and lag, read while they turn at one speed in both directions.

use codegen::options::Options;
use codegen::turn;
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha12Rng;
use twin::encoder::{Encoder, Row, Turning, record, write_csv};

use super::reference::{ONE, Reference};
use super::{Fresh, TENTHS, Trial};

const ACCURACY_DEG: f64 = 0.01;
const TURN_DEG: f64 = 360.0;
const BITS: u32 = 14;

pub fn simulate(generator: &mut ChaCha12Rng) -> Trial {
    let encoder = Encoder::from_seed(generator.random());
    let reference = Reference::draw(ACCURACY_DEG, ONE, generator);
    // At one speed: what the directions differ by is then one number, play and lag together.
    let turning = Turning { speed_factor: 1.0, ..Turning::default() };
    let mut rows = record(&encoder, &turning, generator.random());
    for row in &mut rows {
        row.reference = (row.reference + reference.error(row.reference / TURN_DEG)).rem_euclid(TURN_DEG);
    }
    let mut csv = Vec::new();
    // Writing into memory has no way to fail.
    let _ = write_csv(&rows, &mut csv);
    // The truth is what a reference without noise reads.
    let known = Encoder { reference_noise_deg: 0.0, ..encoder.clone() };
    let one = |row: Row| {
        let tenth = (TENTHS as f64 * row.reference / TURN_DEG) as usize;
        let counts = f64::from(1u32 << BITS);
        let word = (row.measured / TURN_DEG * counts).round().rem_euclid(counts) as i64;
        Fresh {
            tenth: tenth.min(TENTHS - 1),
            place: row.reference,
            word,
            further: None,
            truth: row.reference,
        }
    };
    let mut fresh: Vec<Fresh> = record(&known, &turning, generator.random()).into_iter().map(one).collect();
    // Of any pass, so of either direction.
    fresh.shuffle(generator);
    Trial {
        csv,
        mirror: format!(
            "[sensor]\nkind = \"direct\"\nunit = \"deg\"\nrevolution = {TURN_DEG:?}\n[reference]\naccuracy = \
             {ACCURACY_DEG:?}\nrepeatability = {:?}\n",
            encoder.reference_noise_deg
        ),
        diagnosed: false,
        options: Options {
            encoder: turn::Encoder { bits: Some(BITS), ..turn::Encoder::default() },
            ..Options::default()
        },
        fresh: super::one_in_each(fresh),
        turn: Some(TURN_DEG),
        from_zero: false,
    }
}
