//! From text to an expression.
//!
//! Numbers may carry a unit in square brackets (`10 [V]`). Powers bind more tightly than a sign, a sign more tightly
//! than products, products more tightly than sums; equal ones from left to right.

use std::ops::Range;

use winnow::ascii::{digit1, multispace0};
use winnow::combinator::{
    Infix, Postfix, Prefix, alt, cut_err, delimited, expression, fail, not, opt, preceded, separated,
};
use winnow::error::{ContextError, ErrMode, StrContext, StrContextValue};
use winnow::prelude::*;
use winnow::stream::LocatingSlice;
use winnow::token::{one_of, take_while};

use crate::error::{ExpressionError, nearest};
use crate::expression::{Expression, Kind, binding};
use crate::operator::{self, Operator};
use crate::unit::Unit;

/// Longest text of one expression.
const LONGEST: usize = 4096;
/// Deepest nesting of one expression.
const DEEPEST: usize = 100;

/// Reads an expression.
///
/// # Errors
/// The place that is none, with what was found and what is expected.
///
/// # Example
/// ```
/// let lag = physics::parse("k*lowpass(coil_a^2, tau)")?;
/// assert_eq!(lag.to_string(), "k * lowpass(coil_a^2, tau)");
/// assert_eq!(lag.names(), ["k", "coil_a", "tau"]);
/// # Ok::<(), physics::ExpressionError>(())
/// ```
pub fn parse(text: &str) -> Result<Expression, ExpressionError> {
    let refuse = |span: Range<usize>, what: String| ExpressionError::new(text, &span, what);
    if text.len() > LONGEST {
        return Err(refuse(0..0, format!("the expression has more than {LONGEST} bytes: state it in parts")));
    }
    if let Some(at) = too_deep(text) {
        return Err(refuse(at..at + 1, format!("nested more than {DEEPEST} deep: state it in parts")));
    }
    let parsed =
        delimited(multispace0, sum, multispace0).parse(LocatingSlice::new(text)).map_err(|error| {
            let at = error.offset();
            let found = text[at..].chars().next();
            let expected = error.inner().context().find_map(|context| match context {
                StrContext::Expected(StrContextValue::Description(what)) => Some(*what),
                _ => None,
            });
            let expected = expected.unwrap_or("an operator or the end");
            let shown = found.map_or_else(|| "the end".to_string(), |sign| format!("`{sign}`"));
            refuse(at..at + found.map_or(0, char::len_utf8), format!("found {shown}, expected {expected}"))
        })?;
    resolved(text, parsed, 0)
}

/// Where brackets, signs and powers would nest too deeply for a reader that calls itself for each.
fn too_deep(text: &str) -> Option<usize> {
    let (mut open, mut powers, mut signs) = (0_usize, 0, 0);
    text.char_indices().find_map(|(at, sign)| {
        match sign {
            '(' => open += 1,
            ')' => open = open.saturating_sub(1),
            '^' => powers += 1,
            _ => {}
        }
        signs = if sign == '-' {
            signs + 1
        } else if sign.is_whitespace() {
            signs
        } else {
            0
        };
        (open + powers + signs > DEEPEST).then_some(at)
    })
}

type Input<'a> = LocatingSlice<&'a str>;

/// An expression whose functions and units are still words.
struct Parsed<'a> {
    what: What<'a>,
    span: Range<usize>,
}

