//! The sequences of calls that a routine with terms is swept over: where the input space is too large to be run
//! through, every place where something could go wrong is visited, and much else at random.
//!
//! - corners: every argument at the ends of its box, one word beyond, at its type's extremes, in the middle;
//! - breakpoints: readings beside thresholds, centres and the borders of segments;
//! - ramps: slow triangles whose amplitude shrinks, for states that remember reversals, at every corner of the box;
//! - holds: the same words for long, where a state could creep into a limit cycle;
//! - walks: random steps of every size, jumps, and words outside of the range and the boxes.

use fitter::terms::Operator;

use super::model::measured_by_word;
use crate::program::Type;
use crate::routine::Routine;
use crate::verify::calls::Calls;
use crate::verify::domain::numbers_of;

/// A number that is as good as random, by Steele, Lea and Flood's SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From −1 to 1.
    fn signed(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.next()) * count as u128) >> 64) as usize
    }
}

/// One axis: the reading, or a further input.
struct Axis {
    from: f64,
    to: f64,
    /// Extremes of what can arrive.
    least: f64,
    most: f64,
    /// Further words that are visited.
    breaks: Vec<f64>,
}

impl Axis {
    fn corners(&self) -> Vec<f64> {
        let middle = 0.5 * (self.from + self.to);
        let all = [self.from, self.to, middle.round(), self.from - 1.0, self.to + 1.0, self.least, self.most];
        all.into_iter().map(|v| v.clamp(self.least, self.most)).collect()
    }

    fn at(&self, place: f64) -> f64 {
        (self.from + (self.to - self.from) * place).clamp(self.least, self.most)
    }
}

/// Sequences for `routine`: about `calls` of random ones and what else there is. Where nothing `limits` the reading it
/// stays inside the range, for beyond it nothing is promised of any later call either.
pub fn of(routine: &Routine, calls: usize, limits: bool) -> Calls {
    let axes = axes(routine, limits);
    let mut out = Writer::new(routine);
    let mut random = Random(0x0041_7263_736d_6974);
    let mut corners = 0;
    for_each_corner(&axes, &mut |places: &[f64]| {
        corners += 1;
        out.call(true, places);
        let others: Vec<f64> = axes.iter().map(|a| a.at(0.5 + 0.5 * random.signed())).collect();
        out.call(false, &others);
        out.call(false, places);
    });
    let mut breaks = 0;
    for (index, axis) in axes.iter().enumerate() {
        for near in axis.breaks.iter().flat_map(|b| [-2.0, -1.0, 0.0, 1.0, 2.0].map(|by| b + by)) {
            breaks += 1;
            let mut places: Vec<f64> = axes.iter().map(|a| a.at(0.5 + 0.5 * random.signed())).collect();
            places[index] = near.clamp(axis.least, axis.most);
            out.call(true, &places);
            out.call(false, &places);
        }
    }
    let (ramps, holds) = (calls / 8, calls / 8);
    let boxes = 1usize << axes[1..].len();
    for corner in 0..boxes {
        let beside = |i: usize| axes[i + 1].at(f64::from(u8::from(corner >> i & 1 == 1)));
        let further: Vec<f64> = (0..axes.len() - 1).map(beside).collect();
        let mut places = vec![0.0; axes.len()];
        places[1..].clone_from_slice(&further);
        let count = ramps / boxes;
        for k in 0..count {
            let (turn, phase) = (k * 16 / count, (k * 16 % count) as f64 / count as f64);
            let height = 1.0 - turn as f64 / 16.0;
            let up = if turn.is_multiple_of(2) { phase } else { 1.0 - phase };
            places[0] = axes[0].at(0.5 + height * (up - 0.5)).round();
            out.call(k == 0, &places);
        }
        // From the opposite corner to this one, and stay.
        let opposite = |i: usize| axes[i + 1].at(f64::from(u8::from(corner >> i & 1 == 0)));
        places[0] = axes[0].at(0.0);
        (0..axes.len() - 1).for_each(|i| places[i + 1] = opposite(i));
        out.call(true, &places);
        places[0] = axes[0].at(0.9).round();
        places[1..].clone_from_slice(&further);
        (0..holds / boxes).for_each(|_| out.call(false, &places));
    }
    let sequences = (calls / 4096).max(8);
    for sequence in 0..sequences {
        walk(&mut out, &axes, &mut random, sequence, calls / sequences);
    }
    out.calls.what = format!(
        "{corners} corners, {breaks} words beside breakpoints, ramps with reversals and holds at {boxes} corners of the \
         boxes, {sequences} random walks with jumps; not all"
    );
    out.calls
}

/// One random sequence; its temper is drawn.
fn walk(out: &mut Writer, axes: &[Axis], random: &mut Random, sequence: usize, length: usize) {
    let mut places: Vec<f64> = axes.iter().map(|a| a.at(0.5 + 0.5 * random.signed()).round()).collect();
    // Steps from a word to the whole range.
    let sizes: Vec<f64> =
        axes.iter().map(|a| (a.to - a.from) * 2f64.powf(-8.0 + 8.0 * random.signed())).collect();
    for k in 0..length {
        for (place, (axis, size)) in places.iter_mut().zip(axes.iter().zip(&sizes)) {
            *place = match random.below(64) {
                0 => axis.least + (axis.most - axis.least) * (0.5 + 0.5 * random.signed()),
                1 => [axis.from, axis.to, axis.least, axis.most][random.below(4)],
                2 if !axis.breaks.is_empty() => axis.breaks[random.below(axis.breaks.len())],
                // A step back inside, where it had left.
                _ => (*place + size * random.signed()).clamp(axis.at(0.0), axis.at(1.0)),
            };
            *place = place.round().clamp(axis.least, axis.most);
        }
        // Every other sequence runs on from whatever state the one before left the routine in.
        out.call(k == 0 && sequence.is_multiple_of(2), &places);
    }
}

