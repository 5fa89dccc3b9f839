//! A map: cells over two axes, whose colour is the sign of a value and whose strength is its size.

use plotters::prelude::*;

use super::axes::{self, BELOW, Drawn, tick, width_beside};
use super::chart::SIZE;
use super::colour::{Colour, themed};
use super::hover::titled;

/// Strength of the weakest cell: it is told from one without readings.
const WEAKEST: f64 = 0.04;

/// A cell.
pub struct Cell {
    /// Lower left corner.
    pub from: (f64, f64),
    /// Upper right corner.
    pub to: (f64, f64),
    /// The value.
    pub value: f64,
}

/// A map before it is drawn.
pub struct Map<'a> {
    /// For those who do not see it.
    pub label: &'a str,
    /// What abscissa, ordinate and value are.
    pub names: [&'a str; 3],
    /// Range of the abscissa and of the ordinate.
    pub ranges: [(f64, f64); 2],
    /// The value of full colour.
    pub full: f64,
    /// The cells.
    pub cells: Vec<Cell>,
}

impl Map<'_> {
    /// The SVG, whose cells show their values where the pointer rests on them; blank where a range is empty.
    pub fn draw(&self) -> String {
        let mut svg = String::new();
        if self.draw_into(&mut svg).is_err() {
            return String::new();
        }
        let [x, y, value] = self.names;
        let title = |cell: &Cell| {
            let middle = |from: f64, to: f64| tick(0.5 * (from + to));
            let (across, up) = (middle(cell.from.0, cell.to.0), middle(cell.from.1, cell.to.1));
            Some(format!("{x} {across}, {y} {up}: {value} {}", tick(cell.value)))
        };
        themed(&titled(&svg, self.label, "rect", self.cells.iter().map(title)))
    }

    fn draw_into(&self, svg: &mut String) -> Drawn {
        let [x, y] = self.ranges;
        let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        let mut builder = ChartBuilder::on(&root);
        builder.margin(10).margin_right(16).x_label_area_size(BELOW);
        builder.y_label_area_size(width_beside(Some(y)));
        let mut chart = builder.build_cartesian_2d(x.0..x.1, y.0..y.1)?;
        axes::draw(&mut chart, (self.names[0], self.names[1]), tick)?;
        chart.draw_series(self.cells.iter().map(|cell| {
            let colour = if cell.value > 0.0 { Colour::First } else { Colour::Second };
            let strength = (cell.value / self.full).abs().clamp(WEAKEST, 1.0);
            Rectangle::new([cell.from, cell.to], colour.of().mix(strength).filled())
        }))?;
        root.present()?;
        Ok(())
    }
}
