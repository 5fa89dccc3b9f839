//! The catalogue as a page: what `arcsmith effects` prints and `docs/effects.md` holds.

use super::{Effect, listed};

/// One paragraph of Markdown for every effect, in the order of the catalogue.
pub fn markdown() -> String {
    listed().iter().map(one).collect::<Vec<String>>().join("\n")
}

fn one(effect: &Effect) -> String {
    let confused: Vec<String> = effect.confused_with.iter().map(|id| format!("`{id}`")).collect();
    let confused = if confused.is_empty() { "nothing of the catalogue".into() } else { confused.join(", ") };
    let firmware = if effect.of_one_time {
        "no: it belongs to the recording in which it happened"
    } else {
        "yes, from what the mirror measures at run time"
    };
    let units: Vec<String> =
        effect.made.declared.parameters.iter().map(|p| format!("{} in {}", p.name, p.unit_text)).collect();
    format!(
        "### `{}`: {}\n\n- adds to the angular error: `{}`; {}\n- size: {}\n- taken for: {confused}\n- correctable in \
         firmware: {firmware}\n- source: {}\n",
        effect.id,
        effect.title,
        effect.formula.replace(", or ", "`, or `"),
        units.join(", "),
        effect.size,
        effect.source
    )
}

#[cfg(test)]
mod tests {
    use super::markdown;

    #[test]
    fn the_documentation_holds_the_catalogue_as_it_is() {
        let page = include_str!("../../../docs/effects.md");
        for paragraph in markdown().split("\n### ") {
            let id = paragraph.lines().next().unwrap_or_default();
            assert!(page.contains(paragraph.trim()), "{id}: print it again with `arcsmith effects`");
        }
    }
}
