//! Structure that no physics of the catalogue explains must still be found and located: smooth curves of
//! every observable, of histories and of products, offsets of passes, and differences of direction. These
//! families compete with the catalogue; where one of them wins, the verdict says so.

mod histories;
mod screen;

use crate::base::legendre;
use crate::effects::{Place, low_pass};
use crate::rows::Rows;

use crate::thresholds::generic::{MOST_RIPPLES, ONSET, WAVES};
use histories::histories;
use numerics::{mean, range};
pub use screen::keep_strongest_columns;

/// One family: what it depends on and the candidates in it, each a group of columns.
pub struct Generic {
    /// Where it lives.
    pub place: Place,
    /// Groups of columns; the family's statistic is the largest over its groups.
    pub groups: Vec<Vec<Vec<f64>>>,
    /// Whether its columns are a measurement of their own: whatever a model leaves of them is then real.
    pub measured: bool,
}

/// An observable scaled to −1 … 1, with its name.
pub struct Scaled {
    /// Name as in `locations`.
    pub name: String,
    /// Scaled values.
    pub z: Vec<f64>,
}

/// The observables beside angle, time, pass and direction that vary at all.
pub fn observables(rows: &Rows) -> Vec<Scaled> {
    let mut out = Vec::new();
    let mut add =
        |name: &str, values: Option<&Vec<f64>>| out.extend(values.and_then(|values| varying(name, values)));
    add("temperature_c", rows.temperature_c.as_ref());
    add("common_mode_um", rows.common_mode_um.as_ref());
    add("cross_arcsec", rows.cross_arcsec.as_ref());
    add("coil_a", rows.coil_a.as_ref());
    for column in &rows.extra {
        add(&column.name, Some(&column.values));
    }
    out
}

/// A column as an observable; none where it does not vary.
fn varying(name: &str, values: &[f64]) -> Option<Scaled> {
    let (low, high) = range(values);
    let varies = high - low > 1e-9 * high.abs().max(low.abs()).max(1e-300);
    varies.then(|| Scaled { name: name.into(), z: scaled(values) })
}

/// An observable less its smooth dependence on the angle, where that is nearly all of it; else itself.
pub fn own_part(z: &[f64], x: &[f64]) -> Vec<f64> {
    beside_the_angle(z, x).map_or_else(|| z.to_vec(), |left| scaled(&left))
}

/// What a smooth dependence on the angle leaves of an observable, where that is nearly all of it.
pub fn beside_the_angle(z: &[f64], x: &[f64]) -> Option<Vec<f64>> {
    let mut smooth = numerics::Basis::new(x.len());
    for column in legendre(x, 3) {
        smooth.add(&column);
    }
    let mut left = z.to_vec();
    smooth.project_off(&mut left);
    let whole = numerics::centred(z);
    (numerics::rms(&left) < 0.3 * numerics::rms(&whole)).then_some(left)
}

/// Values mapped linearly onto −1 … 1.
pub fn scaled(values: &[f64]) -> Vec<f64> {
    let (low, high) = range(values);
    let half = (0.5 * (high - low)).max(1e-300);
    values.iter().map(|v| (v - 0.5 * (low + high)) / half).collect()
}

/// Product of two columns.
pub fn times(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

/// A family's place and groups.
type Placed = (Place, Vec<Vec<Vec<f64>>>);

/// What the families of every observable are made with.
struct Setting<'a> {
    rows: &'a Rows,
    /// The scaled reading, and its square.
    x: Vec<f64>,
    x2: Vec<f64>,
    /// The scaled time.
    t: Vec<f64>,
}

