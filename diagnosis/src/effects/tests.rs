//! The catalogue as a whole.

use fitter::terms::Operator;

use super::{Handed, Origin, catalogue_in, composed, curves, listed};
use crate::rows::{Rows, pauses};
use fitter::error_model::Sensor;

#[test]
fn every_confusion_names_an_effect_of_the_catalogue() {
    let effects = listed();
    for effect in effects.iter() {
        for other in &effect.confused_with {
            assert!(effects.iter().any(|e| e.id == *other), "{}: {other}", effect.id);
            assert_ne!(*other, effect.id);
        }
    }
}

#[test]
fn the_catalogue_is_read_in_any_unit() {
    for unit in ["arcsec", "deg", "mm", "counts", "m2_per_s"] {
        assert_eq!(catalogue_in(unit == "arcsec", unit).len(), listed().len());
    }
}

/// A recording of four passes in which everything moves.
fn rows() -> Rows {
    let count = 80;
    let t_s: Vec<f64> = (0..count).map(|i| 2.0 * f64::from(i)).collect();
    let theta: Vec<f64> = t_s.iter().map(|t| 3000.0 * (t / 25.0).sin() + 7.0).collect();
    let of = |rate: f64| Some(t_s.iter().map(|t| 20.0 + (rate * t).cos()).collect::<Vec<f64>>());
    Rows {
        unit: "arcsec".into(),
        pair: true,
        pass: (0..count).map(|i| i64::from(i / 20)).collect(),
        direction: t_s.iter().map(|t| (t / 25.0).cos().signum()).collect(),
        truth: theta.iter().map(|theta| theta + 3.0).collect(),
        temperature_c: of(0.01),
        coil_a: of(0.3),
        cross_arcsec: of(0.2),
        common_mode_um: of(0.05),
        theta,
        t_s,
        ..Rows::default()
    }
}

#[test]
fn every_effect_of_the_catalogue_is_a_term_of_its_own_kind() {
    let rows = rows();
    for effect in catalogue_in(true, "arcsec").iter() {
        for shape in effect.starts(&rows) {
            let handed = effect.operator(&rows, &shape);
            assert_ne!(handed.operator.kind(), "expression", "{} at {shape:?}", effect.id);
            assert_eq!(handed.map.len(), handed.operator.width());
            let columns = effect.signature(&rows, &shape);
            assert_eq!(handed.map[0].len(), columns.len());
            assert_eq!(effect.over(&rows).signature(&shape), columns, "{} at {shape:?}", effect.id);
            assert!(columns.iter().flatten().all(|value| value.is_finite()), "{} at {shape:?}", effect.id);
        }
    }
}

#[test]
fn a_term_read_off_an_expression_is_that_expression() {
    let rows = rows();
    let effects = super::declared::read(
        "mine.toml",
        r#"
            [[effect]]
            id = "scaled"
            adds = "-3 * k * (2 * coil_a - 1 [A])^2 * (angle / 60 - 4 [arcsec])"
            k = { unit = "1/A^2" }
        "#,
        &fitter::error_model::Sensor::EddyCurrentPair { probe_distance_mm: 12.0, initial_gap_mm: 0.3 },
    );
    let effects = effects.unwrap();
    let Handed { operator: Operator::Product(product), map } = effects[0].operator(&rows, &[]) else {
        panic!("a product")
    };
    let (coil, column) = (rows.coil_a.as_ref().unwrap(), &effects[0].signature(&rows, &[])[0]);
    for row in 0..rows.len() {
        let values = [coil[row], rows.theta[row]];
        let of_product =
            product.factors.iter().zip(values).map(|(f, v)| (v - f.mean).powi(i32::from(f.power)));
        let value = map[0][0] * of_product.product::<f64>();
        // Rounding of a few products.
        assert!((value - column[row]).abs() < 1e-9 * value.abs().max(1.0), "{value} {}", column[row]);
    }
}

