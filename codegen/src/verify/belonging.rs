//! Whether certificate and code belong together: the files against the hashes in the certificate, and the
//! certificate against one that is computed anew from the same coefficients and options.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::certificate::{Certificate, Entry};
use crate::files;
use crate::generate::sha256;

use super::VerifyError;

/// Reads the certificate in a folder of generated files.
///
/// # Errors
/// [`VerifyError::Unread`], [`VerifyError::Certificate`] where it is not one.
pub fn read_certificate(folder: &Path) -> Result<Certificate, VerifyError> {
    let path = folder.join("certificate.json");
    let wrong = |what: String| VerifyError::Certificate { path: path.clone(), what };
    let text = fitter::input::parsed(&path, "certificate.json").map_err(VerifyError::Unread)?;
    let certificate: Certificate = serde_json::from_str(&text)
        .map_err(|cause| wrong(format!("no certificate of this version: {cause}; generate it anew")))?;
    if certificate.schema != "arcsmith-certificate" || certificate.version != 1 {
        return Err(wrong(format!(
            "schema {} version {}, expected arcsmith-certificate version 1",
            certificate.schema, certificate.version
        )));
    }
    Ok(certificate)
}

/// What is wrong with `certificate` in `folder`, given certificate and files as computed anew; empty where nothing is.
pub fn check<T: AsRef<[u8]>>(
    folder: &Path,
    certificate: &Certificate,
    expected: &Certificate,
    files: &BTreeMap<PathBuf, T>,
) -> Vec<String> {
    let mut wrong = edited_files(folder, certificate);
    let mut differs = |what: &str, found: &str, expected: &str| {
        if found != expected {
            wrong.push(format!("certificate.json: {what} is {found}, computed anew it is {expected}"));
        }
    };
    differs("coefficients_sha256", &certificate.coefficients_sha256, &expected.coefficients_sha256);
    differs("recording_sha256", &certificate.recording_sha256, &expected.recording_sha256);
    for entry in &expected.routines {
        let same = |e: &&Entry| e.routine == entry.routine && e.language == entry.language;
        match certificate.routines.iter().find(same) {
            None => wrong.push(format!(
                "certificate.json: no entry for {} in {}: was it generated with other options?",
                entry.routine, entry.language
            )),
            Some(found) => wrong.extend(entry_differences(found, entry)),
        }
    }
    for extra in &certificate.routines {
        if !expected.routines.iter().any(|e| e.routine == extra.routine && e.language == extra.language) {
            wrong.push(format!(
                "certificate.json: {} in {} is not generated with these options",
                extra.routine, extra.language
            ));
        }
    }
    for (file, difference) in files::compare(folder, files) {
        if file != Path::new("certificate.json") {
            wrong.push(format!("{} {difference}", file.display()));
        }
    }
    wrong
}

/// Files whose hash is not the one in the certificate.
pub fn edited_files(folder: &Path, certificate: &Certificate) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut seen: Vec<&str> = Vec::new();
    for entry in &certificate.routines {
        if seen.contains(&entry.file.as_str()) {
            continue;
        }
        seen.push(&entry.file);
        match std::fs::read_to_string(folder.join(&entry.file)) {
            Err(cause) => wrong.push(format!("{}: {cause}", entry.file)),
            Ok(text) if sha256(&text) != entry.file_sha256 => wrong.push(format!(
                "{}: edited after it was generated: its SHA-256 is {}, the certificate says {}",
                entry.file,
                sha256(&text),
                entry.file_sha256
            )),
            Ok(_) => {}
        }
    }
    wrong
}

fn entry_differences(found: &Entry, expected: &Entry) -> Vec<String> {
    let mut wrong = Vec::new();
    let name = format!("certificate.json: {} in {}", found.routine, found.language);
    if found.bound != expected.bound {
        wrong.push(format!(
            "{name}: the bound is stated as {:e} {}, proved is {:e}",
            found.bound, found.unit, expected.bound
        ));
    }
    if found.file_sha256 != expected.file_sha256 {
        wrong.push(format!("{name}: belongs to another {} than is generated", found.file));
    }
    let rest = |entry: &Entry| Entry { bound: 0.0, file_sha256: String::new(), ..entry.clone() };
    if rest(found) != rest(expected) {
        wrong.push(format!("{name}: its parts, range, input or output are not those computed anew"));
    }
    wrong
}
