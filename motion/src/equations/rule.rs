//! Rules of Runge and Kutta.

use std::sync::LazyLock;

use differential_equations::tableau::ButcherTableau;

/// Weights of the rates of some stages.
pub type Weights = Vec<(usize, f64)>;

/// The stages of a step: where each is, and of which rates before it with which weights; then the weights of all rates.
pub struct Rule {
    /// The part of the step after which every stage is, and the weights of the rates of earlier stages in it.
    pub stages: Vec<(f64, Weights)>,
    /// The weights of the rates in the whole step.
    pub weights: Weights,
}

/// Most stages of a rule.
pub const MOST_STAGES: usize = 12;
/// Most steps of the classical rule that are replaced.
const MOST_SMOOTH: usize = 16;

/// The classical rule, of order four.
static FOURTH: LazyLock<Rule> = LazyLock::new(|| Rule::of(&ButcherTableau::<f64, 4>::rk4()));

/// A rule of order six in seven stages (J. C. Butcher, J. Austral. Math. Soc. 4, 1964, 179–194).
static SIXTH: LazyLock<Rule> = LazyLock::new(|| Rule {
    stages: vec![
        (0.0, vec![]),
        (1.0 / 3.0, vec![(0, 1.0 / 3.0)]),
        (2.0 / 3.0, vec![(1, 2.0 / 3.0)]),
        (1.0 / 3.0, vec![(0, 1.0 / 12.0), (1, 1.0 / 3.0), (2, -1.0 / 12.0)]),
        (0.5, vec![(0, -1.0 / 16.0), (1, 9.0 / 8.0), (2, -3.0 / 16.0), (3, -3.0 / 8.0)]),
        (0.5, vec![(1, 9.0 / 8.0), (2, -3.0 / 8.0), (3, -3.0 / 4.0), (4, 0.5)]),
        (1.0, vec![(0, 9.0 / 44.0), (1, -9.0 / 11.0), (2, 63.0 / 44.0), (3, 18.0 / 11.0), (5, -16.0 / 11.0)]),
    ],
    weights: vec![
        (0, 11.0 / 120.0),
        (2, 27.0 / 40.0),
        (3, 27.0 / 40.0),
        (4, -4.0 / 15.0),
        (5, -4.0 / 15.0),
        (6, 11.0 / 120.0),
    ],
});

/// A rule of order eight in twelve stages (Dormand and Prince; Hairer, Nørsett & Wanner, Solving Ordinary Differential
/// Equations I, section II.5).
static EIGHTH: LazyLock<Rule> = LazyLock::new(|| Rule::of(&ButcherTableau::<f64, 12, 16>::dop853()));

impl Rule {
    fn of<const S: usize, const I: usize>(tableau: &ButcherTableau<f64, S, I>) -> Rule {
        let weights =
            |all: &[f64]| all.iter().copied().enumerate().filter(|(_, weight)| *weight != 0.0).collect();
        let stages = tableau.c.iter().zip(&tableau.a).take(S).map(|(part, of)| (*part, weights(of)));
        Rule { stages: stages.collect(), weights: weights(&tableau.b) }
    }

    /// The classical rule of order four.
    pub fn classical() -> &'static Rule {
        &FOURTH
    }

    /// The rule that is about as accurate as so many steps of the classical one with fewer stages, and the number of its
    /// steps. Where that is many the plant is stiff, and the classical rule is stable over a longer time for the same work.
    pub fn for_steps(classical: usize) -> (&'static Rule, usize) {
        match classical {
            2..8 => (&SIXTH, classical.div_ceil(2)),
            8..=MOST_SMOOTH => (&EIGHTH, classical.div_ceil(8)),
            _ => (&FOURTH, classical),
        }
    }
}
