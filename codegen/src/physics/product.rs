//! `product` terms: Σ c·Π(observable − mean)^power, multiplied out into Σ shape(v)·Π vᵢ^pᵢ, where the shapes are
//! polynomials of the routine's variable and the vᵢ the further inputs; each is evaluated once, whatever the
//! number of terms that it came from.

use std::collections::BTreeMap;

use fitter::terms::Product;

use super::Result;
use super::builder::{Builder, Tracked};
use super::further::Given;
use super::shape::{Shape, Variable};
use crate::exact::Interval;

/// Powers of the further inputs, and what they are multiplied by.
pub(super) type Expanded = BTreeMap<Vec<u8>, Shape>;

/// Adds `coefficient`·product, in the result's unit, to what is there.
pub(super) fn expand(
    into: &mut Expanded,
    product: &Product,
    coefficient: &Interval,
    variable: &Variable,
    given: &[(String, Given)],
) -> Result {
    let mut terms: Expanded = [(vec![0; given.len()], Shape::constant(coefficient.clone()))].into();
    for factor in &product.factors {
        let shape = variable.observable(&factor.observable)?.map(|shape| shape.less(factor.mean));
        let input = given.iter().position(|(name, _)| *name == factor.observable);
        for _ in 0..factor.power {
            let mut next = Expanded::new();
            for (powers, so_far) in &terms {
                if let Some(shape) = &shape {
                    put(&mut next, powers.clone(), so_far.times(shape, &variable.radius()));
                } else if let Some(i) = input {
                    let g = &given[i].1;
                    let rest = &g.offset - &Interval::from_f64(factor.mean);
                    put(&mut next, powers.clone(), so_far.scaled(&rest));
                    let mut higher = powers.clone();
                    higher[i] += 1;
                    put(&mut next, higher, so_far.scaled(&g.slope));
                }
            }
            terms = next;
        }
    }
    for (powers, shape) in terms {
        put(into, powers, shape);
    }
    Ok(())
}

fn put(into: &mut Expanded, powers: Vec<u8>, shape: Shape) {
    let sum = into.get(&powers).map_or(shape.clone(), |there| there.plus(&shape));
    into.insert(powers, sum);
}

/// Subtracts the sum of all of it from the result.
pub(super) fn subtract(
    b: &mut Builder,
    expanded: &Expanded,
    variable: &Variable,
    given: &[(String, Given)],
) -> Result {
    let mut words: BTreeMap<Vec<u8>, Tracked> = BTreeMap::new();
    for (powers, shape) in expanded {
        let shape = shape.scaled(&Interval::from_int(-1));
        // |vᵢ| ≤ ½.
        let total: i64 = powers.iter().map(|p| i64::from(*p)).sum();
        let largest = variable.range(&shape).magnitude().mul_pow2(b.sum.bits - total);
        if largest.certainly_le(&b.sum.negligible) {
            b.add_error(&largest);
            continue;
        }
        let names: Vec<&str> =
            given.iter().zip(powers).filter(|(_, p)| **p > 0).map(|((name, _), _)| name.as_str()).collect();
        if total == 0 {
            let note = "terms of the reading";
            let word =
                variable.evaluate(b, "by_reading", &shape, b.sum.bits, &b.sum.tolerance.clone(), note)?;
            b.sum.word = b.add("y", &b.sum.word.clone(), &word, "")?;
            continue;
        }
        let monomial = monomial(b, &mut words, powers, given)?;
        // As fine as the word allows, and never finer than the sum.
        let reach = variable.range(&shape).magnitude().log2_floor().unwrap_or(-120).max(-120);
        let bits = b.sum.bits.min(29 - reach);
        let name = format!("by_{}", names.join("_"));
        let factor = variable.evaluate(b, &name, &shape, bits, &b.sum.tolerance.clone(), "")?;
        let shift = (b.sum.bits - bits) as u32;
        b.sum.word =
            b.mul_add("y", (&factor, &monomial), shift, &b.sum.word.clone(), &names.join(" and "))?;
    }
    Ok(())
}

/// The word of Π vᵢ^pᵢ·2³².
fn monomial(
    b: &mut Builder,
    words: &mut BTreeMap<Vec<u8>, Tracked>,
    powers: &[u8],
    given: &[(String, Given)],
) -> Result<Tracked> {
    if let Some(word) = words.get(powers) {
        return Ok(word.clone());
    }
    let Some(i) = powers.iter().position(|p| *p > 0) else {
        return Ok(Tracked::constant(&Interval::zero()));
    };
    let mut lower = powers.to_vec();
    lower[i] -= 1;
    let factor = &given[i].1.word;
    let word = if lower.iter().all(|p| *p == 0) {
        factor.clone()
    } else {
        let rest = monomial(b, words, &lower, given)?;
        b.mul_add("power", (&rest, factor), 0, &Tracked::constant(&Interval::zero()), "")?
    };
    words.insert(powers.to_vec(), word.clone());
    Ok(word)
}
