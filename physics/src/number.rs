//! Numbers that carry their derivatives (forward-mode automatic differentiation), so that a simulation
//! yields its sensitivities exactly, events included.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// A derivative below this is none: no product of two that are larger is as small as the smallest number.
const FORGOTTEN: f64 = 1e-150;

/// What the physics is written in: a plain number, or one with derivatives.
pub trait Number:
    Copy
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
{
    /// A constant.
    fn from_f64(value: f64) -> Self;
    /// The value without its derivatives.
    fn value(self) -> f64;
    /// The direction of a variable whose only slope is one.
    fn direction(&self) -> Option<usize>;
    /// Adds to its derivative along a direction.
    fn nudge(&mut self, direction: usize, by: f64);
    /// A function of it, given that function's value and slope.
    fn chain(self, value: f64, slope: f64) -> Self;
    /// Adds another's derivatives, times a slope: it follows the other.
    fn follow(&mut self, other: &Self, slope: f64);
    /// Puts derivatives to zero that are too small to move anything: a processor computes with numbers near the smallest a
    /// hundred times more slowly.
    fn forget(&mut self);
    /// Whether it carries derivatives.
    fn carries(&self) -> bool;
    /// Whether any of them is not zero.
    fn moves(&self) -> bool;
    /// e to the power of it.
    fn exp(self) -> Self {
        let e = self.value().exp();
        self.chain(e, e)
    }
    /// Its sine and cosine.
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.value().sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }
    /// Its inverse hyperbolic tangent, for magnitudes below one.
    fn artanh(self) -> Self {
        let x = self.value();
        self.chain(x.atanh(), 1.0 / (1.0 - x * x))
    }
    /// A non-negative number to a fixed power.
    fn powf(self, exponent: f64) -> Self {
        let x = self.value();
        // At zero the slope of a power below one has no value; the force itself is what counts there.
        let slope = if x > 0.0 { exponent * x.powf(exponent - 1.0) } else { 0.0 };
        self.chain(x.powf(exponent), slope)
    }
    /// Its magnitude.
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }
    /// It, and the derivatives with it, cut off at ±`limit`.
    fn clamp(self, limit: Self) -> Self {
        if self.value() > limit.value() {
            limit
        } else if self.value() < -limit.value() {
            -limit
        } else {
            self
        }
    }
}

impl Number for f64 {
    #[inline(always)]
    fn from_f64(value: f64) -> f64 {
        value
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
    #[inline(always)]
    fn direction(&self) -> Option<usize> {
        None
    }
    #[inline(always)]
    fn nudge(&mut self, _: usize, _: f64) {}
    #[inline(always)]
    fn chain(self, value: f64, _: f64) -> f64 {
        value
    }
    #[inline(always)]
    fn follow(&mut self, _: &f64, _: f64) {}
    #[inline(always)]
    fn forget(&mut self) {}
    #[inline(always)]
    fn carries(&self) -> bool {
        false
    }
    #[inline(always)]
    fn moves(&self) -> bool {
        false
    }
}

/// A value and its derivatives along `N` directions.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub struct Dual<const N: usize> {
    /// The derivatives, first, so that no register holds some of them and the value.
    pub slopes: [f64; N],
    /// The value.
    pub value: f64,
}

impl<const N: usize> Dual<N> {
    /// A variable: its derivative along direction `k` is one.
    pub fn variable(value: f64, k: usize) -> Dual<N> {
        let mut slopes = [0.0; N];
        slopes[k] = 1.0;
        Dual { value, slopes }
    }
}

impl<const N: usize> Number for Dual<N> {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Dual { value, slopes: [0.0; N] }
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }
    #[inline(always)]
    fn direction(&self) -> Option<usize> {
        self.slopes.iter().position(|s| *s == 1.0)
    }
    #[inline(always)]
    fn nudge(&mut self, direction: usize, by: f64) {
        if let Some(slope) = self.slopes.get_mut(direction) {
            *slope += by;
        }
    }
    #[inline(always)]
    fn chain(self, value: f64, slope: f64) -> Self {
        Dual { value, slopes: self.slopes.map(|s| s * slope) }
    }
    #[inline(always)]
    fn follow(&mut self, other: &Self, slope: f64) {
        for (a, b) in self.slopes.iter_mut().zip(&other.slopes) {
            *a += slope * b;
        }
    }
    #[inline(always)]
    fn forget(&mut self) {
        for slope in &mut self.slopes {
            if slope.abs() < FORGOTTEN {
                *slope = 0.0;
            }
        }
    }
    #[inline(always)]
    fn carries(&self) -> bool {
        N > 0
    }
    #[inline(always)]
    fn moves(&self) -> bool {
        self.slopes.iter().any(|slope| *slope != 0.0)
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self.value += other.value;
        for (a, b) in self.slopes.iter_mut().zip(&other.slopes) {
            *a += b;
        }
        self
    }
}

impl<const N: usize> AddAssign for Dual<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        for (a, b) in self.slopes.iter_mut().zip(&other.slopes) {
            *a += b;
        }
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        self.value -= other.value;
        for (a, b) in self.slopes.iter_mut().zip(&other.slopes) {
            *a -= b;
        }
        self
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, other: Self) -> Self {
        for (a, b) in self.slopes.iter_mut().zip(&other.slopes) {
            *a = *a * other.value + b * self.value;
        }
        self.value *= other.value;
        self
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn div(mut self, other: Self) -> Self {
        let inverse = 1.0 / other.value;
        self.value *= inverse;
        for (a, b) in self.slopes.iter_mut().zip(&other.slopes) {
            *a = (*a - self.value * b) * inverse;
        }
        self
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Dual { value: -self.value, slopes: self.slopes.map(|s| -s) }
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, factor: f64) -> Self {
        self.value *= factor;
        for a in &mut self.slopes {
            *a *= factor;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_those_of_difference_quotients() {
        fn f<T: Number>(x: T, y: T) -> T {
            (x * y + (x / y).sin_cos().0 + (x / y).sin_cos().1) * (-(x * x)).exp()
                - (x - y).abs() / (y + T::from_f64(2.0))
        }
        let (x, y, step) = (0.7, 1.3, 1e-6);
        let dual = f(Dual::<2>::variable(x, 0), Dual::variable(y, 1));
        let along_x = (f(x + step, y) - f(x - step, y)) / (2.0 * step);
        let along_y = (f(x, y + step) - f(x, y - step)) / (2.0 * step);
        assert!((dual.value - f(x, y)).abs() < 1e-15);
        assert!((dual.slopes[0] - along_x).abs() < 1e-8);
        assert!((dual.slopes[1] - along_y).abs() < 1e-8);
    }
}
