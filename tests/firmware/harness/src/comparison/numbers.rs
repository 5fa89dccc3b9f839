//! The numbers of the alternatives' tables and formulas, computed from the model: files that their sources include.

use std::path::Path;

use super::FULL_SCALE_MM;
use crate::problem::Problem;
use crate::subject;

/// As in `alternatives.h`: spacings of the float tables' nodes, and the slope that is left out of them.
const LINEAR_SPACING_MM: f64 = 3121.0 / 4_194_304.0;
const QUADRATIC_SPACING_MM: f64 = 195.0 / 16_384.0;
const SLOPE: f32 = 0.0715;

/// The numbers of the alternatives' tables, from the model.
///
/// # Errors
/// [`Problem::File`] where they cannot be written.
pub fn write(folder: &Path) -> Result<(), Problem> {
    std::fs::create_dir_all(folder).map_err(Problem::file(folder))?;
    let model = subject::paper_model();
    let angle = |s_mm: f64| model.corrected(s_mm);
    let put = |name: &str, numbers: &[String]| {
        let path = folder.join(name);
        std::fs::write(&path, numbers.join(",\n") + "\n").map_err(Problem::file(&path))
    };
    let float = |value: f64| format!("{:e}f", value as f32);
    let coefficients: Vec<String> = model.coefficients.iter().map(|a| format!("{a:e}")).collect();
    put("coefficients.inc", &coefficients)?;
    let rounded: Vec<String> = model.coefficients.iter().map(|a| float(*a)).collect();
    put("coefficients_f32.inc", &rounded)?;
    let at = |fraction: f64, half_mm: f64| half_mm * (2.0 * fraction - 1.0);
    // What is left to the table: the rest of the multiplication by a float near the slope at zero.
    let rest = |s_mm: f64| angle(s_mm) - f64::from(SLOPE) * s_mm;
    let linear = |i: i32| {
        let (s, h) = (f64::from(i - 511) * LINEAR_SPACING_MM, LINEAR_SPACING_MM);
        // A chord departs from the curve by f''h²/8 in its middle: half of that to either side.
        let bend = rest(s + h) - 2.0 * rest(s) + rest(s - h);
        float(rest(s) - bend / 16.0)
    };
    put("linear.inc", &(0..1024).map(linear).collect::<Vec<_>>())?;
    let words =
        |i: u32| format!("{}", (angle(at(f64::from(i) / 1024.0, FULL_SCALE_MM)) * 2f64.powi(33)).round());
    put("words.inc", &(0..=1024).map(words).collect::<Vec<_>>())?;
    let parabola = |i: i32| {
        // Through the three Chebyshev nodes of the segment, which is nearly the best.
        let node =
            |k: u32| -0.5 * QUADRATIC_SPACING_MM * (f64::from(2 * k + 1) * std::f64::consts::PI / 6.0).cos();
        let value = |t: f64| rest(f64::from(2 * i - 63) * (0.5 * QUADRATIC_SPACING_MM) + t);
        let [t0, t1, t2] = [node(0), node(1), node(2)];
        let slope = (value(t1) - value(t0)) / (t1 - t0);
        let c2 = ((value(t2) - value(t1)) / (t2 - t1) - slope) / (t2 - t0);
        let c1 = slope - c2 * (t0 + t1);
        let c0 = value(t0) - t0 * (c1 + t0 * c2);
        format!("{{ {}, {}, {} }}", float(c0), float(c1), float(c2))
    };
    put("quadratic.inc", &(0..64).map(parabola).collect::<Vec<_>>())
}
