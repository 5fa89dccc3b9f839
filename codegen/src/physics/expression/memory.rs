//! Operators that remember: the state is a word, or one of 64 bits, that begins with what the expression without its
//! memories is at the first call.

use physics::Operation;

use super::super::builder::Tracked;
use super::super::sum::fitted;
use super::super::{PhysicsError, Result};
use super::value::Value;
use super::words::{self, Scaled};
use super::{Lowering, Tree};
use crate::exact::{Interval, exp_minus};
use crate::program::Operand;

/// The input of a lag, less the middle of its range, is taken to words below 2^FRACTION.
const FRACTION: i64 = 23;
/// The factor of a lag has at most so many bits more than 31: its state is a word of 2^(FRACTION + 1 + 31 + MORE) at
/// most.
const MORE: i64 = 7;
/// Part of the distance between input and start, on the other side of the start, at most: a lag that begins elsewhere is
/// not faster than half the period.
const BEYOND: i64 = 2;
/// Bits that its state needs more for that.
const WIDER: i64 = 3;
/// Bits of the smallest gap of a play at most: it is ±2^n, so that its limits are one instruction.
const FINEST: i64 = 28;
/// Words up to this have room for what is rounded.
const LARGEST: f64 = i32::MAX as f64 - 16.0;
/// Words below 2^HALF have a difference that is a word.
const HALF: i64 = 30;
/// A delay of more calls than this takes too much memory, and too long to move on.
const MOST_CALLS: f64 = 64.0;
/// A delay is a whole number of calls within this part of one: both times are rounded decimals.
const WHOLE: f64 = 1e-12;

impl Lowering<'_, '_> {
    fn period(&self) -> Result<Interval> {
        let (effect, kind) = self.term;
        let needed = || PhysicsError::NeedsPeriod { effect: effect.into(), kind };
        (self.period_s > 0.0).then(|| Interval::from_f64(self.period_s)).ok_or_else(needed)
    }

    /// What a memory of `tree` begins with, as a word like that of `now`.
    fn start(
        &mut self,
        (tree, now): (&Tree, &Tracked),
        start: Option<&Tree>,
        (from, bits): (&Interval, i64),
        within: f64,
    ) -> Result<Tracked> {
        let start = start.unwrap_or(tree).at_start();
        if start == *tree {
            return Ok(now.clone());
        }
        let value = self.lower(&start, within)?;
        let within = Interval::from_f64(within);
        words::word_at(self.b, &self.shared.bases, &value, (from, bits), (&within, "start"))
    }

