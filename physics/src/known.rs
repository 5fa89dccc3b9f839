//! An expression over one recording: what in it depends on no parameter is evaluated once.

use std::borrow::Cow;

use crate::check::{Applied, Node, Sentence};
use crate::evaluate::{Columns, Time};

/// See the module.
pub struct OverRows {
    root: Node,
    known: Vec<Vec<f64>>,
}

impl Sentence {
    /// The sentence over the rows that `columns` holds.
    pub fn over(&self, columns: &dyn Columns) -> OverRows {
        let mut known = Vec::new();
        let root = settled(&self.root, columns, &mut known);
        OverRows { root, known }
    }
}

impl OverRows {
    /// As [`Sentence::values`], over the same rows.
    ///
    /// # Errors
    /// The name of a column that is missing.
    pub fn values(&self, columns: &dyn Columns, values: &[f64]) -> Result<Vec<f64>, String> {
        let columns = WithKnown { known: &self.known, columns };
        Ok(self.root.value(&columns, values, false)?.rows)
    }
}

/// Columns, and what is known under its number, which is no column's name.
struct WithKnown<'a> {
    known: &'a [Vec<f64>],
    columns: &'a dyn Columns,
}

impl Columns for WithKnown<'_> {
    fn column(&self, name: &str) -> Option<Cow<'_, [f64]>> {
        match name.parse::<usize>() {
            Ok(number) => self.known.get(number).map(|values| Cow::Borrowed(&values[..])),
            Err(_) => self.columns.column(name),
        }
    }

    fn time(&self) -> Time<'_> {
        self.columns.time()
    }
}

/// A tree with a column in the place of every part that depends on no parameter and has a value.
fn settled(node: &Node, columns: &dyn Columns, known: &mut Vec<Vec<f64>>) -> Node {
    let value = match node {
        Node::Constant(_) => None,
        node if has_parameter(node) => None,
        node => node.value(columns, &[], false).ok(),
    };
    match (value, node) {
        // A column of the recording is at hand as it is.
        (Some(value), Node::Column(_)) if value.rows.len() > 1 => node.clone(),
        (Some(value), _) => {
            known.push(value.rows);
            Node::Column((known.len() - 1).to_string())
        }
        (None, Node::Apply(applied)) => {
            let of = applied.arguments.iter().map(|(of, factor)| (settled(of, columns, known), *factor));
            Node::Apply(Applied { arguments: of.collect(), ..applied.clone() })
        }
        (None, _) => node.clone(),
    }
}

fn has_parameter(node: &Node) -> bool {
    match node {
        Node::Parameter(_) => true,
        Node::Constant(_) | Node::Column(_) => false,
        Node::Apply(applied) => applied.arguments.iter().any(|(of, _)| has_parameter(of)),
    }
}
