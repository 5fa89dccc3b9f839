//! Elementary functions, enclosed: value and Taylor coefficients at a point, or over an interval, where the n-th
//! bounds what a series of n terms about any point of the interval leaves out (Lagrange).

use super::{Interval, cos_sin, exp_minus, pi};

/// A function of one number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Function {
    /// e^x.
    Exp,
    /// The natural logarithm, for x > 0.
    Log,
    /// sin x, x in radians.
    Sin,
    /// cos x, x in radians.
    Cos,
    /// tanh x.
    Tanh,
    /// e^(−x²/2).
    Bump,
    /// A power: of any x where it is whole and not below 0, of any x ≠ 0 where it is whole, else for x > 0.
    Power(f64),
}

impl Function {
    /// Whether it and all its derivatives exist on an interval.
    pub fn exists(self, on: &Interval) -> bool {
        let zero = Interval::zero();
        let above = zero.certainly_le(&on.lower()) && on.lower() != zero;
        let below = on.upper().certainly_le(&zero) && on.upper() != zero;
        match self {
            Function::Exp | Function::Sin | Function::Cos | Function::Tanh | Function::Bump => true,
            Function::Log => above,
            Function::Power(p) if p == p.round() => p >= 0.0 || above || below,
            Function::Power(_) => above,
        }
    }

    /// The value in `f64`: for search, never for proof.
    pub fn near(self, x: f64) -> f64 {
        match self {
            Function::Exp => x.exp(),
            Function::Log => x.ln(),
            Function::Sin => x.sin(),
            Function::Cos => x.cos(),
            Function::Tanh => x.tanh(),
            Function::Bump => (-0.5 * x * x).exp(),
            Function::Power(p) if p == p.round() => x.powi(p as i32),
            Function::Power(p) => x.powf(p),
        }
    }

    /// Its value over an interval on which it exists.
    pub fn value(self, x: &Interval) -> Interval {
        let one = Interval::from_int(1);
        let ends = |of: &dyn Fn(&Interval) -> Interval| of(&x.lower()).hull(&of(&x.upper()));
        match self {
            Function::Exp => ends(&exp),
            Function::Log => ends(&log),
            Function::Sin => wave(x).1,
            Function::Cos => wave(x).0,
            Function::Tanh => ends(&|x| {
                let left = exp_minus(&x.magnitude().mul_pow2(1));
                let size = (&one - &left).div(&(&one + &left));
                if Interval::zero().certainly_le(x) { size } else { -size }
            }),
            Function::Bump => {
                // It falls with x²; the product of an interval around 0 with itself reaches below 0.
                let square = x * x;
                let least = if square.lower().certainly_le(&Interval::zero()) {
                    Interval::zero()
                } else {
                    square.lower()
                };
                exp_minus(&square.upper().mul_pow2(-1)).hull(&exp_minus(&least.mul_pow2(-1)))
            }
            Function::Power(p) if p == p.round() => whole_power(x, p as i64),
            Function::Power(p) => ends(&|x| exp(&(&Interval::from_f64(p) * &log(x)))),
        }
    }

    /// f, f′, f″/2, … f⁽ⁿ⁾/n! up to `count` of them, over an interval on which it exists.
    pub fn taylor(self, x: &Interval, count: usize) -> Vec<Interval> {
        let number = |k: usize| Interval::from_int(k as i64);
        let mut c = vec![self.value(x)];
        while c.len() < count {
            let k = c.len();
            let next = match self {
                Function::Exp => c[k - 1].div(&number(k)),
                Function::Log if k == 1 => Interval::from_int(1).div(x),
                Function::Log => -(&c[k - 1] * &Interval::from_ratio(k as i64 - 1, k as i64)).div(x),
                Function::Sin | Function::Cos if k == 1 => {
                    let (cosine, sine) = wave(x);
                    if self == Function::Sin { cosine } else { -sine }
                }
                Function::Sin | Function::Cos => -c[k - 2].div(&number(k * (k - 1))),
                // y′ = 1 − y².
                Function::Tanh => {
                    let square = (0..k).fold(Interval::zero(), |sum, i| &sum + &(&c[i] * &c[k - 1 - i]));
                    let one = Interval::from_int(i64::from(k == 1));
                    (&one - &square).div(&number(k))
                }
                // y′ = −x·y.
                Function::Bump => {
                    let before = if k > 1 { c[k - 2].clone() } else { Interval::zero() };
                    -(&(x * &c[k - 1]) + &before).div(&number(k))
                }
                // A polynomial ends.
                Function::Power(p) if p == (k - 1) as f64 => Interval::zero(),
                Function::Power(p) => {
                    let factor = &Interval::from_f64(p) - &number(k - 1);
                    if c[k - 1] == Interval::zero() {
                        Interval::zero()
                    } else {
                        (&c[k - 1] * &factor).div(&(x * &number(k)))
                    }
                }
            };
            c.push(next);
        }
        c
    }
}

