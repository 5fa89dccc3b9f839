//! Where the argument of a sign or a step passes zero in a run. Where both sides push it back, it is held there (A. F.
//! Filippov, Differential Equations with Discontinuous Righthand Sides, 1988), as dry friction holds a mechanism.
//!
//! The times of these events carry derivatives, so that sensitivities are exact through them.

use physics::number::Number;
use physics::tape::Side;

use super::delays::NEAR;
use super::run::{At, Run};

/// Changes of side in one step that are followed; beyond them the motion is smaller than the step resolves.
const MOST_EVENTS: usize = 6;
/// Slope of an argument where it passes zero, over its change in the step, below which it grazes.
const GRAZING: f64 = 1e-6;
/// Change of an argument where an input enters another stretch, over the argument, up to which it is rounding.
const ROUNDED: f64 = 1e-9;
/// Steps of the search for the instant of an event.
const MOST_STEPS: usize = 30;

impl<T: Number> Run<'_, T> {
    /// Puts every switch on the side to which the motion goes from the first row on.
    pub fn choose_sides(&mut self) {
        let first = self.arguments(0.0, At::Before);
        for (side, argument) in self.sides.iter_mut().zip(&first) {
            *side = if *argument < 0.0 { Side::Below } else { Side::Above };
        }
        for k in (0..first.len()).filter(|k| first[*k] == 0.0) {
            self.sides[k] = self.side_after(k, 0.0, None);
        }
    }

    /// Takes switches whose argument has been moved across zero to the other side.
    pub fn turn_sides(&mut self, t_s: f64) {
        let arguments = self.arguments(t_s, At::Before);
        for (side, argument) in self.sides.iter_mut().zip(arguments) {
            *side = match *side {
                Side::Above if argument < 0.0 => Side::Below,
                Side::Below if argument > 0.0 => Side::Above,
                same => same,
            };
        }
    }

    /// Lets the inputs enter another stretch at `t_s`. A held input jumps there: switches whose argument jumps with it go to the
    /// side where it lands.
    fn enter_turning(&mut self, t_s: f64, enter: impl FnOnce(&mut Self)) {
        if self.sides.is_empty() {
            return enter(self);
        }
        let from = self.arguments(t_s, At::Before);
        enter(self);
        // A switch may be within the argument of another.
        for _ in 0..self.sides.len() {
            let to = self.arguments(t_s, At::Before);
            let mut turned = false;
            for (switch, (from, to)) in from.iter().zip(to).enumerate() {
                if (to - from).abs() <= ROUNDED * f64::max(from.abs(), to.abs()) {
                    continue;
                }
                let side = match to {
                    to if to < 0.0 => Side::Below,
                    to if to > 0.0 => Side::Above,
                    _ => self.side_after(switch, t_s, None),
                };
                turned |= side != self.sides[switch];
                self.sides[switch] = side;
            }
            if !turned {
                break;
            }
        }
    }

    /// One step of `h` seconds from `t_s` on, divided where a row comes through a delay and where a switch changes its side.
    pub fn advance(&mut self, t_s: f64, h: f64) {
        let plays = self.plays_before(t_s, h);
        self.enter_turning(t_s, |run| run.enter(t_s + 0.5 * h));
        let breaks = self.breaks(t_s, t_s + h);
        if breaks.is_empty() {
            self.stretch(T::from_f64(t_s), T::from_f64(h), false);
        } else {
            let mut now = T::from_f64(t_s);
            for end in breaks.into_iter().chain([T::from_f64(t_s + h)]) {
                // What comes at `end` is not here yet, however short the stretch.
                let before = end.value() - 2.0 * NEAR * self.course.sample_s;
                let within_s = before.min(0.5 * (now + end).value());
                self.enter_turning(now.value(), |run| run.enter_ago(within_s));
                self.stretch(now, end - now, true);
                now = end;
            }
        }
        self.play(&plays, t_s, h);
    }

    /// A stretch of `left` seconds from `now` on; `moving` where these have derivatives.
    fn stretch(&mut self, mut now: T, mut left: T, moving: bool) {
        let least = 1e-9 * left.value();
        for event in 0..=MOST_EVENTS {
            self.hold(now.value());
            match moving || event > 0 {
                false => self.step(now.value(), left.value(), false),
                true => self.step(now, left, true),
            }
            let passed = if event < MOST_EVENTS { self.crossed((now + left).value()) } else { None };
            let Some((switch, to)) = passed else {
                return std::mem::swap(&mut self.states, &mut self.after);
            };
            let part = self.event(switch, (now, left), to);
            self.step(now, left * part, true);
            std::mem::swap(&mut self.states, &mut self.after);
            now += left * part;
            left = left * (T::from_f64(1.0) - part);
            let came = self.sides[switch];
            self.sides[switch] = self.side_after(switch, now.value(), Some(came));
            if left.value() <= least {
                return;
            }
        }
    }

    /// The arguments of all switches.
    fn arguments(&mut self, t_s: f64, at: At) -> Vec<f64> {
        self.load(t_s, at);
        self.routines.sides.run(&self.sides, &mut self.registers);
        self.routines.sides.rows.iter().map(|row| self.registers[row.value]).collect()
    }

    /// The first switch whose argument has passed zero after the step, and its argument there.
    fn crossed(&mut self, t_s: f64) -> Option<(usize, f64)> {
        if self.sides.is_empty() {
            return None;
        }
        self.load(t_s, At::After);
        self.routines.sides.run(&self.sides, &mut self.registers);
        let rows = self.routines.sides.rows.iter().zip(&self.sides).enumerate();
        let passed = |(k, (row, side)): (usize, (&physics::tape::Places, &Side))| {
            let argument = self.registers[row.value];
            let gone = match side {
                Side::Above => argument < 0.0,
                Side::Below => argument > 0.0,
                Side::Held(_) => false,
            };
            gone.then_some((k, argument))
        };
        let mut rows = rows;
        rows.find_map(passed)
    }

    /// The part of a step after which a switch's argument is zero, with its derivatives; `to` is its argument after the
    /// step.
    fn event(&mut self, switch: usize, (now, left): (T, T), to: f64) -> T {
        let from = self.arguments(now.value(), At::Before)[switch];
        let mut ends = [(0.0, from), (1.0, to)];
        // It began on the other side already: an event a moment ago left it there.
        if from == 0.0 || (from > 0.0) == (to > 0.0) {
            return T::from_f64(0.0);
        }
        let (mut part, mut last) = (1.0, None);
        for _ in 0..MOST_STEPS {
            let [(a, fa), (b, fb)] = ends;
            part = a + (b - a) * (fa / (fa - fb));
            self.step(now, left * part, true);
            let argument = self.arguments((now + left * part).value(), At::After)[switch];
            let end = usize::from((argument > 0.0) == (to > 0.0));
            // The Illinois rule: an end that stays counts for half.
            ends[1 - end].1 *= if last == Some(end) { 0.5 } else { 1.0 };
            ends[end] = (part, argument);
            last = Some(end);
            if argument.abs() <= 1e-13 * from.abs().max(to.abs()) || ends[1].0 - ends[0].0 < 1e-13 {
                break;
            }
        }
        let there = now + left * part;
        let slope = self.drift(switch, there.value(), At::After) * left.value();
        let row = &self.routines.arguments.rows[switch];
        let mut argument = self.value(row, &self.after, there.value());
        argument.follow(&there, self.pace(row, there.value()));
        let corrected = T::from_f64(part) - argument * (1.0 / slope);
        // Where it only grazes zero, the instant has no derivatives that mean anything.
        let steep = slope.abs() > GRAZING * f64::max(from.abs(), to.abs());
        let sound = slope.is_finite() && steep && (corrected.value() - part).abs() < 0.02;
        if sound && (0.0..=1.0).contains(&corrected.value()) { corrected } else { T::from_f64(part) }
    }

    /// The rate of a switch's argument along the motion.
    fn drift(&mut self, switch: usize, t_s: f64, at: At) -> f64 {
        self.load(t_s, at);
        self.routines.moving.run(&self.sides, &mut self.registers);
        self.routines.arguments.run(&self.sides, &mut self.registers);
        let (row, rates) = (&self.routines.arguments.rows[switch], &self.routines.moving.rows);
        let rate = |state: usize| self.registers[rates[state].value];
        let along = row.states.iter().map(|(state, place)| self.registers[*place] * rate(*state));
        self.pace(row, t_s) + along.sum::<f64>()
    }

    /// The rates of a switch's argument on either side of zero.
    fn drifts(&mut self, switch: usize, t_s: f64) -> [f64; 2] {
        let now = self.sides[switch];
        let both = [Side::Below, Side::Above].map(|side| {
            self.sides[switch] = side;
            self.drift(switch, t_s, At::Before)
        });
        self.sides[switch] = now;
        both
    }

    /// On which side a switch is whose argument is zero now, and was on side `came` before, where there is a before.
    fn side_after(&mut self, switch: usize, t_s: f64, came: Option<Side>) -> Side {
        let [below, above] = self.drifts(switch, t_s);
        match came {
            // Both sides push it back.
            _ if above <= 0.0 && below >= 0.0 => Side::Held(held_part([below, above])),
            Some(Side::Above) if below < 0.0 => Side::Below,
            Some(Side::Below) if above > 0.0 => Side::Above,
            _ if above > 0.0 => Side::Above,
            _ => Side::Below,
        }
    }

    /// What holds each switch that is held, and which is held no longer.
    fn hold(&mut self, t_s: f64) {
        self.held.clear();
        for switch in 0..self.sides.len() {
            if !matches!(self.sides[switch], Side::Held(_)) {
                continue;
            }
            self.sides[switch] = match held_part(self.drifts(switch, t_s)) {
                part if part > 1.0 => Side::Above,
                part if part < -1.0 => Side::Below,
                part => Side::Held(part),
            };
            if matches!(self.sides[switch], Side::Held(_)) {
                self.load(t_s, At::Before);
                self.routines.arguments.run(&self.sides, &mut self.registers);
                let row = &self.routines.arguments.rows[switch];
                let mut slopes = vec![0.0; self.states.len()];
                row.states.iter().for_each(|(state, place)| slopes[*state] = self.registers[*place]);
                if slopes.iter().any(|slope| *slope != 0.0) {
                    let alone = self.pace(row, t_s);
                    self.held.push((slopes, alone));
                }
            }
        }
    }
}

/// Where between both sides the value of a switch is that keeps its argument at zero, −1 being below and 1 above.
fn held_part([below, above]: [f64; 2]) -> f64 {
    match above == below {
        // As at a bend: nothing holds it, unless it rests.
        true if above == 0.0 => 0.0,
        true => above * f64::INFINITY,
        false => -(above + below) / (above - below),
    }
}
