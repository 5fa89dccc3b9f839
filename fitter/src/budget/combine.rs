//! Combined and expanded uncertainty.
//!
//! The combined standard uncertainty is the root of the sum of squares (GUM 5.1.2), its degrees of freedom those of Welch
//! and Satterthwaite (GUM G.4.1). The coverage factor is that of the distribution that the components have together
//! (GUM G.1.4): Student's t of all that are normal or small, convolved with the largest rectangular one and with what takes
//! two values. Student's t alone, as GUM G.4 has it, supposes that no such component dominates; a stated accuracy often does.

use serde::{Deserialize, Serialize};
use statrs::distribution::{Continuous, ContinuousCDF, Normal, StudentsT};

use super::{Component, Distribution, rounded};

/// The probability that an expanded uncertainty stands for.
pub const COVERAGE: f64 = 0.95;

/// From so many degrees of freedom on, Student's t is normal: the quantile differs by a part in 10⁵.
const MANY: f64 = 1e5;
/// Fewer have no mean, which the convolution needs: one degree of freedom is taken as so many.
const FEWEST: f64 = 1.05;
/// Part of the combined uncertainty below which a component is not worth its own distribution.
const SMALL: f64 = 1e-4;

/// What several components make together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Combined {
    /// u_c, the combined standard uncertainty.
    pub standard_uncertainty: f64,
    /// ν_eff, the effective degrees of freedom; none where they are infinite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degrees_of_freedom: Option<f64>,
    /// k.
    pub coverage_factor: f64,
    /// U = k·u_c, for [`COVERAGE`].
    pub expanded: f64,
}

/// Combines independent components.
///
/// # Example
/// ```
/// use fitter::budget::{Component, combine};
///
/// // Ten readings' scatter alone: Student's t of nine degrees of freedom.
/// let scatter = Component::observed("repeatability", "scatter", "arcsec", 0.5, 9.0);
/// let alone = combine(&[scatter]);
/// assert!((alone.coverage_factor - 2.262).abs() < 1e-3);
/// // Limits alone: 95 % of the width.
/// let limits = combine(&[Component::within("reference", "its accuracy", "arcsec", 1.0)]);
/// assert!((limits.expanded - 0.95).abs() < 1e-3);
/// ```
pub fn combine(components: &[Component]) -> Combined {
    let bell = Bell::of(components.iter());
    if bell.deviation == 0.0 {
        return Combined {
            standard_uncertainty: 0.0,
            degrees_of_freedom: None,
            coverage_factor: 0.0,
            expanded: 0.0,
        };
    }
    let largest = |distribution| {
        let all = components.iter().enumerate().filter(|(_, c)| c.distribution == distribution);
        all.max_by(|a, b| a.1.contribution.total_cmp(&b.1.contribution)).map(|(k, _)| k)
    };
    let (flat, two) = (largest(Distribution::Rectangular), largest(Distribution::TwoValued));
    let rest = components.iter().enumerate().filter(|(k, _)| Some(*k) != flat && Some(*k) != two);
    let of = |k: Option<usize>| k.map_or(0.0, |k| components[k].contribution);
    let together = Together {
        rest: Bell::of(rest.map(|(_, component)| component)).at_least(SMALL * bell.deviation),
        half: 3f64.sqrt() * of(flat),
        step: of(two),
    };
    let expanded = together.reach(bell.deviation);
    Combined {
        standard_uncertainty: rounded(bell.deviation),
        degrees_of_freedom: bell.freedom.map(rounded),
        coverage_factor: rounded(expanded / bell.deviation),
        expanded: rounded(expanded),
    }
}

/// Student's t of a deviation, or a normal distribution.
struct Bell {
    deviation: f64,
    /// By Welch and Satterthwaite; none where they are infinite.
    freedom: Option<f64>,
}

impl Bell {
    fn of<'a>(components: impl Iterator<Item = &'a Component>) -> Bell {
        let (mut squares, mut fourths) = (0.0, 0.0);
        for component in components {
            let square = component.contribution * component.contribution;
            squares += square;
            fourths += component.degrees_of_freedom.map_or(0.0, |freedom| square * square / freedom);
        }
        let freedom = Some(squares * squares / fourths).filter(|freedom| *freedom < MANY);
        Bell { deviation: squares.sqrt(), freedom }
    }

    fn at_least(self, deviation: f64) -> Bell {
        if self.deviation < deviation { Bell { deviation, freedom: None } } else { self }
    }

    /// Probability below z standard deviations, and the integral of that from −∞ to z:
    /// z F(z) + (ν + z²)/(ν − 1) f(z), of a normal distribution z F(z) + f(z).
    fn below(&self, z: f64) -> (f64, f64) {
        let student = self.freedom.and_then(|freedom| {
            let freedom = freedom.max(FEWEST);
            let t = StudentsT::new(0.0, 1.0, freedom).ok()?;
            let below = t.cdf(z);
            Some((below, z * below + (freedom + z * z) / (freedom - 1.0) * t.pdf(z)))
        });
        student.unwrap_or_else(|| {
            let normal = Normal::standard();
            let below = normal.cdf(z);
            (below, z * below + normal.pdf(z))
        })
    }
}

