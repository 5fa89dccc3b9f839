//! Why a recording, or what was given with it, cannot be diagnosed.

use fitter::limits::LARGEST;
use fitter::message::FileLine;
use fitter::table::Place;
use fitter::{FitError, RecordingError};
use motion::equations::EquationsError;
use motion::series::SeriesError;

fitter::errors! {
    /// See the module.
    #[derive(Debug)]
    #[non_exhaustive]
    pub enum DiagnosisError {
        Kind { file: String, found: &'static str, expected: &'static str } =>
            at(file) says("the recording holds {found}, but the mirror file describes {expected}")
            mend("give the mirror file that belongs to it");
        NoReference { file: String, expected: &'static str } =>
            at(file) says("no reference column") expected("{expected}")
            mend("without a reference there is no error to diagnose");
        TooShort { file: String, rows: usize, needed: usize } =>
            at(file) says("{rows} readings")
            expected("at least {needed}: too short to hold anything against the noise")
            mend("record more passes");
        NoCommonRange { file: String, found: String, expected: String } =>
            at(file) says("its range has too little in common with the earlier recording's") found("{found}")
            expected("{expected}") mend("record both over the same range");
        NoModel { file: String, reason: String } =>
            at(file) says("no model can be made of it ({reason})")
            mend("check the readings against the reference");
        NoTurn { file: String } =>
            at(file) says("harmonics of the turn need a sensor that turns") found("none")
            mend("state `revolution` in the mirror file, or state an order") by(turn_harmonics) by(order);
        Column { at: FileLine, column: String, found: String } =>
            at(at) says("column `{column}` is missing") found("{found}") mend("add it");
        Cell { place: Place, found: f64 } =>
            at(place) cell("{found}") expected("a number from -{LARGEST:e} to {LARGEST:e}")
            mend("correct the cell");
        Rows { file: String, found: String, expected: String } =>
            at(file) found("{found}") expected("{expected}")
            mend("simulate exactly the rows of the recording");
        ConstantDrive { file: String, column: String, value: f64 } =>
            at(file) column(column) found("the constant {value}") expected("a drive that moves the mechanism")
            mend("excite it (multisine, sweep, steps) and record again");
        ConstantPosition { file: String, column: String, value: f64 } =>
            at(file) column(column) found("the constant {value}")
            expected("a position that follows the drive") mend("check the sensor");
        Saturated { file: String, line: u64, column: String, end: &'static str, value: f64, rows: usize } =>
            at(file) line(line) column(column)
            says("the reading stands at its {end} {value} for {rows} rows in all and is cut off there")
            expected("a read-out within its range") mend("reduce the drive or extend the range");
        RunLength { file: String, run: i64, found: usize, first: i64, expected: usize } =>
            at(file) says("run {run} has {found} rows") expected("{expected} as run {first}")
            mend("cut the runs to the same length, or diagnose them apart");
        Channels { file: String, found: usize, positions: usize } =>
            at(file) found("{found} drives and {positions} positions")
            expected("one of each for kind = \"second-order\"")
            mend("use kind = \"linear\" for several, or give one axis at a time");
        Rate { file: String, found: f64, expected: f64, recording: String } =>
            at(file) says("is sampled every {found} s") expected("{expected} s as the recording {recording}")
            mend("resample it yourself or give a held-out recording of the same rate");
        OtherChannels { file: String, found: String, expected: String, recording: String } =>
            at(file) says("has {found}") expected("{expected} as the recording {recording}")
            mend("give one of the same device");
        Feedback { at: FileLine, column: String, found: String } =>
            at(at) says("the column `{column}`, which `feedback` in the plant names, is missing")
            found("{found}") mend("add it, or drop `feedback` if the drive was not under feedback");
        NoPlant { file: String, percent: f64 } =>
            at(file)
            says("no second-order plant follows this drive (the best leaves {percent:.0} % of the position's \
                variance)")
            mend("check that `drive` and `position` belong together, or use kind = \"linear\"");
        Effect { file: String, id: String, reason: String } => at(file) says("effect `{id}`: {reason}");
        Inputs { file: String, wanted: usize, found: usize, positions: usize } =>
            at(file) found("{found} drives and {positions} positions")
            expected("one position and as many drives as the plant has inputs ({wanted})")
            mend("give a recording of this plant, or correct its `inputs`");
        NoEquations { file: String, percent: f64 } =>
            at(file)
            says("the equations follow this recording with no parameters in their ranges (the best leave {percent:.0} % \
                of the position's variance)")
            mend("check signs, units and ranges, and that no root or logarithm is taken of what can be negative");
        OwnSimulation { file: String } =>
            at(file) says("a simulation of your own does not stand beside a plant in equations")
            mend("state that simulation as the equations");
    }
    from { Equations(EquationsError), Recording(RecordingError), Series(SeriesError), Fit(FitError) }
}
