//! How much of a residual is no noise, whether a family of forces has its shape or not: what is above the noise, and
//! a tone that the drive does not hold.

use numerics::fourier::{coefficients, hann};

use super::data::{ALL, Data};
use super::estimate::{Fitted, Simulated};
use super::noise::Autoregression;
use super::structure::Structure;
use crate::thresholds::dynamic::remainder::{
    ABOVE, ALONE, AROUND, COLOURED, IN_DRIVE, LEAST_PART, PREDICTED, SPREAD, TONE,
};

/// The part of a model's squared residual that is no noise. `floor` is the noise where the recording itself shows it;
/// elsewhere, once the residual is `known` to hold structure, or is such that its own past predicts it, what its past
/// predicts counts as structure too: what showed it is only the part of it that some family has the shape of.
pub fn above<M: Simulated>(
    found: &Fitted<M>,
    floor: Option<f64>,
    noise: &Autoregression,
    known: bool,
) -> f64 {
    let rows: usize = found.rows.iter().sum();
    let level = match floor {
        Some(floor) if found.rms(ALL) > ABOVE * floor => floor,
        None if known || noise.innovation < PREDICTED * found.rms(ALL) => COLOURED * noise.innovation,
        _ => return 0.0,
    };
    (found.cost(ALL) - level * level * rows as f64).max(0.0)
}

/// A tone in a residual, at a frequency at which the drive has none: no mechanism that stays as it is makes one.
pub fn tone(residual: &[f64], data: &Data) -> Option<Structure> {
    let run = data.runs.iter().max_by_key(|run| run.len())?.clone();
    let power = |values: &[f64]| -> Vec<f64> {
        let middle = numerics::mean(values);
        let window = hann(values.len());
        let windowed: Vec<f64> = values.iter().zip(window).map(|(x, w)| (x - middle) * w).collect();
        coefficients(&windowed).iter().map(|c| c.norm_sqr()).collect()
    };
    let (own, drive) = (power(&residual[run.clone()]), power(&data.drive[run.clone()]));
    // Power on a line over the median of the lines around it.
    let stands_out = |power: &[f64], k: usize| {
        let beside = power[k.saturating_sub(AROUND)..k - SPREAD].iter();
        let beside = beside.chain(&power[k + SPREAD + 1..power.len().min(k + AROUND + 1)]);
        let mut beside: Vec<f64> = beside.copied().collect();
        let middle = beside.len() / 2;
        beside.select_nth_unstable_by(middle, f64::total_cmp);
        power[k] / beside[middle].max(f64::MIN_POSITIVE)
    };
    let mut lines: Vec<usize> = (SPREAD + 1..own.len().saturating_sub(SPREAD + 1)).collect();
    lines.retain(|k| stands_out(&own, *k) > TONE);
    let strongest = |lines: &[usize]| lines.iter().copied().max_by(|a, b| own[*a].total_cmp(&own[*b]));
    let line = strongest(&lines)?;
    lines.retain(|k| k.abs_diff(line) > SPREAD);
    let alone = strongest(&lines).is_none_or(|second| own[line] > ALONE * own[second]);
    if !alone || stands_out(&drive, line) > IN_DRIVE {
        return None;
    }
    let spread: f64 = own[line - SPREAD..=line + SPREAD].iter().sum();
    let part = spread / own.iter().sum::<f64>();
    let unit = 1.0 / (run.len() as f64 * data.step_s);
    let at = Some(((line - 1) as f64 * unit, (line + 1) as f64 * unit));
    (part > LEAST_PART).then(|| Structure::of_part(("frequency_hz", None), part, run.len(), 3, at))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamic::recording::DynamicRecording;

    const ROWS: usize = 8192;

    /// A drive of many lines, and a residual of noise with a tone in it.
    fn recording(frequency_hz: f64, amplitude: f64, in_drive: f64) -> DynamicRecording {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let tone = |k: usize| (std::f64::consts::TAU * frequency_hz * k as f64 * 1e-3).sin();
        let drive = (0..ROWS).map(|k| random() + in_drive * tone(k)).collect();
        let position = (0..ROWS).map(|k| random() + amplitude * tone(k)).collect();
        DynamicRecording::made(1e-3, drive, position)
    }

    fn found(recording: &DynamicRecording) -> Option<Structure> {
        tone(&recording.positions[0], &Data::new(recording))
    }

    #[test]
    fn a_tone_stands_out_of_noise_where_the_drive_has_none() {
        assert!(found(&recording(50.03, 0.0, 0.0)).is_none());
        let tone = found(&recording(50.03, 0.1, 0.0)).expect("a tone");
        let (from, to) = tone.at.expect("a place");
        assert!(from < 50.03 && to > 50.03 && to - from < 0.3, "{from} {to}");
        // 0.1²/2 beside a variance of 1/12.
        assert!((tone.part - 0.056).abs() < 0.02, "{}", tone.part);
        assert!(found(&recording(50.03, 0.1, 0.5)).is_none(), "what the drive holds is no hum");
    }

    #[test]
    fn the_largest_excursion_of_the_drive_is_on_rows_that_fit() {
        for place in [100, 200, 300, 450, 8000] {
            let mut recording = recording(50.0, 0.0, 0.0);
            recording.drives[0][place] = -3.0;
            let fold = Data::new(&recording).fold;
            assert_eq!([fold[0], fold[place]].map(usize::from), [crate::dynamic::data::FIT; 2], "{place}");
        }
    }
}
