//! Dynamic recordings as files: equidistant rows of drives and positions, in one run or several.

use std::io::{self, Write};
use std::path::Path;

use fitter::text_safety;

/// A dynamic recording.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// Time in seconds.
    pub t_s: Vec<f64>,
    /// Number of the run of every row, where there are several.
    pub run: Option<Vec<u32>>,
    /// Number of the period of every row, where the excitation is periodic and in its steady state.
    pub period: Option<Vec<u32>>,
    /// The drives.
    pub drives: Vec<Vec<f64>>,
    /// The positions; none where the file holds drives only.
    pub positions: Vec<Vec<f64>>,
}

/// Why a recording is refused.
#[derive(Debug, thiserror::Error)]
pub enum SeriesError {
    /// It cannot be read.
    #[error("{file}: cannot be read ({reason}); give a CSV, or CSV.gz, with the columns t_s and drive")]
    Unreadable {
        /// The file.
        file: String,
        /// What the system said.
        reason: String,
    },
    /// It is no CSV.
    #[error("{file}: {reason}; expected a CSV of as many fields in every row as in the header")]
    Form {
        /// The file.
        file: String,
        /// What is wrong.
        reason: String,
    },
    /// A column is missing.
    #[error(
        "{file}, line 1: there is no column `{column}`, found {found}; expected t_s and drive (or drive_1, drive_2, …)"
    )]
    Column {
        /// The file.
        file: String,
        /// The column.
        column: String,
        /// The columns that there are.
        found: String,
    },
    /// A field is no number.
    #[error("{file}, line {line}, column `{column}`: found `{found}`, expected a finite number; correct it")]
    Number {
        /// The file.
        file: String,
        /// The line, the header being line 1.
        line: usize,
        /// The column.
        column: String,
        /// What stands there.
        found: String,
    },
    /// Too few rows.
    #[error("{file}: has {rows} rows, expected two or more in every run; record longer")]
    Short {
        /// The file.
        file: String,
        /// How many.
        rows: usize,
    },
    /// The rows are not equidistant.
    #[error(
        "{file}, line {line}, column `t_s`: {found} s after the row before, expected {expected} s as in the \
         other rows; fill the gap or cut the recording there: nothing is resampled silently"
    )]
    Step {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// The step.
        found: f64,
        /// The step of the rest.
        expected: f64,
    },
}

impl Series {
    /// Reads the file at `path`, `.gz` as it is.
    ///
    /// # Errors
    /// [`SeriesError`].
    pub fn read(path: &Path) -> Result<Series, SeriesError> {
        let file = text_safety::path(path);
        let unreadable =
            |error: io::Error| SeriesError::Unreadable { file: file.clone(), reason: error.to_string() };
        Series::parse(&file, &fitter::input::unpacked(path).map_err(unreadable)?)
    }

