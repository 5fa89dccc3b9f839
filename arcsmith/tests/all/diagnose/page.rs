//! The report of a diagnosis as a browser draws it.

use std::path::Path;

use crate::diagnose::common::{recording, scene};
use crate::pages::browser;

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
    browser::measured(browser, folder, "probe.html", &["--window-size=1400,1000"])
}

#[test]
fn the_drawn_page_fits_a_desk_and_a_phone() {
    let Some(browser) = browser::found("the drawn page of a diagnosis") else { return };
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