/// e^x at a point.
fn exp(x: &Interval) -> Interval {
    let size = exp_minus(&x.magnitude());
    if x.upper().certainly_le(&Interval::zero()) { size } else { Interval::from_int(1).div(&size) }
}

/// ln x at a point x > 0: y + 2 artanh((z − 1)/(z + 1)) with z = x·e^−y next to 1.
fn log(x: &Interval) -> Interval {
    const TERMS: i64 = 12;
    let one = Interval::from_int(1);
    let y = Interval::from_f64(x.to_f64().ln());
    let z = x.div(&exp(&y));
    let t = (&z - &one).div(&(&z + &one));
    let square = &t * &t;
    let sum = (0..TERMS)
        .rev()
        .fold(Interval::zero(), |sum, k| &(&sum * &square) + &Interval::from_ratio(1, 2 * k + 1));
    // Σ t²ᵏ beyond the terms is at most twice the first, t being tiny.
    let left = (0..TERMS).fold(one, |power, _| (&power * &square.magnitude()).upper()).mul_pow2(1);
    &y + &(&t * &(&sum + &left.symmetric())).mul_pow2(1)
}

/// Cosine and sine over an interval: those of its middle, which it leaves by no more than its radius.
fn wave(x: &Interval) -> (Interval, Interval) {
    let one = Interval::from_int(1);
    let middle = x.midpoint();
    let turns = middle.div(&pi().mul_pow2(1)).midpoint().round_to_i64().unwrap_or(0);
    let reduced = &middle - &(&Interval::from_int(turns) * &pi().mul_pow2(1));
    let (cosine, sine) = cos_sin(&reduced);
    let slack = (x - &middle).magnitude().symmetric();
    let within = |value: Interval| (&value + &slack).meet(&one.symmetric());
    (within(cosine), within(sine))
}

/// x to a whole power.
fn whole_power(x: &Interval, power: i64) -> Interval {
    let product = (0..power.abs()).fold(Interval::from_int(1), |product, _| &product * x);
    if power < 0 { Interval::from_int(1).div(&product) } else { product }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_function() -> impl Strategy<Value = Function> {
        let power = prop::sample::select(vec![-3.0, -1.0, 0.5, 2.0, 3.0, -0.5, 1.5]);
        prop_oneof![
            Just(Function::Exp),
            Just(Function::Log),
            Just(Function::Sin),
            Just(Function::Cos),
            Just(Function::Tanh),
            Just(Function::Bump),
            power.prop_map(Function::Power),
        ]
    }

    proptest! {
        /// Value and series about a point, with what it leaves out, hold the function in `f64`.
        #[test]
        fn the_series_hold_the_function(of in any_function(), at in 0.3..6.0f64, by in -0.1..0.1f64) {
            let exact = of.near(at + by);
            let enclosed = of.value(&Interval::from_f64(at + by));
            let size = 1e-13 * (1.0 + exact.abs());
            prop_assert!((enclosed.to_f64() - exact).abs() < size, "{}", enclosed.to_f64());
            prop_assert!(enclosed.to_f64_up() - enclosed.to_f64_down() < size);
            let count = 6;
            let all = Interval::from_f64(at).hull(&Interval::from_f64(at + by));
            let h = &Interval::from_f64(at + by) - &Interval::from_f64(at);
            let terms = of.taylor(&Interval::from_f64(at), count);
            let sum = terms.iter().rev().fold(Interval::zero(), |sum, c| &(&sum * &h) + c);
            let power = (0..count).fold(Interval::from_int(1), |power, _| &power * &h);
            let whole = &sum + &(&of.taylor(&all, count + 1)[count] * &power);
            prop_assert!(whole.to_f64_down() - size <= exact && exact <= whole.to_f64_up() + size);
        }
    }
}
