//! An expression as firmware computes it: parameters are numbers, names are observables, units are settled.

use fitter::terms::{Expressed, Operator, Side, Term};
use physics::{ELEMENTS, Interval, Node, Operation};

/// See the module.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Tree {
    /// A constant.
    Number(f64),
    /// What is observed, by its name in a recording.
    Observed(String),
    /// An operator on its arguments, which are in the units that it needs.
    Apply(Operation, Vec<Tree>),
}

impl Tree {
    /// What a term adds, of a kind that is an expression or can be written as one.
    ///
    /// # Errors
    /// It is of another kind, or cannot be read.
    pub fn of_term(term: &Term, pair: bool) -> Result<Tree, String> {
        let observed = |name: &String| Tree::Observed(name.clone());
        let number = Tree::Number;
        let tree = match &term.operator {
            Operator::Expression(expressed) => return Tree::of(expressed, &term.coefficients, pair),
            Operator::Lag(lag) => {
                let mut of = vec![observed(&lag.observable), number(lag.time_constant_s)];
                of.extend(lag.initial.map(number));
                let lagged = Tree::Apply(Operation::LowPass, of);
                Tree::Apply(Operation::Difference, vec![lagged, number(lag.mean)])
            }
            Operator::Rate(rate) => Tree::Apply(Operation::Rate, vec![observed(&rate.observable)]),
            Operator::Hinge(hinge) => {
                let ends = [observed(&hinge.observable), number(hinge.threshold)];
                let [from, to] = if hinge.side == Side::Above { [1, 0] } else { [0, 1] };
                Tree::Apply(Operation::Hinge, vec![ends[to].clone(), ends[from].clone()])
            }
            Operator::Step(step) => {
                Tree::Apply(Operation::Step, vec![observed(&step.observable), number(step.at)])
            }
            other => return Err(format!("`{}` is no expression", other.kind())),
        };
        Ok(tree.times(term.coefficients[0]))
    }

