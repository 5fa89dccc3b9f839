//! `gaussian` terms, w·e^(−z²/2) with z = (v − centre)/width, and `exponential` terms of what the routine is given,
//! w·(1 − e^(−z)) with z = (v − start)/scale, 0 before the start. Beyond some widths e^… is below the tolerance, so z is
//! limited to Z, and with ζ = z/Z it is e^(−(Z²/2)·ζ²) or e^(−Z·ζ). Of the time, where the routine is not given it, see
//! `warm_up`.

use fitter::terms::{Exponential, Gaussian};

use super::super::Result;
use super::super::builder::Tracked;
use super::super::exponent::{self, BITS};
use super::value::Value;
use super::{Lowering, words};
use crate::exact::Interval;

impl Lowering<'_, '_> {
    /// Subtracts a bump; the weight is in the result's unit.
    pub fn subtract_gaussian(&mut self, gaussian: &Gaussian, weight: &Interval) -> Result {
        if self.b.leaves_out(weight) {
            return Ok(());
        }
        let (height, quarter) = self.height(weight);
        // Z itself is any number; what lies beyond it is counted.
        let limit = Interval::from_f64((2.0 * exponent::worth(&height, &quarter).to_f64()).sqrt());
        let x = (&limit * &limit).mul_pow2(-1);
        let tail = exponent::tail(&x, &height);
        let zeta = self.relative(&gaussian.observable, (gaussian.centre, gaussian.width), &limit)?;
        // The steepest slope of e^(−z²/2) is e^(−½) < 0.607, of it as a function of ζ Z times that.
        let slope = (&(&limit * &Interval::from_ratio(607, 1000)) * &height).upper();
        let Some(word) = self.cut("off", &zeta, -1, &quarter.div(&slope))? else {
            self.b.add_error(&tail);
            return Ok(());
        };
        let (exact, none) = (word.exactly(), Tracked::constant(&Interval::zero()));
        let number = self.b.program.steps.len();
        let name = format!("square_{number}");
        let square = self.b.mul_add(&name, (&exact, &exact), (32 - BITS) as u32, &none, "")?;
        // A square is not negative, which an analysis by intervals does not see.
        let square = self.b.clamp(&name, &square, (0, (1 << BITS) - 1), &Interval::from_int(1), "")?;
        let wanted = quarter.div(&height).mul_pow2(BITS);
        let bump = exponent::exp_minus_of(self.b, &format!("bump_{number}"), &square, &x, &wanted)?;
        self.b.add_scaled(&(-weight.clone()).mul_pow2(self.b.sum.bits + 32 - BITS), &bump, "a local bump")?;
        self.b.add_error(&(&(&slope * &word.error.mul_pow2(-BITS)) + &tail));
        Ok(())
    }

    /// Subtracts a saturating exponential; the weight is in the result's unit.
    pub fn subtract_exponential(&mut self, exponential: &Exponential, weight: &Interval) -> Result {
        if self.b.leaves_out(weight) {
            return Ok(());
        }
        let (height, quarter) = self.height(weight);
        let limit = exponent::worth(&height, &quarter);
        let tail = exponent::tail(&limit, &height);
        let zeta = self.relative(&exponential.observable, (exponential.start, exponential.scale), &limit)?;
        let slope = (&limit * &height).upper();
        let saturated = (-weight.clone()).mul_pow2(self.b.sum.bits);
        let Some(word) = self.cut("since", &zeta, 0, &quarter.div(&slope))? else {
            if Interval::from_int(1).certainly_le(&zeta.range.lower()) {
                self.b.add_constant(&saturated)?;
                self.b.add_error(&tail);
            }
            return Ok(());
        };
        let wanted = quarter.div(&height).mul_pow2(BITS);
        let name = format!("left_{}", self.b.program.steps.len());
        let left = exponent::exp_minus_of(self.b, &name, &word.exactly(), &limit, &wanted)?;
        self.b.add_scaled(&(-saturated.clone()).mul_pow2(32 - BITS), &left, "what is left of the way")?;
        self.b.add_constant(&saturated)?;
        self.b.add_error(&(&(&slope * &word.error.mul_pow2(-BITS)) + &tail));
        Ok(())
    }

    /// The largest of a term, and a quarter of what it may be off, in words of the sum.
    fn height(&self, weight: &Interval) -> (Interval, Interval) {
        (weight.magnitude().mul_pow2(self.b.sum.bits), self.b.sum.tolerance.mul_pow2(-2))
    }

    /// (v − at)/(scale·limit).
    fn relative(&mut self, name: &str, (at, scale): (f64, f64), limit: &Interval) -> Result<Value> {
        self.begin();
        let away = self.observed(name)?.less(&Value::number(Interval::from_f64(at)));
        Ok(away.scaled(&Interval::from_int(1).div(&(&Interval::from_f64(scale) * limit))))
    }

    /// The word of ζ·2^30 limited to `lowest`…1 (`lowest` −1 or 0), within about `tolerance` of 1; none where ζ lies
    /// beyond either end throughout.
    fn cut(
        &mut self,
        name: &str,
        zeta: &Value,
        lowest: i64,
        tolerance: &Interval,
    ) -> Result<Option<Tracked>> {
        let (one, range) = (Interval::from_int(1), &zeta.range);
        let above = one.certainly_le(&range.lower());
        if above || range.upper().certainly_le(&Interval::from_int(lowest)) {
            return Ok(None);
        }
        let none = Interval::zero();
        let bits = words::finest(&self.shared.bases, zeta, &none).min(BITS - 1);
        let word = words::word_at(self.b, &self.shared.bases, zeta, (&none, bits), (tolerance, name))?;
        let (name, end) = (format!("{name}_{}", self.b.program.steps.len()), 1i64 << bits);
        // Its upper end is one word short of 1.
        let word = self.b.clamp(&name, &word, (lowest * end, end - 1), &one, "")?;
        let left = (BITS - bits) as u32;
        if left == 0 { Ok(Some(word)) } else { Ok(Some(self.b.shift_left(&name, &word, left, "")?)) }
    }
}
