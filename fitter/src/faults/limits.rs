//! Every threshold of the search for cells that cannot be readings, with its reason.

/// Part of the rows that may be affected: a column with more is not a few wrong cells but a wrong column.
pub const MOST_AFFECTED: f64 = 0.1;
/// Fewest rows of which a scatter is known well enough to hold a single cell against it.
pub const FEWEST_ROWS: usize = 12;
/// Searches with the rows found before left out; each finds at least one cell more.
pub const ROUNDS: usize = 12;
/// Rows that are held against each other at once: beyond some ten thousand more of them say nothing new of a cell, and
/// memory goes with them.
pub const STRETCH: usize = 100_000;
/// Of the largest deviation: so large are those that are listed in one search. The images that one bad cell leaves in
/// the prediction of others reach half of it.
pub const TOGETHER: f64 = 0.7;

/// F of the three terms in which deviations go with a further column, from which on it is no chance: of some hundred rows a column of
/// noise reaches it in one of some hundred thousand recordings (F distribution).
pub const OF_A_COLUMN: f64 = 10.0;
/// Part of a deviation that the column may leave of it: by judgement. The terms are fitted to deviations that are cut at
/// [`OUTLIER`], and so say too little of the largest.
pub const UNEXPLAINED: f64 = 0.5;
/// Multiples of the scatter from which on a cell is listed. The scatter holds what the prediction from other
/// rows adds, about a tenth, so that normal noise reaches it in one of two million cells; a cell 8 times the column's own
/// noise off stays above it in 99 % of the cases.
pub const OUTLIER: f64 = 5.0;
/// Rows of a calibration in steps. A recording with more is a scan, in which a single row tells less and structure of the
/// sensor is as narrow as a few rows:
pub const USUAL_ROWS: f64 = 1000.0;
/// for every ten times as many, by this part more.
pub const PER_DECADE: f64 = 0.3;
/// Part of its deviation that a cell must keep against each of its neighbours, and against every other way of
/// predicting it: a bump two rows wide keeps half of its height beside its crest, one of a row and a half a third, a step all of it on one side.
pub const ALONE: f64 = 0.35;
/// Jumps of a column elsewhere, at least half as far as the step beside its first or last cell, from which on that step may be a jump
/// as well. A single wrong cell makes two. By judgement.
pub const JUMPS: usize = 3;
/// Below this many times the scatter nothing is looked at more closely.
pub const CLOSER_LOOK: f64 = 2.0;
/// Other rows among the forty around in time that may deviate by half as much as an outlier does. More are
/// a stretch that scatters more: vibration, or a mirror that has not settled.
pub const CROWD: usize = 2;
/// The same among the forty around in angle: what comes again at an angle is the sensor's.
pub const CROWD_AT_ANGLE: usize = 1;
/// That half.
pub const CROWD_SIZE: f64 = 0.5;
/// A cell is listed only where it exceeds this many times all but [`TAIL_PART`] of the rows: in a channel whose
/// deviations have a long tail an outlier is one that stands out from the tail.
pub const BEYOND_TAIL: f64 = 1.3;
/// Part of the rows that may be outliers themselves: an autocollimator in moving air has two in a hundred.
pub const TAIL_PART: f64 = 0.03;
/// Most cells of a column, row after row, that are single bad ones: of a hundredth of bad cells three follow each other
/// once in a million rows. At an end of the recording, where one side alone speaks, a bend of two rows is one.
pub const LONGEST_RUN: usize = 2;
/// The same at an end of the recording.
pub const LONGEST_RUN_AT_END: usize = 1;
/// Multiples of the usual largest jump of the angle from its neighbours in time from which on an angle is out of place.
/// Where positions come in no order every jump is large, and none is.
pub const OUT_OF_PLACE: f64 = 5.0;
/// Part of its deviation that a cell must keep against what the rows of one side alone say.
pub const BEND: f64 = 0.2;
/// One side is heard where its prediction is at most this many times as uncertain as usual from both: at an end of the
/// recording, and beyond a pause in which the channel wanders, it knows too little.
pub const SIDE: f64 = 3.0;
/// Ways of predicting a cell that are within this factor of the best are heard as witnesses; a worse one knows too
/// little to acquit.
pub const WITNESS: f64 = 1.5;
/// Rows before and after from which a cell is predicted; none leaves the smooth base alone.
pub const WINDOWS: [usize; 4] = [0, 2, 4, 8];
/// Rows of which it is learnt how far a trend wanders.
pub const TREND_ROWS: usize = 2000;
/// An interval this many times the usual one is a pause, which tells nothing of the clock.
pub const PAUSE: f64 = 3.0;
/// Rows beside a pause from which on one can be told from the others: three pauses have six.
pub const FEWEST_BESIDE_PAUSES: usize = 6;
/// Rows at the nearest angles from which a cell is predicted: as many as a calibration of eight passes and more has.
pub const AT_ANGLE: usize = 8;
/// Part of the usual step of the angle within which two rows are at the same angle.
pub const SAME_ANGLE: f64 = 0.25;
/// Rows this near in time are no independent witness for the same angle.
pub const NEAR_IN_TIME: usize = 3;
/// Rows over which the scatter is measured where it changes with time or angle.
pub const LOCAL_ROWS: usize = 40;
/// Turns of the movement from which on the scatter of the rows after them is known by itself.
pub const TURNS: usize = 4;
/// A scatter over forty rows is uncertain by an eighth; so much is taken off before it may exceed the common one.
pub const LOCAL_DISCOUNT: f64 = 0.8;
/// The smooth scatter over the angle is not believed to fall below this part of the common one.
pub const LEAST_LOCAL: f64 = 0.6;
/// The scatter is at least this part of the resolution of the column, so that one count is no outlier.
pub const OF_RESOLUTION: f64 = 0.5;
/// Least size of the scatter beside the column's values: below it, differences are rounding of binary numbers.
pub const ROUNDING: f64 = 1e-13;