impl<'a> Setting<'a> {
    fn of(rows: &'a Rows) -> Setting<'a> {
        let x = rows.scaled_reading();
        Setting { rows, x2: times(&x, &x), x, t: scaled(&rows.t_s) }
    }

    /// The families of one observable: curves of it, its products with angle, direction and time, its history.
    fn about(&self, o: &Scaled) -> Vec<Placed> {
        let Setting { rows, x, x2, t } = self;
        // In products an observable that is all but a function of the angle (the coil's current) counts with what
        // it has of its own: otherwise it would stand in for the angle.
        let own = own_part(&o.z, x);
        let curve = legendre(&o.z, 4);
        let mut groups = vec![curve[1..=1].to_vec(), curve[1..=2].to_vec(), curve[1..=4].to_vec()];
        // What sets in at one value of it.
        for threshold in (-6..=6).map(|k| 0.1 * f64::from(k)) {
            groups.push(vec![o.z.iter().map(|z| ((z - threshold) / ONSET).tanh()).collect()]);
        }
        let with_angle =
            vec![vec![times(&own, x)], vec![times(&own, x), times(&own, x2), times(&curve[2], x)]];
        let square = times(&o.z, &o.z);
        let duration = rows.duration_s();
        let history = [0.01, 0.03, 0.1, 0.3]
            .iter()
            .flat_map(|part| {
                let tau = part * duration;
                let slow = low_pass(&rows.t_s, &own, tau);
                let rate = own.iter().zip(&slow).map(|(z, s)| z - s).collect::<Vec<f64>>();
                [vec![rate], vec![low_pass(&rows.t_s, &square, tau)]]
            })
            .collect();
        // Time always counts from where the recording begins: what creeps at a rate that goes with an observable.
        let mut with_time = product(&own, t);
        with_time.push(vec![t.iter().zip(&own).map(|(t, z)| (t + 1.0) * z).collect()]);
        vec![
            (Place::on(&o.name), groups),
            (Place::product(&o.name, "angle_deg"), with_angle),
            (Place::product(&o.name, "history"), history),
            (Place::product(&o.name, "direction"), vec![vec![times(&own, &rows.direction)]]),
            (Place::product(&o.name, "t_s"), with_time),
        ]
    }
}

/// Products of two columns, counted from the middle of either, or from where the recording begins. The factors
/// themselves are no part of it: two effects would then be one curve.
fn product(a: &[f64], b: &[f64]) -> Vec<Vec<Vec<f64>>> {
    let from_first = |v: &[f64]| v.iter().map(|x| x - v[0]).collect::<Vec<f64>>();
    vec![vec![times(a, b)], vec![times(&from_first(a), &from_first(b))]]
}

/// All generic families for this recording.
pub fn families(rows: &Rows) -> Vec<Generic> {
    let n = rows.len();
    let setting = Setting::of(rows);
    let observables = observables(rows);
    let mut out = Vec::new();
    let mut add =
        |place: Place, groups: Vec<Vec<Vec<f64>>>| out.push(Generic { place, groups, measured: false });

    let own: Vec<Vec<f64>> = observables.iter().map(|o| own_part(&o.z, &setting.x)).collect();
    for (k, o) in observables.iter().enumerate() {
        for (place, groups) in setting.about(o) {
            add(place, groups);
        }
        for (j, other) in observables.iter().enumerate().skip(k + 1) {
            add(Place::product(&o.name, &other.name), product(&own[k], &own[j]));
        }
    }

    let Setting { x, x2, t, .. } = setting;
    // Time.
    let curve = legendre(&t, 6);
    add(Place::on("t_s"), vec![curve[1..=2].to_vec(), curve[1..=4].to_vec(), curve[1..=6].to_vec()]);
    add(Place::on("t_s"), (2..=48).map(|k| wave(&t, k)).collect());
    let breaks: Vec<f64> = (1..24).map(|k| -1.0 + k as f64 / 12.0).collect();
    add(
        Place::on("t_s"),
        breaks.iter().map(|b| vec![t.iter().map(|t| (t - b).max(0.0)).collect()]).collect(),
    );
    add(
        Place::product("t_s", "angle_deg"),
        vec![vec![times(&t, &x)], vec![times(&t, &x), times(&t, &x2), times(&curve[2], &x)]],
    );
    let after = |b: f64| t.iter().zip(&x).map(move |(t, x)| if *t >= b { *x } else { 0.0 });
    add(Place::product("t_s", "angle_deg"), breaks.iter().map(|b| vec![after(*b).collect()]).collect());

    // Passes.
    let passes = rows.passes();
    if passes.len() > 2 && passes.len() <= 40 && passes.len() * 5 <= n {
        let mark = |p: i64| rows.pass.iter().map(move |q| if *q == p { 1.0 } else { 0.0 });
        add(Place::on("pass"), vec![passes[1..].iter().map(|p| mark(*p).collect()).collect()]);
        let slopes = passes[1..].iter().map(|p| mark(*p).zip(&x).map(|(m, x)| m * x).collect()).collect();
        add(Place::product("pass", "angle_deg"), vec![slopes]);
    }

    // Direction and history of the angle.
    if rows.both_directions() {
        let d = &rows.direction;
        add(Place::on("direction"), vec![vec![d.clone()]]);
        add(
            Place::product("direction", "angle_deg"),
            vec![vec![times(d, &x)], vec![d.clone(), times(d, &x), times(d, &x2)]],
        );
        add(Place::on("history"), histories(rows, &x));
    }
    let duration = rows.duration_s();
    let slow = [0.004, 0.012, 0.04, 0.12].iter().map(|part| vec![low_pass(&rows.t_s, &x, part * duration)]);
    add(Place::on("history"), slow.collect());
    let waits: Vec<f64> = (0..n).map(|i| if i > 0 { rows.t_s[i] - rows.t_s[i - 1] } else { 0.0 }).collect();
    let typical = 3.0 * mean(&waits);
    add(Place::on("velocity"), vec![vec![waits.iter().map(|w| w.min(typical)).collect()]]);

    // The angle itself, beyond any polynomial.
    let knots = angle_knots(rows);
    if knots >= 8 {
        add(Place::on("angle_deg"), vec![hats(&x, knots)]);
    }
    add(Place::on("angle_deg"), ripples(rows));
    if !rows.single_move() {
        add(Place::on("angle_deg"), bumps(rows));
    }
    if rows.single_move() {
        // Time runs with the angle, and the reference may be a function of time itself.
        let timely = ["t_s", "history", "velocity"];
        let goes = |name: &str| timely.contains(&name);
        out.retain(|g| !goes(&g.place.variable) && !g.place.times.as_deref().is_some_and(goes));
    }
    for family in out.iter_mut().filter(|g| g.place.times.is_none()) {
        family.measured = observables.iter().any(|o| o.name == family.place.variable);
    }
    out
}

/// A wave of so many half periods over a time that runs from −1 to 1, of any phase.
fn wave(t: &[f64], half_periods: usize) -> Vec<Vec<f64>> {
    let turn = std::f64::consts::FRAC_PI_2 * half_periods as f64;
    vec![t.iter().map(|t| (turn * t).sin()).collect(), t.iter().map(|t| (turn * t).cos()).collect()]
}

/// Waves over the stroke, from those that a polynomial nearly follows to the shortest that the spacing of the
/// angles resolves.
fn ripples(rows: &Rows) -> Vec<Vec<Vec<f64>>> {
    let (low, high) = rows.stroke();
    let most = ((high - low) / (2.2 * rows.step())).clamp(2.0, MOST_RIPPLES);
    let count = ((most - 2.0) / 0.4) as usize;
    (0..=count)
        .map(|k| {
            let turn = std::f64::consts::TAU * (2.0 + 0.4 * k as f64) / (high - low).max(1e-300);
            let phase = rows.theta.iter().map(move |t| turn * (t - low));
            vec![phase.clone().map(f64::sin).collect(), phase.map(f64::cos).collect()]
        })
        .collect()
}

/// Bumps of a few widths at places that overlap by half, narrower than any polynomial follows.
fn bumps(rows: &Rows) -> Vec<Vec<Vec<f64>>> {
    let (low, high) = rows.stroke();
    let stroke = (high - low).max(1e-300);
    let narrow = (rows.step() / stroke).clamp(0.004, 0.05);
    let mut out = Vec::new();
    for width in [narrow, 2.2 * narrow] {
        let count = (1.0 / (1.5 * width)).ceil() as usize;
        for k in 0..=count {
            let centre = low + stroke * k as f64 / count as f64;
            let bump = |t: &f64| (-0.5 * ((t - centre) / (width * stroke)).powi(2)).exp();
            out.push(vec![rows.theta.iter().map(bump).collect()]);
        }
    }
    out
}

/// How many pieces the angle can be cut into so that every piece has several rows at more than one place.
pub fn angle_knots(rows: &Rows) -> usize {
    let (low, high) = rows.stroke();
    let places = (high - low) / rows.step();
    (places / 1.5).min(rows.len() as f64 / 8.0).min(24.0) as usize
}

/// Piecewise linear hats over −1 … 1 with `count` knots.
pub fn hats(x: &[f64], count: usize) -> Vec<Vec<f64>> {
    let spacing = 2.0 / (count - 1) as f64;
    (0..count)
        .map(|k| {
            let knot = -1.0 + k as f64 * spacing;
            x.iter().map(|x| (1.0 - (x - knot).abs() / spacing).max(0.0)).collect()
        })
        .collect()
}

/// The saturated model about which the noise is measured: the base, every angle by itself, smooth in time,
/// linear in the observables, and what has memory. It must absorb every effect well enough that what is
/// left is noise, and no more than a quarter of the rows' freedom.
pub fn saturated(rows: &Rows, base: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = rows.len();
    let x = rows.scaled_reading();
    let t = scaled(&rows.t_s);
    let mut columns = base.to_vec();
    if let Some(temperature) = &rows.temperature_c {
        let z = scaled(temperature);
        columns.push(z.clone());
        columns.push(times(&z, &x));
        columns.push(times(&z, &z));
        if !rows.single_move() {
            columns.push(times(&z, &t));
        }
        columns.push(low_pass(&rows.t_s, &z, 0.03 * rows.duration_s()));
        columns.push(low_pass(&rows.t_s, &z, 0.12 * rows.duration_s()));
    }
    for o in observables(rows).iter().filter(|o| o.name != "temperature_c") {
        columns.push(o.z.clone());
        columns.push(times(&o.z, &o.z));
    }
    if rows.both_directions() {
        // No higher: at the ends of a direction few rows would bear a whole curve, and an outlier among them.
        columns.extend(legendre(&x, 2).iter().map(|curve| times(&rows.direction, curve)));
    }
    if !rows.single_move() {
        columns.push(t.iter().map(|t| -(-(t + 1.0) / 0.1).exp_m1()).collect());
        columns.push(times(&t, &x));
        columns.extend(hats(&t, (n / 24).clamp(3, 14)));
    }
    let knots = if rows.single_move() { (n / 7).min(150) } else { angle_knots(rows) };
    if knots >= 4 {
        columns.extend(hats(&x, knots));
    }
    columns.truncate((n * 2 / 5).max(base.len()));
    columns
}

/// What is taken for correlated noise where it is left in, beside a step: offsets of the passes, waves in time, waves over the
/// angle whose amplitude goes with an observable, and what the history of the angle leaves. Empty for a single move, where such a thing cannot be told
/// from the error's own shape.
pub fn slow_structure(rows: &Rows) -> Vec<Vec<Vec<f64>>> {
    let n = rows.len();
    if rows.single_move() || n < 24 {
        return Vec::new();
    }
    let mut out: Vec<Vec<Vec<f64>>> = Vec::new();
    let passes = rows.passes();
    if passes.len() > 2 && passes.len() <= 40 && passes.len() * 5 <= n {
        let mark = |p: i64| rows.pass.iter().map(|q| if *q == p { 1.0 } else { 0.0 }).collect();
        out.push(passes[1..].iter().map(|p| mark(*p)).collect());
    }
    let t = scaled(&rows.t_s);
    out.extend(WAVES.map(|k| wave(&t, k)));
    let x = rows.scaled_reading();
    for o in observables(rows) {
        let with = |column: &Vec<f64>| times(column, &o.z);
        out.extend(WAVES.map(|k| wave(&x, k).iter().map(with).collect()));
    }
    if rows.both_directions() {
        out.extend(histories(rows, &rows.scaled_reading()));
    }
    out
}
