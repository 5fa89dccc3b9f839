//! What is modelled altogether: the base or the nominal plant, and what every effect adds.

use fitter::plant::{Kind, PlantFile};

use crate::diagnosis::{Diagnosis, Outcome};
use crate::dynamic::effects;
use crate::verdict::NamedEffect;

/// What the effects of a calibration are added to: a sine and a cosine are one harmonic.
pub(super) fn base(outcome: &Outcome) -> String {
    match (outcome.rows.whole_turn(), outcome.after.order) {
        (Some(_), order) => super::plural(order / 2, "harmonic of the turn", "harmonics of the turn"),
        (None, order) => format!("polynomial of order {order}"),
    }
}

/// The base and the formulas of all effects; none where an effect has no formula.
pub(super) fn of_calibration(d: &Diagnosis, base: &str) -> Option<String> {
    if d.effects.iter().any(|effect| effect.formula.is_empty()) {
        return None;
    }
    let alone = d.effects.len() < 2;
    let terms = d.effects.iter().map(|effect| {
        let formula = &effect.formula;
        if alone { formula.clone() } else { format!("[{}: {formula}]", effect.id.replace('_', " ")) }
    });
    let terms: Vec<String> = terms.collect();
    (!terms.is_empty()).then(|| typeset(&format!("error = {base} + {}", terms.join(" + "))))
}

/// An expression with the signs of print: powers are raised, · multiplies.
fn typeset(expression: &str) -> String {
    let raised = |digit: char| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(digit.to_digit(10)? as usize);
    let signs = expression.replace(" * ", " · ").replace(" - ", " − ").replace("' =", "′ =");
    let mut parts = signs.split('^');
    let mut text = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let digits = part.find(|c: char| !c.is_ascii_digit()).unwrap_or(part.len());
        if digits == 0 {
            text.push('^');
        }
        text.extend(part[..digits].chars().filter_map(raised));
        text += &part[digits..];
    }
    text
}

/// The equations of a plant, and what every effect adds to them, one in a line; none without effects.
pub(super) fn of_motion(d: &Diagnosis, file: &PlantFile) -> Option<String> {
    let mut lines = match (&file.equations, file.plant.kind) {
        (Some(plant), _) => {
            let rates = plant.equations.0.iter().map(|(state, rate)| format!("{state}' = {rate}"));
            let output = plant.output.0.iter().map(|(name, of)| format!("{name} = {of}"));
            rates.chain(output).collect()
        }
        (None, Kind::Linear) => vec!["z⁺ = A z + B w".to_string(), "x = C z + D w".to_string()],
        (None, _) => {
            let spring = if file.plant.stiffness.is_some() { " − stiffness x" } else { "" };
            vec![format!("x″ = gain w − damping v{spring}")]
        }
    };
    let added = d.effects.iter().map(of_effect).filter(|formula| !formula.is_empty());
    let equations = lines.len();
    lines.extend(added.map(str::to_string));
    (lines.len() > equations).then(|| typeset(&lines.join("\n")))
}

/// The formula of an effect: its own, or that of the catalogue in motion.
pub(super) fn of_effect(effect: &NamedEffect) -> &str {
    if effect.formula.is_empty() {
        effects::effect(&effect.id).map_or("", |known| known.formula)
    } else {
        &effect.formula
    }
}

#[cfg(test)]
mod tests {
    use super::typeset;

    #[test]
    fn signs_are_those_of_print() {
        assert_eq!(typeset("v' = -k * x^12 - c * x^(n) + 1"), "v′ = -k · x¹² − c · x^(n) + 1");
    }
}
