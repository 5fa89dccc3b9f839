//! LinuxCNC.

use std::f64::consts::TAU;

use codegen::generate::Generated;
use codegen::options::Options;
use codegen::tables::linuxcnc::{Entry, correction, stored};
use codegen::tables::{Asked, Firmware, TableError, Wanted, generate};
use fitter::coefficients::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};
use fitter::mirror::Mirror;
use fitter::recording::{Purpose, Reading, Recording};
use fitter::table::{Cells, IN_MEMORY};
use fitter::terms::{Operator, Periodic, Play, Product, Scope, Term};

use super::compiled::Sources;
use super::device::{READINGS, Random};
use super::{Compared, devices, entry, fixtures, lines, zero};

const FILE: &str = "joint.comp";
/// Steps of the sweep through the range.
const SWEPT: u32 = 100_000;

/// An axis of 400 mm: a screw that is too long, bent, and has lost motion.
struct Screw {
    /// Slope, curve and cubic, of the position over 200 mm, and a wave of a long period: cosine and sine.
    shape: [f64; 5],
    period: f64,
    half: f64,
    noise: f64,
    /// The command at reference 0, but for the rest.
    zero: f64,
}

impl Screw {
    fn draw(random: &mut Random) -> Screw {
        let mut up_to = |size: f64| random.between(-size, size);
        let shape = [up_to(0.05), up_to(0.03), up_to(0.02), up_to(0.004), up_to(0.004)];
        Screw {
            shape,
            period: 160.0,
            half: random.between(0.002, 0.02),
            noise: 0.001,
            zero: random.between(-30.0, 30.0),
        }
    }

    /// The error of the command at a position: commanded less actual.
    fn wave(&self, position: f64) -> f64 {
        let phase = TAU * position / self.period;
        self.shape[3] * phase.cos() + self.shape[4] * phase.sin()
    }

    fn smooth(&self, command: f64) -> f64 {
        let x = command / 200.0;
        self.zero + x * (self.shape[0] + x * (self.shape[1] + x * self.shape[2]))
    }

    /// Where the axis goes: p + wave(p) = m − smooth(m) − half.
    fn position(&self, command: f64, way: f64) -> f64 {
        let fixed = command - self.smooth(command) - way * self.half;
        (0..8).fold(fixed, |position, _| fixed - self.wave(position))
    }

    fn coefficients(&self) -> Coefficients {
        let sensor = Sensor::Direct { unit: "mm".into(), revolution: None };
        let powers = [self.zero, self.shape[0] / 200.0, self.shape[1] / 4e4, self.shape[2] / 8e6];
        let model = ErrorModel { sensor, centre: 0.0, coefficients: powers.to_vec() };
        let mut file = Coefficients::of_model(&model, -200.0, 200.0, "by hand");
        file.terms.push(term(
            "periodic_error",
            Operator::Periodic(Periodic::of(self.period, 1)),
            &self.shape[3..],
        ));
        file.terms.push(lost_motion(self.half));
        file
    }
}

fn term(effect: &str, operator: Operator, coefficients: &[f64]) -> Term {
    let (effect, scope) = (effect.to_string(), Scope::Device);
    Term { effect, scope, operator, coefficients: coefficients.to_vec(), covariance: Vec::new() }
}

fn lost_motion(half: f64) -> Term {
    term("backlash", Operator::Play(Play::of("measured", &[half.abs()])), &[half.signum()])
}

fn table(file: &Coefficients, wanted: Wanted, options: &Options) -> Result<Generated, TableError> {
    generate(Firmware::Linuxcnc, file, "0", &Asked { wanted, options })
}

fn parsed(generated: &Generated) -> Vec<[f64; 3]> {
    let of = |row: &&str| {
        let numbers: Vec<f64> = row.split(' ').map(|number| number.parse().unwrap()).collect();
        [numbers[0], numbers[1], numbers[2]]
    };
    lines(generated, FILE, "#").iter().map(of).collect()
}

/// The largest and the smallest of what a table leaves of an axis, over the range and both ways.
fn left(screw: &Screw, entries: &[Entry]) -> (f64, f64) {
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for step in 0..=SWEPT {
        let position = -199.0 + 398.0 * f64::from(step) / f64::from(SWEPT);
        for (way, sign) in [(0, 1.0), (1, -1.0)] {
            let off = screw.position(position + correction(entries, position, way), sign) - position;
            (least, most) = (least.min(off), most.max(off));
        }
    }
    (least, most)
}

