//! VESC.

use codegen::generate::Generated;
use codegen::tables::vesc::{ENTRIES, index};
use codegen::tables::{Firmware, Wanted};

use super::device::{COUNTS, Device, fitted};
use super::{Compared, devices, entry, fixtures, left, lines, table, worst, zero};

const FILE: &str = "enc_corr.lisp";

fn wanted(ratio: f64) -> Wanted {
    Wanted { ratio: Some(ratio), ..Wanted::default() }
}

/// The table as the script sets it.
fn parsed(generated: &Generated) -> Vec<i8> {
    let rows = lines(generated, FILE, ";");
    let set = rows.iter().filter_map(|row| row.strip_prefix("(enc-corr ")?.strip_suffix(')'));
    let mut table = vec![0; ENTRIES];
    for (place, row) in set.enumerate() {
        let (angle, value) = row.split_once(' ').unwrap();
        assert_eq!(angle.parse::<usize>().unwrap(), place);
        table[place] = value.parse().unwrap();
    }
    assert_eq!(
        (rows[0], &rows[ENTRIES + 1..]),
        ("(enc-corr-en 0)", &["(enc-corr-en 1)", "(store-backup)"][..])
    );
    table
}

/// The phase of every count as the firmware computes it in single precision, its offset being 0, brought back to turns of
/// the encoder.
fn results(table: &[i8], counts: u32, ratio: f32) -> Vec<f64> {
    let of = |count: u32| {
        let angle = (f64::from(count) * 360.0 / f64::from(counts)) as f32;
        let straight = if ratio < 0.0 { (360.0 - f64::from(angle)) as f32 } else { angle } * ratio.abs();
        let phase = straight - f32::from(table[index(count, counts)]);
        let encoder = f64::from(phase) / f64::from(ratio.abs()) / 360.0;
        if ratio < 0.0 { 1.0 - encoder } else { encoder }
    };
    (0..counts).map(of).collect()
}

/// After `enc_sample_task` in `lispBM/lispif_vesc_extensions.c`, which sums the phase's error by whole degrees: the mean of
/// each, rounded. The script that does the rest comes with VESC Tool, and was not read.
fn own_calibration(device: &Device, rows: &[(f64, f64)], ratio: f64) -> Vec<i8> {
    let mut sums = vec![(0.0, 0.0); ENTRIES];
    for (measured, reference) in rows {
        let off = measured - reference - device.zero;
        let sum = &mut sums[((measured * 360.0) as usize).min(ENTRIES - 1)];
        *sum = (sum.0 + 360.0 * ratio * (off - off.round()), sum.1 + 1.0);
    }
    sums.iter().map(|(sum, count)| (sum / count).round() as i8).collect()
}

#[test]
fn every_count_is_within_the_bound_and_the_bound_within_a_tenth_of_the_worst() {
    for (device, mut random) in devices() {
        let counts = [4000, 4096, COUNTS, 65_536][(4.0 * random.uniform()) as usize];
        let ratio = [1.0, 4.0, 7.0, -7.0, 21.0][(5.0 * random.uniform()) as usize];
        let file = device.coefficients();
        let generated = table(Firmware::Vesc, &file, counts, wanted(ratio), None).unwrap();
        let (bound, zero) = (entry(&generated).bound, zero(&generated));
        let found = worst(&file, &results(&parsed(&generated), counts, ratio as f32), zero);
        assert!(found <= bound, "{counts} counts, {ratio}: {found} > {bound}");
        assert!(1.1 * found >= bound, "{counts} counts, {ratio}: {found}, and {bound} is claimed");
    }
}

#[test]
fn its_own_calibration_leaves_more() {
    let mut compared = Compared::default();
    for (device, mut random) in devices() {
        let rows = device.calibration(&mut random);
        let generated = table(Firmware::Vesc, &fitted(&rows), COUNTS, wanted(7.0), None).unwrap();
        let of = |table: &[i8]| left(&device, &results(table, COUNTS, 7.0));
        compared.add(of(&parsed(&generated)), of(&own_calibration(&device, &rows, 7.0)));
    }
    compared.print("VESC");
}

#[test]
fn what_it_cannot_hold_is_refused_in_one_message() {
    let usual = fixtures::encoder(360.0, 0.0, &[0.5, 0.0]);
    let refused =
        |file, wanted, bound| table(Firmware::Vesc, file, COUNTS, wanted, bound).unwrap_err().to_string();
    let said = refused(&usual, Wanted::default(), None);
    assert!(said.starts_with("the table is in electrical degrees, and how many electrical turns"), "{said}");
    assert!(
        refused(&usual, wanted(0.5), None).starts_with("a ratio of 0.5; give foc_encoder_ratio, 1 or more")
    );
    let large = fixtures::encoder(360.0, 0.0, &[20.0, 0.0]);
    let said = refused(&large, wanted(7.0), None);
    assert!(
        said.starts_with("the correction reaches 140.0 electrical degrees either way, and an entry 120"),
        "{said}"
    );
    let said = refused(&usual, wanted(7.0), Some(0.01));
    assert!(
        said.starts_with("the bound is 1.000e-2 deg, and the table of vesc (360 entries, whole"),
        "{said}"
    );
    let mut linear = usual.clone();
    linear.turn = None;
    assert!(refused(&linear, wanted(7.0), None).starts_with("vesc corrects an encoder over its turn"));
}
