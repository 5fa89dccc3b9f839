//! moteus.

use codegen::tables::moteus::{Compensation, ENTRIES};
use codegen::tables::single::Fused;
use codegen::tables::{Firmware, TableError, Wanted};

use super::compiled::Sources;
use super::device::{COUNTS, Device, Random, fitted};
use super::{Compared, devices, entry, fixtures, left, lines, table, worst, zero};

const FILE: &str = "compensation.cfg";

/// The configuration as the file has it.
fn parsed(lines: &[&str], source: u32) -> Compensation {
    let mut found = Compensation { table: vec![0; ENTRIES], scale: 0.0 };
    let of_source = format!("motor_position.sources.{source}.compensation_");
    for line in lines {
        let (key, value) = line.strip_prefix(&of_source).unwrap().split_once(' ').unwrap();
        match key.strip_prefix("table.") {
            Some(index) => found.table[index.parse::<usize>().unwrap()] = value.parse().unwrap(),
            None => found.scale = value.parse().unwrap(),
        }
    }
    assert_eq!(lines.len(), ENTRIES + 1);
    found
}

/// All counts in turns.
fn results(of: &Compensation, counts: u32, fused: Fused) -> Vec<f64> {
    (0..counts).map(|count| f64::from(of.compensated(count, counts, fused)) / f64::from(counts)).collect()
}

/// `utils/compensate_encoder.py --reference-encoder` of the same commit: the circular mean is taken off, the errors are
/// sorted by the reading and interpolated at i/256, and cut to whole parts of the largest.
fn own_calibration(rows: &[(f64, f64)]) -> Compensation {
    let apart = |row: &(f64, f64)| (std::f64::consts::TAU * (row.1 - row.0)).sin_cos();
    let (sine, cosine) = rows.iter().map(apart).fold((0.0, 0.0), |sum, (s, c)| (sum.0 + s, sum.1 + c));
    let offset = sine.atan2(cosine) / std::f64::consts::TAU;
    let wrapped = |turns: f64| turns - turns.round();
    let mut errors: Vec<(f64, f64)> = rows
        .iter()
        .map(|(measured, reference)| (*measured, -wrapped(reference - offset - measured)))
        .collect();
    errors.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let wanted = |index: usize| {
        let place = index as f64 / ENTRIES as f64;
        let after = errors.partition_point(|error| error.0 <= place);
        let (last, count) = (errors[errors.len() - 1], errors.len());
        let left = if after == 0 { (last.0 - 1.0, last.1) } else { errors[after - 1] };
        let right = if after == count { (errors[0].0 + 1.0, errors[0].1) } else { errors[after] };
        -(left.1 + (right.1 - left.1) * (place - left.0) / (right.0 - left.0))
    };
    let wanted: Vec<f64> = (0..ENTRIES).map(wanted).collect();
    let scale = wanted.iter().fold(0.0f64, |most, value| most.max(value.abs()));
    // Python's int() cuts toward zero.
    let table = wanted.iter().map(|value| (127.0 * value / scale) as i8).collect();
    Compensation { table, scale: scale as f32 }
}

#[test]
fn every_count_is_within_the_bound_and_the_bound_within_a_tenth_of_the_worst() {
    for (device, mut random) in devices() {
        let counts = [4000, 4096, COUNTS, 65_536][(4.0 * random.uniform()) as usize];
        let file = device.coefficients();
        let generated = table(Firmware::Moteus, &file, counts, Wanted::default(), None).unwrap();
        let chosen = parsed(&lines(&generated, FILE, "#"), 0);
        let (bound, zero) = (entry(&generated).bound, zero(&generated));
        let seen = Fused::ALL.map(|fused| worst(&file, &results(&chosen, counts, fused), zero));
        for found in seen {
            assert!(found <= bound, "{counts} counts: {found} > {bound}");
            assert!(1.1 * found >= bound, "{counts} counts: {found}, and {bound} is claimed");
        }
        // Rounding to the nearest of the smallest step is half a step; more is given away nowhere.
        let step = f64::from(chosen.scale) / 127.0 * 360.0;
        assert!(bound < 0.56 * step, "{bound} of a step of {step}");
    }
}

