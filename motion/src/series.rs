//! Dynamic recordings as files: equidistant rows of drives and positions, in one run or several.

use std::io::{self, Write};
use std::ops::Range;
use std::path::Path;

use fitter::RecordingError;
use fitter::plant::PlantFile;
use fitter::table::{Cells, Header, Lines, Naming, Table, Use, Values, family};

/// A dynamic recording.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// Time in seconds.
    pub t_s: Values,
    /// Number of the run of every row, where there are several.
    pub run: Option<Vec<i64>>,
    /// Number of the period of every row, where the excitation is periodic and in its steady state.
    pub period: Option<Vec<i64>>,
    /// The drives.
    pub drives: Vec<Values>,
    /// The positions; none where the file holds drives only.
    pub positions: Vec<Values>,
    /// Further columns that hold a number in every row and whose names end in a unit.
    pub further: Vec<(String, Values)>,
    /// The first time as it stands in the file, where that holds points in time; times are seconds since it.
    pub started: Option<String>,
}

fitter::errors! {
    /// Why a recording is refused.
    #[derive(Debug)]
    pub enum SeriesError {
        Short { file: String, run: i64, found: usize, least: usize } =>
            at(file) says("run {run} has {found} rows") expected("{least} or more") mend("record longer");
        Step { file: String, line: u64, found: f64, expected: f64, what: &'static str } =>
            at(file) line(line) column("t_s") found("a step of {found} s")
            expected("{expected} s as between most rows: {what}")
            mend("record without gaps, or resample it yourself (a resampling is never silent)");
        TimeBackward { file: String, line: u64, found: f64, before: f64 } =>
            at(file) line(line) column("t_s") found("{found} s after {before} s")
            expected("times that increase within a run")
            mend("sort the rows, or number the runs in a column `run`");
    }
    from { Recording(RecordingError) }
}

/// Whether a column can be an input of a plant in equations by its own name.
fn is_further(name: &str) -> bool {
    physics::is_identifier(name) && name.contains('_')
}

impl Series {
    /// What drives a plant: the drives, and for inputs beyond them the columns of their names.
    pub fn inputs(&self, plant: &PlantFile) -> Vec<&Values> {
        let names = plant.equations.as_ref().map_or_else(Vec::new, |equations| equations.inputs.names());
        let of = |name: &&str| self.further.iter().find(|(own, _)| own == name).map(|(_, values)| values);
        self.drives.iter().chain(names.iter().skip(self.drives.len()).filter_map(of)).collect()
    }

    /// Reads the file at `path`, whose positions may be missing.
    ///
    /// # Errors
    /// [`SeriesError`].
    pub fn read(path: &Path) -> Result<Series, SeriesError> {
        Series::read_as(path, true)
    }

    /// The same of what may move by itself: its drives may be missing as well.
    ///
    /// # Errors
    /// [`SeriesError`].
    pub fn read_undriven(path: &Path) -> Result<Series, SeriesError> {
        Series::read_as(path, false)
    }

    fn read_as(path: &Path, drives: bool) -> Result<Series, SeriesError> {
        let uses = |header: &Header| Series::uses(header, [drives, false], &[]);
        Series::checked(Table::read(path, &Naming::default(), &uses, &mut |_| {})?)
    }

    /// Takes columns in memory for a recording, whose drives may be missing unless they are `driven`; `file` is as in
    /// [`Table::of_columns`].
    ///
    /// # Errors
    /// [`SeriesError`].
    pub fn of_columns(
        file: &str,
        columns: Vec<(String, Cells)>,
        driven: bool,
    ) -> Result<Series, SeriesError> {
        let uses = |header: &Header| Series::uses(header, [driven, false], &[]);
        Series::checked(Table::of_columns(file, columns, &Naming::default(), &uses)?)
    }

    fn checked(mut table: Table) -> Result<Series, SeriesError> {
        let series = Series::of(&mut table);
        series.step_s(&table.header.file, &table.lines, table.rounding, 2)?;
        Ok(series)
    }

    /// How the columns of a header are used; whether a drive and a position are needed is said. Columns that are named
    /// in `further` are read as well, where they are there.
    ///
    /// # Errors
    /// [`RecordingError::MissingColumns`].
    pub fn uses(
        header: &Header,
        [drives, positions]: [bool; 2],
        further: &[&str],
    ) -> Result<Vec<Use>, RecordingError> {
        let channels = ["drive", "position"].map(|stem| family(&header.names, stem));
        let absent = |k: usize, stem| channels[k].is_empty().then_some(stem);
        let needed =
            [Some("t_s"), absent(0, "drive").filter(|_| drives), absent(1, "position").filter(|_| positions)];
        header.require(&needed.into_iter().flatten().collect::<Vec<_>>())?;
        let used = |name: &String| match name.as_str() {
            "t_s" => Use::Printed,
            "run" | "period" => Use::Whole,
            name if further.contains(&name) => Use::Needed,
            _ if channels.iter().flatten().any(|channel| channel == name) => Use::Needed,
            name if is_further(name) => Use::Optional,
            _ => Use::Ignored,
        };
        Ok(header.names.iter().map(used).collect())
    }

    /// Takes its columns out of a table.
    pub fn of(table: &mut Table) -> Series {
        let mut whole = |name: &str| Some(table.take(name)?.iter().map(|number| *number as i64).collect());
        let (run, period) = (whole("run"), whole("period"));
        let [drives, positions] = ["drive", "position"].map(|stem| {
            let names = family(&table.header.names, stem);
            names.iter().filter_map(|name| table.take(name)).collect()
        });
        let t_s = table.take_time();
        let further = table.columns.iter().filter(|column| is_further(&column.name));
        let complete = further.filter(|column| column.values.iter().all(|value| value.is_finite()));
        let further = complete.map(|column| (column.name.clone(), column.values.clone())).collect();
        Series { t_s, run, period, drives, positions, further, started: table.started.clone() }
    }

    /// Time from row to row, as the longest run gives it, where all steps are equal to within the `rounding_s` of the
    /// printed times and every run has the `least` number of rows.
    ///
    /// # Errors
    /// [`SeriesError`] but for [`SeriesError::Recording`].
    pub fn step_s(
        &self,
        file: &str,
        lines: &Lines,
        rounding_s: f64,
        least: usize,
    ) -> Result<f64, SeriesError> {
        let (file, t_s, runs) = (file.to_string(), &self.t_s, self.runs());
        let steps = || runs.iter().flat_map(|run| run.start + 1..run.end).map(|k| (k, t_s[k] - t_s[k - 1]));
        if let Some((k, _)) = steps().find(|(_, step)| *step < -rounding_s) {
            let (line, found, before) = (lines.of(k), t_s[k], t_s[k - 1]);
            return Err(SeriesError::TimeBackward { file, line, found, before });
        }
        let mut sorted: Vec<f64> = steps().map(|(_, step)| step).collect();
        if sorted.is_empty() {
            return Err(SeriesError::Short { file, run: 0, found: t_s.len(), least });
        }
        let middle = sorted.len() / 2;
        let usual = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
        // Rounding of both times, and of the binary fractions.
        let slack = |k: usize| 1.01 * rounding_s + 1e-6 * usual.abs() + 4e-16 * t_s[k].abs();
        if let Some((k, found)) = steps().find(|(k, step)| (step - usual).abs() > slack(*k)) {
            let what = if found > 1.5 * usual { "rows are missing" } else { "the steps are unequal" };
            return Err(SeriesError::Step { file, line: lines.of(k), found, expected: usual, what });
        }
        if let Some(run) = runs.iter().find(|run| run.len() < least) {
            let number = self.run.as_ref().map_or(0, |numbers| numbers[run.start]);
            return Err(SeriesError::Short { file, run: number, found: run.len(), least });
        }
        // The mean over the longest run is free of the rounding of single steps.
        let longest = runs.iter().max_by_key(|run| run.len()).cloned().unwrap_or(0..t_s.len());
        Ok((t_s[longest.end - 1] - t_s[longest.start]) / (longest.len() - 1).max(1) as f64)
    }

    /// The rows of each run.
    pub fn runs(&self) -> Vec<Range<usize>> {
        let Some(run) = &self.run else { return std::iter::once(0..self.t_s.len()).collect() };
        let lengths = run.chunk_by(|a, b| a == b).map(<[i64]>::len);
        let mut start = 0;
        lengths
            .map(|length| {
                start += length;
                start - length..start
            })
            .collect()
    }

    /// Rows of a period in the rows of a run, where the excitation is periodic.
    pub fn period_of(&self, rows: &Range<usize>) -> Option<usize> {
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

    fn parse(file: &str, bytes: &[u8]) -> Result<Series, SeriesError> {
        let uses = |header: &Header| Series::uses(header, [true, false], &[]);
        Series::checked(Table::from_bytes(file, bytes, &Naming::default(), &uses)?)
    }

    #[test]
    fn runs_periods_and_several_columns_are_read() {
        let text = "t_s,run,period,drive_1,drive_2,position\n0,1,1,1,2,3\n0.1,1,2,4,5,6\n0,2,1,7,8,9\n0.1,2,1,1,1,1\n";
        let series = parse("r.csv", text.as_bytes()).unwrap();
        assert_eq!(series.runs(), [0..2, 2..4]);
        assert_eq!(series.drives[1][..], [2.0, 5.0, 8.0, 1.0]);
        assert_eq!(series.period_of(&(0..2)), Some(1));
        assert_eq!(series.period_of(&(2..4)), Some(2));
        let mut written = Vec::new();
        series.write_csv(None, &mut written).unwrap();
        assert_eq!(parse("again", &written).unwrap(), series);
    }

    #[test]
    fn timestamps_and_counts_are_seconds_since_the_first_rounded_as_they_are_printed() {
        let head = "t_s,drive\n";
        for rows in [
            "2026-11-24T12:00:59.90Z,1\n2026-11-24T12:01:00.00Z,1\n2026-11-24T12:01:00.11Z,1\n",
            "1795521659900,1\n1795521660000,1\n1795521660109,1\n",
        ] {
            // The steps differ by some ten milliseconds: no more than the rounding of hundredths, but more than that of
            // thousandths.
            let hundredths = rows.contains('Z');
            let read = parse("r.csv", format!("{head}{rows}").as_bytes());
            assert_eq!(read.is_ok(), hundredths, "{read:?}");
            let Ok(read) = read else { continue };
            // Since the whole second of the first.
            let wanted = [0.9, 1.0, 1.11];
            assert!(
                read.t_s.iter().zip(wanted).all(|(t, wanted)| (t - wanted).abs() < 1e-9),
                "{:?}",
                read.t_s
            );
        }
        let mixed = parse("r.csv", b"t_s,drive\n2026-11-24T12:00:59Z,1\n60,1\n").unwrap_err().to_string();
        assert!(mixed.contains("line 3, column `t_s`: found `60`"), "{mixed}");
    }

    #[test]
    fn rounding_of_the_time_is_no_gap_but_a_gap_is() {
        // 610.35 Hz printed to 10 µs.
        let row = |k: i32, t: f64| format!("{t:.5},{k},0\n");
        let even: String = (0..500).map(|k| row(k, f64::from(k) / 610.35)).collect();
        let head = "t_s,drive,position\n";
        let series = parse("r.csv", format!("{head}{even}").as_bytes()).unwrap();
        assert!((series.sample_s() * 610.35 - 1.0).abs() < 1e-4);
        let gap: String = (0..500).filter(|k| *k != 200).map(|k| row(k, f64::from(k) / 610.35)).collect();
        let error = parse("r.csv", format!("{head}{gap}").as_bytes()).unwrap_err().to_string();
        assert!(error.contains("line 202"), "{error}");
        let wrong = parse("r.csv", b"t_s,drive\n0,1\n1,x\n").unwrap_err().to_string();
        assert!(wrong.contains("line 3, column `drive`: found `x`"), "{wrong}");
        let missing = parse("r.csv", b"t_s,input\n0,1\n1,2\n").unwrap_err().to_string();
        assert!(missing.contains("`drive`") && missing.contains("input"), "{missing}");
    }
}
