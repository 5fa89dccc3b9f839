//! Which of many things differ between two recordings: the fewest beside which nothing else does, at a family-wise false-alarm
//! rate.

use crate::thresholds::compare::{ALTERNATIVE, FALSE_ALARMS, MOST_CHANGES};

/// What differs.
pub struct Step {
    /// Its number.
    pub number: usize,
    /// Its family-wise p-value beside the others that differ.
    pub p_value: f64,
    /// Others that would do nearly as well in its place.
    pub alternatives: Vec<usize>,
}

/// Takes what is the most surprising one by one, then leaves out what those that came later explain as well.
///
/// `surprises` gives −ln of the p-value that each thing differs beside those that do, `strongest` the one to be taken, and
/// `family_wise` the p-value over all of a thing with a surprise.
pub fn stepwise(
    surprises: impl Fn(&[usize]) -> Vec<f64>,
    strongest: impl Fn(&[f64]) -> Option<usize>,
    family_wise: impl Fn(usize, f64) -> f64,
) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    while steps.len() < MOST_CHANGES {
        let found = surprises(&numbers(&steps));
        let Some(number) = strongest(&found) else { break };
        let p_value = family_wise(number, found[number]);
        if p_value > FALSE_ALARMS {
            break;
        }
        let near = |k: &usize| *k != number && found[*k] > found[number] - ALTERNATIVE;
        steps.push(Step { number, p_value, alternatives: (0..found.len()).filter(near).collect() });
    }
    let mut k = 0;
    while k < steps.len() && steps.len() > 1 {
        let number = steps[k].number;
        let others: Vec<usize> = numbers(&steps).into_iter().filter(|other| *other != number).collect();
        steps[k].p_value = family_wise(number, surprises(&others)[number]);
        if steps[k].p_value > FALSE_ALARMS {
            steps.remove(k);
            k = 0;
        } else {
            k += 1;
        }
    }
    steps
}

fn numbers(steps: &[Step]) -> Vec<usize> {
    steps.iter().map(|step| step.number).collect()
}
