//! From an expression to a sentence: every name known, every unit right, every factor a factor.

use std::ops::Range;

use crate::error::{ExpressionError, nearest};
use crate::expression::{Expression, Kind};
use crate::interval::Interval;
use crate::operator::{Operation, Operator};
use crate::parse::parse;
use crate::quantity::{Quantity, UnitError};
use crate::unit::Unit;

/// A parameter of an expression.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Its name in the expression.
    pub name: String,
    /// Its unit.
    pub unit: Unit,
    /// In which range its value lies, in its unit; none of a factor, on which the expression depends linearly.
    pub range: Option<Interval>,
}

/// What names mean.
pub struct Names<'a> {
    /// The unit of a column; none where there is no such column.
    pub column: &'a dyn Fn(&str) -> Option<Unit>,
    /// Columns to suggest.
    pub known: &'a [&'a str],
    /// Parameters.
    pub parameters: &'a [Parameter],
}

/// An expression whose names and units are right, ready to be evaluated.
#[derive(Debug, Clone)]
pub struct Sentence {
    /// As it was written.
    pub text: String,
    /// As it was read.
    pub expression: Expression,
    /// The unit of its values.
    pub unit: Unit,
    /// The columns that it reads.
    pub columns: Vec<String>,
    /// Its parameters, in the order in which their values are given.
    pub parameters: Vec<Parameter>,
    /// What is evaluated.
    pub root: Node,
}

/// What is evaluated: the tree of a sentence, whose units are settled.
#[derive(Clone)]
pub enum Node {
    /// A number.
    Constant(f64),
    /// The value of a column, by its name in the sentence, in the column's own unit.
    Column(String),
    /// A parameter, by its index in [`Sentence::parameters`], in its own unit.
    Parameter(usize),
    /// An operator on its arguments.
    Apply(Applied),
}

/// An operator on its arguments.
#[derive(Clone)]
pub struct Applied {
    /// The operator.
    pub operator: &'static dyn Operator,
    /// Every argument with the factor that brings it to the unit that the operator needs.
    pub arguments: Vec<(Node, f64)>,
    pub(crate) span: Range<usize>,
    /// The unit of what is computed of figures of the recording alone; none of anything else.
    pub(crate) unit: Option<Unit>,
}

impl Applied {
    /// Which operator it is.
    pub fn operation(&self) -> Operation {
        self.operator.operation()
    }
}

impl std::fmt::Debug for Node {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Node::Constant(value) => write!(f, "{value}"),
            Node::Column(name) => f.write_str(name),
            Node::Parameter(index) => write!(f, "#{index}"),
            Node::Apply(Applied { operator, arguments, .. }) => write!(f, "{}{arguments:?}", operator.name()),
        }
    }
}

impl Sentence {
    /// Reads an expression whose values are in `unit`; without one, in whatever unit it has.
    ///
    /// # Errors
    /// The place, with the name that is not known, the units that do not go together, or the parameter without a range
    /// that is no factor.
    pub fn read(text: &str, unit: Option<&Unit>, names: &Names) -> Result<Sentence, ExpressionError> {
        let expression = parse(text)?;
        let reader = Reader { text, names };
        let (root, found, _) = reader.read(&expression)?;
        let unit = unit.cloned().unwrap_or_else(|| found.unit());
        let whole = |what: String| ExpressionError::new(text, &expression.span, what);
        let factor = match &found {
            Quantity::Number(_) => 1.0,
            Quantity::Of(found) => found
                .in_units_of(&unit)
                .ok_or_else(|| whole(format!("the expression is in {found}, expected a value in {unit}")))?,
        };
        let root = scaled(root, factor, &expression.span);
        let used = expression.names();
        if let Some(idle) = names.parameters.iter().find(|parameter| !used.contains(&parameter.name.as_str()))
        {
            return Err(whole(format!(
                "the parameter `{}` is not in the expression: use it or drop it",
                idle.name
            )));
        }
        let is_parameter = |name: &&str| names.parameters.iter().any(|parameter| parameter.name == **name);
        let columns = used.iter().filter(|name| !is_parameter(name)).map(ToString::to_string).collect();
        let parameters = names.parameters.to_vec();
        Ok(Sentence { text: text.to_string(), unit, columns, parameters, root, expression })
    }

    /// What is evaluated, in its unit.
    pub fn tree(&self) -> &Node {
        &self.root
    }

    /// The interval of its values, in its unit, where every `column` has its least and its largest value in some row.
    ///
    /// # Errors
    /// The place of an operation that has no value somewhere in the intervals: a division by zero, a root of what is
    /// negative.
    pub fn interval(&self, column: &dyn Fn(&str) -> Interval) -> Result<Interval, ExpressionError> {
        self.interval_of(&self.root, column)
    }

