//! The fit as a library: what it finds on devices that are known.

use crate::common;

use common::{Device, PAPER, arcsec, direct, mirror, normal};
use fitter::{ErrorModel, Fitted, Options, Recording, Solver, choose_order, fit};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

fn given(order: usize) -> Options {
    Options { order: Some(order), ..Options::default() }
}

/// Largest difference of two models' corrected angles over the paper's range, a constant removed, in arcsec.
fn distance_arcsec(a: &ErrorModel, b: &ErrorModel) -> f64 {
    let difference = |s: f64| arcsec(a.corrected(s) - b.corrected(s));
    let grid: Vec<f64> = (-100..=100).map(|i| difference(0.00356 * f64::from(i))).collect();
    let mean = grid.iter().sum::<f64>() / grid.len() as f64;
    grid.iter().map(|d| (d - mean).abs()).fold(0.0, f64::max)
}

fn truth() -> ErrorModel {
    ErrorModel { sensor: mirror().sensor, centre: 0.0, coefficients: PAPER.to_vec() }
}

#[test]
fn the_papers_figures_on_the_embedded_recording() {
    let (recording, mirror) = fitter::default_recording().unwrap();
    let fit = fit(&recording, &mirror, &Options::default()).unwrap();
    let file = &fit.coefficients;
    let selection = file.order_selection.as_ref().unwrap();
    assert!((7..=11).contains(&file.base.order), "order {}", file.base.order);
    assert_eq!((selection.groups, selection.held_out_groups), (35, 11));
    // Figure 6: large below 3, and the testing error rises beyond the chosen order, above the training error.
    let testing = |order: usize| selection.curve[order - 1].testing;
    let training = |order: usize| selection.curve[order - 1].training;
    assert!(testing(1) > 10.0 && testing(2) > 5.0);
    assert!(testing(15) > 2.0 * testing(file.base.order) && testing(13) > 1.5 * training(13));
    assert!(selection.curve.windows(2).all(|pair| pair[1].training < 1.001 * pair[0].training));
    // 0.28° before; after, the averaged points are fitted to about half an arcsecond.
    let statistics = file.statistics.as_ref().unwrap();
    assert!((0.27..0.29).contains(&(statistics.before.max / 3600.0)));
    assert!(statistics.after.max_of_point_means < 1.0 && statistics.after.rms < 0.6);
    assert_eq!(statistics.points.len(), 35);
    assert!(distance_arcsec(&file.error_model(), &truth()) < 1.0);
}

#[test]
fn the_trust_region_finds_the_same_minimum() {
    let recording = Device::paper().recording(3);
    for order in 1..=15 {
        let qr = fit(&recording, &mirror(), &given(order)).unwrap();
        let options = Options { solver: Solver::TrustRegion, ..given(order) };
        let trust = fit(&recording, &mirror(), &options).unwrap();
        let (a, b) = (qr.coefficients.error_model(), trust.coefficients.error_model());
        for s in &qr.calibrated.reading {
            approx::assert_abs_diff_eq!(a.corrected(*s), b.corrected(*s), epsilon = 1e-10);
        }
    }
}

#[test]
fn the_powers_are_the_orthogonal_solution() {
    let recording = Device::paper().recording(4);
    for order in 1..=15 {
        let fit = fit(&recording, &mirror(), &given(order)).unwrap();
        let model = fit.coefficients.error_model();
        for (row, s) in fit.calibrated.reading.iter().enumerate() {
            let orthogonal = fit.calibrated.error[row] - fit.residual[row];
            approx::assert_abs_diff_eq!(model.error(*s), orthogonal, epsilon = 1e-10);
        }
    }
}

#[test]
fn only_a1_less_dd_over_d_is_determined() {
    let recording = Device::paper().recording(5);
    let fitted = fit(&recording, &mirror(), &given(9)).unwrap();
    let identification = fitted.coefficients.identification.as_ref().unwrap();
    let open = &identification.unidentifiable[0];
    assert!(open.statement.contains("only a1 - dd/d") && open.relative_singular_value < 1e-12);
    let moved: Vec<(&str, f64)> = open.direction.iter().map(|m| (m.parameter.as_str(), m.change)).collect();
    assert_eq!(moved.len(), 2, "{moved:?}");
    assert_eq!((moved[0].0, moved[1].0), ("dd", "a1"));
    approx::assert_abs_diff_eq!(moved[0].1, 1.0, epsilon = 1e-9);
    approx::assert_abs_diff_eq!(moved[1].1, 1.0 / 12.0, epsilon = 1e-8);

    // The paper's Δd = 0.073 mm frees a₁ and changes no angle.
    let options = Options { probe_distance_error_mm: Some(0.073), ..given(9) };
    let freed = fit(&recording, &mirror(), &options).unwrap();
    assert_eq!(freed.coefficients.base, fitted.coefficients.base);
    let identification = freed.coefficients.identification.as_ref().unwrap();
    assert!(identification.unidentifiable.is_empty());
    let of = |name: &str| identification.parameters.iter().find(|p| p.name == name).unwrap().value;
    approx::assert_abs_diff_eq!(of("a1"), of("a1 - dd/d") + 0.073 / 12.0, epsilon = 1e-15);
    assert_eq!(of("dd"), 0.073);
}

