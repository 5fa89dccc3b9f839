//! `fleet.json`: what all units together say. Every probability is family-wise: over all parameters, and over all units
//! where single ones are meant.

use std::collections::{BTreeMap, BTreeSet};

use diagnosis::fleet::{self, Estimate, FALSE_ALARMS, Pooled, Shared, Trend, lots, outlying, pool, trend};
use serde::Serialize;

use super::results::{OfUnit, Results};
use super::table::PROGRAM;

/// What is left of held-out rows.
pub const LEFT: &str = "rms_after";
/// Units from which on a parameter is pooled, and of a lot within which a unit can depart.
const FEWEST: usize = 5;
const FEWEST_OF_LOT: usize = 10;

/// See the module.
#[derive(Serialize)]
pub struct Summary {
    /// Version of the format.
    schema: u32,
    program: &'static str,
    /// False alarms of each question that is asked of the fleet.
    false_alarms: f64,
    /// Number of units, and of those that failed.
    pub units: usize,
    pub failed: Vec<Failed>,
    /// Units by verdict.
    pub verdicts: BTreeMap<String, usize>,
    /// Effects by the number of units that name them, the most frequent first.
    pub physics: Vec<Physics>,
    /// The parameters: first those of effects that the fleet shows.
    pub parameters: Vec<Parameter>,
    /// Units that depart from the others, the furthest first.
    pub outlying: Vec<Departing>,
}

/// A unit that failed.
#[derive(Serialize)]
pub struct Failed {
    pub unit: String,
    pub error: String,
}

/// How often an effect is named.
#[derive(Serialize)]
pub struct Physics {
    pub effect: String,
    pub units: usize,
    /// Part of the units that did not fail.
    pub share: f64,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub by_lot: BTreeMap<String, usize>,
}

/// A parameter over the fleet.
#[derive(Serialize)]
pub struct Parameter {
    pub effect: String,
    pub parameter: String,
    /// The shape at which it is estimated; blank where nothing is chosen.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub at: String,
    pub unit_of_measure: String,
    /// Whether it is estimated in every unit; else in those alone whose diagnosis names the effect, which favours large
    /// values.
    pub of_every_unit: bool,
    /// How many units name the effect.
    pub named_by: usize,
    /// Probability of so clear a mean without the effect, where the fleet shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shown_by_fleet: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<String>,
    #[serde(flatten)]
    pub pooled: Pooled,
    /// Whether one value serves all units: nothing shows that they differ.
    pub common: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lots: Option<ByLot>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trend: Option<Trend>,
    /// Change since the earlier campaign.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drift: Option<Drift>,
    /// For the page: the number of each unit and its estimate.
    #[serde(skip)]
    pub estimates: Vec<(usize, Estimate)>,
}

/// Means of lots.
#[derive(Serialize)]
pub struct ByLot {
    pub lots: Vec<String>,
    #[serde(flatten)]
    pub means: fleet::Lots,
}

/// Change of a mean since an earlier campaign.
#[derive(Serialize)]
pub struct Drift {
    /// Whether the same units were compared, each with itself; else two fleets.
    pub of_same_units: bool,
    pub units: usize,
    pub change: f64,
    pub ci95: [f64; 2],
    pub p_value: f64,
}

/// A unit that departs, and in what.
#[derive(Serialize)]
pub struct Departing {
    pub unit: String,
    pub effect: String,
    pub parameter: String,
    pub unit_of_measure: String,
    pub value: f64,
    /// The median of the fleet, or of its lot, is 0.
    pub z: f64,
    pub p_value: f64,
}

/// What a parameter is called before it is pooled, and its estimate in every unit, by number.
struct Series {
    effect: String,
    parameter: String,
    at: String,
    unit_of_measure: String,
    of_every_unit: bool,
    shown: Option<f64>,
    alternatives: Vec<String>,
    estimates: Vec<(usize, Estimate)>,
    /// The same of the earlier campaign.
    earlier: Vec<(usize, Estimate)>,
}

impl Summary {
    /// Of the results, and those of an earlier campaign.
    pub fn of(results: &Results, earlier: Option<&Results>) -> Summary {
        let mut parameters: Vec<Parameter> = series(results, earlier)
            .into_iter()
            .filter_map(|series| Parameter::of(series, &results.units, earlier.map(|e| &e.units[..])))
            .collect();
        let looked_at = parameters.len() as f64;
        let over_all = |p: &mut f64| *p = (*p * looked_at).min(1.0);
        for parameter in &mut parameters {
            over_all(&mut parameter.pooled.p_same);
            parameter.common = parameter.pooled.p_same >= FALSE_ALARMS;
            parameter.lots.iter_mut().for_each(|lots| over_all(&mut lots.means.p_value));
            parameter.trend.iter_mut().for_each(|trend| over_all(&mut trend.p_value));
            parameter.drift.iter_mut().for_each(|drift| over_all(&mut drift.p_value));
        }
        let units = &results.units;
        let failed = units
            .iter()
            .filter_map(|of| Some(Failed { unit: of.unit.name.clone(), error: of.error.clone()? }));
        let mut verdicts = BTreeMap::new();
        units.iter().filter_map(|of| of.verdict.clone()).for_each(|v| *verdicts.entry(v).or_insert(0) += 1);
        Summary {
            schema: 1,
            program: PROGRAM,
            false_alarms: FALSE_ALARMS,
            units: units.len(),
            failed: failed.collect(),
            verdicts,
            physics: physics(units),
            outlying: departing(&parameters, units),
            parameters,
        }
    }
}