#[test]
fn its_own_calibration_leaves_more() {
    let mut compared = Compared::default();
    for (device, mut random) in devices() {
        let rows = device.calibration(&mut random);
        let generated = table(Firmware::Moteus, &fitted(&rows), COUNTS, Wanted::default(), None).unwrap();
        let of = |chosen: &Compensation| left(&device, &results(chosen, COUNTS, Fused::ALL[0]));
        compared.add(of(&parsed(&lines(&generated, FILE, "#"), 0)), of(&own_calibration(&rows)));
    }
    compared.print("moteus");
}

#[test]
fn the_firmwares_own_code_gives_the_same_bits() {
    let Some(sources) = Sources::of("moteus", "https://github.com/mjbots/moteus") else { return };
    let header = sources.read("fw/motor_position.h");
    let functions: String =
        ["static float WrapCpr(float value, float cpr, float inv_cpr)", "static float lerp("]
            .iter()
            .map(|begin| sources.function(&header, begin))
            .map(|text| text.replace("MOTEUS_CCM_ATTRIBUTE", "") + "\n")
            .collect();
    let functions = functions.replace("static float lerp(", "template <typename Array>\nstatic float lerp(");
    let device = Device::draw(&mut Random::new(7));
    let generated = table(Firmware::Moteus, &device.coefficients(), COUNTS, Wanted::default(), None).unwrap();
    let chosen = parsed(&lines(&generated, FILE, "#"), 0);
    let entries: Vec<String> = chosen.table.iter().map(i8::to_string).collect();
    let program = format!(
        "#include <algorithm>\n#include <array>\n#include <cstdint>\n#include <cstdio>\n{functions}\n\
         int main() {{ std::array<int8_t, 256> table = {{{}}}; const float scale = {:?}f, cpr = {COUNTS}, inv = 1.0f / cpr;\n\
         for (uint32_t count = 0; count < {COUNTS}; count++) std::printf(\"%a\\n\", WrapCpr(count + \
         lerp(table, scale / 127.0f, static_cast<float>(count) * inv) * cpr, cpr, inv)); }}\n",
        entries.join(", "),
        chosen.scale,
    );
    let printed = sources.run(&program);
    let ours: Vec<f64> = (0..COUNTS).map(|c| chosen.compensated(c, COUNTS, Fused::ALL[0]).into()).collect();
    assert_eq!(printed, ours);
}

#[test]
fn what_it_cannot_hold_is_refused_in_one_message() {
    let usual = fixtures::encoder(360.0, 0.0, &[0.5, 0.0]);
    let refused =
        |file, wanted, bound| table(Firmware::Moteus, file, COUNTS, wanted, bound).unwrap_err().to_string();
    let mut linear = usual.clone();
    linear.turn = None;
    let said = refused(&linear, Wanted::default(), None);
    assert!(
        said.starts_with("moteus corrects an encoder over its turn, and these coefficients are not"),
        "{said}"
    );
    let said = refused(&usual, Wanted { source: Some(3), ..Wanted::default() }, None);
    assert!(said.starts_with("there is no source 3"), "{said}");
    let said = refused(&usual, Wanted::default(), Some(1e-4));
    assert!(
        said.starts_with("the bound is 1.000e-4 deg, and the table of moteus (256 entries, int8"),
        "{said}"
    );
    let steep = fixtures::encoder(360.0, 0.0, &[80.0, 0.0]);
    let error = table(Firmware::Moteus, &steep, COUNTS, Wanted::default(), None).unwrap_err();
    assert!(matches!(error, TableError::NotAccepted(_)), "{error}");
    // Nothing to correct: the firmware leaves the count as it is.
    let none = fixtures::encoder(360.0, 12.0, &[0.0, 0.0]);
    let generated = table(Firmware::Moteus, &none, COUNTS, Wanted::default(), None).unwrap();
    assert!(entry(&generated).bound < 1e-9 && zero(&generated) == 12.0);
}
