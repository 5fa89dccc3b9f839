//! Physics as expressions: what a recording holds and what was fitted, put together by operators.
//!
//! An expression is read from text ([`parse`]), its names and units are checked ([`Sentence::read`]), and it is
//! evaluated over the rows of a recording with its derivatives by the parameters ([`Sentence::evaluate`]). Every
//! operator takes any expression whose unit fits, so that operators compose: a lag of a square, a rate of a difference.
//!
//! A sentence whose units are settled is a tree of operators ([`Sentence::tree`]), for whoever computes it otherwise than
//! over a recording; an [`Operation`] says which operator it is.
//!
//! [`declared`] reads effects that a user states in a file. A [`tape::Tape`] is what the right-hand sides of equations of
//! motion are compiled to.

#[cfg(feature = "declarations")]
mod catalogue;
mod check;
#[cfg(feature = "declarations")]
mod declaration;
mod error;
mod evaluate;
mod expression;
mod first_state;
mod grammar;
mod interval;
mod known;
pub mod number;
mod operator;
mod parse;
mod quantity;
pub mod tape;
mod unit;

#[cfg(feature = "declarations")]
pub use catalogue::{CATALOGUE, found_by_fit};
pub use check::{Applied, Names, Node, Parameter, Sentence};
#[cfg(feature = "declarations")]
pub use declaration::{
    DeclarationError, Declared, DeclaredParameter, Formula, Grid, Known, MISSING, Reported, Role, Scale,
    Since, Starts, Unsettled, Vocabulary, What, declared,
};
pub use error::ExpressionError;
pub use evaluate::{Columns, Time, Value};
pub use expression::{Expression, is_identifier};
pub use grammar::{curves, forms};
pub use interval::Interval;
pub use known::OverRows;
pub use operator::{ELEMENTS, Operation, Operator, table};
pub use parse::parse;
pub use unit::Unit;

#[cfg(test)]
#[cfg(feature = "declarations")]
mod tests;