fn physics(units: &[OfUnit]) -> Vec<Physics> {
    let diagnosed = units.iter().filter(|of| of.error.is_none()).count();
    let mut all: BTreeMap<&str, Physics> = BTreeMap::new();
    for of in units {
        for effect in of.effects.iter().collect::<BTreeSet<_>>() {
            let none = || Physics { effect: effect.clone(), units: 0, share: 0.0, by_lot: BTreeMap::new() };
            let one = all.entry(effect).or_insert_with(none);
            one.units += 1;
            one.share = one.units as f64 / diagnosed as f64;
            of.unit.lot.iter().for_each(|lot| *one.by_lot.entry(lot.clone()).or_insert(0) += 1);
        }
    }
    let mut all: Vec<Physics> = all.into_values().collect();
    all.sort_by_key(|one| std::cmp::Reverse(one.units));
    all
}

/// Everything that is pooled: parameters of effects in every unit, those that only a diagnosis that names the effect gives,
/// noise, and what is left.
fn series(results: &Results, earlier: Option<&Results>) -> Vec<Series> {
    let named: BTreeSet<String> = results.units.iter().flat_map(|of| of.effects.iter().cloned()).collect();
    let shared = fleet::shared(&results.forced, &named);
    let before = earlier.map(|earlier| fleet::of_others(&earlier.forced, &shared)).unwrap_or_default();
    let numbered =
        |all: &[Option<Estimate>]| (0..).zip(all).filter_map(|(k, one)| Some((k, (*one)?))).collect();
    let of_shared = |(k, one): (usize, &Shared)| Series {
        effect: one.test.effect.clone(),
        parameter: one.test.parameter.clone(),
        at: one.test.at.clone(),
        unit_of_measure: one.test.unit.clone(),
        of_every_unit: true,
        shown: one.found,
        alternatives: one.alternatives.clone(),
        estimates: numbered(&one.estimates),
        earlier: before.get(k).map(|all| numbered(all)).unwrap_or_default(),
    };
    let mut all: Vec<Series> = shared.iter().enumerate().map(of_shared).collect();
    for (key, estimates) in &results.named {
        let (effect, parameter, unit_of_measure) = key.clone();
        if all.iter().any(|one| (&one.effect, &one.parameter) == (&effect, &parameter)) {
            continue;
        }
        let earlier = earlier.and_then(|earlier| earlier.named.get(key)).cloned().unwrap_or_default();
        let estimates = estimates.clone();
        all.push(Series { effect, parameter, unit_of_measure, earlier, estimates, ..Series::alone("", "") });
    }
    let figure = |of: fn(&OfUnit) -> Option<Estimate>, parameter: &str| {
        let values = |results: &Results| numbered(&results.units.iter().map(of).collect::<Vec<_>>());
        let measure =
            results.units.iter().map(|of| of.unit_of_measure.as_str()).find(|unit| !unit.is_empty());
        Series {
            of_every_unit: true,
            estimates: values(results),
            earlier: earlier.map(values).unwrap_or_default(),
            ..Series::alone(parameter, measure.unwrap_or_default())
        }
    };
    all.push(figure(|of| of.noise, "noise"));
    all.push(figure(|of| of.left, LEFT));
    all
}

impl Series {
    /// One of a parameter of no effect, without estimates.
    fn alone(parameter: &str, unit_of_measure: &str) -> Series {
        Series {
            effect: String::new(),
            parameter: parameter.into(),
            at: String::new(),
            unit_of_measure: unit_of_measure.into(),
            of_every_unit: false,
            shown: None,
            alternatives: Vec::new(),
            estimates: Vec::new(),
            earlier: Vec::new(),
        }
    }
}

