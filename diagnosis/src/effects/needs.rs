//! What a recording must have to show an effect.

use super::velocity;
use crate::rows::Rows;

/// One condition.
#[derive(Debug, Clone)]
pub struct Need {
    condition: Condition,
    /// Why, where the usual reason does not say it.
    reason: Option<String>,
}

#[derive(Debug, Clone, Copy)]
enum Condition {
    Rows(usize),
    /// More than a single move, in which time runs with the angle, and the reference may be a function of time.
    SeveralPasses,
    /// Time passes, and is tied neither to the angle nor to the direction.
    Time,
    BothDirections,
    SeveralSpeeds,
    WholeTurn,
    NoWholeTurn,
}

impl Need {
    /// From `condition` or `condition: reason`.
    ///
    /// # Errors
    /// What is expected.
    pub fn read(text: &str) -> Result<Need, String> {
        let (condition, reason) = match text.split_once(": ") {
            Some((condition, reason)) => (condition, Some(reason.to_string())),
            None => (text, None),
        };
        let condition = match condition {
            "several passes" => Condition::SeveralPasses,
            "time" => Condition::Time,
            "both directions" => Condition::BothDirections,
            "several speeds" => Condition::SeveralSpeeds,
            "whole turn" => Condition::WholeTurn,
            "no whole turn" => Condition::NoWholeTurn,
            other => match other.strip_suffix(" rows").and_then(|count| count.parse().ok()) {
                Some(count) => Condition::Rows(count),
                None => {
                    return Err(format!(
                        "`{other}` is nothing that a recording has, expected `several passes`, `time`, `both \
                         directions`, `several speeds`, `whole turn`, `no whole turn` or a number of rows such as `24 rows`"
                    ));
                }
            },
        };
        Ok(Need { condition, reason })
    }

    /// Whether a recording meets it.
    ///
    /// # Errors
    /// Why not.
    pub fn check(&self, rows: &Rows) -> Result<(), String> {
        self.condition.check(rows).map_err(|usual| self.reason.clone().unwrap_or(usual))
    }
}

impl Condition {
    fn check(self, rows: &Rows) -> Result<(), String> {
        let met = |met: bool, otherwise: &str| if met { Ok(()) } else { Err(otherwise.to_string()) };
        let reversals = || rows.direction.windows(2).filter(|pair| pair[0] != pair[1]).count();
        match self {
            Condition::Rows(count) => met(rows.len() >= count, &format!("fewer than {count} rows")),
            Condition::SeveralPasses => met(!rows.single_move(), "a single move: time runs with the angle"),
            Condition::Time => {
                Condition::SeveralPasses.check(rows)?;
                met(reversals() != 1, "one move each way: time runs with the direction")?;
                met(rows.t_s.last() > rows.t_s.first(), "time stands still")
            }
            Condition::BothDirections => {
                met(rows.both_directions(), "the recording moves in one direction only")
            }
            Condition::SeveralSpeeds => several_speeds(rows),
            Condition::WholeTurn => met(rows.whole_turn().is_some(), "nothing turns"),
            Condition::NoWholeTurn => met(rows.whole_turn().is_none(), "the sensor turns"),
        }
    }
}

fn several_speeds(rows: &Rows) -> Result<(), String> {
    let velocity = velocity(rows);
    // Settled readings are taken at one pace; only a recording that moves is taken at several speeds.
    if rows.command_deg.is_some() && !unlike_passes(rows, &velocity) {
        return Err("the readings are settled ones at commanded angles: nothing moves".into());
    }
    let (low, high) = numerics::range(&velocity);
    let middle = numerics::mean(&velocity).abs().max(1e-12);
    if high - low > 0.2 * middle {
        Ok(())
    } else {
        Err("the speed is constant: a delay is a constant offset".into())
    }
}

/// Whether some pass was run at least half as fast again as another.
fn unlike_passes(rows: &Rows, velocity: &[f64]) -> bool {
    let typical = rows.passes().into_iter().map(|pass| {
        let mut speeds: Vec<f64> =
            velocity.iter().zip(&rows.pass).filter(|(_, p)| **p == pass).map(|(v, _)| v.abs()).collect();
        numerics::median(&mut speeds)
    });
    let (slowest, fastest) = typical.fold((f64::INFINITY, 0.0), |(s, f), v: f64| (v.min(s), v.max(f)));
    fastest > 1.5 * slowest
}
