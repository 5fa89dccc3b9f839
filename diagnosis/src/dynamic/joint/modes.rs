//! A recording of a structure of many modes, as one of two: poles and strengths of one state space, fitted in the time domain.
//!
//! The states of either recording's own model have coordinates of their own. So one of the two models is fitted anew to the other
//! recording: it keeps the coordinates that it began with, and its parameters can be held against each other.

use std::f64::consts::TAU;
use std::ops::Range;

use fitter::plant::Plant;
use numerics::{Limits, Normal, Symmetric, dot, parallel, rms};

use super::expansion::{Evaluation, Expansion};
use super::{Direction, Group, Joint, Of, Reported, Side};
use crate::dynamic::data::{Data, Folds};
use crate::dynamic::interval::Sort;
use crate::dynamic::linear::diagnose::free_run;
use crate::dynamic::linear::looped::{Looped, Stretch};
use crate::dynamic::linear::plan::Plan;
use crate::dynamic::linear::sensitivity::Simulation;
use crate::dynamic::linear::{file, sensitivity};
use crate::dynamic::noise::autoregression;
use crate::dynamic::recording::DynamicRecording;
use crate::dynamic::spectrum::Complex;
use crate::thresholds::compare::joint::{DECREASE, STEPS};
use crate::thresholds::dynamic::linear::plan::FINAL_ROWS;
use crate::verdict::{Location, Parameter};

/// What of a structure may differ.
#[derive(Clone, PartialEq)]
enum Part {
    /// The natural frequency of the pairs of poles of these blocks, which lie within each other's width: of one resonance.
    Frequency(Vec<usize>),
    /// Its damping ratio.
    Damping(Vec<usize>),
    /// The strength of this drive.
    Drive(usize),
    /// The scale of this position, where there are several.
    Position(usize),
    /// The strength of the hysteresis.
    Hysteresis,
}

/// See the module.
#[derive(Clone)]
pub struct Structure<'a> {
    recording: &'a DynamicRecording,
    plan: Plan,
    stretches: Vec<Stretch>,
    data: Data<'a>,
    model: Looped,
    /// The parts, in the order of frequencies, and the numbers that they have in names.
    parts: Vec<(Part, usize)>,
    /// What the loop adds to states and positions in the recording that shows more of it.
    strength: Vec<f64>,
    /// Autoregression and variance of what is left, weighted as the stretches are.
    whitening: Vec<f64>,
    variance: f64,
    own: Expansion,
}

/// A model of both recordings, which have these models of their own; none where neither model fits the other recording.
pub fn joint<'a>(
    recordings: [&'a DynamicRecording; 2],
    models: [&Looped; 2],
    plant: &Plant,
) -> Option<Joint<Structure<'a>>> {
    if plant.feedback.is_some() {
        return None;
    }
    let plans = recordings.map(Plan::new);
    let stretches = [0, 1].map(|k| plans[k].chosen(recordings[k], FINAL_ROWS));
    let limits = Limits { steps: STEPS, decrease: DECREASE };
    let from = |first: usize| {
        // Of a loop that the other recording does not show its own fit says where it is driven from.
        let shown = models[1 - first].loops() > 0;
        let start = if shown { models[first].clone() } else { models[first].of_strength(0.0) };
        let fitted = sensitivity::fit(&start, &stretches[1 - first], limits);
        let mut both = [models[first].clone(), models[first].clone()];
        both[1 - first] = fitted;
        let cost = |k: usize| Some(sensitivity::cost(&both[k], &stretches[k])?.ln());
        Some((cost(0)? + cost(1)?, both))
    };
    let (a, b) = parallel::join(|| from(0), || from(1));
    let (_, both) = a.into_iter().chain(b).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let parts = parts(&both[0]);
    let [first, second] = both.each_ref().map(|model| [&model.e[..], &model.f].concat());
    let strength = if dot(&first, &first) > dot(&second, &second) { first } else { second };
    let [then, now] = both;
    let side = |k: usize, model: Looped| {
        Structure::of(recordings[k], plans[k].clone(), stretches[k].clone(), model, (&parts, &strength))
    };
    Some(Joint::new(side(0, then)?, side(1, now)?))
}

