//! Klipper.

use codegen::generate::Generated;
use codegen::tables::klipper::{ANGLES, adjusted, load_calibration};
use codegen::tables::{Firmware, Wanted};

use super::device::{COUNTS, Device, READINGS, Random, fitted};
use super::{Compared, devices, entry, fixtures, left, lines, table, worst, zero};

const FILE: &str = "angle_calibrate.cfg";
const STEPS: usize = 200;

fn wanted(entries: Option<usize>) -> Wanted {
    Wanted { entries, ..Wanted::default() }
}

/// The list, from the smallest angle on as Klipper turns it, and where that was: it has to be among the first four, and the
/// list has to rise at its end, or Klipper takes it for one of a sensor that turns the other way.
fn parsed(generated: &Generated) -> (Vec<f64>, usize) {
    let text = lines(generated, FILE, "#").join("");
    let list = text.strip_prefix("calibrate =").unwrap();
    let mut angles: Vec<f64> = list.split(',').map(|angle| angle.trim().parse().unwrap()).collect();
    let least = angles.iter().copied().fold(f64::INFINITY, f64::min);
    let first = angles.iter().position(|angle| *angle == least).unwrap();
    assert!(first < 4 && angles[angles.len() - 2] < angles[angles.len() - 1]);
    angles.rotate_left(first);
    assert!(angles.windows(2).all(|pair| pair[0] < pair[1]));
    (angles, first)
}

/// All angles of a sensor with so many counts, in turns.
fn results(calibration: &[i64], counts: u32) -> Vec<f64> {
    let angle = |count: u32| i64::from(count) * i64::from(ANGLES / counts);
    (0..counts).map(|count| adjusted(calibration, angle(count)) as f64 / f64::from(ANGLES)).collect()
}

/// `ANGLE_CALIBRATE`: the mean angle of each full step, printed with one decimal. The smallest comes first.
fn own_calibration(device: &Device, random: &mut Random) -> Vec<i64> {
    let turn = f64::from(ANGLES);
    let mut angles: Vec<f64> = (0..STEPS)
        .map(|step| {
            let near = device.reading(step as f64 / STEPS as f64, random);
            let readings = READINGS / STEPS;
            // Klipper counts its angles on over the end of the turn.
            let of = |_| {
                let off = device.reading(step as f64 / STEPS as f64, random) - near;
                off - off.round()
            };
            let mean = near + (0..readings).map(of).sum::<f64>() / readings as f64;
            ((turn * mean).rem_euclid(turn - 1.0) * 10.0).round() / 10.0
        })
        .collect();
    angles.sort_by(f64::total_cmp);
    load_calibration(&angles).0
}

#[test]
fn every_angle_is_within_the_bound_and_the_bound_within_a_tenth_of_the_worst() {
    for (device, mut random) in devices() {
        let steps = [200, 200, 400, 128][(4.0 * random.uniform()) as usize];
        let file = device.coefficients();
        let generated = table(Firmware::Klipper, &file, ANGLES, wanted(Some(steps)), None).unwrap();
        let (angles, first) = parsed(&generated);
        assert_eq!(angles.len(), steps);
        let (bound, zero) = (entry(&generated).bound, zero(&generated));
        let (calibration, off) = load_calibration(&angles);
        assert!(off < 0.1, "the fit is {off} from whole numbers");
        let found = worst(&file, &results(&calibration, ANGLES), zero);
        assert!(found <= bound, "{found} > {bound}");
        assert!(1.1 * found >= bound, "{found}, and {bound} is claimed");
        // Five 65536ths at most: one of the arithmetic, the rest of entries and lines.
        assert!(bound < 5.0 * 360.0 / f64::from(ANGLES), "{bound}");
        // Step `first` of the reference has the smallest angle, up to a multiple of four.
        let counted = (-zero / 360.0 * steps as f64).round().rem_euclid(steps as f64) as usize;
        assert_eq!(counted % 4, first);
    }
}

#[test]
fn its_own_calibration_leaves_more() {
    let mut compared = Compared::default();
    for (device, mut random) in devices() {
        let rows = device.calibration(&mut random);
        let generated = table(Firmware::Klipper, &fitted(&rows), ANGLES, wanted(None), None).unwrap();
        let of = |calibration: &[i64]| left(&device, &results(calibration, COUNTS));
        let ours = load_calibration(&parsed(&generated).0).0;
        compared.add(of(&ours), of(&own_calibration(&device, &mut random)));
    }
    compared.print("Klipper");
}

#[test]
fn what_it_cannot_hold_is_refused_in_one_message() {
    let usual = fixtures::encoder(360.0, 0.0, &[0.5, 0.0]);
    let refused = |file, entries, bound| {
        table(Firmware::Klipper, file, ANGLES, wanted(entries), bound).unwrap_err().to_string()
    };
    for steps in [100, 202, 2000] {
        let said = refused(&usual, Some(steps), None);
        assert!(
            said.starts_with(&format!("{steps} full steps for the 64 entries that Klipper fits")),
            "{said}"
        );
    }
    let said = refused(&usual, None, Some(1e-4));
    assert!(said.contains("the table of klipper (64 entries, whole 65536ths of a turn"), "{said}");
    let mut linear = usual.clone();
    linear.turn = None;
    assert!(refused(&linear, None, None).starts_with("klipper corrects an encoder over its turn"));
}

/// The sensor's zero anywhere, and just where Klipper's arithmetic has its seams.
#[test]
fn the_list_is_right_wherever_the_turn_begins() {
    for zero_at in
        (0..40).map(|k| 0.09 * f64::from(k)).chain([0.0, 1e-4, -1e-4, 1.8 - 1e-4, 1.8 + 1e-4, 359.9999])
    {
        let file = fixtures::encoder(360.0, zero_at, &[0.3, 0.1, 0.05, -0.02]);
        let generated = table(Firmware::Klipper, &file, ANGLES, wanted(None), None).unwrap();
        let calibration = load_calibration(&parsed(&generated).0).0;
        let found = worst(&file, &results(&calibration, ANGLES), zero(&generated));
        assert!(
            found <= entry(&generated).bound && found < 5.0 * 360.0 / f64::from(ANGLES),
            "{zero_at}: {found}"
        );
    }
}
