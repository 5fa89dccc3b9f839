//! From row to row, in steps as short as the equations ask for.

use physics::number::Number;

use super::course::{MOST_SUBSTEPS, Stopped};
use super::rule::Rule;
use super::run::{At, Run};

/// A state beyond this, in its unit, is no motion any more.
const RUNAWAY: f64 = 1e12;
/// Most of the fastest time constant that a step goes, to be accurate.
const FASTEST: f64 = 1.0;
/// The same where steps can be no shorter: the rule is stable up to 2.78.
const STABLE: f64 = 2.5;
/// What rounding may add to a bound.
const ROUNDING: f64 = 1e-9;
/// Sweeps in which units are balanced: of two states one does.
const SWEEPS: usize = 3;
/// Squarings of a matrix whose spectral radius is estimated: to the sixteenth power, right to some percent.
const SQUARINGS: i32 = 4;

impl<T: Number> Run<'_, T> {
    /// Goes on to a row, in shorter steps where the equations have a faster time constant.
    pub fn reach(&mut self, row: usize) -> Result<(), Stopped> {
        let sample_s = self.course.sample_s;
        self.before.0.clone_from(&self.states);
        self.before.1.clone_from(&self.sides);
        let before = match self.reached.take() {
            Some(speed) => speed,
            None => self.speed((row - 1) as f64 * sample_s, row),
        };
        let steps = |(speed, _): (f64, usize)| (speed * sample_s / FASTEST).ceil() as usize;
        let most = MOST_SUBSTEPS.max(self.course.substeps);
        let mut substeps = steps(before).clamp(self.course.substeps, most);
        loop {
            let (rule, count) = match substeps == self.course.substeps {
                true => Rule::for_steps(substeps),
                false => (Rule::classical(), substeps),
            };
            self.rule = rule;
            let step_s = sample_s / count as f64;
            for k in 0..count {
                self.advance(((row - 1) * count + k) as f64 * step_s, step_s);
            }
            let stopped = |state: usize, stiff: bool| {
                let state = self.system.names[state].clone();
                Err(Stopped { state, t_s: row as f64 * sample_s, row, stiff })
            };
            let after = self.speed(row as f64 * sample_s, row);
            let fastest = if after.0 > before.0 { after } else { before };
            let lost = self.states.iter().position(|x| x.value().is_nan() || x.value().abs() > RUNAWAY);
            // What ran away in steps too long for it, or needs shorter ones where it has come to.
            let wanted = if lost.is_some() { 4 * substeps } else { steps(after) };
            if substeps < most && wanted > substeps {
                substeps = wanted.min(most);
                self.states.clone_from(&self.before.0);
                self.sides.clone_from(&self.before.1);
                continue;
            }
            if let Some(state) = lost {
                return stopped(state, false);
            }
            if fastest.0 * sample_s > STABLE * substeps as f64 {
                return stopped(fastest.1, true);
            }
            self.states.iter_mut().for_each(T::forget);
            self.reached = self.course.observer.is_none().then_some(after);
            return Ok(());
        }
    }

    /// The spectral radius of the rates' derivatives by the states, 1/s, and the state that is fastest by itself; 0 where it
    /// asks for no shorter steps. A motion that has settled shows no speed, but its derivatives would grow without bound in
    /// steps too long for it.
    fn speed(&mut self, t_s: f64, row: usize) -> (f64, usize) {
        self.enter((row as f64 - 0.5) * self.course.sample_s);
        self.load(t_s, At::Before);
        self.routines.slopes.run(&self.sides, &mut self.registers);
        let size = self.states.len();
        let [mut power, mut next] = std::mem::take(&mut self.powers);
        power.clear();
        power.resize(size * size, 0.0);
        for (k, places) in self.routines.slopes.rows.iter().enumerate() {
            places.states.iter().for_each(|(state, place)| power[k * size + state] = self.registers[*place]);
        }
        if self.is_slow(&power) {
            self.powers = [power, next];
            return (0.0, 0);
        }
        let by_itself = |k: &usize| power[k * (size + 1)].abs();
        let state = (0..size).max_by(|a, b| by_itself(a).total_cmp(&by_itself(b))).unwrap_or(0);
        let largest = |matrix: &[f64]| matrix.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        // The sixteenth root of the norm of the sixteenth power, whatever the units.
        let norm = largest(&power);
        let scale = if norm > 0.0 { 1.0 / norm } else { 0.0 };
        power.iter_mut().for_each(|x| *x *= scale);
        for _ in 0..SQUARINGS {
            next.clear();
            for row in power.chunks_exact(size) {
                for column in 0..size {
                    next.push(row.iter().enumerate().map(|(j, x)| x * power[j * size + column]).sum());
                }
            }
            std::mem::swap(&mut power, &mut next);
        }
        let root = (0..SQUARINGS).fold(largest(&power), |x, _| x.sqrt());
        // Where no derivative has a value, what runs away is found by its state.
        let radius = if norm.is_finite() { norm * root } else { f64::MAX };
        self.powers = [power, next];
        (radius, state)
    }

    /// Whether a matrix is sure to ask for no shorter steps: in other units u of the states, its norm bounds what is
    /// estimated, but for a factor (max u / min u)^(1/16).
    fn is_slow(&mut self, matrix: &[f64]) -> bool {
        let size = self.states.len();
        if self.units.0.is_empty() {
            self.units = balanced(matrix, size);
        }
        let (units, factor) = &self.units;
        let most = FASTEST * self.course.substeps as f64 / (factor * self.course.sample_s);
        matrix.chunks_exact(size).zip(units).all(|(row, unit)| {
            row.iter().zip(units).map(|(x, of_column)| x.abs() * of_column).sum::<f64>() <= most * unit
        })
    }
}

/// Units of the states in which rows and columns of a matrix are alike (E. E. Osborne, J. ACM 7, 1960), and the factor of
/// a bound in them.
fn balanced(matrix: &[f64], size: usize) -> (Vec<f64>, f64) {
    let mut units = vec![1.0; size];
    for k in (0..SWEEPS * size).map(|k| k % size) {
        let others = || (0..size).filter(|j| *j != k);
        let row: f64 = others().map(|j| matrix[k * size + j].abs() * units[j]).sum();
        let column: f64 = others().map(|j| matrix[j * size + k].abs() / units[j]).sum();
        let unit = (row / column).sqrt();
        if unit.is_normal() {
            units[k] = unit;
        }
    }
    let (low, high) = units.iter().fold((f64::MAX, 0.0_f64), |(a, b), u| (a.min(*u), b.max(*u)));
    let factor = (0..SQUARINGS).fold(high / low, |x, _| x.sqrt());
    (units, factor * (1.0 + ROUNDING))
}

#[cfg(test)]
mod tests {
    use super::balanced;

    #[test]
    fn an_oscillator_is_hardly_faster_in_balanced_units_than_it_is() {
        let (frequency, damping) = (190.0_f64, 40.0);
        let matrix = [0.0, 1.0, -frequency * frequency, -damping];
        let (units, factor) = balanced(&matrix, 2);
        let row = |k: usize| (0..2).map(|j| matrix[2 * k + j].abs() * units[j]).sum::<f64>() / units[k];
        let bound = factor * f64::max(row(0), row(1));
        assert!((frequency..2.0 * frequency).contains(&bound), "{bound}");
    }
}
