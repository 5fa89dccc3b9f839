//! The numbers of the alternatives' tables and formulas, computed from the model: files that their sources include.

use std::path::Path;

use super::FULL_SCALE_MM;
use crate::problem::Problem;
use crate::subject::{self, PAPER_RANGE_MM};

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
    put("quadratic.inc", &(0..64).map(parabola).collect::<Vec<_>>())?;
    // Of x/2^32, x in 2^-31 of 0.4 mm and of 0.76 mm; half a unit for the last truncation.
    let polynomial = |degree: usize, from: f64, to: f64, full_scale_mm: f64, bits: i32| -> Vec<i64> {
        let mm = 2.0 * full_scale_mm;
        let coefficients = interpolated(degree, (from / mm, to / mm), &|v| angle(mm * v));
        let unit = 2f64.powi(bits);
        let half = |k: usize| if k == 0 { 0.5 } else { 0.0 };
        coefficients.iter().enumerate().map(|(k, c)| (c * unit + half(k)).round() as i64).collect()
    };
    let horner = polynomial(9, -PAPER_RANGE_MM, PAPER_RANGE_MM, 0.4, 33);
    let defined = horner.iter().enumerate().map(|(k, c)| format!("#define C{k} ({c})\n"));
    let path = folder.join("horner.inc");
    std::fs::write(&path, defined.collect::<String>()).map_err(Problem::file(&path))?;
    let row = |i: i32| {
        let [from, to] = [i - 16, i - 15].map(|end| f64::from(end) * PAPER_RANGE_MM / 16.0);
        let row = polynomial(2, from, to, 2.0 * PAPER_RANGE_MM, 32);
        format!("{{ {}, {}, {} }}", row[0], row[1], row[2])
    };
    put("parabolas.inc", &(0..32).map(row).collect::<Vec<_>>())
}

/// The polynomial through the values at Chebyshev's nodes, which is nearly the best; constant first.
fn interpolated(degree: usize, (from, to): (f64, f64), value: &dyn Fn(f64) -> f64) -> Vec<f64> {
    let count = degree + 1;
    let node = |i: usize| {
        let angle = std::f64::consts::PI * (i as f64 + 0.5) / count as f64;
        0.5 * (from + to) - 0.5 * (to - from) * angle.cos()
    };
    // Newton's divided differences, then Horner's scheme from the inside out.
    let mut differences: Vec<f64> = (0..count).map(|i| value(node(i))).collect();
    for order in 1..count {
        for i in (order..count).rev() {
            differences[i] = (differences[i] - differences[i - 1]) / (node(i) - node(i - order));
        }
    }
    let mut powers = vec![0.0; count];
    for i in (0..count).rev() {
        for k in (0..count).rev() {
            powers[k] = if k > 0 { powers[k - 1] } else { 0.0 } - node(i) * powers[k];
        }
        powers[0] += differences[i];
    }
    powers
}