    /// A first-order lag: y' = y + κ₀(e₋ − y) + κ₁(e − y), with a = e^(−T/τ), κ₁ = 1 − (1 − a)τ/T, κ₀ = 1 − a − κ₁, e₋
    /// being the input of the call before: e is a straight line between two calls.
    ///
    /// The state is a word of 64 bits, so that a slow lag moves at all. What it is off obeys
    /// δ ← a·δ + (1 − a)·(1 + δ_e) + what the rounded κ leave, so that it stays within 1 + δ_e + |δκ|·width/(1 − a)
    /// words however long it runs: that is its limit cycle.
    pub(super) fn low_pass(&mut self, of: &[Tree], within: f64) -> Result<Value> {
        let e = self.lower(&of[0], within)?;
        let tau = self.constant(&of[1], "a time constant")?;
        if e.is_constant() && of.get(2).is_none() {
            return Ok(e);
        }
        let one = Interval::from_int(1);
        let ratio = self.period()?.div(&tau);
        let gone = &one - &exp_minus(&ratio);
        let last = &one - &gone.div(&ratio);
        let before = &gone - &last;
        let fits = |bits: &i64| gone.mul_pow2(*bits).certainly_le(&Interval::from_int(i32::MAX.into()));
        let more = if of.len() > 2 { MORE - WIDER } else { MORE };
        let bits = (31..=31 + more).rev().find(fits).unwrap_or(30);
        let [k0, k1] = [&before, &last].map(|k| Tracked::constant(&k.mul_pow2(bits)));

        let start = of.get(2).map(Tree::at_start);
        let start_range = match &start {
            Some(start) => self.lower(start, within)?.range,
            None => e.range.clone(),
        };
        let all = e.range.hull(&start_range);
        let middle = all.midpoint();
        let scale = FRACTION - 1 - (&all - &middle).magnitude().log2_floor().unwrap_or(-300).max(-300);
        let tolerance = Interval::pow2(-scale).hull(&Interval::from_f64(within)).lower();
        let tolerance = (&tolerance, "now");
        let now = words::word_at(self.b, &self.shared.bases, &e, (&middle, scale), tolerance)?;
        let start = self.start((&of[0], &now), start.as_ref(), (&middle, scale), within)?;
        let number = self.b.program.state.len() + 1;
        let before_start = match of.len() {
            2 => start.clone(),
            _ => {
                let first = self.start((&of[0], &now), None, (&middle, scale), within)?;
                self.before_start((&first, &start), &last.div(&before))?
            }
        };
        let held = Tracked {
            range: now.range.hull(&start.range).hull(&before_start.range),
            error: now.error.hull(&start.error).magnitude(),
            ..now.clone()
        };
        let b = &mut *self.b;
        let meaning = "the input of the lag at the call before".to_string();
        let was = b.state(&format!("before_{number}"), meaning, &before_start, &held)?;
        b.keep(was.0, now.operand);
        // Two words wider than what the input can be: the lag's own floor.
        let range = &held.range + &Interval::from_int(2).symmetric();
        let width = (&range.upper() - &range.lower()).upper();
        let limit = (&(&k0.error + &k1.error) * &width).div(&gone.mul_pow2(bits));
        let error = (&(&held.error + &one) + &limit).hull(&start.error).magnitude();
        let name = format!("lag_{number}");
        let begin = b.mul_add_wide(&format!("{name}_start"), (&start, 1i64 << bits), None)?;
        let meaning = format!("the lagged input, of which 2^-{bits} is a word");
        let (index, state) = b.wide_state(&name, meaning, begin.operand, range.mul_pow2(bits))?;
        let there = b.high(&format!("held_{number}"), &state, bits as u32, range.clone(), &error)?;
        let e0 = b.sub(&format!("e0_{number}"), &was.1, &there)?;
        let e1 = b.sub(&format!("e1_{number}"), &now, &there)?;
        let word = |k: &Tracked| k.range.round_to_i64().unwrap_or(0);
        let half = b.mul_add_wide(&format!("{name}_half"), (&e0, word(&k0)), Some(&state))?;
        let next = b.mul_add_wide(&format!("{name}_next"), (&e1, word(&k1)), Some(&half))?;
        b.keep(index, next.operand);
        let word = b.high(&format!("lagged_{number}"), &next, bits as u32, range, &error)?;
        let scaled = Scaled { word, offset: middle, unit: Interval::pow2(-scale) };
        Ok(words::value_of(&mut self.shared.bases, scaled).within(&mut self.shared.bases, &all))
    }

    /// The input before the first call with which that call leaves the lag where it starts.
    fn before_start(&mut self, (now, start): (&Tracked, &Tracked), ratio: &Interval) -> Result<Tracked> {
        if !ratio.certainly_le(&Interval::from_int(BEYOND)) {
            return Err(self
                .refuse("a lag that starts elsewhere needs a period below twice its time constant".into()));
        }
        let name = format!("before_start_{}", self.b.program.steps.len());
        let away = self.b.sub(&name, now, start)?;
        let (factor, shift) = fitted(&(-ratio.clone()).mul_pow2(32), 30)?;
        self.b.mul_add(&format!("{name}_word"), (&factor, &away), shift, start, "")
    }

    /// A word as it was at the call before, and at the first call what it began with.
    fn before(&mut self, tree: &Tree, now: &Scaled, within: f64) -> Result<(usize, Tracked)> {
        let Scaled { word, offset, unit } = now;
        let number = self.b.program.state.len() + 1;
        let start = tree.at_start();
        let start = match start == *tree {
            true => word.clone(),
            false => {
                let value = self.lower(&start, within)?;
                let value =
                    value.less(&Value::number(offset.clone())).scaled(&Interval::from_int(1).div(unit));
                let within = Interval::from_f64(within).div(&unit.magnitude());
                let at = (&Interval::zero(), 0);
                words::word_at(self.b, &self.shared.bases, &value, at, (&within, "start"))?
            }
        };
        let held = Tracked {
            range: word.range.hull(&start.range),
            error: word.error.hull(&start.error).magnitude(),
            ..word.clone()
        };
        let meaning = "a reading at the call before".to_string();
        self.b.state(&format!("before_{number}"), meaning, &start, &held)
    }

