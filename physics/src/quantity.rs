//! Units of what stands in an expression, and how they go together.

use thiserror::Error;

use crate::unit::Unit;

/// What an argument is, as far as units go.
#[derive(Debug, Clone, PartialEq)]
pub enum Quantity {
    /// A number that was written without a unit: it takes that of what it stands beside.
    Number(f64),
    /// Anything else.
    Of(Unit),
}

/// The unit of a result, and the factors that bring each argument to the unit that is needed.
pub type Agreed = (Quantity, Vec<f64>);

/// Units that do not go together.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum UnitError {
    /// Two quantities of different dimensions.
    #[error("{0} and {1} do not go together: expected the same kind of quantity")]
    Differ(Unit, Unit),
    /// A quantity where another kind is needed.
    #[error("found {0}, expected {1}")]
    Needs(Unit, &'static str),
    /// An exponent that is no number, or no whole one.
    #[error(
        "the exponent of a power is a whole number, or a simple fraction of a quantity that is never negative"
    )]
    Exponent,
}

impl Quantity {
    /// Its unit, a bare number being a pure one.
    pub fn unit(&self) -> Unit {
        match self {
            Quantity::Number(_) => Unit::one(),
            Quantity::Of(unit) => unit.clone(),
        }
    }

    /// The number that it is.
    pub fn number(&self) -> Option<f64> {
        match self {
            Quantity::Number(value) => Some(*value),
            Quantity::Of(_) => None,
        }
    }

    /// The factor that makes a pure number of it.
    ///
    /// # Errors
    /// [`UnitError::Needs`] where it has a dimension.
    pub(crate) fn pure(&self) -> Result<f64, UnitError> {
        let unit = self.unit();
        unit.in_units_of(&Unit::one()).ok_or(UnitError::Needs(unit, "a pure number"))
    }
}

/// The unit that all have, and the factors that bring each to it. Bare numbers take it as they are.
///
/// # Errors
/// [`UnitError::Differ`].
pub(crate) fn common(of: &[Quantity]) -> Result<Agreed, UnitError> {
    let unit = of.iter().find_map(|quantity| match quantity {
        Quantity::Of(unit) => Some(unit),
        Quantity::Number(_) => None,
    });
    let Some(unit) = unit else { return Ok((Quantity::Of(Unit::one()), vec![1.0; of.len()])) };
    let factors = of.iter().map(|quantity| match quantity {
        Quantity::Number(_) => Ok(1.0),
        Quantity::Of(other) => {
            other.in_units_of(unit).ok_or_else(|| UnitError::Differ(unit.clone(), other.clone()))
        }
    });
    Ok((Quantity::Of(unit.clone()), factors.collect::<Result<_, _>>()?))
}