#[test]
fn averages_and_rows_agree_where_every_pass_has_every_angle() {
    let recording = Device::paper().recording(6);
    let rows = fit(&recording, &mirror(), &given(9)).unwrap();
    let averages = fit(&recording, &mirror(), &Options { fitted: Fitted::Averages, ..given(9) }).unwrap();
    assert!(
        !rows.coefficients.statistics.as_ref().unwrap().between_passes.as_ref().unwrap().weighted,
        "even noise was weighted"
    );
    let (a, b) = (rows.coefficients.error_model(), averages.coefficients.error_model());
    assert!(distance_arcsec(&a, &b) < 1e-3);
    assert!(averages.coefficients.identification.unwrap().fitted.contains("Eq. 7"));
}

/// The 95 % intervals hold the truth in 95 % of the cases: 400 recordings, 10 coefficients. Of 400, binomial
/// limits at one in ten thousand are 0.902 and 0.985.
#[test]
fn intervals_cover() {
    let device = Device::paper();
    let mut covered = [0; 10];
    for seed in 0..400 {
        let fit = fit(&device.recording(100 + seed), &mirror(), &given(9)).unwrap();
        let parameters = fit.coefficients.identification.unwrap().parameters;
        for (power, parameter) in parameters.iter().enumerate().skip(1) {
            let [low, high] = parameter.ci95.unwrap();
            covered[power] += i32::from(low <= PAPER[power] && PAPER[power] <= high);
        }
    }
    for (power, count) in covered.iter().enumerate().skip(1) {
        assert!((361..=394).contains(count), "a{power}: {count} of 400");
    }
}

/// Polynomials whose last coefficient stands out are recognised: never below the order, and at it mostly.
#[test]
fn the_order_of_a_clear_polynomial_is_found() {
    let polynomial = [0.0, 0.1, -0.05, 0.2, 0.1, -3.0];
    let device = Device { polynomial: &polynomial, ..Device::paper() };
    let orders: Vec<usize> = (0..60)
        .map(|seed| choose_order(&device.recording(seed), &mirror(), &Options::default()).unwrap().chosen)
        .collect();
    assert!(orders.iter().all(|order| *order >= 5), "{orders:?}");
    assert!(orders.iter().filter(|order| **order == 5).count() >= 48, "{orders:?}");
}

/// Where one pass alone reaches an edge, leaving it out does not make a high order look uncertain.
#[test]
fn the_order_of_unequal_passes_is_found() {
    let ends = [(-0.3, 1.0), (-1.0, 0.6), (-0.5, 0.5), (-0.6, 0.8), (-0.8, 0.4), (-0.4, 0.7)];
    let unequal = |seed: u64| {
        let text = Device::paper().csv(seed);
        let within = |line: &&str| {
            let fields: Vec<&str> = line.split(',').collect();
            let (pass, angle): (usize, f64) = (fields[1].parse().unwrap(), fields[3].parse().unwrap());
            let (from, to) = ends[(pass - 1) % ends.len()];
            (from * 1.5 - 0.01..=to * 1.5 + 0.01).contains(&angle)
        };
        let header = text.lines().next().unwrap();
        let rows: Vec<&str> = std::iter::once(header).chain(text.lines().skip(1).filter(within)).collect();
        Recording::from_bytes("unequal.csv", rows.join("\n").as_bytes()).unwrap()
    };
    for seed in 0..30 {
        let selection = choose_order(&unequal(seed), &mirror(), &Options::default()).unwrap();
        let testing = |order: usize| selection.curve[order - 1].testing;
        assert!(testing(selection.chosen) < 1.2 * testing(selection.smallest_testing_error), "{selection:?}");
    }
}