impl Parameter {
    /// None where too few units have it.
    fn of(series: Series, units: &[OfUnit], earlier: Option<&[OfUnit]>) -> Option<Parameter> {
        let values: Vec<Estimate> = series.estimates.iter().map(|(_, estimate)| *estimate).collect();
        let pooled = pool(&values).filter(|_| values.len() >= FEWEST)?;
        let own: Vec<&OfUnit> = series.estimates.iter().map(|(k, _)| &units[*k]).collect();
        let times: Option<Vec<f64>> = own.iter().map(|of| of.unit.time).collect();
        let drift = earlier.and_then(|earlier| Drift::of(&series, units, earlier));
        Some(Parameter {
            named_by: units.iter().filter(|of| of.effects.contains(&series.effect)).count(),
            effect: series.effect,
            parameter: series.parameter,
            at: series.at,
            unit_of_measure: series.unit_of_measure,
            of_every_unit: series.of_every_unit,
            shown_by_fleet: series.shown,
            alternatives: series.alternatives,
            pooled,
            common: false,
            lots: by_lot(&own, &values),
            trend: times.and_then(|times| trend(&values, &times)),
            drift,
            estimates: series.estimates,
        })
    }
}

fn by_lot(own: &[&OfUnit], values: &[Estimate]) -> Option<ByLot> {
    let names: BTreeSet<&str> = own.iter().filter_map(|of| of.unit.lot.as_deref()).collect();
    let known = own.iter().zip(values).filter_map(|(of, value)| {
        Some((names.iter().position(|name| Some(*name) == of.unit.lot.as_deref())?, *value))
    });
    let (lot, values): (Vec<usize>, Vec<Estimate>) = known.unzip();
    Some(ByLot { means: lots(&values, &lot)?, lots: names.into_iter().map(str::to_string).collect() })
}

impl Drift {
    /// Unit by unit where enough are in both campaigns, else between the campaigns.
    fn of(series: &Series, units: &[OfUnit], earlier: &[OfUnit]) -> Option<Drift> {
        let before: BTreeMap<&str, Estimate> =
            series.earlier.iter().map(|(k, estimate)| (earlier[*k].unit.name.as_str(), *estimate)).collect();
        let change = |(k, now): &(usize, Estimate)| {
            let then = before.get(units[*k].unit.name.as_str())?;
            Some(Estimate { value: now.value - then.value, error: now.error.hypot(then.error) })
        };
        let changes: Vec<Estimate> = series.estimates.iter().filter_map(change).collect();
        if changes.len() >= FEWEST {
            let of = pool(&changes)?;
            let (change, ci95, p_value) = (of.mean, of.mean_ci95, of.p_zero);
            return Some(Drift { of_same_units: true, units: changes.len(), change, ci95, p_value });
        }
        if series.earlier.len() < FEWEST {
            return None;
        }
        let both: Vec<&(usize, Estimate)> = series.earlier.iter().chain(&series.estimates).collect();
        let campaign: Vec<f64> =
            (0..both.len()).map(|k| f64::from(u8::from(k >= series.earlier.len()))).collect();
        let values: Vec<Estimate> = both.iter().map(|(_, estimate)| *estimate).collect();
        let Trend { slope: change, ci95, p_value, .. } = trend(&values, &campaign)?;
        Some(Drift { of_same_units: false, units: both.len(), change, ci95, p_value })
    }
}

/// Units that depart from the others of their lot, where all lots are large enough, else of the fleet. What is left of held-out
/// rows is not looked at: in fleets of nothing it scatters more than normal numbers, and a verdict says what it means.
fn departing(parameters: &[Parameter], units: &[OfUnit]) -> Vec<Departing> {
    let parameters: Vec<&Parameter> = parameters.iter().filter(|one| one.parameter != LEFT).collect();
    let looked_at: usize = parameters.iter().map(|parameter| parameter.estimates.len()).sum();
    let mut all = Vec::new();
    for parameter in parameters {
        let names: BTreeSet<Option<&str>> =
            parameter.estimates.iter().map(|(k, _)| units[*k].unit.lot.as_deref()).collect();
        let lot_of = |(k, _): &(usize, Estimate)| {
            names.iter().position(|name| *name == units[*k].unit.lot.as_deref()).unwrap_or(0)
        };
        let mut lot: Vec<usize> = parameter.estimates.iter().map(lot_of).collect();
        if (0..names.len()).any(|of| lot.iter().filter(|own| **own == of).count() < FEWEST_OF_LOT) {
            lot.fill(0);
        }
        let values: Vec<Estimate> = parameter.estimates.iter().map(|(_, estimate)| *estimate).collect();
        for ((k, estimate), far) in parameter.estimates.iter().zip(outlying(&values, &lot)) {
            let p_value = (far.p_value * looked_at as f64).min(1.0);
            if p_value < FALSE_ALARMS {
                all.push(Departing {
                    unit: units[*k].unit.name.clone(),
                    effect: parameter.effect.clone(),
                    parameter: parameter.parameter.clone(),
                    unit_of_measure: parameter.unit_of_measure.clone(),
                    value: estimate.value,
                    z: far.z,
                    p_value,
                });
            }
        }
    }
    all.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
    all
}