/// What may differ of a model, with a number for its name; 0 where there is one of its kind.
fn parts(model: &Looped) -> Vec<(Part, usize)> {
    let lin = &model.linear;
    let mut modes: Vec<usize> = (0..lin.blocks.len()).filter(|k| lin.blocks[*k].pair).collect();
    modes.sort_by(|a, b| mode(model, *a).0.total_cmp(&mode(model, *b).0));
    let one_resonance = |a: &usize, b: &usize| {
        let [(a, of_a), (b, of_b)] = [mode(model, *a), mode(model, *b)];
        (a - b).abs() < (a * of_a).max(b * of_b)
    };
    let resonances: Vec<Vec<usize>> = modes.chunk_by(one_resonance).map(<[usize]>::to_vec).collect();
    let of_modes = (1..).zip(resonances);
    let of_modes = of_modes.flat_map(|(n, of)| [(Part::Frequency(of.clone()), n), (Part::Damping(of), n)]);
    let drives = (0..lin.inputs).map(|j| (Part::Drive(j), if lin.inputs > 1 { j + 1 } else { 0 }));
    // The scale of one position is that of all drives.
    let positions = (0..lin.outputs).filter(|_| lin.outputs > 1).map(|i| (Part::Position(i), i + 1));
    let hysteresis = (model.loops() > 0).then_some((Part::Hysteresis, 0));
    of_modes.chain(drives).chain(positions).chain(hysteresis).collect()
}

/// Natural frequency in Hz and damping ratio of a block's pair of poles.
fn mode(model: &Looped, block: usize) -> (f64, f64) {
    let rate = rate(model, block) / model.linear.step_s;
    (rate.norm() / TAU, -rate.re / rate.norm())
}

/// The mean of both over the blocks of a resonance.
fn resonance(model: &Looped, blocks: &[usize]) -> (f64, f64) {
    let count = blocks.len() as f64;
    let sum = |of: fn((f64, f64)) -> f64| blocks.iter().map(|k| of(mode(model, *k))).sum::<f64>();
    (sum(|mode| mode.0) / count, sum(|mode| mode.1) / count)
}

/// The logarithm of a block's pole: its rate times the time of a row.
fn rate(model: &Looped, block: usize) -> Complex {
    let [re, im] = model.linear.blocks[block].parameters;
    Complex::new(re, im).ln()
}

/// The expansion of normal equations, in units of the noise of this variance; none where it is not finite.
fn expansion(normal: &Normal, variance: f64) -> Option<Expansion> {
    let size = normal.gradient.len();
    let mut information = Symmetric::zero(size);
    for i in 0..size {
        for j in 0..size {
            *information.at_mut(i, j) = normal.gram[(i.max(j), i.min(j))] / variance;
        }
    }
    let pull = normal.gradient.iter().map(|slope| -slope / variance).collect();
    let expansion = Expansion { cost: normal.cost / variance, pull, information };
    expansion.is_finite().then_some(expansion)
}