/// Noise that is eight times larger at one end is seen, weighted, and the fit is the better for it at the
/// quiet end.
#[test]
fn uneven_noise_is_weighted() {
    let device = Device { noise_arcsec: 0.0, ..Device::paper() };
    let uneven = |seed: u64| {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let text = device.csv(seed);
        let mut lines = text.lines();
        let mut out = format!("{}\n", lines.next().unwrap());
        for line in lines {
            let mut fields: Vec<String> = line.split(',').map(String::from).collect();
            let angle: f64 = fields[3].parse().unwrap();
            let noise = if angle > 0.5 { 4.0 } else { 0.5 } * normal(&mut random);
            fields[6] = format!("{}", fields[6].parse::<f64>().unwrap() + noise);
            out += &(fields.join(",") + "\n");
        }
        Recording::from_bytes("uneven.csv", out.as_bytes()).unwrap()
    };
    let (mut weighted, mut plain) = ([0.0f64; 2], [0.0f64; 2]);
    for seed in 0..30 {
        let recording = uneven(seed);
        let fit_of = |fitted| fit(&recording, &mirror(), &Options { fitted, ..given(9) }).unwrap();
        let (rows, averages) = (fit_of(Fitted::Rows), fit_of(Fitted::Averages));
        assert!(rows.coefficients.statistics.as_ref().unwrap().between_passes.as_ref().unwrap().weighted);
        let squares = |model: &ErrorModel, from: i32, to: i32| -> f64 {
            let off = |i: i32| {
                let s = 0.0035 * f64::from(i);
                // α₀ is unknown: slopes are compared.
                arcsec(
                    model.error(s + 0.0035) - model.error(s) - truth().error(s + 0.0035) + truth().error(s),
                )
            };
            (from..to).map(|i| off(i).powi(2)).sum()
        };
        for (sum, model) in [(&mut weighted, &rows), (&mut plain, &averages)] {
            let model = model.coefficients.error_model();
            *sum = [sum[0] + squares(&model, -100, 0), sum[1] + squares(&model, -100, 100)];
        }
    }
    println!("quiet end, whole: weighted {weighted:?}, plain {plain:?}");
    assert!(weighted[0] < 0.5 * plain[0] && weighted[1] < plain[1], "{weighted:?} against {plain:?}");
}

#[test]
fn a_single_pass_fits_and_says_what_is_unknown() {
    let device = Device { passes: 1, ..Device::paper() };
    let fit = fit(&device.recording(1), &mirror(), &Options::default()).unwrap();
    assert!(fit.notes.iter().any(|note| note.to_string().contains("no scatter between passes is known")));
    assert!(fit.coefficients.statistics.as_ref().unwrap().between_passes.is_none());
    let selection = fit.coefficients.order_selection.unwrap();
    assert_eq!(selection.held_out_by, "contiguous block");
    assert!(selection.curve.iter().all(|score| score.leave_one_pass_out.is_none()));
}

#[test]
fn angles_are_recognised_without_the_command() {
    let commanded = Device::paper();
    let without = Device { commanded: false, ..Device::paper() };
    let a = fit(&commanded.recording(8), &mirror(), &Options::default()).unwrap();
    let b = fit(&without.recording(8), &mirror(), &Options::default()).unwrap();
    assert_eq!(a.coefficients.base, b.coefficients.base);
    assert_eq!(b.coefficients.order_selection.unwrap().held_out_by, "angle, by reading");
}

/// α₀ is the reading at calculated angle 0 where there is one; where there is none, the intercept.
#[test]
fn the_zero_is_found_with_and_without_a_reading_there() {
    let device = Device { noise_arcsec: 0.0, ..Device::paper() };
    let zero_of = |recording: &Recording| {
        let fit = fit(recording, &mirror(), &given(9)).unwrap();
        (fit.coefficients.identification.unwrap().zero.unwrap(), fit.coefficients.base.coefficients[0])
    };
    let (with, a0) = zero_of(&device.recording(9));
    assert!(with.from.contains("point nearest zero (") && with.standard_error_arcsec.is_some());
    // Eq. 7 refers all angles to the reading at 0, so that a₀ is what the fit leaves there: nothing.
    approx::assert_abs_diff_eq!(arcsec(a0 / 12.0), 0.0, epsilon = 1e-3);
    let angles = (-17..=17).map(|step| 0.1 * f64::from(step)).filter(|angle| angle.abs() > 0.25).collect();
    let (without, _) = zero_of(&Device { angles, ..device }.recording(9));
    assert!(without.from.contains("intercept"));
    approx::assert_abs_diff_eq!(with.alpha0_arcsec, without.alpha0_arcsec, epsilon = 1.0);
}

