//! The report as a browser draws it. The browser is found through the environment variable CHROMIUM or on the
//! path; without one the test says what it skipped.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::diagnose::common::{recording, scene};

fn browser() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("CHROMIUM") {
        return Some(PathBuf::from(named));
    }
    let path = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome"];
    std::env::split_paths(&path).flat_map(|p| names.map(|n| p.join(n))).find(|p| p.is_file())
}

/// What a page that frames the report measures of it once it is drawn: overflow beyond the frame in pixels,
/// charts, marks in them, smallest height of their text in pixels, headings and the verdict's sentence.
const PROBE: &str = "<!doctype html><body><script>
const frame = document.createElement('iframe');
frame.style = 'border:0;height:900px;width:WIDTHpx';
frame.onload = () => {
  const page = frame.contentDocument, root = page.documentElement;
  const all = (what) => [...page.querySelectorAll(what)];
  const height = (e) => e.getBoundingClientRect().height;
  const pre = document.createElement('pre');
  pre.id = 'measured';
  pre.textContent = JSON.stringify({
    over: root.scrollWidth - root.clientWidth,
    charts: all('svg').filter((s) => height(s) > 50).length,
    marks: all('svg circle').length,
    text: Math.min(...all('svg text').map(height)),
    headings: all('h1, h2, h3').map((e) => e.innerText),
    lead: page.querySelector('.lead').innerText,
  });
  document.body.append(pre);
};
frame.src = 'step.html';
document.body.append(frame);
</script>";

/// Draws the report in `folder` at a width in pixels and returns what the probe measured.
fn drawn(browser: &Path, folder: &Path, width: u32) -> serde_json::Value {
    let probe = folder.join("probe.html");
    std::fs::write(&probe, PROBE.replace("WIDTH", &width.to_string())).expect("a file");
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--allow-file-access-from-files"])
        .args(["--virtual-time-budget=5000", "--window-size=1400,1000"])
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .args(["--dump-dom", &format!("file://{}", probe.display())])
        .output()
        .expect("the browser runs");
    let document = String::from_utf8_lossy(&output.stdout).into_owned();
    let mark = "id=\"measured\">";
    let start =
        document.find(mark).unwrap_or_else(|| panic!("the probe did not run: {document}")) + mark.len();
    let end = start + document[start..].find("</pre>").expect("its end");
    let text = document[start..end].replace("&amp;", "&").replace("&lt;", "<").replace("&gt;", ">");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn the_drawn_page_fits_a_desk_and_a_phone() {
    let Some(browser) = browser() else {
        assert!(std::env::var_os("CI").is_none(), "no browser to draw the report with: install chromium");
        println!(
            "skipped the drawn report: no browser on the path; install chromium, or set CHROMIUM to one"
        );
        return;
    };
    let scene = scene();
    let path = recording(scene.folder.path(), "step.csv", 6, |row, cells| {
        if row >= 100 {
            let value: f64 = cells[5].parse().expect("a number");
            cells[5] = format!("{:.3}", value - 3.0);
        }
    });
    let (output, out) = scene.diagnose(&[&path], &[]);
    assert!(output.status.success());
    for width in [1280, 400] {
        let measured = drawn(&browser, &out, width);
        assert!(measured["over"].as_f64().expect("a number") <= 0.0, "{width}: {measured}");
        // The map and two charts of the residual, with two marks for nearly every one of the 186 readings.
        assert!(measured["charts"].as_u64() >= Some(3), "{width}: {measured}");
        assert!(measured["marks"].as_u64() >= Some(2 * 2 * 180), "{width}: {measured}");
        // Smaller than 9 px is not read on a phone.
        assert!(measured["text"].as_f64() >= Some(9.0), "{width}: {measured}");
        let headings = measured["headings"].to_string();
        for wanted in ["step.csv", "What was found", "Where it differs", "Proof on held-out data"] {
            assert!(headings.contains(wanted), "{wanted}: {headings}");
        }
        let lead = measured["lead"].as_str().expect("a sentence");
        assert!(lead.contains("a step at one time") && lead.contains("held-out"), "{lead}");
    }
}
