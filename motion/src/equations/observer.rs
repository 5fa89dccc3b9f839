//! What keeps a run beside a recording.

use physics::number::Number;

use super::run::{At, Run};

/// A correction of the states that the output reads, at every row, by part of what it is off there. It keeps a simulation
/// beside a recording while the parameters are far from right, so that an estimate does not stop in a local minimum
/// (H. D. I. Abarbanel et al., SIAM J. Appl. Dyn. Syst. 8, 2009).
#[derive(Clone, Copy)]
pub struct Observer<'a> {
    /// The recorded output at every row.
    pub recorded: &'a [f64],
    /// The part, 0 to 1.
    pub part: f64,
}

impl<T: Number> Run<'_, T> {
    /// Corrects the states that the output of the plant reads, and the sides of switches that this takes across zero.
    pub fn correct(&mut self, row: usize, output: T, observer: Observer) {
        let t_s = row as f64 * self.course.sample_s;
        self.enter(t_s + 0.25 * self.course.sample_s);
        self.load(t_s, At::Before);
        self.routines.read.run(&self.sides, &mut self.registers);
        let slopes = &self.routines.read.rows[0].states;
        let square: f64 = slopes.iter().map(|(_, place)| self.registers[*place].powi(2)).sum();
        if square > 0.0 {
            let off = (T::from_f64(observer.recorded[row]) - output) * observer.part;
            for (state, place) in slopes {
                self.states[*state] = self.states[*state] + off * (self.registers[*place] / square);
            }
            self.turn_sides(t_s);
        }
    }
}
