//! What `diagnose` prints of a recording: one screen, the figure that matters in colour.

use diagnosis::Diagnosis;
use diagnosis::report::without_unit;
use diagnosis::verdict::{Location, NamedEffect, Verdict};
use fitter::figures::{figure, plain, with_interval};

use crate::fit::summary::left_out;
use crate::terminal::{FIGURE, WARNING, line};

/// So many places and effects are listed unless everything is.
const LISTED: usize = 4;

/// The sentence that says it all.
pub fn sentence(d: &Diagnosis) -> String {
    let names: Vec<String> = d.effects.iter().map(name).collect();
    let place = d.locations.first().map_or(String::new(), |l| format!(" on {}", l.variable));
    match d.verdict {
        Verdict::Consistent => format!("{}: consistent with the simulation", d.recording),
        Verdict::Described => format!("{}: described by {}", d.recording, names.join(" and ")),
        Verdict::Explained => format!("{}: explained by {}", d.recording, names.join(" and ")),
        Verdict::PartlyExplained => {
            format!("{}: partly explained by {}; structure is left", d.recording, names.join(" and "))
        }
        Verdict::Unexplained => format!("{}: unexplained structure{place}", d.recording),
    }
}

fn name(e: &NamedEffect) -> String {
    if e.alternatives.is_empty() {
        e.id.clone()
    } else {
        format!("{} (or {})", e.id, e.alternatives.join(", "))
    }
}

/// The sentence and what it rests on; `verbose` leaves nothing out.
pub fn styled(d: &Diagnosis, verbose: bool) -> String {
    let style = match d.verdict {
        Verdict::Consistent | Verdict::Explained | Verdict::Described => FIGURE,
        Verdict::PartlyExplained | Verdict::Unexplained => WARNING,
    };
    let listed = if verbose { usize::MAX } else { LISTED };
    let mut text = format!("{style}{}{style:#}\n", sentence(d));
    text += &left_out(&d.bad_rows, &[], verbose);
    let floor = &d.noise_floor;
    text += &line("noise", &format!("{} from {}", figure(floor.value, &floor.unit), floor.from));
    for location in d.locations.iter().take(listed) {
        text += &line("where", &place(location));
    }
    for effect in d.effects.iter().take(listed) {
        text += &line("what", &described(effect));
    }
    for p in &d.plant {
        text += &line(
            "plant",
            &format!("{} {:.5} [{:.5}, {:.5}] {}", p.name, p.value, p.ci95[0], p.ci95[1], p.unit),
        );
    }
    if d.verdict != Verdict::Consistent {
        text += &fit(d);
    }
    for sentence in &d.judged {
        text += &line("checked", sentence);
    }
    if let Some(reason) = &d.withheld {
        text += &line("withheld", &format!("no coefficients are written: {reason}"));
    }
    for sentence in d.unidentifiable.iter().filter(|_| verbose) {
        text += &line("open", sentence);
    }
    if let Some(next) = &d.next_experiment {
        text += &line("next", next);
    }
    text
}

/// The same without colours.
pub fn plain_text(d: &Diagnosis) -> String {
    anstream::adapter::strip_str(&styled(d, false)).to_string()
}

fn place(l: &Location) -> String {
    let times = l.times.as_ref().map_or(String::new(), |other| format!(" times {other}"));
    let share = 100.0 * l.share;
    format!("{}{times} from {} to {}, {share:.0} % of it", l.variable, plain(l.from), plain(l.to))
}

fn described(e: &NamedEffect) -> String {
    let parameters: Vec<String> = (e.parameters.iter())
        .map(|p| format!("{} {}", without_unit(&p.name, &p.unit), with_interval(p.value, p.ci95, &p.unit)))
        .collect();
    let correctable = if e.runtime_correctable { "" } else { "; no firmware can undo it" };
    format!("{}: {}{correctable}", e.id, parameters.join(", "))
}

fn fit(d: &Diagnosis) -> String {
    let fit = &d.fit;
    match (fit.before.held_out_rms, fit.after.held_out_rms) {
        (Some(before), Some(after)) => {
            let by = &fit.held_out_by;
            let (before, after) = (figure(before, &fit.unit), figure(after, &fit.unit));
            line("held out", &format!("rms {before} → {FIGURE}{after}{FIGURE:#}, by {by}"))
        }
        _ => {
            let (before, after) =
                (figure(fit.before.train_rms, &fit.unit), figure(fit.after.train_rms, &fit.unit));
            line("fit", &format!("rms {before} → {after}; nothing could be held out"))
        }
    }
}
