//! Recordings before they are damaged: what kind of sensor, how many passes over which positions, and what disturbs it.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A recording as text, cell by cell.
pub struct Table {
    pub header: Vec<&'static str>,
    pub rows: Vec<Vec<String>>,
    /// Standard deviation of the noise of measured and reference, in their unit.
    pub noise: f64,
}

impl Table {
    pub fn index(&self, column: &str) -> usize {
        self.header.iter().position(|name| *name == column).expect("a column")
    }

    pub fn get(&self, row: usize, column: &str) -> f64 {
        self.rows[row][self.index(column)].parse().unwrap_or(f64::NAN)
    }

    pub fn set(&mut self, row: usize, column: &str, value: f64) {
        let index = self.index(column);
        self.rows[row][index] = value.to_string();
    }

    /// Changes every number of a column, which is told its row.
    pub fn change(&mut self, column: &str, change: impl Fn(usize, f64) -> f64) {
        for row in 0..self.rows.len() {
            let value = change(row, self.get(row, column));
            self.set(row, column, value);
        }
    }

    pub fn text(&self) -> String {
        let lines = self.rows.iter().map(|cells| cells.join(",") + "\n");
        self.header.join(",") + "\n" + &lines.collect::<String>()
    }
}

/// A sum of twelve even numbers, normal enough for a scatter.
pub fn normal(random: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0
}

fn pick<T: Copy>(random: &mut ChaCha8Rng, from: &[T]) -> T {
    from[random.random_range(0..from.len())]
}

pub const LINEAR: &str = "[sensor]\nkind = \"direct\"\nunit = \"mm\"\n";
pub const TURNING: &str = "[sensor]\nkind = \"direct\"\nunit = \"deg\"\nrevolution = 360.0\n";
pub const PAIR: &str = "[geometry]\nprobe_distance_mm = 12.0\ninitial_gap_mm = 0.3\n";

/// A sensor and what it recorded; the noise is a ten-thousandth of the range.
pub fn draw(random: &mut ChaCha8Rng) -> (&'static str, Table) {
    let mirror = pick(random, &[LINEAR, LINEAR, PAIR, TURNING]);
    let positions: usize = pick(random, &[4, 6, 17, 35, 80]);
    // Of fewer than sixteen readings nothing is said, and damage takes some; every pass of a turning sensor takes a whole turn.
    let positions = if mirror == LINEAR { positions } else { positions.max(17) };
    let passes = pick(random, &[1, 2, 4, 6]).max(24_usize.div_ceil(positions));
    let (half, scale) = match mirror {
        LINEAR => (5.0, pick(random, &[1e-6, 1.0, 1e3])),
        TURNING => (175.0, 1.0),
        _ => (1.5, 1.0),
    };
    let offset = if mirror == LINEAR { pick(random, &[0.0, 1e3]) * scale } else { 0.0 };
    let (one_way, kind) = (random.random_range(0..4) == 0, random.random_range(0..12));
    let size: f64 = pick(random, &[3.0, 30.0, 1000.0]);
    let sigma = 2e-4 * half * scale;
    // What is concealed stays below what a sensor of this kind can be off.
    let a = size.min(if mirror == LINEAR { 1000.0 } else { 100.0 }) * sigma;
    let reading: &[&str] =
        if mirror == PAIR { &["x1_mm", "x2_mm", "reference_arcsec"] } else { &["measured", "reference"] };
    let header = [&["t_s", "pass", "direction"], reading, &["temperature_c"]].concat();
    let rows = passes * positions;
    let mut table = Table { header, rows: Vec::new(), noise: sigma };
    for row in 0..rows {
        let (pass, k) = (row / positions, row % positions);
        let forward = one_way || pass % 2 == 0;
        let place = if forward { k } else { positions - 1 - k } as f64 / (positions - 1) as f64;
        let (t, d) = (row as f64, if forward { 1.0 } else { -1.0 });
        let truth = 2.0 * half * scale * (place - 0.5);
        let temperature = 25.0 + 0.01 * t + 0.02 * normal(random);
        let error = match kind {
            0 => 0.0,
            1 => a * (7.0 * place).sin(),
            2 => a * d,
            3 => -a * d,
            4 => a * (temperature - 25.0),
            5 => a * (25.0 * place).sin() * (1.0 + temperature - 25.0),
            6 => a * f64::from(u8::from(row > rows / 2)),
            7 => a * (place - 0.3).abs(),
            8 => a * normal(random) * f64::from(u8::from(row % 17 == 0)),
            9 => a * (t / 7.0).sin(),
            10 => a * (normal(random) - 0.5).max(0.0),
            _ => (a * normal(random) / 0.3).round() * 0.3 * place,
        };
        let measured = truth + error + sigma * normal(random) + offset;
        let mut cells = vec![t.to_string(), pass.to_string(), d.to_string()];
        match mirror {
            PAIR => {
                let s = 12.0 * measured.to_radians().tan();
                let common = 0.3 + 2e-4 * normal(random);
                cells.extend([common - 0.5 * s, common + 0.5 * s, 3600.0 * truth].map(|v| v.to_string()));
            }
            TURNING => cells.extend([measured, truth].map(|v| (v + 180.0).rem_euclid(360.0).to_string())),
            _ => cells.extend([measured, truth].map(|v| v.to_string())),
        }
        cells.push(format!("{temperature:.3}"));
        table.rows.push(cells);
    }
    if mirror == PAIR {
        table.noise *= 3600.0;
    }
    (mirror, table)
}
