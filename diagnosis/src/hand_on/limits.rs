//! How far beyond the recorded range of a column a form without a name goes on. One that sets in near the end of the range has
//! been seen in few rows: going on as far as another form it would add many times what the recording shows.

use std::borrow::Cow;
use std::collections::BTreeMap;

use fitter::terms::Expressed;
use numerics::range;
use physics::{Columns, Sentence, Time};

use crate::effects::Read;
use crate::rows::Rows;
use crate::thresholds::hand_on::{BEYOND, GROWS};

/// Between which values each of these columns counts, in its unit. `coefficients` are what multiplies the factors.
pub fn limits(
    expressed: &Expressed,
    coefficients: &[f64],
    columns: &[&str],
    rows: &Rows,
) -> BTreeMap<String, [f64; 2]> {
    let fixed = expressed.parameters.iter().map(|fixed| fixed.value);
    let values: Vec<f64> = coefficients.iter().copied().chain(fixed).collect();
    let sentence = expressed.sentence(rows.pair).ok();
    let within = |name: &&str| {
        let (from, to) = range(&Read(rows).column(name)?);
        let side = |sign: f64| {
            let most = sign * BEYOND * (to - from);
            sentence.as_ref().map_or(most, |sentence| most * part(sentence, &values, name, most, rows))
        };
        Some((name.to_string(), [from + side(-1.0), to + side(1.0)]))
    };
    columns.iter().filter_map(within).collect()
}

/// The largest of 1, 1/2, 1/4 and 1/8 of the way at which what is added spans no more than [`GROWS`] times what it spans in the
/// recording; else 0.
fn part(sentence: &Sentence, values: &[f64], name: &str, most: f64, rows: &Rows) -> f64 {
    let added = |by: f64| sentence.values(&Moved { rows, name, by }, values).unwrap_or_default();
    let (low, high) = range(&added(0.0));
    let near = |part: &f64| {
        let (lowest, highest) = range(&added(part * most));
        highest.max(high) - lowest.min(low) <= GROWS * (high - low)
    };
    [1.0, 0.5, 0.25, 0.125].into_iter().find(near).unwrap_or(0.0)
}

/// A recording in which one column is higher by so much in every row.
struct Moved<'a> {
    rows: &'a Rows,
    name: &'a str,
    by: f64,
}

impl Columns for Moved<'_> {
    fn column(&self, name: &str) -> Option<Cow<'_, [f64]>> {
        let recording = Read(self.rows);
        let read = recording.column(name)?;
        if name != self.name {
            return Some(Cow::Owned(read.into_owned()));
        }
        Some(read.iter().map(|value| value + self.by).collect())
    }

    fn time(&self) -> Time<'_> {
        Time { t_s: &self.rows.t_s, pass: &self.rows.pass }
    }
}

#[cfg(test)]
mod tests {
    use super::limits;
    use crate::rows::{Column, Rows};
    use fitter::terms::{Expressed, ExpressionFactor};

    #[test]
    fn what_sets_in_near_the_end_of_a_column_goes_no_farther_than_it_was_seen_to() {
        let values: Vec<f64> = (0..=100).map(f64::from).collect();
        let t_s = values.clone();
        let rows = Rows {
            unit: "mm".into(),
            pass: vec![1; 101],
            t_s,
            extra: vec![Column { name: "load_n".into(), values }],
            ..Rows::default()
        };
        let factor = ExpressionFactor { name: "k".into(), unit: "mm/N".into() };
        let form = |text: &str| Expressed::of(text.into(), "mm", false, vec![factor.clone()], Vec::new());
        let of = |text: &str| limits(&form(text), &[3.0], &["load_n"], &rows)["load_n"];
        assert_eq!(of("k * load_n"), [-25.0, 125.0]);
        // Beyond 92 eight more were seen, and 6.25 is the largest part of 25 that does not exceed them.
        assert_eq!(of("k * hinge(load_n, 92 [N])"), [-25.0, 106.25]);
        assert_eq!(of("k * hinge(-load_n, -8 [N])"), [-6.25, 125.0]);
    }
}