impl<'a> Structure<'a> {
    fn of(
        recording: &'a DynamicRecording,
        plan: Plan,
        stretches: Vec<Stretch>,
        model: Looped,
        (parts, strength): (&[(Part, usize)], &[f64]),
    ) -> Option<Structure<'a>> {
        let outputs = model.linear.outputs;
        let (mut left, mut runs) = (Vec::new(), Vec::new());
        for stretch in &stretches {
            let predicted = sensitivity::predict(&model, stretch)?;
            let scored = stretch.skip * outputs..predicted.len();
            for output in 0..outputs {
                let start = left.len();
                let of = scored.clone().skip(output).step_by(outputs);
                left.extend(of.map(|k| stretch.weight * (stretch.position[k] - predicted[k])));
                runs.push(start..left.len());
            }
        }
        let whitening = autoregression(&left, &runs).coefficients;
        let mut structure = Structure {
            data: Data::new(recording),
            recording,
            plan,
            stretches,
            own: Expansion { cost: 0.0, pull: Vec::new(), information: Symmetric::zero(0) },
            parts: parts.to_vec(),
            strength: strength.to_vec(),
            model,
            whitening,
            variance: 1.0,
        };
        let normal =
            sensitivity::normal_equations(&structure.model, &structure.stretches, &structure.whitening)?;
        structure.variance = normal.cost / left.len().max(1) as f64;
        structure.own = expansion(&normal, structure.variance)?;
        Some(structure)
    }

    fn id(&self, (part, number): &(Part, usize)) -> String {
        let (of, numbered) = match part {
            Part::Frequency(_) => ("resonance", true),
            Part::Damping(_) => ("damping", true),
            Part::Drive(_) => ("gain", *number > 0),
            Part::Position(_) => ("sensitivity", true),
            Part::Hysteresis => (file::ID, false),
        };
        if numbered { format!("{of}_{number}") } else { of.into() }
    }

    fn title(&self, part: &Part) -> String {
        let at = |blocks: &[usize]| format!("{:.4} Hz", resonance(&self.model, blocks).0);
        match part {
            Part::Frequency(blocks) => format!("the frequency of the resonance at {}", at(blocks)),
            Part::Damping(blocks) => format!("the damping of the resonance at {}", at(blocks)),
            Part::Drive(_) => "the strength of the drive".into(),
            Part::Position(_) => "the scale of the position".into(),
            Part::Hysteresis => "the hysteresis".into(),
        }
    }

    /// How the parameters change with a part; with a resonance also how strongly it is driven, which follows from what moved it.
    fn directions(&self, part: &Part) -> Vec<Direction> {
        let lin = &self.model.linear;
        let mut all = vec![self.direction(part)];
        if let Part::Frequency(blocks) | Part::Damping(blocks) = part {
            let (first, width) = (lin.order(), 2 * lin.inputs);
            let lanes = blocks.iter().flat_map(|k| first + k * width..first + (k + 1) * width);
            all.push(lanes.map(|lane| (lane, lin.b[lane - first])).collect());
        }
        all
    }

    /// How the parameters change with a part alone: by its logarithm, or by the angle of a pole.
    fn direction(&self, part: &Part) -> Direction {
        let lin = &self.model.linear;
        let (n, m, q) = (lin.order(), lin.inputs, self.model.loops());
        let (b, c) = (n, n + lin.b.len());
        let (d, e) = (c + lin.c.len(), c + lin.c.len() + lin.d.len());
        let all = self.model.parameters();
        let scaled = |lanes: &mut dyn Iterator<Item = usize>| lanes.map(|lane| (lane, all[lane])).collect();
        match part {
            Part::Frequency(blocks) | Part::Damping(blocks) => {
                let of_block = |block: &usize| {
                    let [re, im] = lin.blocks[*block].parameters;
                    let log = rate(&self.model, *block);
                    let turn = if matches!(part, Part::Frequency(_)) { log } else { Complex::I * log };
                    let by = Complex::new(re, im) * turn;
                    [(2 * block, by.re), (2 * block + 1, by.im)]
                };
                blocks.iter().flat_map(of_block).collect()
            }
            &Part::Drive(j) => {
                let mut lanes = (0..n).map(|s| b + s * m + j).chain((0..lin.outputs).map(|i| d + i * m + j));
                scaled(&mut lanes)
            }
            &Part::Position(i) => {
                let of_loop = (0..q).map(|l| e + n * q + i * q + l);
                let mut lanes = (c + i * n..c + (i + 1) * n).chain(d + i * m..d + (i + 1) * m).chain(of_loop);
                scaled(&mut lanes)
            }
            Part::Hysteresis => (e..).zip(self.strength.iter().copied()).collect(),
        }
    }
}