    /// The expression of a term with these coefficients of its factors.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn of(expressed: &Expressed, coefficients: &[f64], pair: bool) -> Result<Tree, String> {
        let sentence = expressed.sentence(pair)?;
        let fixed = expressed.parameters.iter().map(|fixed| fixed.value);
        let values: Vec<f64> = coefficients.iter().copied().chain(fixed).collect();
        Tree::of_node(sentence.tree(), &values, (pair, expressed))
    }

    fn of_node(node: &Node, values: &[f64], (pair, of): (bool, &Expressed)) -> Result<Tree, String> {
        Ok(match node {
            Node::Constant(value) => Tree::Number(*value),
            Node::Column(name) => {
                let seen = Tree::Observed(Expressed::observable(name, pair, &of.unit)?.0.into());
                let Some([from, to]) = of.limits.get(name) else { return Ok(seen) };
                let above = Tree::Apply(Operation::Max, vec![seen, Tree::Number(*from)]);
                Tree::Apply(Operation::Min, vec![above, Tree::Number(*to)])
            }
            Node::Parameter(index) => Tree::Number(values[*index]),
            Node::Apply(applied) => {
                let arguments = applied.arguments.iter().map(|(argument, factor)| {
                    let tree = Tree::of_node(argument, values, (pair, of))?;
                    Ok(if *factor == 1.0 { tree } else { tree.times(*factor) })
                });
                Tree::Apply(applied.operation(), arguments.collect::<Result<_, String>>()?)
            }
        })
    }

    /// Multiplied by a number.
    pub fn times(self, factor: f64) -> Tree {
        Tree::Apply(Operation::Product, vec![Tree::Number(factor), self])
    }

    /// Whether it holds what depends on the time between two calls.
    pub fn needs_period(&self) -> bool {
        let Tree::Apply(operation, arguments) = self else { return false };
        matches!(operation, Operation::LowPass | Operation::Rate | Operation::Delay)
            || arguments.iter().any(Tree::needs_period)
    }

    /// What it is at the first call, when every memory begins: the same, without memory.
    pub fn at_start(&self) -> Tree {
        let Tree::Apply(operation, arguments) = self else { return self.clone() };
        let of: Vec<Tree> = arguments.iter().map(Tree::at_start).collect();
        let apply = |operation, of: &[&Tree]| Tree::Apply(operation, of.iter().copied().cloned().collect());
        // What follows from `start` across a gap of ±r.
        let following = |start: &Tree, r: &Tree| {
            let below = apply(Operation::Difference, &[&of[0], r]);
            let above = apply(Operation::Sum, &[&of[0], r]);
            let raised = apply(Operation::Max, &[start, &below]);
            apply(Operation::Min, &[&raised, &above])
        };
        match (operation, of.get(2)) {
            (Operation::Rate, _) => Tree::Number(0.0),
            (Operation::LowPass, Some(start)) => start.clone(),
            (Operation::LowPass | Operation::Delay | Operation::Play | Operation::Plays, None) => {
                of[0].clone()
            }
            (Operation::Play, Some(start)) => following(start, &of[1]),
            (Operation::Plays, Some(start)) => {
                let count = match of.get(3) {
                    Some(Tree::Number(count)) => count.round() as usize,
                    _ => ELEMENTS,
                };
                let share = |k: usize| of[1].clone().times(k as f64 / count as f64);
                let elements = (1..=count).map(|k| following(start, &share(k)));
                let sum = elements.reduce(|a, b| Tree::Apply(Operation::Sum, vec![a, b]));
                sum.unwrap_or(Tree::Number(0.0)).times(1.0 / count as f64)
            }
            _ => Tree::Apply(*operation, of),
        }
    }

    /// Whether its value depends on the calls before.
    pub fn remembers(&self) -> bool {
        match self {
            Tree::Apply(operation, of) => operation.remembers() || of.iter().any(Tree::remembers),
            _ => false,
        }
    }

    /// Its parts that are observed.
    pub fn observed(&self) -> Vec<&Tree> {
        match self {
            Tree::Number(_) => Vec::new(),
            Tree::Observed(_) => vec![self],
            Tree::Apply(_, of) => of.iter().flat_map(Tree::observed).collect(),
        }
    }

    /// Where something observed is compared with a number: its name and the number.
    pub fn thresholds(&self) -> Vec<(String, f64)> {
        let Tree::Apply(operation, of) = self else { return Vec::new() };
        let mut found: Vec<(String, f64)> = of.iter().flat_map(Tree::thresholds).collect();
        if let [Tree::Observed(name), Tree::Number(at), ..] = &of[..] {
            let numbers: Vec<f64> = of.iter().map(|of| of.at(&|_| f64::NAN)).collect();
            match operation {
                Operation::Table => {
                    found.extend(physics::table::places(&numbers).map(|at| (name.clone(), at)))
                }
                _ => found.push((name.clone(), *at)),
            }
        }
        found
    }

    /// About what it can be, calls coming every `period_s`: in `f64`, for choices and estimates, never for proof.
    ///
    /// # Errors
    /// A sentence, where it has no value somewhere.
    pub fn interval(&self, observed: &dyn Fn(&str) -> Interval, period_s: f64) -> Result<Interval, String> {
        match self {
            Tree::Number(value) => Ok(Interval::point(*value)),
            Tree::Observed(name) => Ok(observed(name)),
            Tree::Apply(operation, of) => {
                let of = of.iter().map(|argument| argument.interval(observed, period_s));
                let of = of.collect::<Result<Vec<Interval>, String>>()?;
                if *operation == Operation::Rate {
                    let most = (of[0].to - of[0].from) / period_s;
                    return Ok(Interval { from: -most, to: most });
                }
                operation.interval(&of)
            }
        }
    }

    /// Its value where it has no memory, or at a first call.
    pub fn at(&self, observed: &dyn Fn(&str) -> f64) -> f64 {
        match self {
            Tree::Number(value) => *value,
            Tree::Observed(name) => observed(name),
            Tree::Apply(operation, of) => {
                let of: Vec<f64> = of.iter().map(|argument| argument.at(observed)).collect();
                operation.at(&of).0
            }
        }
    }
}
