use super::*;
use crate::noise::Noise;

fn schedule() -> Schedule {
    Schedule { stops: 61, passes: 6, random: false, noise: Noise::White }
}

fn recorded(kind: &'static Kind, seed: u64) -> Vec<Row> {
    Bench::from_seed(3, Some(kind), schedule().duration_s()).record(&schedule(), seed)
}

#[test]
fn every_kind_adds_something_beside_the_characteristic_and_comes_again_from_its_seed() {
    for kind in ALL.into_iter().flatten() {
        let rows = recorded(kind, 5);
        let effect: Vec<f64> = rows.iter().map(|row| row.effect).collect();
        let x: Vec<f64> = rows.iter().map(|row| row.measured_mm).collect();
        let rms = |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
        let mean = effect.iter().sum::<f64>() / effect.len() as f64;
        let varies = rms(&effect.iter().map(|e| e - mean).collect::<Vec<_>>());
        let left = rms(&crate::orthogonal::residual(&x, &effect, 9));
        // What a polynomial of the position follows could not be seen by anybody.
        assert!(left > 0.1 * varies && varies > 0.0, "{}: {left} of {varies}", kind.id);
        let again: Vec<f64> = recorded(kind, 5).iter().map(|row| row.effect).collect();
        assert_eq!(effect, again, "{}", kind.id);
        let other: Vec<f64> = recorded(kind, 6).iter().map(|row| row.measured_mm).collect();
        assert_ne!(x, other, "{}", kind.id);
    }
}

#[test]
fn the_columns_that_carry_a_kind_are_columns_and_ids_are_outside_the_table() {
    for kind in ALL.into_iter().flatten() {
        assert!(
            kind.columns.iter().all(|column| kind.depends_on.contains(&COLUMNS[*column].name)),
            "{}",
            kind.id
        );
        assert!(kind.id.starts_with("ooc_") && crate::effects::find(kind.id).is_none());
        assert_eq!(find(kind.id).map(|found| found.title), Some(kind.title));
    }
}

#[test]
fn the_noise_of_the_error_is_what_is_stated() {
    let schedule = Schedule { passes: 40, ..schedule() };
    let rows = Bench::from_seed(1, None, 1.0).record(&schedule, 2);
    let x: Vec<f64> = rows.iter().map(|row| row.measured_mm).collect();
    let error: Vec<f64> = rows.iter().map(|row| row.measured_mm - row.reference_mm).collect();
    let left = crate::orthogonal::residual(&x, &error, 7);
    let rms = (left.iter().map(|v| v * v).sum::<f64>() / left.len() as f64).sqrt();
    // 2440 rows: a standard error of 1.4 %.
    approx::assert_relative_eq!(rms, Bench::noise_mm(&Noise::White), max_relative = 0.06);
}