impl Side for Structure<'_> {
    fn groups(&self) -> Vec<Group> {
        let group = |(k, part): (usize, &(Part, usize))| Group {
            id: self.id(part),
            title: self.title(&part.0),
            directions: self.directions(&part.0),
            of: Of::Structure(k),
        };
        self.parts.iter().enumerate().map(group).collect()
    }

    fn packed(&self) -> Vec<f64> {
        self.model.parameters()
    }

    fn evaluate(&self, packed: &[f64]) -> Option<Evaluation<'_>> {
        let simulation = Simulation::of(&self.model.with(packed), &self.stretches, &self.whitening)?;
        let (cost, variance) = (simulation.cost / self.variance, self.variance);
        Some(Evaluation { cost, expand: Box::new(move || expansion(&simulation.normal(), variance)) })
    }

    fn own(&self) -> &Expansion {
        &self.own
    }

    /// Every joint model has the same effects.
    fn deviance(&self) -> f64 {
        0.0
    }

    /// No fit has seen the rows that are held out.
    fn without(&self, _: usize) -> Option<Self> {
        (!self.plan.held().is_empty()).then(|| self.clone())
    }

    fn left(&self, packed: &[f64], _: Folds) -> Option<Vec<f64>> {
        let model = self.model.with(packed);
        let positions = &self.recording.positions;
        let mut left = vec![0.0; self.recording.rows()];
        for run in &self.recording.runs {
            let predicted = free_run(&model, self.recording, run)?;
            for (row, predicted) in run.clone().zip(predicted.chunks_exact(positions.len())) {
                let apart = positions.iter().zip(predicted).map(|(y, p)| y[row] - p);
                left[row] = rms(&apart.collect::<Vec<f64>>());
            }
        }
        Some(left)
    }

    fn noise(&self) -> f64 {
        let left = self.left(&self.packed(), [true; 3]).unwrap_or_default();
        let rows = self.plan.fitted().into_iter().flatten().filter(|row| self.recording.scored(*row));
        rms(&rows.map(|row| left[row]).collect::<Vec<f64>>())
    }

    fn data(&self) -> &Data<'_> {
        &self.data
    }

    fn stretches(&self, _: usize) -> Vec<Range<usize>> {
        self.plan.held()
    }

    fn counts(&self, row: usize) -> bool {
        self.recording.scored(row)
    }

    fn readings(&self, of: Of, packed: &[f64]) -> Vec<Reported> {
        let Of::Structure(k) = of else { return Vec::new() };
        let (name, unit, blocks) = match &self.parts[k].0 {
            Part::Frequency(blocks) => ("frequency_hz", "Hz", blocks),
            Part::Damping(blocks) => ("damping_ratio", "1", blocks),
            _ => return Vec::new(),
        };
        let model = self.model.with(packed);
        let (frequency, damping) = resonance(&model, blocks);
        let is_frequency = matches!(self.parts[k].0, Part::Frequency(_));
        let slopes = |block: &usize| {
            let [re, im] = model.linear.blocks[*block].parameters;
            let step_s = model.linear.step_s;
            let rate = rate(&model, *block) / step_s;
            // Of the rate by the pole's real part; by its imaginary part i times as much.
            let by = Complex::new(re, im).inv() / step_s;
            let slope = |by: Complex| {
                let size = rate.norm();
                let of_size = (rate.re * by.re + rate.im * by.im) / size;
                if is_frequency { of_size / TAU } else { (rate.re * of_size / size - by.re) / size }
            };
            let of_mean = 1.0 / blocks.len() as f64;
            [(2 * block, of_mean * slope(by)), (2 * block + 1, of_mean * slope(Complex::I * by))]
        };
        let value = if is_frequency { frequency } else { damping };
        let parameter = Parameter { name: name.into(), value, unit: unit.into(), ci95: [value; 2] };
        vec![(parameter, blocks.iter().flat_map(slopes).collect(), Sort::Amount)]
    }

    fn ratio(&self, of: Of, then: &[f64], length: f64, error: f64) -> Option<(f64, f64)> {
        let Of::Structure(k) = of else { return None };
        match self.parts[k].0 {
            Part::Frequency(_) | Part::Damping(_) => None,
            Part::Drive(_) | Part::Position(_) => Some((1.0 + length, error)),
            Part::Hysteresis => {
                let along: f64 =
                    self.direction(&Part::Hysteresis).iter().map(|(lane, by)| then[*lane] * by).sum();
                let had = along / dot(&self.strength, &self.strength);
                Some((1.0 + length / had, error / had.abs()))
            }
        }
    }

    fn amounts(&self, of: Of) -> Vec<usize> {
        match of {
            Of::Structure(k) if self.parts[k].0 == Part::Hysteresis => {
                self.direction(&Part::Hysteresis).iter().map(|(lane, _)| *lane).collect()
            }
            _ => Vec::new(),
        }
    }

    fn place(&self, group: &Group, p_value: f64) -> Option<Location> {
        let Of::Structure(k) = group.of else { return None };
        let whole = |variable: &str, values: &[f64]| {
            let (from, to) = numerics::range(values);
            (variable.to_string(), from, to)
        };
        let (variable, from, to) = match &self.parts[k].0 {
            Part::Frequency(blocks) | Part::Damping(blocks) => {
                let (frequency, damping) = resonance(&self.model, blocks);
                // Its half width.
                let half = frequency * damping;
                ("frequency_hz".into(), frequency - half, frequency + half)
            }
            Part::Drive(j) => whole("drive", &self.recording.drives[*j]),
            Part::Position(i) => whole("position", &self.recording.positions[*i]),
            Part::Hysteresis => whole("history", &self.recording.positions[0]),
        };
        Some(Location { variable, times: None, from, to, share: 1.0, p_value })
    }
}