#[test]
fn every_position_is_within_the_bound_and_the_bound_within_a_tenth_of_the_worst() {
    for (_, mut random) in devices() {
        let screw = Screw::draw(&mut random);
        let wanted = Wanted {
            entries: [None, Some(20), Some(100)][(3.0 * random.uniform()) as usize],
            ..Wanted::default()
        };
        let generated = table(&screw.coefficients(), wanted, &Options::default()).unwrap();
        let kept = stored(&parsed(&generated));
        assert_eq!(kept.len(), wanted.entries.unwrap_or(256));
        let (bound, zero) = (entry(&generated).bound, zero(&generated));
        // What the command should be is found from where the axis goes, by bisection: not as the table finds it.
        let command = |position: f64, way: f64| {
            let (mut low, mut high) = (position - 50.0, position + 50.0);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if screw.position(middle, way) < position { low = middle } else { high = middle }
            }
            0.5 * (low + high)
        };
        let mut found = 0.0f64;
        for step in 0..=SWEPT / 5 {
            let position = -200.0 + 400.0 * f64::from(step) / f64::from(SWEPT / 5);
            for (way, sign) in [(0, 1.0), (1, -1.0)] {
                let off = position + correction(&kept, position, way) - command(position - zero, sign);
                found = found.max(off.abs());
            }
        }
        assert!(found <= bound, "{found} > {bound}");
        assert!(1.1 * found >= bound, "{found}, and {bound} is claimed");
    }
}

/// What its users do: go to 256 places up and down, measure, and write where the joint is, as type 0. Ours is fitted to the
/// same readings; half of the distance between both ways, as `diagnose` finds it, is the lost motion.
#[test]
fn measured_triplets_leave_more() {
    let mut compared = Compared::default();
    for (_, mut random) in devices() {
        // Users set the scale to zero first.
        let screw = Screw { zero: 0.0, ..Screw::draw(&mut random) };
        let places: Vec<f64> = (0..256).map(|i| -200.0 + 400.0 * f64::from(i) / 255.0).collect();
        let passes = READINGS / 512;
        let mut rows = Vec::new();
        let mut means = vec![[0.0; 2]; 256];
        for pass in 0..2 * passes {
            let (way, sign) = if pass % 2 == 0 { (0, 1.0) } else { (1, -1.0) };
            for (index, place) in places.iter().enumerate() {
                let seen = screw.position(*place, sign) + screw.noise * random.normal();
                means[index][way] += seen / passes as f64;
                rows.push(Row { pass: pass as f64, way: sign, command: *place, seen });
            }
        }
        // Type 0, as `usrmotLoadComp` takes it.
        let theirs: Vec<[f64; 3]> =
            places.iter().zip(&means).map(|(p, [up, down])| [*p, p - up, p - down]).collect();
        let half: f64 = means.iter().map(|[up, down]| 0.5 * (down - up) / 256.0).sum();
        let generated = table(&fitted(&rows, half), Wanted::default(), &Options::default()).unwrap();
        let spread = |entries: &[Entry]| {
            let (least, most) = left(&screw, entries);
            0.5 * (most - least)
        };
        compared.add(spread(&stored(&parsed(&generated))) / 360.0, spread(&stored(&theirs)) / 360.0);
    }
    compared.print("LinuxCNC (mm)");
}

/// A reading: `way` is 1 up and −1 down.
struct Row {
    pass: f64,
    way: f64,
    command: f64,
    seen: f64,
}

/// Fitted to the rows, with the lost motion taken off before and added after.
fn fitted(rows: &[Row], half: f64) -> Coefficients {
    let column = |name: &str, of: &dyn Fn(&Row) -> f64| {
        (name.to_string(), Cells::Numbers(rows.iter().map(of).collect::<Vec<f64>>().into()))
    };
    let t_s: Vec<f64> = (0..rows.len()).map(|row| row as f64).collect();
    let columns = vec![
        ("t_s".to_string(), Cells::Numbers(t_s.into())),
        column("pass", &|row| row.pass + 1.0),
        column("direction", &|row| row.way),
        column("measured", &|row| row.command),
        column("reference", &|row| row.seen + row.way * half),
    ];
    let recording = Recording::of_columns(IN_MEMORY, columns, &Reading::plain(Purpose::Fit)).unwrap();
    let mirror = Mirror::parse("axis.toml", "[sensor]\nkind = \"direct\"\nunit = \"mm\"\n").unwrap();
    let mut file = fitter::fit(&recording, &mirror, &fitter::Options::default()).unwrap().coefficients;
    file.terms.push(lost_motion(half));
    file
}

