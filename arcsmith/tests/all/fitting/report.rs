//! The report: its figures as a browser draws them, in two widths, and its SVG files.

use std::path::Path;
use std::process::Command;

use crate::fitting::common::Device;
use crate::fitting::common::encoder::Encoder;
use crate::pages::browser;
use serde_json::Value;

/// The figures of a mirror.
const NAMES: [&str; 10] =
    ["angle", "error", "order", "model", "fit-error", "passes", "mean", "scatter", "histogram", "quantiles"];

fn fitter(folder: &Path, arguments: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_arcsmith"))
        .current_dir(folder)
        .arg("--json")
        .args(arguments)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A folder with the reports of a mirror, with a verification, and of an encoder.
fn reports() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    put("calibration.csv", &Device::paper().csv(1));
    put("verification.csv", &Device::paper().csv(2));
    put("mirror.toml", fitter::mirror::PAIR_FILE);
    put("encoder.toml", fitter::mirror::ENCODER_FILE);
    put("encoder.csv", &Encoder { friction: 2e-4, readings: 60, ..Encoder::eccentric(14) }.csv(360.0, 3));
    let arguments =
        ["report", "calibration.csv", "verification.csv", "--mirror", "mirror.toml", "--out", "pair.html"];
    let value = fitter(folder.path(), &arguments);
    assert_eq!(value["figures"], serde_json::json!(NAMES));
    for path in value["written"].as_array().unwrap() {
        assert!(folder.path().join(path.as_str().unwrap()).is_file(), "{path}");
    }
    fitter(
        folder.path(),
        &["report", "encoder.csv", "--mirror", "encoder.toml", "--out", "turn.html", "--no-svg"],
    );
    folder
}

#[test]
fn svg_files_stand_alone_and_the_page_asks_for_nothing_else() {
    let folder = reports();
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    for name in NAMES {
        let svg = read(&format!("pair-{name}.svg"));
        assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"), "{name}");
        assert!(svg.contains("xmlns=") && svg.contains("aria-label=\""), "{name}");
        assert!(!svg.contains("var(") && !svg.contains("#01020"), "{name}");
    }
    assert!(!folder.path().join("turn-error.svg").exists());
    for name in ["pair.html", "turn.html"] {
        let page = read(name);
        for word in ["src=", "href=", "@import", "url(", "<script", "NaN", "#01020"] {
            assert!(!page.contains(word), "{name} contains {word}");
        }
    }
    // The figures of the verification are those of what the correction leaves of it: about its noise of 0.5″.
    let page = read("pair.html");
    let caption = page.split("id=\"passes\"").nth(1).unwrap().split("<figcaption>").nth(1).unwrap();
    assert!(caption.starts_with("Of verification.csv: 0."), "{}", &caption[..60]);
    assert!(read("turn.html").contains("forward and backward lie 2 × "));
}

/// Runs the browser on a page of the folder; what it prints.
fn browse(browser: &Path, folder: &Path, page: &str, arguments: &[&str]) -> String {
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--allow-file-access-from-files",
            "--hide-scrollbars",
        ])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg("--virtual-time-budget=5000")
        .args(arguments)
        .arg(format!("file://{}", folder.join(page).display()))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// A page that shows the report in a given width and writes down what was drawn there.