    /// The difference to the call before, over the time between; 0 at the first call.
    pub(super) fn rate(&mut self, of: &Tree, within: f64) -> Result<Value> {
        let e = self.lower(of, within)?;
        let period = self.period()?;
        if e.is_constant() {
            return Ok(Value::number(Interval::zero()));
        }
        let mut now = self.word(&e, false, within, "now")?;
        if now.word.range.log2_floor().is_some_and(|bits| bits >= HALF) {
            // The difference of two must be a word.
            let (middle, bits) = (e.range.midpoint(), HALF - 1);
            let bits = bits - (&e.range - &middle).magnitude().log2_floor().unwrap_or(0);
            let at = (&middle, bits);
            let word =
                words::word_at(self.b, &self.shared.bases, &e, at, (&Interval::from_f64(within), "now"))?;
            now = Scaled { word, offset: middle, unit: Interval::pow2(-bits) };
        }
        let (index, was) = self.before(of, &now, within)?;
        self.b.keep(index, now.word.operand);
        let name = format!("moved_{}", self.b.program.state.len());
        let word = self.b.sub(&name, &now.word, &was)?;
        let unit = now.unit.div(&period);
        let moved = Scaled { word, offset: Interval::zero(), unit };
        Ok(words::value_of(&mut self.shared.bases, moved))
    }

    /// What it was some time ago, straight between two calls.
    pub(super) fn delay(&mut self, of: &[Tree], within: f64) -> Result<Value> {
        let e = self.lower(&of[0], within)?;
        let exact = self.constant(&of[1], "a delay")?.div(&self.period()?);
        let calls = exact.to_f64();
        let near = (calls - calls.round()).abs() <= WHOLE * calls.max(1.0);
        let whole = if near { calls.round() } else { calls.floor() };
        if e.is_constant() || calls < WHOLE {
            return Ok(e);
        }
        if whole > MOST_CALLS || whole == MOST_CALLS && !near {
            return Err(self.refuse(format!(
                "a delay of {calls:.1} calls: a routine keeps what it read {MOST_CALLS} calls ago at most"
            )));
        }
        let now = self.word(&e, false, within, "now")?;
        let (mut word, mut later) = (now.word.clone(), now.word.clone());
        for _ in 0..whole as usize + usize::from(!near) {
            let (index, was) = self.before(&of[0], &now, within)?;
            self.b.keep(index, word.operand);
            later = std::mem::replace(&mut word, was);
        }
        let mut delayed = words::value_of(&mut self.shared.bases, Scaled { word, ..now.clone() });
        if !near {
            let later = words::value_of(&mut self.shared.bases, Scaled { word: later, ..now });
            let part = &exact - &Interval::from_f64(whole);
            delayed = later.plus(&delayed.less(&later).scaled(&part));
        }
        delayed.range = e.range;
        Ok(delayed)
    }

    /// What follows across gaps of ±r/elements, ±2r/elements, … ±r, the mean of those.
    pub(super) fn play(&mut self, of: &[Tree], elements: i64, within: f64) -> Result<Value> {
        let e = self.lower(&of[0], within)?;
        let mut follows = e.less(&self.gaps(of, elements, within)?);
        if of.get(2).is_none() {
            follows.range = e.range;
        }
        Ok(follows)
    }

