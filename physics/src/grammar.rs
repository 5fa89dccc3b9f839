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
        let mut filled: Vec<(String, Vec<usize>)> =
            with_states(form).into_iter().map(|form| (form, Vec::new())).collect();
        for place in &PLACES {
            filled = filled.into_iter().flat_map(|(form, used)| place.fill(form, &used, columns)).collect();
        }
        forms.extend(filled.into_iter().map(|(form, _)| form));
    }
    forms
}

/// Of a form that may be unsettled all that it can be, the settled one first; else the form alone.
fn with_states(form: String) -> Vec<String> {
    let Some(line) = form.lines().find(|line| line.starts_with("unsettled = ")) else { return vec![form] };
    let named = |id: &str, title: &str| {
        let form = form.replacen("id = \"", &format!("id = \"{id}_"), 1);
        form.replacen("\"\nadds", &format!(", {title}\"\nadds"), 1)
    };
    let settled = form.replacen(&format!("{line}\n"), "", 1);
    let from_start = named("unsettled", "from an unknown state");
    if !line.contains("pauses") {
        return vec![settled, from_start];
    }
    let from_start = from_start.replacen(line, &line.replace("pauses", "start"), 1);
    vec![settled, from_start, named("resumed", "from an unknown state after every pause")]
}

/// A place for a column in a form.
struct Place {
    name: &'static str,
    /// The place of the column's unit.
    unit: &'static str,
    /// Whether the column of this number may stand here beside those of other places.
    may: fn(k: usize, columns: &[&str], used: &[usize]) -> bool,
}

/// In the order in which they are filled. Of `{z}` and `{w}` a form says the same whichever is which.
const PLACES: [Place; 4] = [
    Place { name: "{shaft}", unit: "{u}", may: |k, columns, _| is_angle(columns[k]) },
    Place { name: "{w}", unit: "{v}", may: |_, _, _| true },
    Place { name: "{z}", unit: "{u}", may: |k, _, used| used.iter().all(|other| k < *other) },
    Place { name: "{other}", unit: "{v}", may: |k, _, used| !used.contains(&k) },
];

impl Place {
    /// A form with every column in this place that may stand there, and the numbers of its columns; the form itself where it has
    /// no such place.
    fn fill(&self, form: String, used: &[usize], columns: &[&str]) -> Vec<(String, Vec<usize>)> {
        if !form.contains(self.name) {
            return vec![(form, used.to_vec())];
        }
        let numbers = (0..columns.len()).filter(|k| (self.may)(*k, columns, used));
        numbers.map(|k| (with(&form, self.name, self.unit, columns[k]), [used, &[k]].concat())).collect()
    }
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