    /// Parses the text of a recording; `file` is the name that stands in messages.
    ///
    /// # Errors
    /// As [`Series::read`].
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Series, SeriesError> {
        let form = |error: csv::Error| SeriesError::Form { file: file.to_owned(), reason: error.to_string() };
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
        let header: Vec<String> = reader.headers().map_err(form)?.iter().map(str::to_owned).collect();
        fitter::input::check_columns(header.len())
            .map_err(|limit| SeriesError::Form { file: file.to_owned(), reason: limit.to_string() })?;
        let at = |name: &str| header.iter().position(|column| column == name);
        let missing = |column: &str| SeriesError::Column {
            file: file.to_owned(),
            column: column.to_owned(),
            found: header.join(", "),
        };
        let family = |name: &str| -> Vec<usize> {
            match at(name) {
                Some(index) => vec![index],
                None => (1..).map_while(|number| at(&format!("{name}_{number}"))).collect(),
            }
        };
        let time = at("t_s").ok_or_else(|| missing("t_s"))?;
        let (drives, positions) = (family("drive"), family("position"));
        if drives.is_empty() {
            return Err(missing("drive"));
        }
        let mut series = Series {
            run: at("run").map(|_| Vec::new()),
            period: at("period").map(|_| Vec::new()),
            drives: vec![Vec::new(); drives.len()],
            positions: vec![Vec::new(); positions.len()],
            ..Series::default()
        };
        let (run, period) = (at("run"), at("period"));
        // The last printed digit of the time.
        let mut digits = 0;
        for (row, record) in reader.records().enumerate() {
            let record = record.map_err(form)?;
            let number = |column: usize| -> Result<f64, SeriesError> {
                let text = &record[column];
                match text.parse::<f64>() {
                    Ok(value) if value.is_finite() => Ok(value),
                    _ => Err(SeriesError::Number {
                        file: file.to_owned(),
                        line: row + 2,
                        column: header[column].clone(),
                        found: text.to_owned(),
                    }),
                }
            };
            digits = digits.max(record[time].split_once('.').map_or(0, |(_, decimals)| decimals.len()));
            series.t_s.push(number(time)?);
            for (column, values) in drives.iter().zip(&mut series.drives) {
                values.push(number(*column)?);
            }
            for (column, values) in positions.iter().zip(&mut series.positions) {
                values.push(number(*column)?);
            }
            for (column, values) in [(run, &mut series.run), (period, &mut series.period)] {
                if let (Some(column), Some(values)) = (column, values) {
                    values.push(number(column)? as u32);
                }
            }
        }
        series.check(file, 0.1f64.powi(digits.min(15) as i32))?;
        Ok(series)
    }

    /// Refuses rows that are not equidistant to within the rounding of the printed time.
    fn check(&self, file: &str, rounding_s: f64) -> Result<(), SeriesError> {
        let short = |rows: usize| SeriesError::Short { file: file.to_owned(), rows };
        if self.t_s.len() < 2 {
            return Err(short(self.t_s.len()));
        }
        for rows in self.runs() {
            if rows.len() < 2 {
                return Err(short(rows.len()));
            }
        }
        let expected = self.sample_s();
        for rows in self.runs() {
            let start_s = self.t_s[rows.start];
            for row in rows.start + 1..rows.end {
                let step = self.t_s[row] - self.t_s[row - 1];
                let due_s = start_s + (row - rows.start) as f64 * expected;
                // Either end of a step may be rounded; the sampling rate is known from all rows of the run.
                let slack_s = 1.01 * rounding_s + 1e-6 * expected;
                if (step - expected).abs() > slack_s && (self.t_s[row] - due_s).abs() > slack_s || step <= 0.0
                {
                    let file = file.to_owned();
                    return Err(SeriesError::Step { file, line: row + 2, found: step, expected });
                }
            }
        }
        Ok(())
    }

    /// The rows of each run.
    pub fn runs(&self) -> Vec<std::ops::Range<usize>> {
        let Some(run) = &self.run else { return std::iter::once(0..self.t_s.len()).collect() };
        let mut ranges = Vec::new();
        let mut start = 0;
        for row in 1..=run.len() {
            if row == run.len() || run[row] != run[start] {
                ranges.push(start..row);
                start = row;
            }
        }
        ranges
    }

    /// Rows of a period in the rows of a run, where the excitation is periodic.
    pub fn period_of(&self, rows: &std::ops::Range<usize>) -> Option<usize> {
        let period = self.period.as_ref()?;
        let first = *period.get(rows.start)?;
        Some(rows.clone().take_while(|row| period[*row] == first).count())
    }

    /// Time from row to row in seconds: the median of the runs' means, so that one gap does not hide in it.
    pub fn sample_s(&self) -> f64 {
        let mut steps: Vec<f64> =
            self.t_s.windows(2).map(|t| t[1] - t[0]).filter(|step| *step > 0.0).collect();
        steps.sort_by(f64::total_cmp);
        let median = steps.get(steps.len() / 2).copied().unwrap_or(1.0);
        // The printed column rounds every step; their mean, without gaps, does not.
        let near: Vec<f64> = steps.into_iter().filter(|step| (step / median - 1.0).abs() < 0.5).collect();
        near.iter().sum::<f64>() / near.len().max(1) as f64
    }

