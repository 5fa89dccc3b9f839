//! Inputs that come later.

use physics::number::Number;

use super::input::Input;
use super::run::Run;

/// Times this close, over the time from row to row, are the same.
pub(super) const NEAR: f64 = 1e-9;

/// A further input: another one some time ago.
pub(super) struct Delay<T> {
    pub input: usize,
    pub by_s: T,
}

impl<T: Number> Run<'_, T> {
    /// The same of inputs that come later.
    #[inline(always)]
    pub fn enter_ago(&mut self, within_s: f64) {
        for (piece, delay) in self.pieces[self.system.inputs..].iter_mut().zip(&self.delays) {
            if !piece.holds(within_s) {
                let by_s = delay.by_s.value();
                *piece = self.course.signals[delay.input].piece(within_s - by_s);
                piece.from_s += by_s;
            }
        }
    }

    /// When a row reaches the mechanism through a delay from `from_s` on and before `to_s`, in order: an input may jump or
    /// bend there.
    pub fn breaks(&self, from_s: f64, to_s: f64) -> Vec<T> {
        let sample_s = self.course.sample_s;
        let near = NEAR * sample_s;
        let mut all = Vec::new();
        for Delay { input, by_s } in &self.delays {
            let mut row = ((from_s - near - by_s.value()) / sample_s).ceil();
            while row * sample_s + by_s.value() < to_s - near {
                if bends(self.course.signals[*input], row * sample_s, sample_s) {
                    all.push(*by_s + T::from_f64(row * sample_s));
                }
                row += 1.0;
            }
        }
        all.sort_by(|a, b| a.value().total_cmp(&b.value()));
        all
    }
}

/// Whether an input jumps or bends at a row.
fn bends(signal: &dyn Input, t_s: f64, sample_s: f64) -> bool {
    let [before, after] = [-0.05, 0.05].map(|part| signal.piece(t_s + part * sample_s));
    let differ = |a: f64, b: f64| (a - b).abs() > NEAR * (a.abs() + b.abs());
    differ(before.value(t_s), after.value(t_s)) || differ(before.rate(t_s), after.rate(t_s))
}