    fn interval_of(
        &self,
        node: &Node,
        column: &dyn Fn(&str) -> Interval,
    ) -> Result<Interval, ExpressionError> {
        match node {
            Node::Constant(value) => Ok(Interval::point(*value)),
            Node::Column(name) => Ok(column(name)),
            Node::Parameter(index) => {
                let unbounded = Interval { from: f64::NEG_INFINITY, to: f64::INFINITY };
                Ok(self.parameters[*index].range.unwrap_or(unbounded))
            }
            Node::Apply(Applied { operator, arguments, span, .. }) => {
                if let [(Node::Column(name), 1.0)] = &arguments[..]
                    && let Some(interval) = operator.interval_of_column(column(name))
                {
                    return Ok(interval);
                }
                let of = arguments.iter().map(|(argument, factor)| {
                    self.interval_of(argument, column)
                        .map(|interval| Interval::corners(interval, Interval::point(*factor), |a, b| a * b))
                });
                let of = of.collect::<Result<Vec<_>, _>>()?;
                operator.interval(&of).map_err(|what| ExpressionError::new(&self.text, span, what))
            }
        }
    }

    /// Whether a value depends on the rows before.
    pub fn remembers(&self) -> bool {
        fn remembers(node: &Node) -> bool {
            match node {
                Node::Apply(Applied { operator, arguments, .. }) if !operator.of_recording() => {
                    operator.remembers() || arguments.iter().any(|(argument, _)| remembers(argument))
                }
                _ => false,
            }
        }
        remembers(&self.root)
    }
}

fn scaled(node: Node, factor: f64, span: &Range<usize>) -> Node {
    if factor == 1.0 {
        return node;
    }
    let arguments = vec![(node, factor), (Node::Constant(1.0), 1.0)];
    Node::Apply(Applied { operator: crate::operator::PRODUCT, arguments, span: span.clone(), unit: None })
}

/// Looks names and units up.
struct Reader<'a> {
    text: &'a str,
    names: &'a Names<'a>,
}

impl Reader<'_> {
    fn refuse(&self, span: &Range<usize>, what: String) -> ExpressionError {
        ExpressionError::new(self.text, span, what)
    }

    /// What is evaluated, its unit, and the power of the factors in it.
    fn read(&self, expression: &Expression) -> Result<(Node, Quantity, u32), ExpressionError> {
        match &expression.kind {
            Kind::Number(value, None) => Ok((Node::Constant(*value), Quantity::Number(*value), 0)),
            Kind::Number(value, Some(unit)) => Ok((Node::Constant(*value), Quantity::Of(unit.clone()), 0)),
            Kind::Name(name) => self.name(name, &expression.span),
            Kind::Call(operator, arguments) => self.call(*operator, arguments, &expression.span),
        }
    }

    fn name(&self, name: &str, span: &Range<usize>) -> Result<(Node, Quantity, u32), ExpressionError> {
        let Names { column, known, parameters } = self.names;
        if let Some(index) = parameters.iter().position(|parameter| parameter.name == name) {
            let Parameter { unit, range, .. } = &parameters[index];
            return Ok((Node::Parameter(index), Quantity::Of(unit.clone()), u32::from(range.is_none())));
        }
        let unit = column(name).ok_or_else(|| {
            let names =
                known.iter().copied().chain(parameters.iter().map(|parameter| parameter.name.as_str()));
            let mend = match nearest(name, names) {
                Some(near) => format!("perhaps `{near}`"),
                None => "a column of the recording or a declared parameter".to_string(),
            };
            self.refuse(span, format!("`{name}` is not known, expected {mend}"))
        })?;
        Ok((Node::Column(name.to_string()), Quantity::Of(unit), 0))
    }

    fn call(
        &self,
        operator: &'static dyn Operator,
        arguments: &[Expression],
        span: &Range<usize>,
    ) -> Result<(Node, Quantity, u32), ExpressionError> {
        let mut nodes = Vec::with_capacity(arguments.len());
        let (mut quantities, mut degrees) = (Vec::new(), Vec::new());
        for argument in arguments {
            let (node, quantity, degree) = self.read(argument)?;
            nodes.push(node);
            quantities.push(quantity);
            degrees.push(degree);
        }
        let (quantity, factors) = operator.unit(&quantities).map_err(|error| {
            let place = match &error {
                UnitError::Differ(..) => span,
                UnitError::Needs(unit, _) => (arguments.iter().zip(&quantities))
                    .find(|(_, quantity)| quantity.unit() == *unit)
                    .map_or(span, |(argument, _)| &argument.span),
                UnitError::Exponent => arguments.last().map_or(span, |argument| &argument.span),
            };
            self.refuse(place, format!("`{}`: {error}", operator.name()))
        })?;
        let degree = operator.degree(&degrees).filter(|degree| *degree <= 1).ok_or_else(|| {
            let factor = self.names.parameters.iter().filter(|parameter| parameter.range.is_none());
            let names = arguments.iter().flat_map(Expression::names).collect::<Vec<_>>();
            let name = factor.map(|factor| &factor.name).find(|name| names.contains(&name.as_str()));
            let name = name.map_or("", String::as_str);
            self.refuse(
                span,
                format!("`{name}` is no mere factor of the whole here: give it a range (from, to), or correct the expression"),
            )
        })?;
        let arguments = nodes.into_iter().zip(factors).collect();
        let mut applied = Applied { operator, arguments, span: span.clone(), unit: None };
        applied.unit = applied.is_figure().then(|| quantity.unit());
        Ok((Node::Apply(applied), quantity, degree))
    }
}
