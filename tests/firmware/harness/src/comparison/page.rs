//! The comparison's committed figures and its page: what they claim, and whether that holds.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

use minijinja::{Environment, Value, context};
use serde::Deserialize;

use super::{Count, Row};
use crate::cases;
use crate::problem::Problem;
use crate::table;

/// The committed figures.
pub fn path() -> PathBuf {
    cases::folder().join("comparison.json")
}

/// The page for people.
pub fn page() -> PathBuf {
    cases::folder().join("../../docs/comparison.md")
}

/// Renders the page.
///
/// # Errors
/// [`Problem::Content`] where the template is defective.
pub fn render(rows: &[Row]) -> Result<String, Problem> {
    let path = cases::folder().join("comparison/page.md.jinja");
    let template = std::fs::read_to_string(&path).map_err(Problem::file(&path))?;
    let power = |value: f64| format!("{value:.1e}");
    let cells = |row: &Row| {
        context! {
            what => &*row.what, ours => row.ours,
            gcc => described(&row.gcc), clang => described(&row.clang),
            flash => row.flash_bytes, stack => row.stack_bytes,
            worst => power(row.worst_arcsec), bound => row.bound_arcsec.map(power),
            by => winner(row, rows).map(|w| &*w.what),
        }
    };
    let cells: Vec<Value> = rows.iter().map(cells).collect();
    let text = Environment::new().render_str(&template, context! { rows => cells, bounds => bounds()? });
    text.map(|t| t + "\n").map_err(|e| Problem::Content { path, message: format!("{e:#}") })
}

/// What `benches/compare/expert` wrote: proven bounds beside those of Sollya and Gappa.
#[derive(Deserialize)]
struct Bounds {
    summaries: Vec<BTreeMap<String, String>>,
    paper: Vec<BTreeMap<String, String>>,
}

fn bounds() -> Result<Value, Problem> {
    let path = cases::folder().join("../../benches/compare/expert/bounds.json");
    let text = std::fs::read_to_string(&path).map_err(Problem::file(&path))?;
    let read: Bounds =
        serde_json::from_str(&text).map_err(|e| Problem::Content { path, message: e.to_string() })?;
    let rows =
        |rows: Vec<BTreeMap<String, String>>| rows.into_iter().map(Value::from_pairs).collect::<Vec<_>>();
    Ok(context! { summaries => rows(read.summaries), paper => rows(read.paper) })
}

fn described(count: &Count) -> String {
    let mut text = count.average.to_string();
    if count.fewest != count.most {
        let _ = write!(text, " ({}…{})", count.fewest, count.most);
    }
    text
}

/// The routine of ours with the smallest error among those that beat an alternative: in instructions (both
/// compilers) and in error; double precision in instructions only, a hundredfold.
fn winner<'a>(row: &Row, rows: &'a [Row]) -> Option<&'a Row> {
    let beats = |our: &&Row| {
        if row.what.contains("double") {
            row.gcc.average >= 100 * our.gcc.average && row.clang.average >= 100 * our.clang.average
        } else {
            our.gcc.average < row.gcc.average
                && our.clang.average < row.clang.average
                && our.worst_arcsec < row.worst_arcsec
        }
    };
    let ours = rows.iter().filter(|r| r.ours).filter(beats);
    ours.min_by(|a, b| a.worst_arcsec.total_cmp(&b.worst_arcsec))
}

/// The alternatives that no routine of ours beats, a line each.
pub fn unbeaten(rows: &[Row]) -> Vec<String> {
    let lost = rows.iter().filter(|r| !r.ours && winner(r, rows).is_none());
    lost.map(|r| format!("{} is not beaten", r.what)).collect()
}

/// Writes the figures and the page.
///
/// # Errors
/// [`Problem::File`] where they cannot be written.
pub fn write(rows: &[Row]) -> Result<(), Problem> {
    let page = page();
    if let Some(folder) = page.parent() {
        std::fs::create_dir_all(folder).map_err(Problem::file(folder))?;
    }
    table::write_json(&path(), &rows)?;
    table::write_text(&page, &render(rows)?)
}

/// Holds the committed figures against what they claim, and the page against them.
///
/// # Errors
/// [`Problem::Figures`] with what does not hold.
pub fn committed() -> Result<Vec<Row>, Problem> {
    let path = path();
    let text = std::fs::read_to_string(&path).map_err(Problem::file(&path))?;
    let rows: Vec<Row> = serde_json::from_str(&text)
        .map_err(|e| Problem::Content { path: path.clone(), message: e.to_string() })?;
    let shown = std::fs::read_to_string(page()).map_err(Problem::file(page()))?;
    if shown != render(&rows)? {
        return Err(Problem::Figures(format!(
            "docs/comparison.md is not what comparison.json says: {AGAIN}"
        )));
    }
    let lost = unbeaten(&rows);
    if lost.is_empty() { Ok(rows) } else { Err(Problem::Figures(lost.join("\n"))) }
}

const AGAIN: &str = "where that is meant: cargo run --release -p firmware-tests -- record";

/// Holds `found` against the committed figures; those of other compilers than `instructions.json` was made by
/// are not compared.
///
/// # Errors
/// [`Problem::Figures`] with what differs, or which alternative is not beaten.
pub fn check(found: &[Row], same_compilers: bool) -> Result<(), Problem> {
    let committed = committed()?;
    let lost = unbeaten(found);
    if !lost.is_empty() {
        return Err(Problem::Figures(lost.join("\n")));
    }
    if same_compilers && committed != found {
        let differs =
            |(before, now): (&Row, &Row)| (before != now).then(|| format!("now {now:?}\nwas {before:?}"));
        let lines: Vec<String> = committed.iter().zip(found).filter_map(differs).collect();
        return Err(Problem::Figures(format!("the comparison differs; {AGAIN}\n{}", lines.join("\n"))));
    }
    Ok(())
}