/// `EMCMOT_SET_JOINT_COMP` and the part of `compute_screw_comp` up to the interpolation, as they stand in the source.
#[test]
fn the_firmwares_own_code_gives_the_same_bits() {
    let Some(sources) = Sources::of("linuxcnc", "https://github.com/LinuxCNC/linuxcnc") else { return };
    let command = sources.read("src/emc/motion/command.c");
    let control = sources.read("src/emc/motion/control.c");
    let header = sources.read("src/emc/motion/motion.h");
    let between = |text: &str, from: &str, to: &str| {
        let at = text.find(from).unwrap_or_else(|| panic!("{from} is no longer there"));
        let end = text[at..].find(to).unwrap_or_else(|| panic!("{to} is no longer there"));
        text[at..at + end].to_string()
    };
    let types = between(&header, "    typedef struct {\n\tdouble nominal;", "/* motion controller states */");
    let store = between(&command, "comp_entry = &(joint->comp.array", "case EMCMOT_SET_OFFSET:");
    let store = store.replace("break;", "return;");
    let find = between(
        &control,
        "while ( joint->pos_cmd < comp->entry->nominal )",
        "\t} else {\n\t    /* no compensation data",
    );
    let screw = Screw::draw(&mut Random::new(3));
    let generated = table(&screw.coefficients(), Wanted::default(), &Options::default()).unwrap();
    let rows: Vec<String> =
        parsed(&generated).iter().map(|[p, f, r]| format!("{{{p:?}, {f:?}, {r:?}}}")).collect();
    let program = format!(
        "#include <cfloat>\n#include <cstdio>\n#define _(x) x\nextern \"C\" {{\n{types}\n}}\n\
         struct Joint {{ emcmot_comp_t comp; double pos_cmd, vel_cmd, backlash_corr; }} one, *joint = &one;\n\
         struct Command {{ double comp_nominal, comp_forward, comp_reverse; }} given, *emcmotCommand = &given;\n\
         static int joint_num = 0; static void reportError(const char *, int) {{}}\n\
         static void store() {{ emcmot_comp_entry_t *comp_entry; double tmp1;\n{store}\n}}\n\
         static void find() {{ emcmot_comp_t *comp = &joint->comp; double dpos;\n{find}\n}}\n\
         static const double rows[][3] = {{{}}};\nint main() {{\n\
         for (auto &entry : one.comp.array) entry = {{DBL_MAX, 0, 0, 0, 0}};\n\
         one.comp.array[0].nominal = -DBL_MAX; one.comp.entry = one.comp.array;\n\
         for (auto &row : rows) {{ given = {{row[0], row[1], row[2]}}; store(); }}\n\
         for (int step = 0; step <= 10000; step++) for (int way = 0; way < 2; way++) {{\n\
         one.pos_cmd = -210.0 + 0.042 * step; one.vel_cmd = way ? -1.0 : 1.0; find();\n\
         std::printf(\"%a\\n\", one.backlash_corr); }} }}\n",
        rows.join(",\n"),
    );
    let kept = stored(&parsed(&generated));
    let ours: Vec<f64> = (0..=10_000)
        .flat_map(|step| [0, 1].map(|way| correction(&kept, -210.0 + 0.042 * f64::from(step), way)))
        .collect();
    assert_eq!(sources.run(&program), ours);
}

#[test]
fn what_it_cannot_hold_is_refused_in_one_message() {
    let screw = Screw::draw(&mut Random::new(5));
    let usual = screw.coefficients();
    let refused = |file: &Coefficients, entries, options: &Options| {
        table(file, Wanted { entries, ..Wanted::default() }, options).unwrap_err().to_string()
    };
    let options = Options::default();
    let said = refused(&fixtures::encoder(360.0, 0.0, &[0.5, 0.0]), None, &options);
    assert!(
        said.starts_with("linuxcnc corrects a joint between two ends, and its table does not start again"),
        "{said}"
    );
    assert!(
        refused(&usual, Some(300), &options)
            .starts_with("300 entries for an error of 3 periods; give 12 to 256")
    );
    assert!(refused(&usual, Some(5), &options).starts_with("5 entries for an error of 3 periods"));
    let far = Options { range: Some((-300.0, 200.0)), ..Options::default() };
    let said = refused(&usual, None, &far);
    assert!(said.starts_with("a table from -300 to 200, and the recording covers -200 to 200"), "{said}");
    let fine = Options { bound: Some(1e-9), ..Options::default() };
    let said = refused(&usual, Some(20), &fine);
    assert!(
        said.contains("the table of linuxcnc (20 entries, triplets of type 1, single precision) can reach"),
        "{said}"
    );
    let mut steep = usual.clone();
    steep.base.coefficients[1] = 0.7;
    assert!(refused(&steep, None, &options).starts_with("the error may change by 0.70"));
}

/// Temperature is left out by name; the head stands below the table, where LinuxCNC no longer reads.
#[test]
fn what_is_left_out_is_named_and_the_head_comes_last() {
    let mut file = Screw::draw(&mut Random::new(5)).coefficients();
    file.observed.insert("temperature_c".into(), [20.0, 30.0]);
    file.terms.push(term(
        "thermal_zero_drift",
        Operator::Product(Product::of("temperature_c", 25.0)),
        &[0.002],
    ));
    file.terms.push(term("screw_pitch", Operator::Periodic(Periodic::of(5.0, 1)), &[0.001, 0.0]));
    let generated = table(&file, Wanted::default(), &Options::default()).unwrap();
    let out = &entry(&generated).left_out[2];
    assert!(
        out.starts_with("screw_pitch: it has more periods than the file has entries for; it is up to"),
        "{out}"
    );
    let out = &entry(&generated).left_out[1];
    assert!(out.starts_with("thermal_zero_drift: ") && out.ends_with("it is up to 1.00e-2 mm"), "{out}");
    let text = &generated.files[std::path::Path::new(FILE)];
    assert!(text.starts_with("-200.0 ") && text.lines().nth(256).unwrap().starts_with('#'));
}