const FRAME: &str = r#"<!doctype html><body style="margin:0">
<iframe id="frame" src="REPORT" style="width:WIDTHpx;height:4200px;border:0"></iframe>
<script>
window.onload = () => {
  const page = document.getElementById("frame").contentDocument;
  const figures = [...page.querySelectorAll("figure")].map(figure => {
    const svg = figure.querySelector("svg"), box = svg.getBoundingClientRect();
    const outside = [...svg.querySelectorAll("text,circle")].filter(part => {
      const b = part.getBoundingClientRect();
      return b.left < box.left - 1 || b.right > box.right + 1 || b.top < box.top - 1 || b.bottom > box.bottom + 1;
    }).map(part => part.textContent || part.tagName);
    return {
      id: figure.id, width: box.width, height: box.height, outside,
      circles: svg.querySelectorAll("circle").length, lines: svg.querySelectorAll("polyline").length,
      texts: [...svg.querySelectorAll("text")].map(text => text.textContent.trim()),
      coloured: [...svg.querySelectorAll("circle")].every(c => {
        const style = page.defaultView.getComputedStyle(c), fill = style.fill == "none" ? style.stroke : style.fill;
        return fill.startsWith("rgb(") && fill != "rgb(0, 0, 0)";
      }),
    };
  });
  const root = page.documentElement;
  document.body.dataset.drawn = JSON.stringify({figures, across: root.scrollWidth, width: root.clientWidth});
};
</script>"#;

#[test]
fn a_browser_draws_every_figure_in_two_widths() {
    let Some(browser) = browser::found("the figures of both reports") else { return };
    let folder = reports();
    let pictures = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for report in ["pair", "turn"] {
        for width in [1280, 390] {
            let frame =
                FRAME.replace("REPORT", &format!("{report}.html")).replace("WIDTH", &width.to_string());
            std::fs::write(folder.path().join("frame.html"), frame).unwrap();
            let dom =
                browse(&browser, folder.path(), "frame.html", &["--window-size=1280,4200", "--dump-dom"]);
            let drawn = dom.split("data-drawn=\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
            let drawn: Value =
                serde_json::from_str(&drawn.replace("&quot;", "\"").replace("&amp;", "&")).unwrap();
            assert_eq!(drawn["across"], drawn["width"], "{report} scrolls sideways in {width}");
            assert_eq!(drawn["width"].as_u64(), Some(width));
            let figures = drawn["figures"].as_array().unwrap();
            // Of what turns also the harmonics and the error around the turn.
            assert_eq!(figures.len(), if report == "pair" { 10 } else { 12 });
            for figure in figures {
                let id = figure["id"].as_str().unwrap();
                let size = figure["width"].as_f64().unwrap();
                assert!(
                    size > 300.0 && size <= width as f64 && figure["height"].as_f64().unwrap() > 180.0,
                    "{figure}"
                );
                let few = ["harmonics", "histogram"].contains(&id);
                assert!(few || figure["circles"].as_u64().unwrap() >= 15, "{id}: {figure}");
                assert_eq!(figure["coloured"], Value::Bool(true), "{id}");
                assert_eq!(figure["outside"], serde_json::json!([]), "{id} in {width}");
                let texts: Vec<&str> =
                    figure["texts"].as_array().unwrap().iter().map(|text| text.as_str().unwrap()).collect();
                assert!(
                    texts.len() >= 8 && texts.iter().all(|text| !text.contains("NaN")),
                    "{id}: {texts:?}"
                );
                let unit = if report == "pair" { "arcsec" } else { "deg" };
                assert!(
                    ["angle", "around"].contains(&id) || texts.iter().any(|text| text.contains(unit)),
                    "{id}: {texts:?}"
                );
            }
            let of = |id: &str| figures.iter().find(|figure| figure["id"] == id).unwrap();
            // Both curves of the cross-validation, and of the mirror every one of its 210 readings and 35 points.
            assert!(of("order")["lines"].as_u64().unwrap() >= 2);
            if report == "pair" {
                assert!(of("passes")["circles"].as_u64().unwrap() >= 210);
                assert!(of("error")["circles"].as_u64().unwrap() >= 35);
            }
            let picture = pictures.join(format!("report-{report}-{width}.png"));
            let _ = std::fs::remove_file(&picture);
            let screenshot = format!("--screenshot={}", picture.display());
            let size = format!("--window-size={width},4200");
            browse(&browser, folder.path(), "frame.html", &[&screenshot, &size]);
            assert!(picture.metadata().unwrap().len() > 20_000);
        }
    }
}