#[test]
fn a_direct_sensor_may_count_other_turns_than_its_reference() {
    let rows = |turns: bool| -> String {
        (0..200)
            .map(|i| {
                let x = 1.8 * f64::from(i);
                let measured = if turns { x % 360.0 } else { x };
                format!("{i},{},1,{measured},{}\n", i / 100, x + 0.01 * (x / 57.3).sin() + 720.0)
            })
            .collect()
    };
    let header = "t_s,pass,direction,measured,reference\n";
    let mut mirror = direct("deg");
    if let fitter::Sensor::Direct { revolution, .. } = &mut mirror.sensor {
        *revolution = Some(360.0);
    }
    let recording =
        Recording::from_bytes("turns.csv", (header.to_string() + &rows(true)).as_bytes()).unwrap();
    let fit = fit(&recording, &mirror, &Options::default()).unwrap();
    let statistics = fit.coefficients.statistics.unwrap();
    assert!(statistics.before.max < 0.02 && statistics.after.max < 2e-3, "{statistics:?}");
    assert_eq!(statistics.unit, "deg");
}

#[test]
fn what_else_the_residual_depends_on_is_said_and_only_then() {
    // 400 recordings without any dependence: at 1 % each, more than 12 are seen once in 2000 times.
    let false_alarms = (0..400)
        .filter(|seed| {
            !fit(&Device::paper().recording(1000 + seed), &mirror(), &given(9))
                .unwrap()
                .dependences
                .is_empty()
        })
        .count();
    assert!(false_alarms <= 12, "{false_alarms} false alarms in 400");
    let strongest = |extra: fn(f64, f64, f64, f64) -> f64| {
        let fit = fit(&Device { extra, ..Device::paper() }.recording(7), &mirror(), &given(9)).unwrap();
        fit.dependences.first().map(|found| found.variable.clone())
    };
    assert_eq!(
        strongest(|_, _, temperature, _| 2.0 * (temperature - 27.0)).as_deref(),
        Some("temperature_c")
    );
    assert_eq!(strongest(|_, direction, _, _| 0.4 * direction).as_deref(), Some("direction"));
    assert_eq!(strongest(|time, _, _, _| time / 200.0).as_deref(), Some("t_s"));
    assert_eq!(strongest(|_, _, _, angle| (20.0 * angle).sin()).as_deref(), Some("angle"));
}

#[test]
fn the_same_bytes_every_time() {
    let recording = Device::paper().recording(11);
    let text = |_| fit(&recording, &mirror(), &Options::default()).unwrap().coefficients.to_json();
    assert_eq!(text(0), text(1));
}

/// Noise that lasts from row to row is found, and so is what it does to the variance of the fit: near the spectrum of the
/// noise at the frequencies of the polynomial, (1 + ρ)/(1 − ρ) = 4.7 at most. White noise is not taken for it.
#[test]
fn noise_that_lasts_is_recorded() {
    const RHO: f64 = 0.65;
    let recorded = |rho: f64, seed: u64| {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (mut csv, mut noise) = (String::from("t_s,pass,direction,measured,reference\n"), 0.0);
        for row in 0..246i32 {
            let (pass, place) = (row / 41, f64::from(row % 41) / 20.0 - 1.0);
            let (way, x) = if pass % 2 == 0 { (1, place) } else { (-1, -place) };
            noise = rho * noise + (1.0 - rho * rho).sqrt() * normal(&mut random);
            csv += &format!("{row},{pass},{way},{:.6},{x:.6}\n", x + 1e-3 * x * x + 1e-4 * noise);
        }
        let recording = Recording::from_bytes("lasting.csv", csv.as_bytes()).unwrap();
        let file = fit(&recording, &direct("mm"), &given(5)).unwrap().coefficients;
        file.recorded.unwrap().correlation
    };
    let found: Vec<_> = (1..=8).map(|seed| recorded(RHO, seed).unwrap()).collect();
    let mean = found.iter().map(|found| found.neighbours).sum::<f64>() / 8.0;
    // One standard error, 0.06, stands on top.
    assert!((mean - RHO - 0.06).abs() < 0.08, "{found:?}");
    assert!(found.iter().all(|found| (1.5..8.0).contains(&found.of_fitted)), "{found:?}");
    let white = (1..=20).filter(|seed| recorded(0.0, *seed).is_some()).count();
    assert!(white <= 3, "{white} of 20");
}