/// Highest order of the smooth base over the angle, rows for each of its terms, and its order over time.
pub const BASE_ORDER: usize = 14;
/// Rows that each term of the base needs.
pub const ROWS_PER_TERM: usize = 6;
/// Order of the base over time: drift and warm-up.
pub const TIME_ORDER: usize = 3;

/// A value this many times the spread of the column (25 % to 75 %) away from its median cannot be a reading of the same
/// quantity, alone or not.
pub const ABSURD: f64 = 1e4;
/// A value that programs write for "no reading" is one where it lies outside all other values by this many times the
/// widest step between them: no further position of the same series.
pub const CODE_STEPS: f64 = 2.0;
/// It lies outside them by this part of their range as well: a dense scan may end at such a value.
pub const CODE_PART: f64 = 0.2;
/// A value outside all others by this many times their whole range cannot be a reading of the same series,
pub const LONE: f64 = 5.0;
/// where at most so many do: more are a place where the sensor was.
pub const LONE_ROWS: usize = 2;
/// What programs and converters write where there is no reading.
pub const CODES: [f64; 14] = [
    999.0,
    9999.0,
    99999.0,
    999_999.0,
    9_999_999.0,
    99_999_999.0,
    999_999_999.0,
    9999.99,
    999.99,
    999.9,
    32767.0,
    32768.0,
    65535.0,
    2_147_483_647.0,
];
/// Ten years in seconds: no recording has a pause of it.
pub const LONGEST_PAUSE_S: f64 = 3.2e8;
/// A first or last row this many times the duration of all others away is a wrong time, not a pause.
pub const LONE_END: f64 = 10.0;

/// Intervals that a time must lie from its place to be wrong where times run backward: rows that have changed places lie
/// one and a half away.
pub const BACKWARD: f64 = 2.5;
/// Part of the usual interval that a time must be off to be listed: less does no harm, and clocks tick.
pub const OF_INTERVAL: f64 = 0.6;
/// A pause this many times the usual interval is told.
pub const GAP: f64 = 20.0;
/// Rows in a row with one and the same reading while the reference moves from which on a channel counts as stuck.
pub const STUCK_ROWS: usize = 6;
/// Part of the rows at one extreme value from which on a channel counts as saturated.
pub const SATURATED: f64 = 0.02;
/// Rows in a row at it, which no turn of the movement has.
pub const CUT_OFF_ROWS: usize = 4;
/// Resolution in multiples of the scatter from which on it is told.
pub const COARSE: f64 = 2.0;

/// Of a motion: multiples of the scatter around it from which on a single position counts as wrong. A position that jumps
/// and is back at the next sample would need an acceleration that no other sample shows.
pub const SPIKE: f64 = 20.0;
/// Samples around from which that scatter is taken.
pub const AROUND: usize = 100;
/// How nearly the samples beside a spike must show its image, a cubic's weight of it, as a part of it.
pub const IMAGE: f64 = 0.25;
/// Spread of a column in multiples of that of its middle nine tenths beyond which a code is no reading.
pub const BEYOND: f64 = 50.0;
/// Part of a motion's read-out at one extreme from which on it counts as cut off.
pub const MOVING_CUT_OFF: f64 = 2e-3;
/// Rows in a row at one extreme that a moving mechanism does not show by chance.
pub const MOVING_CUT_OFF_ROWS: usize = 5;
