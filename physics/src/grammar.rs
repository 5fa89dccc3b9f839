//! Forms of dependences that have no name: a file of declarations with places for columns.

use crate::unit::Unit;

const GRAMMAR: &str = include_str!("grammar.toml");
const CURVES: &str = include_str!("curves.toml");
const BEGINS: &str = "[[effect]]";

/// Every form of a dependence on these columns and on the angle, as declarations that [`crate::declared`] reads.
///
/// # Example
/// ```
/// let forms = physics::forms(&["flow_l_min"]);
/// assert!(forms.iter().any(|form| form.contains("adds = \"k * lowpass(flow_l_min, tau)\"")));
/// assert!(forms.iter().any(|form| form.contains("k = { unit = \"p/(l/min)\" }")));
/// ```
pub fn forms(columns: &[&str]) -> Vec<String> {
    of_columns(GRAMMAR, columns)
}

/// Curves over these columns and the angle, and what they remember, for where no form describes a dependence.
pub fn curves(columns: &[&str]) -> Vec<String> {
    of_columns(CURVES, columns)
}

/// The declarations of a file with every column in its places.
fn of_columns(file: &str, columns: &[&str]) -> Vec<String> {
    let mut forms = Vec::new();
    // Comments are for the reader of the file: one stands before the form that it is about, and so behind another.
    let lines: Vec<&str> = file.lines().filter(|line| !line.starts_with('#')).collect();
    for form in lines.join("\n").split(BEGINS).skip(1).map(|form| format!("{BEGINS}{}\n", form.trim_end())) {
        match (form.contains("{z}"), form.contains("{w}")) {
            (false, _) if form.contains("{shaft}") => {
                let shafts = columns.iter().filter(|column| is_angle(column));
                forms.extend(shafts.map(|column| with(&form, "{shaft}", "{u}", column)));
            }
            (false, _) => forms.push(form),
            (true, false) => forms.extend(columns.iter().map(|column| with(&form, "{z}", "{u}", column))),
            (true, true) => {
                for (k, other) in columns.iter().enumerate() {
                    let form = with(&form, "{w}", "{v}", other);
                    forms.extend(columns[..k].iter().map(|column| with(&form, "{z}", "{u}", column)));
                }
            }
        }
    }
    forms
}

/// Whether a column is an angle.
fn is_angle(column: &str) -> bool {
    Unit::of_column(column).in_units_of(&Unit::named("deg")).is_some()
}

/// A form with a column in its place, and the column's unit.
fn with(form: &str, place: &str, of_unit: &str, column: &str) -> String {
    let unit = Unit::of_column(column).to_string();
    let one = unit.chars().all(char::is_alphabetic);
    form.replace(place, column).replace(of_unit, &if one { unit } else { format!("({unit})") })
}
