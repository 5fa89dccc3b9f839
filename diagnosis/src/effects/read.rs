//! The rows of a diagnosis, and figures of them, as expressions read them.

use std::borrow::Cow;
use std::cell::OnceCell;

use physics::{Columns, Time, Unit};

use crate::rows::Rows;

/// The figures that the ends of ranges may name, with their units; `p` is that of the position.
const FIGURES: [(&str, &str); 10] = [
    ("spacing", "p"),
    ("stroke", "p"),
    ("low", "p"),
    ("middle", "p"),
    ("high", "p"),
    ("turn", "p/turn"),
    ("duration", "s"),
    ("interval", "s"),
    ("rows", "1"),
    ("positions", "1"),
];

/// The unit of a figure, of a position in `position`.
pub fn unit_of_figure(name: &str, position: &Unit) -> Option<Unit> {
    let (_, unit) = FIGURES.iter().find(|(figure, _)| *figure == name)?;
    Unit::parse(unit).ok().map(|unit| unit.with("p", position))
}

/// The columns of a recording.
pub struct Read<'a>(pub &'a Rows);

/// The same, with the figures: each is computed when it is first asked for.
pub struct Figures<'a> {
    rows: &'a Rows,
    stroke: OnceCell<(f64, f64)>,
    spacing: OnceCell<f64>,
}

impl<'a> Figures<'a> {
    /// Of a recording.
    pub fn of(rows: &'a Rows) -> Figures<'a> {
        Figures { rows, stroke: OnceCell::new(), spacing: OnceCell::new() }
    }

    fn figure(&self, name: &str) -> Option<f64> {
        let rows = self.rows;
        let stroke = || *self.stroke.get_or_init(|| rows.stroke());
        Some(match name {
            "spacing" => *self.spacing.get_or_init(|| rows.step()),
            "stroke" => stroke().1 - stroke().0,
            "low" => stroke().0,
            "middle" => 0.5 * (stroke().0 + stroke().1),
            "high" => stroke().1,
            "turn" => rows.whole_turn().unwrap_or(f64::NAN),
            "duration" => rows.duration_s(),
            "interval" => rows.duration_s() / rows.len().max(2) as f64,
            "rows" => rows.len() as f64,
            "positions" => rows.positions() as f64,
            _ => return None,
        })
    }
}

impl Read<'_> {
    /// A column that the recording need not have, as a reader knows it; none of those that all have.
    pub fn need_not_be(name: &str) -> Option<&str> {
        match name {
            "angle" | "measured" | "true_angle" | "t_s" | "direction" | "pass" => None,
            "common_mode" => Some("common mode of x1_mm and x2_mm"),
            _ => Some(name),
        }
    }
}

fn optional(values: &Option<Vec<f64>>) -> Option<Cow<'_, [f64]>> {
    values.as_deref().map(Cow::Borrowed)
}

impl Columns for Read<'_> {
    fn column(&self, name: &str) -> Option<Cow<'_, [f64]>> {
        let rows = self.0;
        match name {
            "angle" => Some(Cow::Borrowed(&rows.theta)),
            "measured" if !rows.pair => Some(Cow::Borrowed(&rows.theta)),
            "true_angle" => Some(Cow::Borrowed(&rows.truth)),
            "t_s" => Some(Cow::Borrowed(&rows.t_s)),
            "direction" => Some(Cow::Borrowed(&rows.direction)),
            "pass" => Some(rows.pass.iter().map(|pass| *pass as f64).collect()),
            "common_mode" | "common_mode_um" => optional(&rows.common_mode_um),
            "cross_arcsec" => optional(&rows.cross_arcsec),
            "temperature_c" => optional(&rows.temperature_c),
            "coil_a" => optional(&rows.coil_a),
            "command_deg" => optional(&rows.command_deg),
            _ => {
                let further = rows.extra.iter().find(|column| column.name == name);
                further.map(|column| Cow::Borrowed(&column.values[..]))
            }
        }
    }

    fn time(&self) -> Time<'_> {
        Time { t_s: &self.0.t_s, pass: &self.0.pass }
    }
}

impl Columns for Figures<'_> {
    fn column(&self, name: &str) -> Option<Cow<'_, [f64]>> {
        match self.figure(name) {
            Some(value) => Some(Cow::Owned(vec![value])),
            None => Read(self.rows).column(name).map(|column| Cow::Owned(column.into_owned())),
        }
    }

    fn time(&self) -> Time<'_> {
        Time { t_s: &self.rows.t_s, pass: &self.rows.pass }
    }
}
