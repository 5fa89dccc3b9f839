//! Recordings as tables, and what can be wrong with them.

use std::sync::Arc;

use parquet::data_type::DoubleType;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

use super::draw::Draw;

/// Columns that some reader looks for.
const KNOWN: &str = "t_s pass direction x1_mm x2_mm measured reference reference_arcsec drive position run period \
    temperature_c command";

/// A recording: its header and its rows as text.
#[derive(Debug, Clone)]
pub struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// From CSV as the program writes it: commas, no quotes.
    pub fn parse(text: &[u8]) -> Table {
        let text = String::from_utf8_lossy(text);
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_string).collect::<Vec<_>>());
        Table { header: lines.next().unwrap_or_default(), rows: lines.collect() }
    }

    /// Damages it once.
    pub fn damage(&mut self, draw: &mut Draw) {
        let (columns, height) = (self.header.len(), self.rows.len());
        if columns == 0 || height == 0 {
            return;
        }
        let (column, row) = (draw.below(columns), draw.below(height));
        match draw.below(19) {
            0..=3 => self.set(row, column, draw.number()),
            4 => self.set(row, column, draw.text()),
            5 | 6 => {
                let factor = draw.factor();
                self.each(column, |_, value| (value * factor).to_string());
            }
            7 => {
                let constant = draw.number();
                self.each(column, |_, _| constant.clone());
            }
            8 => self.each(column, |_, value| format!("{}", value + f64::from(draw.byte()) * 1e-3)),
            9 => self.each(column, |row, value| if row % 3 == 0 { String::new() } else { value.to_string() }),
            10 => self.without(column),
            11 => self.extra(draw),
            12 => self.header[column] = draw.text(),
            13 => self.header[column] = draw.part(KNOWN, ' ').to_string(),
            14 => self.rows.truncate(row),
            15 => {
                let repeated = self.rows[row..].to_vec();
                (0..1 + draw.below(3)).for_each(|_| self.rows.extend(repeated.clone()));
            }
            16 => self.rows.rotate_left(row),
            17 => self.rows[row].truncate(column),
            _ => self.each(column, |at, value| if at < row { value } else { value + 1e17 }.to_string()),
        }
    }

    fn set(&mut self, row: usize, column: usize, cell: String) {
        if let Some(old) = self.rows[row].get_mut(column) {
            *old = cell;
        }
    }

    fn each(&mut self, column: usize, mut change: impl FnMut(usize, f64) -> String) {
        for (index, row) in self.rows.iter_mut().enumerate() {
            if let Some(cell) = row.get_mut(column) {
                *cell = change(index, cell.parse().unwrap_or(0.0));
            }
        }
    }

    fn without(&mut self, column: usize) {
        self.header.remove(column);
        self.rows.iter_mut().filter(|row| row.len() > column).for_each(|row| drop(row.remove(column)));
    }

    /// Further columns, copies of one of them: one of the same name, or up to 300 of other names.
    fn extra(&mut self, draw: &mut Draw) {
        let (from, count) = (draw.below(self.header.len()), *draw.pick(&[1, 1, 3, 30, 300]));
        for n in 0..count {
            let name = if count == 1 { self.header[from].clone() } else { format!("extra_{n}") };
            self.header.push(name);
            for row in &mut self.rows {
                let cell = row.get(from).cloned().unwrap_or_default();
                row.push(cell);
            }
        }
    }

    /// As CSV: commas, no quotes.
    pub fn plain(&self) -> Vec<u8> {
        let lines = std::iter::once(&self.header).chain(&self.rows).map(|row| row.join(",") + "\n");
        lines.collect::<String>().into()
    }

    /// As a file: CSV as instruments and spreadsheets write it.
    pub fn csv(&self, draw: &mut Draw) -> Vec<u8> {
        if !draw.one_in(4) {
            return self.plain();
        }
        let separator = *draw.pick(&[",", ",", ",", ";", "\t", "|", " "]);
        let end = *draw.pick(&["\n", "\n", "\n", "\r\n", "\r", "\n\n"]);
        let (comma, quoted) = (separator != "," && draw.one_in(2), draw.one_in(5));
        let mut text = String::new();
        for row in std::iter::once(&self.header).chain(&self.rows) {
            let cells: Vec<String> = row
                .iter()
                .map(|cell| if comma { cell.replace('.', ",") } else { cell.clone() })
                .map(|cell| if quoted || cell.contains('\n') { format!("\"{cell}\"") } else { cell })
                .collect();
            text += &cells.join(separator);
            text += end;
        }
        match draw.below(9) {
            0 => [b"\xef\xbb\xbf", text.as_bytes()].concat(),
            1 => text.encode_utf16().flat_map(u16::to_le_bytes).collect(),
            2 => text.chars().map(|c| u8::try_from(u32::from(c)).unwrap_or(b'?')).collect(),
            3 => text.trim_end().into(),
            _ => text.into(),
        }
    }

    /// As a file: Parquet, all columns as numbers; what is none is missing. `None` where Parquet cannot hold it.
    pub fn parquet(&self) -> Option<Vec<u8>> {
        let fields: String = self.header.iter().map(|name| format!("optional double {name};")).collect();
        let schema = Arc::new(parse_message_type(&format!("message recording {{ {fields} }}")).ok()?);
        let mut file = Vec::new();
        let mut writer = SerializedFileWriter::new(&mut file, schema, Arc::default()).ok()?;
        let mut group = writer.next_row_group().ok()?;
        for column in 0..self.header.len() {
            let cells: Vec<Option<f64>> =
                self.rows.iter().map(|row| row.get(column).and_then(|cell| cell.parse().ok())).collect();
            let known: Vec<f64> = cells.iter().flatten().copied().collect();
            let levels: Vec<i16> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
            let mut next = group.next_column().ok()??;
            next.typed::<DoubleType>().write_batch(&known, Some(&levels), None).ok()?;
            next.close().ok()?;
        }
        group.close().ok()?;
        writer.close().ok()?;
        Some(file)
    }
}
