//! The firmware's own code, from a checkout beside the project, compiled on this machine.

use std::path::PathBuf;
use std::process::Command;

/// A checkout.
pub struct Sources(PathBuf);

impl Sources {
    /// The one in the folder that `ARCSMITH_FIRMWARE` names, into which it is fetched where it is not there yet; where none is
    /// named, one line says what is skipped. Fetching needs the network, so that its lack is no failure by itself.
    pub fn of(name: &str, repository: &str) -> Option<Sources> {
        let Some(folder) = std::env::var_os("ARCSMITH_FIRMWARE") else {
            println!(
                "skipped: the code of {name}: ARCSMITH_FIRMWARE=FOLDER fetches {repository} into that folder"
            );
            return None;
        };
        let path = PathBuf::from(folder).join(name);
        if !path.is_dir() {
            let fetched = Command::new("git")
                .args(["clone", "--quiet", "--depth", "1", repository])
                .arg(&path)
                .status();
            assert!(fetched.is_ok_and(|status| status.success()), "{repository} was not fetched");
        }
        Some(Sources(path))
    }

    /// A file of it.
    pub fn read(&self, file: &str) -> String {
        let path = self.0.join(file);
        std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }

    /// The function of a file that begins with `begin`, to its last brace.
    pub fn function(&self, text: &str, begin: &str) -> String {
        let from = text.find(begin).unwrap_or_else(|| panic!("{begin} is no longer there"));
        let mut depth = 0;
        for (at, character) in text[from..].char_indices() {
            match character {
                '{' => depth += 1,
                '}' if depth == 1 => return text[from..=from + at].to_string(),
                '}' => depth -= 1,
                _ => {}
            }
        }
        panic!("{begin} has no end")
    }

    /// Compiles a program of C++, without fused products, and reads the numbers that it prints.
    pub fn run(&self, program: &str) -> Vec<f64> {
        let folder = tempfile::tempdir().unwrap();
        let source = folder.path().join("main.cc");
        std::fs::write(&source, program).unwrap();
        let built = Command::new("g++")
            .args(["-std=c++17", "-O2", "-ffp-contract=off", "-o"])
            .arg(folder.path().join("main"))
            .arg(&source)
            .output()
            .unwrap();
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        let output = Command::new(folder.path().join("main")).output().unwrap();
        assert!(output.status.success());
        String::from_utf8_lossy(&output.stdout).lines().map(hexadecimal).collect()
    }
}

/// A number as `%a` prints it.
fn hexadecimal(text: &str) -> f64 {
    let (sign, rest) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let (digits, exponent) = rest.strip_prefix("0x").unwrap().split_once('p').unwrap();
    let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
    let mantissa = u64::from_str_radix(&format!("{whole}{part}"), 16).unwrap() as f64;
    sign * mantissa * 2f64.powi(exponent.parse::<i32>().unwrap() - 4 * part.len() as i32)
}
