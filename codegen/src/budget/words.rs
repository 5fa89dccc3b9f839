//! A budget in the head of a file: short, the whole table stands in the certificate.

use fitter::budget::Budget;

use crate::text;

/// What a head says of a budget: how large the expanded uncertainty is, and the lines below it.
pub fn in_words(budget: &Budget) -> (String, Vec<String>) {
    let unit = &budget.unit;
    let [low, high] = budget.expanded().map(text::rounded_up);
    let expanded = if low == high { format!("{high} {unit}") } else { format!("{low} … {high} {unit}") };
    let mut lines: Vec<String> = (budget.components.iter())
        .map(|component| {
            let u = text::rounded_up(component.contribution);
            format!("{u} {unit}  {}, {}", component.what, component.distribution.name())
        })
        .collect();
    lines.extend(budget.missing.iter().map(|missing| format!("MISSING: {missing}")));
    (expanded, lines)
}
