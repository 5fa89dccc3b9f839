//! Where a lag begins on another recording than the one that it was found on: its state before the first row is not known there.

use std::convert::Infallible;
use std::ops::Range;

use crate::check::{Applied, Node, Sentence};
use crate::evaluate::Columns;

impl Sentence {
    /// The text where every lag that does not state its state before the first row begins at the mean of what it follows, if
    /// over the rows of `columns` its state was `nearer` times nearer to that mean (root mean square) than to what it follows.
    /// Other lags still begin at the first value of what they follow. `values` are those of the parameters.
    ///
    /// # Errors
    /// The name of a column that is missing.
    pub fn with_first_states(
        &self,
        columns: &dyn Columns,
        values: &[f64],
        nearer: f64,
    ) -> Result<String, String> {
        self.where_lags_begin(|lag| {
            // What follows something with a parameter begins with it: no number would go with its values.
            if lag.followed.has_parameter() {
                return Ok(None);
            }
            let state = lag.node.value(columns, values, false)?;
            let followed = lag.followed.value(columns, values, false)?.times(lag.factor);
            let rows = state.rows.len();
            let mean = (0..rows).map(|row| followed.at(row)).sum::<f64>() / rows as f64;
            let squares = |of: &dyn Fn(usize) -> f64| {
                (0..rows).map(|row| (state.at(row) - of(row)).powi(2)).sum::<f64>()
            };
            let is_nearer = nearer.powi(2) * squares(&|_| mean) < squares(&|row| followed.at(row));
            Ok(is_nearer.then_some(mean))
        })
    }

    /// The text where no lag states its state before the first row by a number.
    pub fn where_lags_state_nothing(&self) -> String {
        let mut stated = Vec::new();
        self.root.stated_lags(&mut stated);
        stated.sort_by_key(|span| std::cmp::Reverse(span.end));
        let mut text = self.text.clone();
        for span in stated {
            // A number holds no comma.
            if let Some(comma) = text[span.clone()].rfind(',') {
                text.replace_range(span.start + comma..span.end - 1, "");
            }
        }
        text
    }

    /// The text where every such lag begins at zero: a body that nothing has heated yet.
    pub fn from_nothing(&self) -> String {
        let Ok(text) = self.where_lags_begin(|_| Ok::<_, Infallible>(Some(0.0)));
        text
    }

    /// The text with a number for where a lag begins that does not state it, where there is one.
    fn where_lags_begin<E>(&self, start: impl Fn(&Lag) -> Result<Option<f64>, E>) -> Result<String, E> {
        let mut lags = Vec::new();
        self.root.unstated_lags(&mut lags);
        let mut text = self.text.clone();
        // From the end, so that the places before stay.
        lags.sort_by_key(|lag| std::cmp::Reverse(lag.span.end));
        for lag in &lags {
            if let Some(start) = start(lag)? {
                text.insert_str(lag.span.end - 1, &format!(", {start}"));
            }
        }
        Ok(text)
    }
}

/// A lag that does not state where it begins.
struct Lag<'a> {
    node: &'a Node,
    /// What it follows, with the factor that brings it to the lag's unit.
    followed: &'a Node,
    factor: f64,
    /// Its place in the text, up to its closing bracket.
    span: &'a Range<usize>,
}

impl Node {
    fn has_parameter(&self) -> bool {
        match self {
            Node::Parameter(_) => true,
            Node::Apply(applied) => applied.arguments.iter().any(|(argument, _)| argument.has_parameter()),
            Node::Constant(_) | Node::Column(_) => false,
        }
    }

    /// The places of lags that begin at a number.
    fn stated_lags(&self, found: &mut Vec<Range<usize>>) {
        let Node::Apply(Applied { operator, arguments, span, .. }) = self else { return };
        if let ("lowpass", [_, _, (Node::Constant(_), _)]) = (operator.name(), &arguments[..]) {
            found.push(span.clone());
        }
        arguments.iter().for_each(|(argument, _)| argument.stated_lags(found));
    }

    fn unstated_lags<'a>(&'a self, found: &mut Vec<Lag<'a>>) {
        let Node::Apply(Applied { operator, arguments, span, .. }) = self else { return };
        if let ("lowpass", [(followed, factor), _]) = (operator.name(), &arguments[..]) {
            found.push(Lag { node: self, followed, factor: *factor, span });
        }
        arguments.iter().for_each(|(argument, _)| argument.unstated_lags(found));
    }
}