    /// Writes time, run, period, drives and positions as CSV with the given decimals of time, drive and
    /// position; none prints every digit that matters.
    ///
    /// # Errors
    /// What writing refuses.
    pub fn write_csv(&self, decimals: Option<[usize; 3]>, mut to: impl Write) -> io::Result<()> {
        let name = |stem: &str, count: usize, index: usize| {
            if count == 1 { stem.to_owned() } else { format!("{stem}_{}", index + 1) }
        };
        let mut header = vec!["t_s".to_owned()];
        header.extend(self.run.iter().map(|_| "run".to_owned()));
        header.extend(self.period.iter().map(|_| "period".to_owned()));
        header.extend((0..self.drives.len()).map(|i| name("drive", self.drives.len(), i)));
        header.extend((0..self.positions.len()).map(|i| name("position", self.positions.len(), i)));
        writeln!(to, "{}", header.join(","))?;
        let print = |value: f64, place: usize| match decimals {
            Some(decimals) => format!("{value:.*}", decimals[place]),
            None => format!("{value}"),
        };
        for row in 0..self.t_s.len() {
            write!(to, "{}", print(self.t_s[row], 0))?;
            for numbers in self.run.iter().chain(&self.period) {
                write!(to, ",{}", numbers[row])?;
            }
            for (place, columns) in [(1, &self.drives), (2, &self.positions)] {
                for column in columns {
                    write!(to, ",{}", print(column[row], place))?;
                }
            }
            writeln!(to)?;
        }
        to.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_periods_and_several_columns_are_read() {
        let text = "t_s,run,period,drive_1,drive_2,position\n0,1,1,1,2,3\n0.1,1,2,4,5,6\n0,2,1,7,8,9\n0.1,2,1,1,1,1\n";
        let series = Series::parse("r.csv", text.as_bytes()).unwrap();
        assert_eq!(series.runs(), [0..2, 2..4]);
        assert_eq!(series.drives[1], [2.0, 5.0, 8.0, 1.0]);
        assert_eq!(series.period_of(&(0..2)), Some(1));
        assert_eq!(series.period_of(&(2..4)), Some(2));
        let mut written = Vec::new();
        series.write_csv(None, &mut written).unwrap();
        assert_eq!(Series::parse("again", &written).unwrap(), series);
    }

    #[test]
    fn rounding_of_the_time_is_no_gap_but_a_gap_is() {
        // 610.35 Hz printed to 10 µs.
        let row = |k: i32, t: f64| format!("{t:.5},{k},0\n");
        let even: String = (0..500).map(|k| row(k, f64::from(k) / 610.35)).collect();
        let head = "t_s,drive,position\n";
        let series = Series::parse("r.csv", format!("{head}{even}").as_bytes()).unwrap();
        assert!((series.sample_s() * 610.35 - 1.0).abs() < 1e-4);
        let gap: String = (0..500).filter(|k| *k != 200).map(|k| row(k, f64::from(k) / 610.35)).collect();
        let error = Series::parse("r.csv", format!("{head}{gap}").as_bytes()).unwrap_err().to_string();
        assert!(error.contains("line 202"), "{error}");
        let wrong = Series::parse("r.csv", b"t_s,drive\n0,1\n1,x\n").unwrap_err().to_string();
        assert!(wrong.contains("line 3, column `drive`: found `x`"), "{wrong}");
        let missing = Series::parse("r.csv", b"t_s,input\n0,1\n1,2\n").unwrap_err().to_string();
        assert!(missing.contains("`drive`") && missing.contains("input"), "{missing}");
    }
}