fn for_each_corner(axes: &[Axis], visit: &mut dyn FnMut(&[f64])) {
    let corners: Vec<Vec<f64>> = axes.iter().map(Axis::corners).collect();
    let count: usize = corners.iter().map(Vec::len).product();
    for mut index in 0..count {
        let mut places = Vec::with_capacity(axes.len());
        for of_axis in &corners {
            places.push(of_axis[index % of_axis.len()]);
            index /= of_axis.len();
        }
        visit(&places);
    }
}

/// The reading first, then the further inputs.
fn axes(routine: &Routine, limits: bool) -> Vec<Axis> {
    let program = &routine.design.program;
    let (from, to) = program.valid;
    let readings = program.arguments.len() - routine.physics.further.len();
    let (least, most) = match (program.arguments[0].ty.range(), readings) {
        _ if !limits => (from, to),
        // A float: far beyond the range, where it is limited.
        (None, _) => (from - 2.0 * (to - from), to + 2.0 * (to - from)),
        (Some((lo, hi)), 1) => (lo as f64, hi as f64),
        (Some((lo, hi)), _) => ((lo - hi) as f64, (hi - lo) as f64),
    };
    let mut axes = vec![Axis { from, to, least, most, breaks: breaks(routine) }];
    for (index, further) in routine.physics.further.iter().enumerate() {
        let argument = &program.arguments[readings + index];
        let (least, most) = argument.ty.range().map_or((0.0, 0.0), |(lo, hi)| (lo as f64, hi as f64));
        let (from, to) = further.words(program).unwrap_or((least, most));
        axes.push(Axis { from, to, least, most, breaks: Vec::new() });
    }
    axes
}

/// Readings, in their own words, at which a term changes its course or a segment ends.
fn breaks(routine: &Routine) -> Vec<f64> {
    let program = &routine.design.program;
    let (from, to) = program.valid;
    let place = |v: f64| {
        let exponent = program.variable_exponent;
        let (offset, step) = (routine.plan.reading_word.0.to_f64(), routine.plan.reading_word.1.to_f64());
        (offset + step * v * 2f64.powi(-(exponent as i32))).round()
    };
    let mut found = Vec::new();
    if let Some(width) = program.index().filter(|_| routine.design.segments > 1).map(|(_, by)| by) {
        let (a, b) = (routine.plan.word_from.to_f64(), routine.plan.word_to.to_f64());
        let size = 2f64.powi(width as i32);
        let first = (a / size).ceil();
        found.extend((0..4096).map(|k| (first + f64::from(k)) * size).take_while(|w| *w < b).map(place));
    }
    let wanted = routine.physics.terms.iter().flat_map(|term| match &term.operator {
        Operator::Hinge(h) => vec![(h.observable.clone(), h.threshold)],
        Operator::Gaussian(g) => {
            [-8.0, -1.0, 0.0, 1.0, 8.0].map(|z| (g.observable.clone(), g.centre + z * g.width)).to_vec()
        }
        Operator::Exponential(e) => vec![(e.observable.clone(), e.start)],
        Operator::Expression(_) => routine.physics.tree(term).map_or(Vec::new(), |tree| tree.thresholds()),
        _ => Vec::new(),
    });
    let (offset, per_word) = measured_by_word(routine);
    for (name, value) in wanted {
        // What is observed of the reading rises with it.
        let observe = |reading: f64| routine.physics.of_reading(&name, offset + per_word * reading);
        let (Some(a), Some(b)) = (observe(from), observe(to)) else { continue };
        if !(a < value && value < b) {
            continue;
        }
        let (mut low, mut high) = (from, to);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if observe(middle).is_some_and(|v| v < value) { low = middle } else { high = middle }
        }
        found.push(high.round());
    }
    found
}

/// Turns places into argument words.
struct Writer {
    types: Vec<Type>,
    readings: usize,
    calls: Calls,
}

impl Writer {
    fn new(routine: &Routine) -> Self {
        let program = &routine.design.program;
        let types: Vec<Type> = program.arguments.iter().map(|a| a.ty).collect();
        let readings = types.len() - routine.physics.further.len();
        let stride = 1 + types.len();
        Writer { types, readings, calls: Calls { stride, ..Calls::default() } }
    }

    fn call(&mut self, begins: bool, places: &[f64]) {
        self.calls.words.push(u32::from(begins));
        let readings = numbers_of(self.types[0], self.readings, places[0]);
        for (i, place) in readings.iter().chain(&places[1..]).enumerate() {
            let bits = match self.types[i] {
                Type::F32 => (*place as f32).to_bits(),
                _ => *place as i64 as u32,
            };
            self.calls.words.push(bits);
        }
    }
}