#[test]
fn every_form_can_be_read_of_a_column_whose_unit_fits() {
    let forms = |columns: &[&str], unit: &str| {
        let sensor = Sensor::Direct { unit: unit.into(), revolution: None };
        let made = composed(columns, &sensor, &[]);
        (made.len(), physics::forms(columns).len(), made)
    };
    for column in ["shaft_deg", "flow_l_min", "temperature_c", "humidity_pct", "strain_ue", "load"] {
        for unit in ["mm", "arcsec", "counts"] {
            let (made, known, _) = forms(&[column], unit);
            assert_eq!(made, known, "{column} in {unit}");
            let columns = [column, "supply_v"];
            let made = curves(&columns, &Sensor::Direct { unit: unit.into(), revolution: None }, &[]);
            assert_eq!(made.len(), physics::curves(&columns).len(), "{column} in {unit}");
        }
    }
    // The common mode's past would average the noise of the probes.
    let (made, known, effects) = forms(&["common_mode"], "arcsec");
    assert!(made < known && effects.iter().any(|effect| effect.formula == "k * common_mode^2"));
    let past = |formula: &str| {
        ["lowpass(common", "delay(common", "play(common"].iter().any(|of| formula.contains(of))
    };
    assert!(!effects.iter().any(|effect| past(&effect.formula)));
    // Only an angle turns: in one harmonic, two or six, differently in each direction, and as a sensitivity.
    assert_eq!(forms(&["shaft_deg"], "mm").0, forms(&["load"], "mm").0 + 5);
    // A name that cannot stand in an expression is left out.
    let (made, _, effects) = forms(&["load_n", "two words", "supply_v"], "counts");
    assert_eq!(made, forms(&["load_n", "supply_v"], "counts").0);
    assert!(
        effects
            .iter()
            .all(|effect| matches!(&effect.origin, Origin::Form(text) if text.contains(&effect.id) && !text.contains('#')))
    );
    assert!(effects.iter().all(|effect| !effect.suggestions.is_empty()));
}

#[test]
fn what_is_missing_since_the_start_and_pauses_fades() {
    let mut rows = rows();
    // 38 s pass between rows 39 and 40, where 2 s are usual.
    rows.t_s.iter_mut().skip(40).for_each(|t| *t += 36.0);
    rows.pauses_s = pauses(&rows.t_s);
    let sensor = Sensor::EddyCurrentPair { probe_distance_mm: 12.0, initial_gap_mm: 0.3 };
    let forms = composed(&["coil_a"], &sensor, &[]);
    let of = |id: &str| forms.iter().find(|form| form.id == id).unwrap();
    let (settled, start, pauses) = (of("lag_coil_a"), of("unsettled_lag_coil_a"), of("resumed_lag_coil_a"));
    let columns = pauses.signature(&rows, &[20.0]);
    assert_eq!(columns[0], settled.signature(&rows, &[20.0])[0]);
    assert_eq!(columns[..2], start.signature(&rows, &[20.0])[..]);
    // The pause's middle is at 97 s, 19 s before the next row.
    let near =
        |value: f64, expected: f64| assert!((value - expected).abs() < 1e-12, "{value}, expected {expected}");
    near(columns[1][0], 1.0);
    near(columns[1][10], (-1f64).exp());
    assert_eq!(columns[2][39], 0.0);
    near(columns[2][40], (-19f64 / 20.0).exp());
    near(columns[2][50], (-39f64 / 20.0).exp());
    // In a file it is the same, and other recordings get the first column alone.
    let Operator::Expression(here) = pauses.operator(&rows, &[20.0]).operator else {
        panic!("an expression")
    };
    let value = |of: &[f64]| here.sentence(true).unwrap().values(&super::Read(&rows), of).unwrap();
    let sum = value(&[2.0, -3.0, 5.0, 20.0]);
    (0..rows.len())
        .for_each(|i| near(sum[i], 2.0 * columns[0][i] - 3.0 * columns[1][i] + 5.0 * columns[2][i]));
    let Operator::Expression(elsewhere) = settled.operator(&rows, &[20.0]).operator else { return };
    assert_eq!(pauses.without_missing(&here).text, elsewhere.text);
    // Without a pause there is nothing to resume after.
    assert!(pauses.testable(&super::tests::rows()).is_err() && start.testable(&super::tests::rows()).is_ok());
}
