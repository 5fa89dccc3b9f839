//! Sets of files from outside: killed at any moment, or out of room, a command leaves the old set or the new one, and
//! the next clears what it left.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};

const ARCSMITH: &str = env!("CARGO_BIN_EXE_arcsmith");
const HIDDEN: &str = ".arcsmith-";

/// Commands that write sets; `A` and `B` stand for the inputs of the old set and of the new one, `OUT` for the folder.
const COMMANDS: [&str; 4] = [
    "generate --coefficients A/coefficients.json --format q31 --out OUT",
    "report A/good.csv --mirror mirror.toml --splits 2 --out OUT/report.html --overview OUT/over/o.svg",
    "diagnose A/good.csv --mirror mirror.toml --out OUT --jobs 2",
    "diagnose A/moves.csv --plant plant.toml --out OUT --jobs 2",
];

type Files = BTreeMap<PathBuf, Vec<u8>>;

/// A folder with what the commands need.
struct Scene {
    root: tempfile::TempDir,
}

impl Scene {
    fn new() -> Scene {
        let scene = Scene { root: tempfile::tempdir().unwrap() };
        let run = |line: &str| {
            let output = scene.command(line).output().unwrap();
            assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        };
        fs::write(scene.path("mirror.toml"), "[geometry]\nprobe_distance_mm = 12.0\ninitial_gap_mm = 0.3\n")
            .unwrap();
        fs::write(
            scene.path("plant.toml"),
            "[plant]\nkind = \"second-order\"\nposition_unit = \"arcsec\"\ndrive_unit = \"A\"\n",
        )
        .unwrap();
        for (seed, folder) in [(7, "A"), (8, "B")] {
            fs::create_dir(scene.path(folder)).unwrap();
            run(&format!("record --protocol calibration --seed {seed} --out {folder}/good.csv"));
            run(&format!("excite --seed {seed} --samples 512 --out {folder}/moves.csv"));
            let fit = format!("fit {folder}/good.csv --mirror mirror.toml --splits 2");
            run(&format!("{fit} --out {folder}/coefficients.json"));
        }
        scene
    }

    fn path(&self, name: &str) -> PathBuf {
        self.root.path().join(name)
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(ARCSMITH);
        command.current_dir(self.root.path()).args(line.split(' '));
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        command
    }

    /// The set of a command's old or new inputs, written into an empty folder.
    fn set(&self, line: &str, inputs: &str) -> (Files, Duration) {
        let out = self.path("OUT");
        let _ = fs::remove_dir_all(&out);
        fs::create_dir_all(out.join("over")).unwrap();
        let begun = Instant::now();
        let output = self.command(&filled(line, inputs, "OUT")).output().unwrap();
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        let took = begun.elapsed();
        let files = visible(&out);
        fs::remove_dir_all(&out).unwrap();
        (files, took)
    }

    /// Makes `OUT` hold these files and nothing else.
    fn lay(&self, files: &Files) {
        let out = self.path("OUT");
        let _ = fs::remove_dir_all(&out);
        fs::create_dir_all(out.join("over")).unwrap();
        for (name, bytes) in files {
            fs::create_dir_all(out.join(name).parent().unwrap()).unwrap();
            fs::write(out.join(name), bytes).unwrap();
        }
    }
}

fn filled(line: &str, inputs: &str, out: &str) -> String {
    line.replace("A/", &format!("{inputs}/")).replace("OUT", out)
}

/// All files and folders below a folder.
fn everything(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).map(|entries| entries.flatten().collect::<Vec<_>>());
    let mut found = Vec::new();
    for path in entries.unwrap_or_default().into_iter().map(|entry| entry.path()) {
        found.push(path.clone());
        if path.is_dir() {
            found.extend(everything(&path));
        }
    }
    found.sort();
    found
}

fn is_hidden(path: &Path) -> bool {
    path.components().any(|part| part.as_os_str().to_string_lossy().starts_with(HIDDEN))
}

/// The files below a folder but the hidden ones.
fn visible(folder: &Path) -> Files {
    let files = everything(folder).into_iter().filter(|path| path.is_file());
    files
        .filter_map(|path| {
            let name = path.strip_prefix(folder).unwrap().to_owned();
            (!is_hidden(&name)).then(|| (name, fs::read(path).unwrap()))
        })
        .collect()
}

/// Whether a decided set waits in a folder to be completed.
fn is_interrupted(folder: &Path) -> bool {
    everything(folder).iter().any(|path| is_hidden(path) && path.ends_with("set"))
}

