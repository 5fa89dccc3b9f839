//! Colours as CSS variables, so that one drawing serves a light and a dark page.

use plotters::style::RGBColor;

use super::chart::SIZE;

/// Stand-ins for the page's colours: what is drawn in them is given the CSS variable of that name.
pub(super) const INK: RGBColor = RGBColor(1, 2, 3);
pub(super) const GRID: RGBColor = RGBColor(1, 2, 4);
const FIRST: RGBColor = RGBColor(1, 2, 5);
const SECOND: RGBColor = RGBColor(1, 2, 6);
pub(super) const SOFT: RGBColor = RGBColor(1, 2, 7);
/// Stand-in, CSS variable, colours on a light and on a dark page.
const NAMES: [(&str, &str, [&str; 2]); 5] = [
    ("#010203", "--ink", ["#1d2430", "#e6e9ee"]),
    ("#010204", "--grid", ["#d5dae1", "#3a4250"]),
    ("#010205", "--before", ["#c2571a", "#f0935a"]),
    ("#010206", "--after", ["#1f6fb2", "#6cb2ee"]),
    ("#010207", "--soft", ["#5a6473", "#9aa4b2"]),
];
/// The ground of a light and of a dark page.
const GROUND: [&str; 2] = ["#ffffff", "#0d1117"];

/// What a drawing of its own stands on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Page {
    Light,
    Dark,
}

/// What a series is drawn in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Colour {
    /// Measured before, backward, testing, positive.
    First,
    /// Modelled, forward, training, negative.
    Second,
    /// What is only there to compare with.
    Soft,
    /// What was recorded, and what points something out.
    Ink,
}

impl Colour {
    pub(super) fn of(self) -> RGBColor {
        match self {
            Colour::First => FIRST,
            Colour::Second => SECOND,
            Colour::Soft => SOFT,
            Colour::Ink => INK,
        }
    }

    /// The CSS variable of its name.
    pub fn variable(self) -> &'static str {
        match self {
            Colour::First => "var(--before)",
            Colour::Second => "var(--after)",
            Colour::Soft => "var(--soft)",
            Colour::Ink => "var(--ink)",
        }
    }
}

/// Puts CSS variables in the place of the stand-in colours, and leaves the size to the page.
pub(super) fn themed(svg: &str) -> String {
    // What is said here of every circle is what SVG takes it for anyway.
    let short = svg.replace(" opacity=\"1\"", "").replace(" stroke=\"none\" stroke-width=\"1\"", "");
    NAMES.iter().fold(short, |svg, (code, name, _)| {
        ["fill", "stroke"].iter().fold(svg, |svg, attribute| {
            svg.replace(&format!("{attribute}=\"{code}\""), &format!("style=\"{attribute}:var({name})\""))
        })
    })
}

/// The SVG with the colours of a page, and a ground to stand on.
pub(super) fn standing_alone(svg: &str, page: Page) -> String {
    let coloured = NAMES.iter().fold(svg.to_string(), |svg, (_, name, colours)| {
        svg.replace(&format!("var({name})"), colours[page as usize])
    });
    let fill = GROUND[page as usize];
    let ground = format!("<rect width=\"{}\" height=\"{}\" fill=\"{fill}\"/>", SIZE.0, SIZE.1);
    match coloured.find('>') {
        Some(end) => format!("{}\n{ground}{}", &coloured[..=end], &coloured[end + 1..]),
        None => coloured,
    }
}
