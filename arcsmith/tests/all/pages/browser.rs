//! A browser without a window. It is found through the environment variable CHROMIUM or on the path; without one a test
//! says in one line what it skipped.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// The browser; none after a line that says so. Where CI is set there has to be one.
pub fn found(skipped: &str) -> Option<PathBuf> {
    let named = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let on_path = || {
        let path = std::env::var_os("PATH")?;
        std::env::split_paths(&path).flat_map(|p| names.map(|n| p.join(n))).find(|p| p.is_file())
    };
    let browser = named.or_else(on_path);
    if browser.is_none() {
        assert!(std::env::var_os("CI").is_none(), "no browser for {skipped}: install chromium");
        println!("skipped {skipped}: no browser on the path; install chromium, or set CHROMIUM to one");
    }
    browser
}

/// Loads a page of the folder, which writes its result as JSON into an element `measured`.
pub fn measured(browser: &Path, folder: &Path, page: &str, arguments: &[&str]) -> Value {
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--allow-file-access-from-files"])
        .args(["--hide-scrollbars", "--virtual-time-budget=20000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .args(arguments)
        .arg(format!("file://{}", folder.join(page).display()))
        .output()
        .unwrap();
    let document = String::from_utf8_lossy(&output.stdout).into_owned();
    let result = document.split("id=\"measured\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let result = result.unwrap_or_else(|| panic!("the page measured nothing: {document}"));
    let text = result.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    serde_json::from_str(&text).unwrap()
}
