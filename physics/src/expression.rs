//! An expression as it was written: numbers, names, and operators applied to expressions.

use std::fmt;
use std::ops::Range;

use crate::operator::Operator;
use crate::unit::Unit;

/// An expression with the place in the text that it was read from.
#[derive(Clone, Debug)]
pub struct Expression {
    /// What it is.
    pub(crate) kind: Kind,
    /// Bytes of the text.
    pub(crate) span: Range<usize>,
}

/// What an expression is.
#[derive(Clone)]
pub(crate) enum Kind {
    /// A number; without a unit it takes that of what it is added to or compared with.
    Number(f64, Option<Unit>),
    /// A column of the recording, or a parameter.
    Name(String),
    /// An operator with its arguments.
    Call(&'static dyn Operator, Vec<Expression>),
}

impl fmt::Debug for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Kind::Number(value, unit) => f.debug_tuple("Number").field(value).field(unit).finish(),
            Kind::Name(name) => f.debug_tuple("Name").field(name).finish(),
            Kind::Call(operator, arguments) => {
                f.debug_tuple("Call").field(&operator.name()).field(arguments).finish()
            }
        }
    }
}

/// Places in the text do not count.
impl PartialEq for Expression {
    fn eq(&self, other: &Expression) -> bool {
        match (&self.kind, &other.kind) {
            (Kind::Number(a, of_a), Kind::Number(b, of_b)) => a.to_bits() == b.to_bits() && of_a == of_b,
            (Kind::Name(a), Kind::Name(b)) => a == b,
            (Kind::Call(a, of_a), Kind::Call(b, of_b)) => a.name() == b.name() && of_a == of_b,
            _ => false,
        }
    }
}

/// As it can be read again, with no more brackets than are needed.
impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.kind {
            Kind::Number(value, None) => write!(f, "{value}"),
            Kind::Number(value, Some(unit)) => write!(f, "{value} [{unit}]"),
            Kind::Name(name) => f.write_str(name),
            Kind::Call(operator, arguments) => operator.write(arguments, f),
        }
    }
}

/// How tightly the parts of an expression hold together: an operand that holds less tightly than its operator asks for
/// stands in brackets.
pub(crate) mod binding {
    /// Sums.
    pub const SUM: u8 = 1;
    /// Products.
    pub const PRODUCT: u8 = 2;
    /// A sign.
    pub const SIGN: u8 = 3;
    /// Powers.
    pub const POWER: u8 = 4;
    /// Numbers, names, calls.
    pub const WHOLE: u8 = 5;
}

impl Expression {
    /// How tightly it holds together.
    pub(crate) fn binding(&self) -> u8 {
        match &self.kind {
            Kind::Call(operator, _) => operator.binding(),
            Kind::Number(value, _) if value.is_sign_negative() => binding::SIGN,
            _ => binding::WHOLE,
        }
    }

    /// It as an operand of what asks for `least`.
    pub(crate) fn within(&self, least: u8) -> String {
        if self.binding() < least { format!("({self})") } else { self.to_string() }
    }

    /// Every name in it, once, in the order of the text.
    pub fn names(&self) -> Vec<&str> {
        let mut names = Vec::new();
        self.visit(&mut |part| match &part.kind {
            Kind::Name(name) if !names.contains(&name.as_str()) => names.push(name.as_str()),
            _ => {}
        });
        names
    }

    /// The same with other names.
    #[must_use]
    pub fn renamed(&self, by: &dyn Fn(&str) -> Option<String>) -> Expression {
        let kind = match &self.kind {
            Kind::Name(name) => Kind::Name(by(name).unwrap_or_else(|| name.clone())),
            Kind::Call(operator, arguments) => {
                Kind::Call(*operator, arguments.iter().map(|argument| argument.renamed(by)).collect())
            }
            number => number.clone(),
        };
        Expression { kind, span: self.span.clone() }
    }

    fn visit<'a>(&'a self, see: &mut impl FnMut(&'a Expression)) {
        see(self);
        if let Kind::Call(_, arguments) = &self.kind {
            arguments.iter().for_each(|argument| argument.visit(see));
        }
    }
}

/// Whether a text is a name in files: small letters, digits and `_`, a letter first.
pub fn is_identifier(id: &str) -> bool {
    id.starts_with(|sign: char| sign.is_ascii_lowercase())
        && id.chars().all(|sign| sign.is_ascii_lowercase() || sign.is_ascii_digit() || sign == '_')
}