enum What<'a> {
    Number(f64, Option<(&'a str, Range<usize>)>),
    Name(&'a str),
    Operation(&'static dyn Operator, Vec<Parsed<'a>>),
    Function(&'a str, Vec<Parsed<'a>>),
}

/// Functions and units looked up.
fn resolved(text: &str, parsed: Parsed<'_>, depth: usize) -> Result<Expression, ExpressionError> {
    let Parsed { what, span } = parsed;
    let refuse = |what: String| ExpressionError::new(text, &span, what);
    if depth > DEEPEST {
        return Err(refuse(format!("nested more than {DEEPEST} deep: state it in parts")));
    }
    let (operator, arguments) = match what {
        What::Number(value, None) => return Ok(Expression { kind: Kind::Number(value, None), span }),
        What::Number(value, Some((unit, place))) => {
            let unit = Unit::parse(unit).map_err(|what| ExpressionError::new(text, &place, what))?;
            return Ok(Expression { kind: Kind::Number(value, Some(unit)), span });
        }
        What::Name(name) => return Ok(Expression { kind: Kind::Name(name.to_string()), span }),
        What::Operation(operator, arguments) => (operator, arguments),
        What::Function(name, arguments) => {
            let operator = operator::function(name).ok_or_else(|| {
                let names = || operator::FUNCTIONS.iter().map(|operator| operator.name());
                let mend = nearest(name, names()).map_or_else(
                    || format!("one of {}", names().collect::<Vec<_>>().join(", ")),
                    |near| format!("perhaps `{near}`"),
                );
                refuse(format!("`{name}` is no function, expected {mend}"))
            })?;
            (operator, arguments)
        }
    };
    let count = &operator.form().arguments;
    if !count.contains(&arguments.len()) {
        let expected = match (*count.start(), *count.end()) {
            (least, most) if least == most => least.to_string(),
            (least, most) => format!("{least} to {most}"),
        };
        let (name, found) = (operator.name(), arguments.len());
        return Err(refuse(format!(
            "`{name}` has {found} arguments, expected {expected}: {}",
            operator.form().usage
        )));
    }
    let arguments = arguments.into_iter().map(|argument| resolved(text, argument, depth + 1));
    Ok(Expression { kind: Kind::Call(operator, arguments.collect::<Result<_, _>>()?), span })
}

fn expect(what: &'static str) -> StrContext {
    StrContext::Expected(StrContextValue::Description(what))
}

fn sum<'a>(input: &mut Input<'a>) -> ModalResult<Parsed<'a>> {
    const SUM: i64 = binding::SUM as i64;
    const PRODUCT: i64 = binding::PRODUCT as i64;
    const SIGN: i64 = binding::SIGN as i64;
    const POWER: i64 = binding::POWER as i64;
    fn both<'a>(operator: &'static dyn Operator, a: Parsed<'a>, b: Parsed<'a>) -> ModalResult<Parsed<'a>> {
        let span = a.span.start..b.span.end;
        Ok(Parsed { what: What::Operation(operator, vec![a, b]), span })
    }
    let sign = |sign: char| delimited(multispace0, one_of(sign), multispace0);
    expression(operand)
        .prefix(sign('-').value(Prefix(SIGN, |_: &mut Input<'a>, a: Parsed<'a>| {
            let span = a.span.start.saturating_sub(1)..a.span.end;
            Ok(Parsed { what: What::Operation(operator::NEGATIVE, vec![a]), span })
        })))
        .postfix(fail::<_, Postfix<Input<'a>, Parsed<'a>, ErrMode<ContextError>>, _>)
        .infix(alt((
            sign('+').value(Infix::Left(SUM, |_: &mut Input<'a>, a, b| both(operator::SUM, a, b))),
            sign('-').value(Infix::Left(SUM, |_: &mut Input<'a>, a, b| both(operator::DIFFERENCE, a, b))),
            sign('*').value(Infix::Left(PRODUCT, |_: &mut Input<'a>, a, b| both(operator::PRODUCT, a, b))),
            sign('/').value(Infix::Left(PRODUCT, |_: &mut Input<'a>, a, b| both(operator::QUOTIENT, a, b))),
            sign('^').value(Infix::Right(POWER, |_: &mut Input<'a>, a, b| both(operator::POWER, a, b))),
        )))
        .parse_next(input)
}

/// A number, a name, a call or a sum in brackets.
fn operand<'a>(input: &mut Input<'a>) -> ModalResult<Parsed<'a>> {
    let bracketed = delimited(('(', multispace0), cut_err(sum), cut_err(closed)).with_span();
    let bracketed = bracketed.map(|(inner, span)| Parsed { span, ..inner });
    // A sign is the business of `sum`.
    let nothing = preceded(not('-'), cut_err(fail).context(expect("a number, a name, a function or `(`")));
    delimited(multispace0, alt((number, named, bracketed, nothing)), multispace0).parse_next(input)
}

fn closed(input: &mut Input<'_>) -> ModalResult<()> {
    preceded(multispace0, ')').void().context(expect("an operator, `,` or `)`")).parse_next(input)
}

fn number<'a>(input: &mut Input<'a>) -> ModalResult<Parsed<'a>> {
    let power = (one_of(['e', 'E']), opt(one_of(['+', '-'])), digit1);
    let digits = (alt(((digit1, opt(('.', opt(digit1)))).void(), ('.', digit1).void())), opt(power));
    let value = digits.take().parse_to::<f64>().verify(|value: &f64| value.is_finite());
    let end = cut_err(']').context(expect("`]` after the unit"));
    let unit = delimited((multispace0, '['), take_while(0.., |sign| sign != ']').with_span(), end);
    let spanned = (value, opt(unit)).with_span();
    spanned.map(|((value, unit), span)| Parsed { what: What::Number(value, unit), span }).parse_next(input)
}

/// A name, or a function with its arguments.
fn named<'a>(input: &mut Input<'a>) -> ModalResult<Parsed<'a>> {
    let first = |sign: char| sign.is_alphabetic() || sign == '_';
    let name = (one_of(first), take_while(0.., |sign: char| sign.is_alphanumeric() || sign == '_')).take();
    let arguments = separated(1.., cut_err(sum), (multispace0, ',', multispace0));
    let bracket = delimited((multispace0, '(', multispace0), arguments, cut_err(closed));
    let spanned = (name, opt(bracket)).with_span();
    let parsed = |((name, arguments), span): ((&'a str, Option<Vec<Parsed<'a>>>), _)| Parsed {
        what: arguments.map_or(What::Name(name), |arguments| What::Function(name, arguments)),
        span,
    };
    spanned.map(parsed).parse_next(input)
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn an_expression_is_printed_with_no_more_brackets_than_are_needed() {
        for (text, printed) in [
            ("a-(b-c)", "a - (b - c)"),
            ("(a-b)-c", "a - b - c"),
            ("a*(b*c)/d", "a * (b * c) / d"),
            ("-(a+b)^2", "-(a + b)^2"),
            ("(-a)^2", "(-a)^2"),
            ("2*-a", "2 * -a"),
            (" max( h - 10 [V] , 0 ) ", "max(h - 10 [V], 0)"),
            ("1e-3*x", "0.001 * x"),
            ("a^2^3", "a^2^3"),
        ] {
            let expression = parse(text).unwrap();
            assert_eq!(expression.to_string(), printed);
            assert_eq!(parse(printed).unwrap(), expression, "{text}");
        }
    }

    #[test]
    fn what_is_no_expression_is_refused_at_its_place() {
        for (text, refusal) in [
            ("", "column 1: found the end, expected a number, a name, a function or `(`"),
            ("k*", "column 3: found the end, expected a number, a name, a function or `(`"),
            ("k*(a+b", "column 7: found the end, expected an operator, `,` or `)`"),
            ("a b", "column 3: found `b`, expected an operator or the end"),
            ("k*lowpas(a, tau)", "column 3: `lowpas` is no function, expected perhaps `lowpass`"),
            (
                "k*lowpass(a)",
                "column 3: `lowpass` has 1 arguments, expected 2 to 3: lowpass(e, tau) or lowpass(e, tau, start)",
            ),
            (
                "10 [arcsec/]*a",
                "column 5: `arcsec/` is no unit: found `/`, expected a product of units such as arcsec/A^2",
            ),
            ("a $ b", "column 3: found `$`, expected an operator or the end"),
        ] {
            assert_eq!(parse(text).map(|e| e.to_string()).unwrap_err().to_string(), refusal, "{text}");
        }
        for sign in ["(", "-", "a^", "a+", "(-", "abs("] {
            let text = sign.repeat(3000 / sign.len()) + "a";
            assert!(parse(&text).unwrap_err().to_string().contains("100 deep"), "{sign}");
        }
    }
}