    /// How far v is from what follows it, the mean of all elements: d ← limit(v − p, −r, r), p ← v − d. Nothing of that
    /// is rounded: only v is.
    ///
    /// The play operator does not expand distances (Brokate and Sprekels, "Hysteresis and Phase Transitions", 1996,
    /// proposition 2.3.9): if every v is known to within e, r to within e_r and the initial state to within e₀, then
    /// every p is within max(e + e_r, e₀), however long the history.
    pub(super) fn gaps(&mut self, of: &[Tree], elements: i64, within: f64) -> Result<Value> {
        let e = self.lower(&of[0], within)?;
        let r = self.constant(&of[1], "a gap")?;
        let zero = Interval::zero();
        if r == zero {
            return Ok(Value::number(zero));
        }
        let seen = self.word(&e, false, within, "follow")?;
        let alike = of.get(2).is_none_or(|start| start.at_start().observed().is_empty());
        if matches!(seen.word.operand, Operand::Int(_)) && alike {
            // Nothing moves, but for what the word is off: it stays as far from what follows as it was at first.
            let v = &seen.offset + &(&seen.word.range * &seen.unit);
            let held = Tree::Number(v.to_f64());
            let off = (&v - &Interval::from_f64(v.to_f64())).magnitude();
            let moved = (&(&seen.word.error * &seen.unit) + &off).mul_pow2(1);
            let followed = [std::slice::from_ref(&held), &of[1..]].concat();
            let follows = Tree::Apply(self.of_elements(elements), followed).at_start();
            let gap = Tree::Apply(Operation::Difference, vec![held, follows]);
            return Ok(self.lower(&gap, within)?.plus(&Value::number(moved.symmetric())));
        }
        // v in words of which the smallest gap is 2^n: not more than half of those that are seen, so few that all gaps
        // together are a word, and so is the way from where it starts.
        let least = r.div(&Interval::from_int(elements));
        let scale = |n: i64| seen.unit.mul_pow2(n).div(&least);
        let largest = Interval::from_int(i32::MAX.into()).mul_pow2(-32);
        let all_gaps = elements * (elements + 1) / 2;
        let far = self.distance_to_start(of, &seen)?;
        let fits = |n: &i64| {
            let scale = scale(*n).magnitude();
            all_gaps << n <= i32::MAX.into()
                && scale.certainly_le(&largest)
                && scale.to_f64() * far <= LARGEST
        };
        let widest = FINEST - elements.ilog2() as i64;
        let n = (1..=widest).rev().find(fits).ok_or_else(|| {
            let (from, to) = (e.range.to_f64_down(), e.range.to_f64_up());
            self.refuse(format!(
                "a play of half-width {:.3e} is too narrow for words that hold {from:.3e}…{to:.3e} and its start: \
                 narrow the ranges of what it reads",
                r.to_f64()
            ))
        })?;
        let number = self.b.program.state.len() + 1;
        let none = Tracked::constant(&zero);
        let factor = Tracked::constant(&scale(n).mul_pow2(32));
        let v = self.b.mul_add(&format!("v{number}"), (&factor, &seen.word), 0, &none, "")?;
        let unit = least.mul_pow2(-n);
        let start = self.start_of_play(of, &v, (&seen.offset, &unit), within)?;
        let mut sum: Option<Tracked> = None;
        for element in 1..=elements {
            let d = self.gap((&v, &start), (element << n, element.count_ones() == 1))?;
            sum = Some(match sum {
                None => d,
                Some(sum) => self.b.add(&format!("gaps_{number}_{element}"), &sum, &d, "")?,
            });
        }
        let word = sum.unwrap_or(none);
        let unit = unit.div(&Interval::from_int(elements));
        Ok(words::value_of(&mut self.shared.bases, Scaled { word, offset: zero, unit }))
    }

    /// How far it is at most from any v to a start that is stated, in words of v; 0 where it starts at v.
    fn distance_to_start(&self, of: &[Tree], seen: &Scaled) -> Result<f64> {
        let Some(start) = of.get(2) else { return Ok(0.0) };
        let start = self.rough(&start.at_start())?;
        let words = seen.word.range.magnitude().to_f64();
        let away = |end: f64| ((end - seen.offset.to_f64()) / seen.unit.to_f64()).abs();
        Ok(words + away(start.from).max(away(start.to)))
    }

    fn of_elements(&self, elements: i64) -> Operation {
        if elements == 1 { Operation::Play } else { Operation::Plays }
    }

    /// What follows at first, in the words of v.
    fn start_of_play(
        &mut self,
        of: &[Tree],
        v: &Tracked,
        (offset, unit): (&Interval, &Interval),
        within: f64,
    ) -> Result<Tracked> {
        let start = of.get(2).unwrap_or(&of[0]).at_start();
        if start == of[0] {
            return Ok(v.clone());
        }
        let value = self.lower(&start, within)?;
        let value = value.less(&Value::number(offset.clone())).scaled(&Interval::from_int(1).div(unit));
        let within = Interval::from_f64(within).div(unit);
        words::word_at(self.b, &self.shared.bases, &value, (&Interval::zero(), 0), (&within, "start"))
    }

    /// The distance of v from what follows it across a gap of ±`half` words, of which a power of two is limited by one
    /// instruction.
    fn gap(&mut self, (v, start): (&Tracked, &Tracked), (half, power): (i64, bool)) -> Result<Tracked> {
        let number = self.b.program.state.len() + 1;
        // The upper limit is one word short then.
        let short = Interval::from_int(i64::from(power));
        let error = (&v.error + &short).hull(&start.error).magnitude();
        let meaning = format!("what follows across a gap of {half} words");
        let held = Tracked { range: v.range.hull(&start.range), error, ..start.clone() };
        let (index, p) = self.b.state(&format!("play_{number}"), meaning, start, &held)?;
        let name = format!("d{number}");
        let distance = self.b.sub(&name, v, &p)?;
        let d = self.b.clamp(&name, &distance, (-half, half - i64::from(power)), &short, "")?;
        let next = self.b.sub(&format!("play_{number}_next"), v, &d)?;
        self.b.keep(index, next.operand);
        Ok(d)
    }
}
