//! Polynomials of the place in a row of the program's table, which the function of the reading and all terms share: cubic
//! ones, or straight lines.

use super::Result;
use super::builder::{Builder, Tracked};
use crate::bound::of_type;
use crate::exact::Interval;
use crate::program::{Op, Operand, Type};

/// Degree of the polynomials of a function.
pub(super) const DEGREE: usize = 3;

/// Points of a row at which its polynomial is tried in f64 before it is bounded in exact arithmetic.
const TRIED: i32 = 8;

/// The largest `distance`, of the place in a row and its cubic there, at some points: no bound, but the bound is not smaller.
pub(super) fn tried(c: &[i64], (from, to): (f64, f64), distance: impl Fn(f64, f64) -> f64) -> f64 {
    let at = |point: i32| {
        let w = from + (to - from) * f64::from(point) / f64::from(TRIED);
        distance(w, c.iter().rev().fold(0.0, |sum, c| sum * w + *c as f64))
    };
    (0..=TRIED).map(at).fold(0.0, f64::max)
}

/// What the steps are called: what tells them from those of other rows, the letter of the coefficients, and the name of the
/// sum at a column.
pub(super) struct Names<'a> {
    pub of_others: &'a str,
    pub coefficient: &'a str,
    pub sum: &'a dyn Fn(usize) -> String,
}

impl Builder {
    /// Appends `rows` of coefficients to the table and what evaluates the one in which word `a` lies: 2^`by` words are a row,
    /// of which the first is row `first` of all words.
    pub fn polynomials(
        &mut self,
        a: Operand,
        rows: &[Vec<i64>],
        (first, by): (i64, i64),
        names: &Names,
    ) -> Result<Tracked> {
        let table = &mut self.program.table;
        let before = table.len() as i64;
        let columns = rows.first().map_or(0, Vec::len);
        // A row's address is one shift.
        let width = columns.next_power_of_two().max(table.first().map_or(0, Vec::len));
        table.extend(rows.iter().cloned());
        table.iter_mut().for_each(|row| row.resize(width, 0));
        let (none, all) = (Interval::zero(), of_type(Type::I32));
        let op = Op::Index { a, add: (before - first) << by, by: by as u32 };
        let of_table = Interval::between(before, before + rows.len() as i64 - 1);
        let index = self.push(&format!("segment{}", names.of_others), op, of_table, none.clone(), "")?;
        let op = Op::Wrap { a, add: 1 << (by - 1), by: (32 - by) as u32 };
        let place = self.push(&format!("place{}", names.of_others), op, all, none.clone(), "")?;
        let mut sum: Option<Tracked> = None;
        for column in (0..columns).rev() {
            let range = rows.iter().map(|row| Interval::from_int(row[column])).reduce(|a, c| a.hull(&c));
            let name = format!("{}{column}{}", names.coefficient, names.of_others);
            let op = Op::Entry { index: index.operand, column };
            let c = self.push(&name, op, range.unwrap_or_else(Interval::zero), none.clone(), "")?;
            sum = Some(match sum {
                None => c,
                Some(sum) => self.mul_add(&(names.sum)(column), (&sum, &place), 0, &c, "")?,
            });
        }
        Ok(sum.unwrap_or_else(|| Tracked::constant(&none)))
    }
}