/// A bell with a rectangle of ±half and two values ±step.
struct Together {
    rest: Bell,
    half: f64,
    step: f64,
}

impl Together {
    /// Probability that the sum is at most `reach` away from zero.
    fn within(&self, reach: f64) -> f64 {
        let below = |x: f64| {
            let (z, wide) = (x / self.rest.deviation, self.half / self.rest.deviation);
            if wide < SMALL {
                return self.rest.below(z).0;
            }
            (self.rest.below(z + wide).1 - self.rest.below(z - wide).1) / (2.0 * wide)
        };
        // All parts are symmetric.
        below(reach - self.step) + below(reach + self.step) - 1.0
    }

    /// The reach of [`COVERAGE`], by bisection; `scale` is a length of its size.
    fn reach(&self, scale: f64) -> f64 {
        const HALVINGS: usize = 40;
        let (mut low, mut high) = (0.0, 2.0 * scale);
        while self.within(high) < COVERAGE && high < 1e3 * scale {
            (low, high) = (high, 2.0 * high);
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.within(middle) < COVERAGE { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normal(deviation: f64, freedom: f64) -> Component {
        Component::observed("a", "a", "mm", deviation, freedom)
    }

    fn flat(half: f64) -> Component {
        Component::within("b", "b", "mm", half)
    }

    #[test]
    fn normal_components_have_the_quantile_of_student() {
        // GUM table G.2: t of 95 %.
        for (freedom, quantile) in [(2.0, 4.303), (5.0, 2.571), (20.0, 2.086), (f64::INFINITY, 1.960)] {
            let found = combine(&[normal(0.3, freedom)]);
            assert!((found.coverage_factor - quantile).abs() < 1e-3, "{freedom}: {found:?}");
        }
    }

    #[test]
    fn degrees_of_freedom_are_those_of_welch_and_satterthwaite() {
        // GUM H.1.6 in parts: u_c⁴/Σ u⁴/ν of end-gauge calibration, 32 nm with about 16.
        let parts =
            [normal(25.0, 18.0), normal(9.7, 25.6), flat(3f64.sqrt() * 2.9).times(1.0), normal(16.6, 2.0)];
        let found = combine(&parts);
        let squares: f64 = parts.iter().map(|p| p.contribution.powi(2)).sum();
        let fourths = 25f64.powi(4) / 18.0 + 9.7f64.powi(4) / 25.6 + 16.6f64.powi(4) / 2.0;
        assert!((found.degrees_of_freedom.unwrap() - squares * squares / fourths).abs() < 1e-3, "{found:?}");
        assert!((found.standard_uncertainty - squares.sqrt()).abs() < 1e-3);
    }

    /// The probability by summing over a fine grid of the rectangle, which shares nothing with the closed form.
    #[test]
    fn a_rectangle_that_dominates_is_convolved() {
        for (half, deviation, freedom, step) in
            [(1.0, 0.4, 30.0, 0.0), (1.0, 0.05, 12.0, 0.0), (0.2, 0.5, 5.0, 0.0), (0.3, 0.1, 50.0, 0.7)]
        {
            let mut parts = vec![flat(half), normal(deviation, freedom)];
            parts.push(Component::of("c", "c", "mm", step, Distribution::TwoValued, 1.0));
            let found = combine(&parts);
            let t = StudentsT::new(0.0, deviation, freedom).unwrap();
            const CELLS: u32 = 20_000;
            let within = |centre: f64| t.cdf(found.expanded - centre) - t.cdf(-found.expanded - centre);
            let cell = |i: u32| half * (2.0 * (f64::from(i) + 0.5) / f64::from(CELLS) - 1.0);
            let sum: f64 = (0..CELLS).map(|i| 0.5 * (within(cell(i) - step) + within(cell(i) + step))).sum();
            assert!((sum / f64::from(CELLS) - COVERAGE).abs() < 1e-5, "{half} {deviation}: {found:?}");
        }
        assert_eq!(combine(&[flat(0.0)]).expanded, 0.0);
    }
}