/// Half of the kills fall anywhere into a run, the others into the moments in which it writes. `ARCSMITH_KILLS` says how
/// many there are of each command.
#[test]
fn a_killed_command_leaves_the_old_set_or_the_new_one() {
    let kills = std::env::var("ARCSMITH_KILLS").ok().map_or(15, |count| count.parse().unwrap());
    let scene = Scene::new();
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let out = scene.path("OUT");
    for line in COMMANDS {
        let ((old, _), (new, took)) = (scene.set(line, "A"), scene.set(line, "B"));
        assert_ne!(old, new, "{line}");
        let (mut stayed, mut changed, mut interrupted) = (0, 0, 0);
        for kill in 0..kills {
            scene.lay(&old);
            let mut child = scene.command(&filled(line, "B", "OUT")).spawn().unwrap();
            let begun = Instant::now();
            let mut part = || random.random::<f64>();
            if kill % 2 == 0 {
                std::thread::sleep(took.mul_f64(1.1 * part()));
            } else {
                let writes = || everything(&out).iter().any(|path| is_hidden(path));
                while !writes() && begun.elapsed() < 10 * took && child.try_wait().unwrap().is_none() {}
                std::thread::sleep(Duration::from_secs_f64(5e-3 * part()));
            }
            child.kill().unwrap();
            child.wait().unwrap();
            match visible(&out) {
                found if found == old => stayed += 1,
                found if found == new => changed += 1,
                _ if is_interrupted(&out) => interrupted += 1,
                found => panic!("{line}: mixed, and nobody is told: {:?}", found.keys()),
            }
            let decided = is_interrupted(&out) || visible(&out) == new;
            // Any other command that writes into the folders completes the set and clears what was left.
            let folders: Vec<PathBuf> =
                everything(&out).into_iter().filter(|path| path.is_dir() && !is_hidden(path)).collect();
            for folder in [out.clone()].iter().chain(&folders) {
                let next = folder.join("next.toml");
                let output = scene.command("init --force --out").arg(&next).output().unwrap();
                assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
                fs::remove_file(next).unwrap();
            }
            assert!(visible(&out) == *if decided { &new } else { &old }, "{line}");
            assert!(!everything(&out).iter().any(|path| is_hidden(path)), "{line}: something is left");
        }
        println!("{kills} kills of {line}: {stayed} old, {changed} new, {interrupted} completed by the next");
    }
}

/// A write past the limit of a file's size fails as one on a full disk does.
#[cfg(unix)]
#[test]
fn without_room_nothing_is_changed_and_nothing_is_left() {
    let scene = Scene::new();
    let out = scene.path("OUT");
    let limited = |line: &str, blocks: u64| -> Output {
        Command::new("sh")
            .current_dir(scene.root.path())
            .args(["-c", "trap '' XFSZ; ulimit -f \"$0\"; exec \"$@\"", &blocks.to_string(), ARCSMITH])
            .args(filled(line, "B", "OUT").split(' '))
            .output()
            .unwrap()
    };
    for line in COMMANDS {
        let (old, _) = scene.set(line, "A");
        let largest = old.values().map(Vec::len).max().unwrap() as u64 / 512;
        for blocks in [0, 1, largest / 4, largest / 2] {
            scene.lay(&old);
            let before = everything(&out);
            let output = limited(line, blocks);
            let said = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{line}: {said}");
            assert!(said.contains("cannot be written") && !said.contains("panicked"), "{line}: {said}");
            assert_eq!((everything(&out), visible(&out) == old), (before, true), "{line}");
        }
    }
    // A folder that was made for the set vanishes with it.
    fs::remove_dir_all(&out).unwrap();
    for line in [COMMANDS[0], COMMANDS[2]] {
        assert_eq!(limited(line, 4).status.code(), Some(2));
        assert!(!out.exists(), "{line}: {:?}", everything(&out));
    }
}

#[test]
fn a_report_whose_overview_cannot_be_written_writes_nothing() {
    let scene = Scene::new();
    let line = "report A/good.csv --mirror mirror.toml --splits 2 --out r.html --overview nowhere/o.svg";
    let before = everything(scene.root.path());
    let output = scene.command(line).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("nowhere/o.svg: cannot be written"));
    assert_eq!(everything(scene.root.path()), before);
}

/// Of two that write at the same time one comes after the other.
#[test]
fn two_at_once_leave_one_of_two_sets() {
    let scene = Scene::new();
    let line = COMMANDS[0];
    let sets = ["A", "B"].map(|inputs| scene.set(line, inputs).0);
    for _ in 0..4 {
        scene.lay(&sets[0]);
        let children = ["A", "B", "A", "B"].map(|i| scene.command(&filled(line, i, "OUT")).spawn().unwrap());
        for mut child in children {
            assert!(child.wait().unwrap().success());
        }
        assert!(sets.contains(&visible(&scene.path("OUT"))));
        assert!(!everything(&scene.path("OUT")).iter().any(|path| is_hidden(path)));
    }
}

/// `check` reports a set that waits to be completed.
#[test]
fn check_reports_an_interrupted_set() {
    let scene = Scene::new();
    let line = COMMANDS[0];
    scene.lay(&scene.set(line, "A").0);
    let check = || scene.command(&filled(&line.replace("generate", "check"), "A", "OUT")).output().unwrap();
    assert_eq!(check().status.code(), Some(0));
    let left = scene.path("OUT").join(format!("{HIDDEN}killed"));
    fs::create_dir_all(left.join("new")).unwrap();
    fs::write(left.join("set"), "[]").unwrap();
    assert_eq!(check().status.code(), Some(1));
    assert!(scene.command(&filled(line, "A", "OUT")).output().unwrap().status.success());
    assert_eq!(check().status.code(), Some(0));
    assert!(!left.exists());
}

/// Whoever has locked the folder, `flock` around the very command for example, does not hold it up for good.
#[cfg(unix)]
#[test]
fn a_folder_that_is_locked_by_others_is_written_to() {
    let scene = Scene::new();
    let (line, new) = (COMMANDS[0], scene.set(COMMANDS[0], "B").0);
    scene.lay(&scene.set(line, "A").0);
    let folder = fs::File::open(scene.path("OUT")).unwrap();
    folder.lock().unwrap();
    assert!(scene.command(&filled(line, "B", "OUT")).status().unwrap().success());
    assert_eq!(visible(&scene.path("OUT")), new);
}
