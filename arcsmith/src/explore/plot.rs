//! The exploration as a picture: proven bound against instructions, one panel for each core, the area of a
//! point growing with its flash.

use codegen::cost::Core;
use codegen::explore::Row;
use codegen::refused;
use plotters::prelude::*;

use crate::terminal::Result;

/// Draws the rows as an SVG picture.
pub fn svg(rows: &[Row], cores: &[Core]) -> Result<String> {
    let mut text = String::new();
    draw(&mut text, rows, cores).map_err(|error| refused!("the plot cannot be drawn: {error}"))?;
    Ok(text)
}

fn draw(text: &mut String, rows: &[Row], cores: &[Core]) -> Result<(), Box<dyn std::error::Error>> {
    let unit = rows.first().map(|r| r.unit.clone()).unwrap_or_default();
    let root = SVGBackend::with_string(text, (420 * cores.len() as u32, 420)).into_drawing_area();
    root.fill(&WHITE)?;
    let bounds = rows.iter().map(|r| r.bound);
    let (low, high) = bounds.fold((f64::INFINITY, 0.0f64), |(l, h), b| (l.min(b), h.max(b)));
    for (panel, &core) in root.split_evenly((1, cores.len())).iter().zip(cores) {
        let here: Vec<&Row> = rows.iter().filter(|r| r.core == core).collect();
        let most = here.iter().map(|r| r.instructions).fold(1.0, f64::max);
        let mut chart = ChartBuilder::on(panel)
            .caption(core.name(), ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(36)
            .y_label_area_size(64)
            .build_cartesian_2d(0.0..most * 1.08, (low * 0.5..high * 2.0).log_scale())?;
        chart
            .configure_mesh()
            .x_desc("instructions (estimate)")
            .y_desc(format!("proven bound in {unit}"))
            .y_label_formatter(&|v| format!("{v:.0e}"))
            .light_line_style(WHITE)
            .draw()?;
        chart.draw_series(here.iter().map(|row| {
            let radius = (row.flash_bytes as f64).sqrt() / 6.0 + 2.0;
            let colour = match row.routine.split(',').next() {
                Some("q31") => BLUE,
                Some("q31-split") => GREEN,
                Some("q15") => MAGENTA,
                _ => RED,
            };
            Circle::new((row.instructions, row.bound), radius as i32, colour.mix(0.6).filled())
        }))?;
    }
    root.present()?;
    Ok(())
}
