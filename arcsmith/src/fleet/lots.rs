//! Lots and times of units in a file of their own: CSV with the columns `unit`, `lot` and, as wanted, `time`.

use std::collections::BTreeMap;
use std::path::Path;

use codegen::refused;
use fitter::text_safety;

use super::answer::Unit;
use crate::terminal::Result;

/// Tells the units what the file says of them. A line may be of a unit that is not there.
pub fn tell(file: &Path, units: &mut [Unit]) -> Result<()> {
    let shown = text_safety::path(file);
    let damaged =
        |error: csv::Error| refused!("cannot be read ({error})").at(&shown).mend("export it as UTF-8 CSV");
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(file).map_err(damaged)?;
    let header = reader.headers().map_err(damaged)?.clone();
    let place = |name: &str| header.iter().position(|column| column == name);
    let (Some(unit), Some(lot)) = (place("unit"), place("lot")) else {
        let found = header.iter().collect::<Vec<_>>().join(", ");
        return Err(refused!("its columns")
            .at(&shown)
            .line(1)
            .found(found)
            .expected("`unit`, `lot` and perhaps `time`"));
    };
    let time = place("time");
    let mut known: BTreeMap<String, (Option<String>, Option<f64>)> = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(damaged)?;
        let line = record.position().map_or(0, csv::Position::line);
        let cell = |at: usize| record.get(at).filter(|text| !text.is_empty());
        let number = |text: &str| match text.parse::<f64>() {
            Ok(time) if time.is_finite() => Ok(time),
            _ => Err(refused!("")
                .at(&shown)
                .line(line)
                .column("time")
                .cell(text)
                .expected("a number, as of days")),
        };
        let time = time.and_then(cell).map(number).transpose()?;
        let name = cell(unit).unwrap_or_default().to_string();
        if known.insert(name.clone(), (cell(lot).map(str::to_string), time)).is_some() {
            return Err(refused!("unit `{}` stands there twice", text_safety::shown(&name))
                .at(&shown)
                .line(line));
        }
    }
    for unit in units {
        if let Some((lot, time)) = known.remove(&unit.name) {
            (unit.lot, unit.time) = (lot, time);
        }
    }
    Ok(())
}
