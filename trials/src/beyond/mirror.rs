//! The scanning mirror as a device of the trials.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use twin::effects::catalogue;
use twin::units::arcsec_from_rad;
use twin::{Device, Injected, Noise, Protocol, Reading, Temperature, calculated_angle_rad, contributions};

use super::draw::Made;
use super::lab::Lab;
use super::plan::{Assignment, Condition};

/// A mirror with physics concealed in it, and how it is recorded.
pub struct Mirror {
    bare: Device,
    effect: Option<Injected>,
    lasts: bool,
    protocol: Protocol,
    seed: u64,
    fresh_protocol: Protocol,
    fresh_seed: u64,
}

impl Mirror {
    /// Draws a mirror and its protocols.
    pub fn draw(assignment: &Assignment, generator: &mut ChaCha12Rng) -> Self {
        let thermal = assignment.concealed.is_some_and(|kind| kind.depends_on.contains(&"temperature_c"));
        let noise = (assignment.family.noise)();
        // What shows only in motion is read in motion.
        let moves = assignment.concealed.is_some_and(|kind| kind.depends_on.contains(&"velocity"));
        let mut protocol = |condition| match moves {
            true => Protocol { temperature: Temperature::Laboratory, ..Protocol::scan() },
            false => protocol(condition, thermal, generator),
        };
        let fresh_protocol = protocol(Condition::Plain);
        let protocol = Protocol { noise, ..protocol(assignment.condition) };
        // In the same chamber: no model is asked about temperatures that it never saw.
        let fresh_protocol = Protocol { temperature: protocol.temperature.clone(), ..fresh_protocol };
        let specification = assignment.concealed.and_then(|kind| catalogue::find(kind.id));
        let effect = specification.map(|s| twin::effects::draw(s, &protocol, generator));
        Self {
            // Probes that match: as drawn, a device leaks some common motion, which nobody concealed.
            bare: Device::from_seed(generator.random()).with_mismatch(0.0),
            effect,
            lasts: assignment.concealed.is_some_and(|kind| kind.lasts),
            protocol,
            seed: generator.random(),
            fresh_protocol,
            fresh_seed: generator.random(),
        }
    }

    fn lab(&self, effect: Option<&Injected>, strength: f64, protocol: &Protocol, seed: u64) -> Option<Lab> {
        let device =
            self.bare.with_effects(effect.iter().map(|effect| effect.scaled(strength)).collect()).ok()?;
        let distance_mm = device.geometry.probe_distance_mm;
        let calculated = |x1, x2| calculated_angle_rad(x1, x2, distance_mm);
        let rows = twin::record_with_truth(&device, protocol, seed, &calculated);
        let effect = contributions(&device, protocol, seed, &calculated).into_iter().next();
        let column = |name: &str, value: &dyn Fn(&Reading) -> f64| {
            (name.to_owned(), rows.iter().map(|(reading, _)| value(reading)).collect::<Vec<f64>>())
        };
        let columns = vec![
            column("t_s", &|r| r.t_s),
            column("pass", &|r| f64::from(r.pass)),
            column("direction", &|r| f64::from(r.direction)),
            column("x1_mm", &|r| r.x1_mm),
            column("x2_mm", &|r| r.x2_mm),
            column("reference_arcsec", &|r| r.reference_arcsec),
            column("cross_arcsec", &|r| r.cross_arcsec),
            column("temperature_c", &|r| r.temperature_c),
            column("coil_a", &|r| r.coil_a),
        ];
        let square: f64 = rows.iter().map(|(_, truth)| truth.noise_arcsec().powi(2)).sum();
        let clean = |(reading, truth): &(Reading, twin::Truth)| {
            reading.reference_arcsec - truth.reference_noise_arcsec
        };
        Some(Lab {
            measured: rows.iter().map(|(r, _)| arcsec_from_rad(calculated(r.x1_mm, r.x2_mm))).collect(),
            clean: rows.iter().map(clean).collect(),
            effect: effect.unwrap_or_else(|| vec![0.0; rows.len()]),
            noise: (square / rows.len().max(1) as f64).sqrt(),
            reference: "reference_arcsec",
            columns,
        })
    }
}

impl Made for Mirror {
    fn record(&self, strength: f64) -> Option<Lab> {
        self.lab(self.effect.as_ref(), strength, &self.protocol, self.seed)
    }

    fn record_afresh(&self, strength: f64) -> Option<Lab> {
        let lasting = self.effect.as_ref().filter(|_| self.lasts);
        self.lab(lasting, strength, &self.fresh_protocol, self.fresh_seed)
    }

    fn shape(&self) -> Vec<f64> {
        self.effect.iter().flat_map(|effect| effect.parameters.values().copied()).collect()
    }
}

/// Decimals of a column.
pub fn decimals(column: &str) -> usize {
    match column {
        "pass" | "direction" => 0,
        "t_s" => 2,
        "x1_mm" | "x2_mm" => 7,
        "coil_a" => 5,
        _ => 3,
    }
}

fn protocol(condition: Condition, thermal: bool, generator: &mut ChaCha12Rng) -> Protocol {
    let usual = [Protocol::calibration, Protocol::coarse, Protocol::fine][generator.random_range(0..3)]();
    let protocol = match condition {
        Condition::RandomOrder => Protocol::random(),
        Condition::FewRows => Protocol { passes: 4, ..Protocol::coarse() },
        Condition::ManyRows => Protocol { passes: 16, ..Protocol::fine() },
        _ => usual,
    };
    let temperature = match generator.random::<f64>() {
        u if u < 0.5 => Temperature::chamber(),
        u if thermal || u < 0.7 => Temperature::levels(),
        _ => Temperature::Laboratory,
    };
    Protocol { temperature, noise: Noise::White, ..protocol }
}
