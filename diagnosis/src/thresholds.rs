//! Every number that was chosen: its value, what it means, and the trial, false-alarm rate or judgement that set it. Those
//! of one module stand under its name, those of several at the beginning.

pub use fitter::figures::NORMAL_95;

/// How many times what the base alone leaves a model with effects may leave, on fitted and on held-out rows: the spread of
/// an rms over a thousand readings, and what parameters without use cost.
pub const NO_WORSE: f64 = 1.02;
/// How many times the noise floor may be left of held-out rows where everything is said to be explained: beside some
/// hundred readings the base's own uncertainty takes up to a tenth, its order the rest.
pub const AT_FLOOR: f64 = 1.3;

/// See [`crate::ambiguity`].
pub mod ambiguity {
    /// Part of a column's square that others may leave for it to be a sum of them: rounding.
    pub const CONTAINED: f64 = 1e-9;
    /// Part of what an effect adds by which another may depart from it in another recording: less is the difference of a lag
    /// or of a slight bend. By judgement.
    pub const DISAGREES: f64 = 0.5;
    /// Parts of the recording by which the columns come later: powers of the golden section, next to no ratio of a few
    /// passes, so that what runs with the passes meets other angles in one of them.
    pub const SHIFTS: [f64; 3] = [0.236, 0.382, 0.618];
}

/// See [`crate::alone`].
pub mod alone {
    /// How much more correlated noise may be about a named effect than about the saturated model where the effect stands
    /// alone. Of 37 made recordings that a single name explains (`trials beyond`, seeds 482978382 and 345716660) forms take its
    /// place in four: in two of them, a lag and a loop that stand for other physics, the noise is more correlated by 0.49, in
    /// one by 0.06, in one, a loop, by 0.00. Of 46 that have the effect itself it is by less than 0.01 in 45.
    pub const MORE_CORRELATED: f64 = 0.03;
}

/// See [`crate::attempt`].
pub mod attempt {
    /// Part of what one explanation leaves of held-out readings that another must leave at most to be preferred.
    pub const CLEARLY: f64 = 0.9;
}

/// See [`crate::averaging`].
pub mod averaging {
    /// Odds before the recording that a given effect which is easily confused with a named one is there too.
    pub const ODDS: f64 = 0.3;
    /// Weight beside the model itself below which another is left out.
    pub const LEAST: f64 = 0.02;
    /// Part of a column's length that must be left beside the model for it to be another explanation.
    pub const OWN: f64 = 1e-3;
}

/// See [`crate::calibrate`].
pub mod calibrate {
    /// Length of an effect beside the base, in standard deviations, of which half are found: by the static trials.
    pub const HALF_SEEN: f64 = 4.5;
    /// False alarms allowed over the whole search.
    pub const FALSE_ALARMS: f64 = 0.004;
    /// Resamples for the families' tails, and as many again for the best family over all: a tail fitted to the
    /// resamples that it is then applied to would look better than it is.
    pub const RESAMPLES: usize = 360;
    /// Resamples that are drawn from one stream of random numbers and projected together.
    pub const TOGETHER: usize = 90;
    /// Ranks of candidates, 0 among them, of which only the largest statistic needs its tail.
    pub const MOST_RANKS: usize = 8;
    /// Part of the resamples that the tails are fitted to.
    pub const TAIL: f64 = 0.2;
    /// Ranges of the angle from which residuals are drawn, as parts of the rows.
    pub const NEIGHBOURHOODS: usize = 8;
    /// Weight of the prior that a family's tail falls as a χ² tail does, in resamples.
    pub const PRIOR_TAIL: f64 = 150.0;
    /// How much more a resample may have of what is new in each reading than the recording has, as a ratio of variances.
    /// A shorter memory at the same level would have more of it than the recording can hide.
    pub const MOST_NEW: f64 = 1.25;
    /// How much less of the allowed false alarms a generic family gets than a catalogued one.
    pub const GENERIC_SHARE: f64 = 0.04;
    /// Highest rank that is tabulated.
    pub const TABLE_RANK: usize = 7;
    /// Entries per unit of s in the table, and the s up to which it goes.
    pub const TABLE_DENSITY: f64 = 4.0;
    pub const TABLE_END: f64 = 120.0;
}

/// See [`crate::compare`].
pub mod compare {
    /// Family-wise false alarms over all that could have changed. Each recording's own search may bring what is not there
    /// as well, at 4 of 1000: with both, fewer than 1 of 100 pairs with nothing changed may alarm.
    pub const FALSE_ALARMS: f64 = 0.001;
    /// −ln p by which another part may fall behind and is an alternative: a factor of 20. Of two models, half of the difference of
    /// Akaike's criterion.
    pub const ALTERNATIVE: f64 = 3.0;
    /// Most parts that differ. By judgement: more is another device.
    pub const MOST_CHANGES: usize = 8;
    /// Effects that are fitted in the place of what came, went or has no name: those that explain most before their shape is
    /// fitted. By judgement.
    pub const CANDIDATES: usize = 3;
    /// Effects of each recording in motion that are tried as what came or went. By judgement.
    pub const CANDIDATES_IN_MOTION: usize = 4;
    /// What the start of such an effect must promise, in −2 log likelihood. By judgement: a light resonance lies between two starts
    /// and promises next to nothing. Of three weak flexible modes that were taken for inertia two are named with it, none without;
    /// starts were half as dense then.
    pub const LEAST_PROMISE_IN_MOTION: f64 = 0.9;
    /// By how much Akaike's criterion must fall for an effect that came or went in motion where nothing else differs. By
    /// judgement: half of what an effect of ρ 8 explains. With it none of 32 unchanged pairs alarms, and one more of 24 effects
    /// that came is found.
    pub const NOTHING_ELSE_DIFFERS: f64 = 30.0;
    /// A model of two recordings in motion, see [`crate::dynamic::joint`].
    pub mod joint {
        /// Most steps of its estimate. By judgement: what has not settled by then is taken as it is.
        pub const PATIENCE: usize = 25;
        /// Fall of −2 log likelihood, promised or seen, below which it is at its end: nothing beside the differences that are
        /// tested.
        pub const ENOUGH: f64 = 0.01;
        /// Steps in which a structure's model is fitted to the other recording. By judgement.
        pub const STEPS: usize = 20;
        /// Part by which such a step must reduce what is left. By judgement.
        pub const DECREASE: f64 = 1e-4;
        /// Step of a difference quotient by a shape under feedback, as a part of it or of the width of a place. By judgement.
        pub const SHAPE_STEP: f64 = 0.05;
        /// Part of itself from which on the error of a shape says that a recording does not determine it. By judgement: beyond it
        /// the first order does not hold.
        pub const UNDETERMINED: f64 = 0.5;
        /// Most Gauss–Newton steps of the shapes in their own recording. By judgement: a step is at most a factor of two.
        pub const POLISHING: usize = 5;
        /// Factor by which a shape may differ from where it was found. By judgement: beyond it the first order does not hold.
        pub const FAR: f64 = 2.0;
        /// By how much a limit is raised that a recording does not show: beyond every drive.
        pub const BEYOND: f64 = 1e3;
    }

    /// Standard deviations beyond a threshold at which 95 of 100 are found.
    pub const POWER: f64 = 1.645;
    /// p-value below which a recording has an effect that its own search did not name.
    pub const PRESENT: f64 = 0.01;
    /// Part of the shorter stroke that both recordings must cover. By judgement.
    pub const LEAST_COMMON: f64 = 0.5;
    /// The time between the recordings, in multiples of the longer one: every memory has faded after it.
    pub const PAUSE: f64 = 100.0;
    /// Part of an effect that other recordings are expected to have below which it counts as what happened at one time, where
    /// one recording alone shows it: it is likelier that than the effect. Without it one of 240 pairs with nothing changed
    /// alarmed.
    pub const MAY_BE_AN_EVENT: f64 = 0.5;
    /// Part of a motion by which another one may differ, and of its rows by which it may be longer, for both to be the same. By
    /// judgement: of a real drive two recordings of one command differ by 0.001, two halves of one recording by 0.06.
    pub const SAME_MOTION: f64 = 0.1;
    /// Part of the square of columns that others may leave for both to say the same.
    pub const SAME: f64 = 0.7;
    /// Part of the square of a form beyond the base that a catalogued effect may leave for the form to be nearly that effect.
    /// By judgement: a tenth of its size. Of 240 pairs with a change, 4 more are rightly named with it.
    pub const NEARLY: f64 = 0.01;
    /// Part of the square of a column that the base may leave of what is the base's: an angle is not quite a polynomial of
    /// the reading. That a difference is judged beside it found 3 more of 240 pairs with a change, without an alarm in 240
    /// with none.
    pub const OF_THE_BASE: f64 = 1e-3;
    /// Step of a difference quotient by a shape, as a part of it or of its range.
    pub const SHAPE_STEP: f64 = 0.01;
    /// Gauss–Newton steps of the shapes, and halvings of each.
    pub const TURNS: usize = 4;
    pub const HALVINGS: i32 = 4;
    /// Rounds in which the zero of the later recording's reference is found.
    pub const ZEROS: usize = 2;
}

/// See [`crate::compose`].
pub mod compose {
    /// Most columns of which forms are made, the strongest: by judgement, so that a search stays below a second.
    pub const MOST_COLUMNS: usize = 5;
    /// What a form without a name must explain beyond a named effect to be preferred. Set on 84 made recordings with
    /// physics of 21 kinds: with 10 a curve or an event takes the place of a form that describes all of it; the trials of
    /// the catalogue are the same with either.
    pub const HANDICAP: f64 = 2.0;
    /// The same for every factor beyond the first, as for the columns of a curve.
    pub const HANDICAP_PER_FACTOR: f64 = 1.5;
    /// What a curve over time must explain beyond forms to be preferred, apart from what it must beyond named effects: it
    /// follows whatever goes slowly, and can be handed to nobody. With 10, a drift with temperature beside one with time
    /// takes the place of creep that heat hastens, and of 136 made recordings five are made worse where 3 makes four.
    pub const CURVE: f64 = 3.0;
    /// What a set of terms with forms must explain beyond the named effects that explain a recording alone: odds of a
    /// hundred and fifty, by judgement. With nothing asked of fewer terms, a thermostat takes the place of the steps of a reference
    /// that switches by itself.
    pub const CLEARLY: f64 = 10.0;
    /// How many times what is left of fitted readings a set of terms with curves may leave of held-out ones. Of 152 answers with
    /// a curve that helped (`trials beyond`, seed 569402721 by two versions without forms, 798072585 with them) 19 of 20 are
    /// below 1.27. Between 1.15 and 1.25 lie eight that realise three quarters of the gain or more (seed 102947617, without
    /// forms), and two that make a fresh recording worse (seed 798072585). Above 1.25 a response to the time before was
    /// fitted to 102 rows, and made one worse by 1.5 times what could be gained.
    pub const OVERFITTED: f64 = 1.25;
}

/// See [`crate::condense`].
pub mod condense {
    /// Rows above which a recording is condensed, and about how many cells are made of it.
    pub const MOST_ROWS: usize = 1100;
    /// Rows up to which a recording is searched row by row where blocks of successive rows would be too coarse.
    pub const MOST_ROWS_APART: usize = 2500;
    /// Fewest ranges of the angle in a pass.
    pub const FEWEST_RANGES: usize = 72;
    /// Fewest groups of passes for which twice as many passes make a group, by judgement: what changes in time is followed
    /// in so many steps.
    pub const FEWEST_GROUPS: usize = 15;
    /// Part of the stroke over which a block of successive rows may move, at most: as coarse as a calibration in steps.
    pub const COARSEST_BLOCK: f64 = 1.0 / 40.0;
}

/// See [`crate::content`].
pub mod content {
    /// −ln of the probability at which one of the six tests says that there is something: one in a thousand.
    pub const SURE: f64 = 6.9;
    /// Blocks of neighbouring rows whose means are compared.
    pub const BLOCKS: [usize; 5] = [2, 4, 8, 16, 32];
    /// Order of the curve over the scaled angle.
    pub const ORDER: usize = 3;
}

/// See [`crate::correlation`].
pub mod correlation {
    /// Prior probability that readings are uncorrelated.
    pub const PRIOR_UNCORRELATED: f64 = 0.5;
    /// Shortest correlation time that is searched, in typical gaps between rows.
    pub const SHORTEST: f64 = 0.3;
    /// Points of the grid of correlation times; every so many of them are tried first.
    pub const POINTS: usize = 41;
    pub const COARSE: usize = 5;
    /// Points of the grid of correlation times of a part beside white readings.
    pub const POINTS_BESIDE_WHITE: usize = 16;
    /// Parts of the variance that are tried for what lasts beside white readings, in equal steps of the logarithm of its
    /// ratio to theirs.
    pub const PARTS_OF_VARIANCE: [f64; 5] = [0.06, 0.2, 0.5, 0.8, 0.95];
    /// Parts for every decade of time constants in flicker: its spectrum follows 1/f to a twentieth.
    pub const FLICKER_PER_DECADE: f64 = 1.5;
    /// Correlation of neighbouring readings up to which they count as uncorrelated.
    pub const UNCORRELATED: f64 = 1e-4;
    /// Log likelihood below the best of the coarse grid at which a neighbourhood is not looked into.
    pub const HOPELESS: f64 = 12.0;
    /// Part of the posterior below which a process is left out.
    pub const NEGLIGIBLE: f64 = 1e-4;

    /// See [`crate::correlation::mistaken`].
    pub mod mistaken {
        /// Gain in −2 log likelihood, correlation times searched on either side, at which structure is believed: one
        /// column among some hundred by chance once in some thousand recordings.
        pub const SLOW_GAIN: f64 = 18.0;
        /// The same for every further column of a group.
        pub const SLOW_GAIN_PER_COLUMN: f64 = 3.0;
        /// Number of columns up to which that is enough. Where noise is correlated, a step at any row is a test of that row's
        /// reading alone, so that there are as many independent ones as rows.
        pub const FEW_COLUMNS: f64 = 50.0;
        /// Gain in −2 log likelihood of the best correlation over none, from which on something can have been taken for
        /// correlation: by chance in one recording of forty.
        pub const CORRELATION_SEEN: f64 = 4.0;
        /// Part of the best gain that a group of fewer columns must reach to be taken instead.
        pub const NEARLY: f64 = 0.6;
        /// The first row at which a step may begin: with fewer before it nothing tells it from the first readings.
        pub const FIRST_STEP: usize = 2;
        /// Most groups that are taken out.
        pub const MOST_TAKEN: usize = 3;
    }
}

/// See [`crate::dictionary`].
pub mod dictionary {
    /// Orders up to which the base polynomial may be raised beyond the one absorbed from the start.
    pub const HIGHEST_ORDER: usize = 13;
    /// The same of a single move.
    pub const HIGHEST_OF_A_MOVE: usize = 9;
    /// Part of a column's length that must be left outside the model for it to be a candidate at all: what is
    /// left of a smooth curve after a polynomial is mostly the noise of its argument.
    pub const SMALLEST_PART: f64 = 0.02;
    /// The same for a measured column. Probes that differ in gain put nearly all of the stroke into their common
    /// mode: a hundredth of it that the base leaves is still many times its reading noise. A column of which the
    /// reading noise alone is left is no more than any other column of noise; below this it is rounding.
    pub const SMALLEST_PART_MEASURED: f64 = 1e-5;
    /// The same for a form of what happened once, by judgement: what comes back in every pass, such as a wave of half a pass, is
    /// of the angle, and spoils the base where it is taken for time.
    pub const SMALLEST_PART_OF_ONE_TIME: f64 = 0.3;
    /// Candidates that are projected together.
    pub const TOGETHER: usize = 128;
}

/// See [`crate::dynamic`].
pub mod dynamic {

    /// See [`crate::dynamic::accurate`].
    pub mod accurate {
        /// Change by twice as many steps, over the recorded output (both as root mean square), that is none: a tenth of the
        /// error of a good converter.
        pub const ACCURATE: f64 = 1e-5;
        /// The same over what a model leaves of the recording: it adds a ten-thousandth to its square, and to −2 log likelihood one
        /// for ten thousand rows. Before it held for a second-order plant, 2 of 40 unchanged pairs alarmed, one of them by this error.
        pub const BESIDE: f64 = 0.01;
    }

    /// See [`crate::dynamic::data`].
    pub mod data {
        /// Blocks into which the rows of all runs are divided; every second one fits, the others choose and score
        /// in turn, so that every kind sees the whole of the excitation.
        pub const BLOCKS: usize = 64;
        /// A position beyond so many times the recorded range is an unstable simulation.
        pub const BOUND: f64 = 30.0;
        /// Most windows into which a long recording is divided for the search.
        pub const WINDOWS: usize = 12;
        /// Most rows before a run through which states are brought that are not recorded.
        pub const MOST_LEAD: usize = 4096;
        /// Least rows of a window.
        pub const LEAST_WINDOW: usize = 400;
        /// Periods of the slowest swing that a run shows. By judgement.
        pub const PERIODS: f64 = 8.0;
        /// Blocks of a window: as many kinds of rows in each as can be.
        pub const BLOCKS_OF_WINDOW: usize = 8;
    }

    /// See [`crate::dynamic::diagnose`].
    pub mod diagnose {
        /// Steps of the integrator that a simulation of the search may take: enough to tell effects apart, few
        /// enough that a hundred thousand rows are diagnosed in seconds.
        pub const SEARCH_STEPS: usize = 33_000;
        /// −2 log likelihood that an effect moves the rows that score by, from which on they tell whether it does them good: a
        /// quarter of what the search asks for, as on the rows that choose.
        pub const MOVED: f64 = 7.5;
        /// Rows from which the nominal plant is identified at first.
        pub const START_ROWS: usize = 16_384;
    }

    /// See [`crate::dynamic::effects`].
    pub mod effects {
        /// Most states that an effect adds to position and velocity.
        pub const MOST_STATES: usize = 2;

        /// See [`crate::dynamic::effects`], dry friction.
        pub mod friction {
            /// Exponent of Armstrong-Hélouvry's law of Stribeck's friction, the usual one.
            pub const GAUSSIAN: f64 = 2.0;
            /// That of Tustin's.
            pub const EXPONENTIAL: f64 = 1.0;
            /// Places along the stroke at which a search starts: half a width of the narrower ones apart.
            pub const PLACES: usize = 40;
            /// Widths at which it starts, as parts of half the stroke.
            pub const WIDTHS: [f64; 2] = [0.05, 0.15];
            /// Narrowest place, likewise. By judgement: a narrower one is met in few rows.
            pub const NARROWEST: f64 = 0.01;
            /// Widest place, likewise. By judgement: a wider one is friction that depends on the position.
            pub const WIDEST: f64 = 0.4;
            /// Plays at which a search starts, likewise.
            pub const PLAYS: [f64; 8] = [5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 0.016, 0.032, 0.064];
            /// Widest play, likewise. By judgement: beyond it the load hardly moves.
            pub const WIDEST_PLAY: f64 = 0.2;
        }
        /// Creep that is none, as a part of the recorded speed.
        pub const HARD: f64 = 1e-9;

        /// See [`crate::dynamic::effects::bouc_wen_hysteresis`].
        pub mod bouc_wen_hysteresis {
            /// β and n where `plant.toml` does not give them, and as the search has them.
            pub const USUAL: [f64; 2] = [0.5, 1.0];
        }

        /// See [`crate::dynamic::effects::flexible_mode`].
        pub mod flexible_mode {
            /// Frequencies from which a search starts, per factor e: so close that one of 2 % damping explains, to first order, three
            /// tenths of a resonance of 1 % half-way between two of them. Of five modes that came between two recordings all are
            /// named; with half as many, from half the rate of the motion on, two.
            pub const STARTS_PER_E_FOLD: f64 = 12.0;
        }
    }

    /// See [`crate::dynamic::equations`].
    pub mod equations {
        /// Ratio of the ends of a range from which on it is covered, and estimated, by its logarithm.
        pub const LOGARITHMIC: f64 = 10.0;
        /// Starts that are tried over the ranges of the parameters: by judgement, two to four per direction of five.
        pub const POINTS: usize = 128;
        /// Starts that are followed.
        pub const FOLLOWED: usize = 8;
        /// Factor of the squared residual within which other parameters do as well.
        pub const AS_WELL: f64 = 1.01;
        /// Relative difference of a parameter from which on two estimates are two: far above what an estimate stops at.
        pub const APART: f64 = 0.05;
        /// Part of what the output is off by that an observer corrects at every row while the starts are tried: with half,
        /// all 64 starts of two tanks that overflow led to one estimate, of free runs two in a hundred.
        pub const OBSERVED: f64 = 0.5;
        /// Part of the motion, as root mean square, that a free run may leave and needs no observer beside it. In 25 searches
        /// of 17 made recordings that left 0.4 to 6 % an observer led to no better effect, and took more than half of the
        /// time; in two of four searches of real ones that left 24 to 64 % it did.
        pub const IN_STEP: f64 = 0.1;
        /// Factor by which the observer is made weaker from one estimate to the next.
        pub const WEAKER: f64 = 4.0;
        /// Most steps of an estimate from one of the starts.
        pub const STEPS: usize = 12;
        /// Rows on which the starts are tried.
        pub const FIRST_ROWS: usize = 1024;
        /// Rows of every run among them at least.
        pub const LEAST_FIRST: usize = 64;
        /// Rows in which effects are sought, in windows, where the recording is too long to be searched whole: over longer
        /// windows an oscillator runs out of step while an effect is missing; of a Duffing oscillator 4000 rows gave all four
        /// effects, 11 000 two, 33 000 none of them.
        pub const SEARCH_ROWS: usize = 4_000;
        /// Chance that a random residual of the same spectrum would lose as much to the best of all effects: one recording
        /// in a thousand.
        pub const BY_CHANCE: f64 = 1e-3;
        /// Simpler effects beside which a second one is sought, where a richer one is the best.
        pub const SIMPLER: usize = 2;
        /// Steps in which the factors of a new effect that has other parameters too are estimated alone: they are linear in what
        /// it adds. Without them stops on both sides were described by four forms in place of one, in one recording of one.
        pub const FACTORS_FIRST: usize = 2;
        /// Effects beside which a second one is sought, where none is worth its parameters alone: by judgement, so that a
        /// search that ends in structure takes twice as long at most.
        pub const PAIRED: usize = 2;
        /// Starts of a parameter with a range beside an effect.
        pub const STARTS: usize = 5;
        /// Range of a parameter of an effect that a second-order plant gives, over its value and under it: by judgement.
        pub const GIVEN_RANGE: f64 = 100.0;
        /// Most starts of one effect: two parameters with a range have their own each, more share them.
        pub const MOST_STARTS: usize = 25;
        /// Time constant of an overflow, in samples: by judgement, so short that what is above the rim is a small part of
        /// what flows in between two samples, and so long that two or three steps from row to row follow it.
        pub const MOMENT: f64 = 0.25;
        /// Parts of the stroke for each of which a form that holds in one place is tried: by judgement.
        pub const PLACES: usize = 8;
    }

    /// See [`crate::dynamic::estimate`].
    pub mod estimate {
        /// Most steps of an estimate.
        pub const PATIENCE: usize = 40;
        /// A promised decrease below this part of the mean square changes no likelihood that anyone reads.
        pub const ENOUGH: f64 = 0.02;
    }

    /// See [`crate::dynamic::expected`].
    pub mod expected {
        /// Part of a position's variance above which a nominal plant does not follow the drive at all.
        pub const LOST: f64 = 0.98;
    }

    /// See [`crate::dynamic::feedback`].
    pub mod feedback {

        /// See [`crate::dynamic::feedback::filter`].
        pub mod filter {
            /// Quality factors of the two sections of a fourth-order Butterworth filter.
            pub const QUALITIES: [f64; 2] = [0.541_196_100_146_197, 1.306_562_964_876_377];
        }

        /// See [`crate::dynamic::feedback::errors`].
        pub mod errors {
            /// Parts of a recording that are held against each other. By judgement: each is long beside what is correlated, and
            /// there are enough for a spread. The viscous friction of a real drive has an error of 7.3 N s/m by 20 parts, 8.1 by
            /// 10, 6.5 by 40, 4.9 by 80, and of 1.0 by white noise.
            pub const PARTS: usize = 20;
            /// Part of the cut-off at which an estimate is made once more, where recordings of different motions are compared: by
            /// how much it moves it is uncertain. By judgement: at half of it the noise of an acceleration has a fifth.
            pub const SMOOTHER: f64 = 0.5;
        }

        /// See [`crate::dynamic::feedback::inverse`].
        pub mod inverse {
            /// Rounds in which the lag and the gain inside the effects settle.
            pub const ROUNDS: usize = 4;
        }

        /// See [`crate::dynamic::feedback::motion`].
        pub mod motion {
            /// Speed below which the direction of a smoothed motion is uncertain, as a part of its root mean square.
            pub const STANDING: f64 = 0.01;
            /// Steps from row to row for an effect's own states.
            pub const SUBSTEPS: usize = 4;
        }

        /// See [`crate::dynamic::feedback::search`].
        pub mod search {
            /// Part of the residual's variance that an effect has to explain: the regressors are themselves measured
            /// and smoothed, and what they are wrong by looks like a small effect.
            pub const LEAST_PART: f64 = 0.05;
            /// Standard errors, by the blocks that did not fit an effect, by which what it adds there has to help. `trials dynamic
            /// --feedback 64` (seed 61720944) loses none of 32 effects by it, and two of them have another one beside them; three
            /// with 3.5, which also finds other effects in either half of a recording of a real drive.
            pub const CONSISTENT: f64 = 5.5;
            /// Part of the variance by which an alternative may fall short.
            pub const ALTERNATIVE: f64 = 0.02;
            pub const RESOLVED: f64 = 3.0;
        }
    }

    /// See [`crate::dynamic::floor`].
    pub mod floor {
        /// Periods of the resonance in a stretch whose spectrum is taken: a resonance of 5 % damping is then ten lines wide.
        pub const PERIODS: f64 = 16.0;
        /// Least rows of a stretch and least number of them: fewer lines or averages tell no peak from chance.
        pub const LEAST_STRETCH: usize = 64;
        pub const LEAST_STRETCHES: usize = 6;
        /// Bands of the frequency axis per octave.
        pub const BANDS: f64 = 2.0;
        /// Frequencies beyond so many times the resonance are those of the reading alone: the mechanism moves a tenth there.
        pub const BEYOND: f64 = 3.0;
        /// Standard deviations that a band may exceed those beside it by: with some ten bands, one recording of 10³ does.
        pub const CHANCE: f64 = 3.0;
        /// Standard errors from which on the power of the innovation depends on the motion: no chance in 10⁸ recordings.
        pub const DEPENDS: f64 = 6.0;
        /// Blocks of time whose power is compared, their least rows, and the least number of blocks.
        pub const BLOCKS: usize = 64;
        pub const LEAST_BLOCK: usize = 64;
        pub const LEAST_BLOCKS: usize = 12;
        /// The quartile of a normal distribution, in standard deviations.
        pub const QUARTILE: f64 = 0.674;
        /// Lags over which the residual's correlation is summed.
        pub const LAGS: usize = 64;
    }

    /// Forms without a name in motion.
    pub mod forms {
        /// Most further columns of which forms are made, the first in the file: by judgement, so that a search stays below
        /// a minute.
        pub const MOST_COLUMNS: usize = 4;
        /// Part of what the first answer leaves of the rows that score that an answer with forms may leave: what one
        /// effect more gains by chance is far less.
        pub const CLEARLY: f64 = 0.95;
    }

    /// See [`crate::dynamic::gram`].
    pub mod gram {
        /// Directions of the initial state of a run.
        pub const STATE: usize = 2;
        /// Most free parameters of a model.
        pub const MOST_FREE: usize = 16 - STATE;
    }

    /// See [`crate::dynamic::interval`].
    pub mod interval {
        /// Half-width of an amount's interval as a multiple of the amount, and factor on either side of a shape, at most: beyond
        /// three decades a recording says nothing, and a number would only pretend to.
        pub const MOST: f64 = 1e3;
        /// Deviation of a shape's logarithm up to which the interval is taken as straight: the third term is 2 % of the first.
        pub const STRAIGHT: f64 = 0.3;
    }

    /// See [`crate::dynamic::judge`].
    pub mod judge {
        /// The noise floor over the residual before, degrees of freedom counted.
        pub const FLOOR_OVER_BEFORE: f64 = 1.05;
        /// Difference between the written plant and the figures that may be the integrators' own.
        pub const WRITTEN: f64 = 0.03;
        /// Rows along which a written plant is simulated at most: a simulation with adaptive steps of more would outlast the
        /// diagnosis.
        pub const MOST_ROWS: usize = 200_000;
    }

    /// See [`crate::dynamic::linear`].
    pub mod linear {

        /// See [`crate::dynamic::linear::diagnose`].
        pub mod diagnose {
            /// Steps of a fit with the loop on the few stretches that hold it.
            pub const STEPS: usize = 7;
            /// Further steps on all rows.
            pub const FINAL_STEPS: usize = 3;
            /// Steps of a linear model on rows that are not periodic.
            pub const LINEAR_STEPS: usize = 20;
            /// Steps that a rival without memory is given.
            pub const RIVAL_STEPS: usize = 4;
            /// Residual rms in units of the noise up to which nothing is left.
            pub const NOISE: f64 = 1.15;
            /// Part of the residual that depends on the amplitude from which on it is no noise.
            pub const GROWS: f64 = 0.2;
            /// Excess of a rival's held-out residual power below which it is not told apart.
            pub const RIVAL: f64 = 0.03;
        }

        /// See [`crate::dynamic::linear::hysteresis`].
        pub mod hysteresis {
            /// Strengths of the loop that are tried, as parts of the drive at the largest signal.
            pub const STRENGTHS: [f64; 6] = [-0.3, -0.1, 0.03, 0.1, 0.2, 0.4];
            /// Exponent of the threshold density to start from.
            pub const EXPONENT: f64 = -0.2;
        }

        /// See [`crate::dynamic::linear::initial`].
        pub mod initial {
            /// Ridge towards the state at rest, relative to the mean diagonal: few rows leave fast modes undetermined.
            pub const RIDGE: f64 = 1e-6;
        }

        /// See [`crate::dynamic::linear::looped`].
        pub mod looped {
            /// A position beyond this many drive units times the gain counts as unbounded.
            pub const UNBOUNDED: f64 = 1e12;
        }

        /// See [`crate::dynamic::linear::modal`].
        pub mod modal {
            /// Poles beyond this modulus count as unstable.
            pub const STABLE: f64 = 0.999_999;
        }

        /// See [`crate::dynamic::linear::nominal`].
        pub mod nominal {
            /// Block rows of the subspace identification; more resolve closer modes and cost noise.
            pub const BLOCK_ROWS: usize = 40;
            /// Largest order that is tried.
            pub const MOST: usize = 60;
            /// Excess of the distance from the measured response over the least among the orders that a smaller order may have.
            pub const EXCESS: f64 = 1.15;
            /// Steps of the refinement.
            pub const STEPS: usize = 8;
        }

        /// See [`crate::dynamic::linear::offset`].
        pub mod offset {
            /// Blocks into which a run is divided: their means are nearly independent of each other.
            pub const BLOCKS: usize = 4;
            /// Chance, for all positions together, below which an offset is none of the noise.
            pub const CHANCE: f64 = 1e-6;
            /// Part of the residual's power on rows that did not fit it that an offset has to take off.
            pub const LEAST_PART: f64 = 0.003;
        }

        /// See [`crate::dynamic::linear::operator`].
        pub mod operator {
            /// Plays of a bank: their half-widths span 0.01 … 2 of the largest signal seen.
            pub const PLAYS: usize = 16;
        }

        /// See [`crate::dynamic::linear::plan`].
        pub mod plan {
            /// Rows of the stretches of one fit in the time domain: as many as hold a few hundred parameters firmly.
            pub const FIT_ROWS: usize = 34_000;
            /// Rows of the last steps of a fit.
            pub const FINAL_ROWS: usize = 100_000;
            /// Rows of a stretch of a recording that is not periodic.
            pub const STRETCH: usize = 4096;
            /// Rows at the start of such a stretch that give its initial state.
            pub const LEAD: usize = 50;
            /// Part of a single run that is held out, at its end.
            pub const LAST: f64 = 0.25;
            /// Amplitudes closer than this are one.
            pub const SAME: f64 = 0.05;
        }

        /// See [`crate::dynamic::linear::refine`].
        pub mod refine {
            /// Lines of one piece of the normal equations; fixed, so that the sum does not depend on the threads.
            pub const PIECE: usize = 128;
        }

        /// See [`crate::dynamic::linear::sensitivity`].
        pub mod sensitivity {
            /// Parameters whose sensitivities run together.
            pub const LANES: usize = 8;
            /// Pieces of rows whose products are summed up in their order, whatever the number of threads.
            pub const PIECES: usize = 4;
        }

        /// See [`crate::dynamic::linear::subspace`].
        pub mod subspace {
            /// Ridge on the Gram matrix of the drives, relative to its trace: a band that is not excited leaves it
            /// singular.
            pub const RIDGE: f64 = 1e-9;
        }

        /// See [`crate::dynamic::linear::verdict`].
        pub mod verdict {
            /// Bands of the frequency axis, in octaves.
            pub const OCTAVE: f64 = 1.0 / 3.0;
            /// Part of the residual that the named bands hold together at least.
            pub const HELD: f64 = 0.6;
            /// Blocks of a held-out stretch whose residuals are compared.
            pub const BLOCKS: usize = 16;
            /// Least part of the residual's power that an effect must take away to be named.
            pub const WORTH: f64 = 0.1;
            /// A probability below which nothing is told apart.
            pub const SMALLEST: f64 = 1e-300;
        }
    }

    /// See [`crate::dynamic::machine`].
    pub mod machine {
        /// Changes of direction within one step of the integrator that are followed; beyond them the motion is
        /// smaller than the step resolves.
        pub const MOST_EVENTS: usize = 4;
        /// A velocity is zero below this part of those at both ends of the step. By judgement: a friction of no force then moves
        /// nothing by 10⁻⁷ of the stroke. With the secant corrected once it added a fifth to the squares left of a recording, in
        /// steps in which the motion nearly rests.
        pub const TURNED: f64 = 1e-6;
        /// Most steps of the search for that instant. By judgement: twenty halvings alone reach 10⁻⁶ of the step.
        pub const MOST_STEPS: usize = 20;
    }

    /// See [`crate::dynamic::model`].
    pub mod model {
        /// Most effects in a model.
        pub const MOST_TERMS: usize = 8;
        /// Most states of all effects in a model.
        pub const MOST_EXTRA: usize = 2 * super::effects::MOST_STATES;
        /// Most states of all effects that are only probed.
        pub const MOST_PROBED: usize = 22;
    }

    /// See [`crate::dynamic::noise`].
    pub mod noise {
        /// Highest order.
        pub const MOST: usize = 10;
    }

    /// See [`crate::dynamic::recording`].
    pub mod recording {
        /// Least number of rows of a run.
        pub const LEAST_ROWS: usize = 200;
    }

    /// See [`crate::dynamic::remainder`].
    pub mod remainder {
        /// A residual above so many times the noise is not noise: the deviation from some thousand rows, be they alike in
        /// ten that follow, is known to 3 %.
        pub const ABOVE: f64 = 1.1;
        /// Innovation of a residual over its root mean square below which it is no noise: one that is alike over a
        /// hundred samples still has 0.14.
        pub const PREDICTED: f64 = 0.12;
        /// How many times its innovation the noise may be where a residual holds structure: a noise that is alike over
        /// eighteen samples is that.
        pub const COLOURED: f64 = 3.0;
        /// Power on one line over the median of that of the lines around it from which on it is a tone: in noise none of
        /// 10¹⁰ lines reaches 34, and the flank of a resonance is far below.
        pub const TONE: f64 = 80.0;
        /// Power of a tone over that of any other: what is not linear makes many of the drive's lines.
        pub const ALONE: f64 = 4.0;
        /// Lines on each side of a tone that its window spreads it to, and lines beyond them to compare it with.
        pub const SPREAD: usize = 3;
        pub const AROUND: usize = 24;
        /// Power on a line of the drive over that around it from which on the drive holds the tone itself.
        pub const IN_DRIVE: f64 = 10.0;
        /// Part of the residual that a tone has to be.
        pub const LEAST_PART: f64 = 0.005;
    }

    /// See [`crate::dynamic::score`].
    pub mod score {
        /// Rows that give the initial state where the whole record is a periodic steady state.
        pub const STEADY_ROWS: usize = 2000;
    }

    /// See [`crate::dynamic::search`].
    pub mod search {
        /// −2 log likelihood that an effect has to gain where it is fitted: with some hundred candidates and starts
        /// pure noise exceeds 30 (1 parameter, p ≈ 4·10⁻⁸ each) in less than one of 10⁵ recordings, and a further
        /// parameter costs its own.
        pub const LEAST_GAIN: f64 = 30.0;
        /// The same for every parameter beyond the first.
        pub const GAIN_PER_PARAMETER: f64 = 6.0;
        /// Part of the residual's variance that an effect has to explain: below it the figures of the proof do not
        /// change, and the integrator of whoever simulated the plant would be found.
        pub const LEAST_PART: f64 = 0.003;
        /// How often over an effect that acts rarely has to gain where it was fitted what others have to: the rows that
        /// choose say little of it.
        pub const RARE_GAIN: f64 = 2.0;
        /// Times that an effect is exchanged for another, at most.
        pub const MOST_EXCHANGES: usize = 3;

        /// See [`crate::dynamic::search::exchange`].
        pub mod exchange {
            /// A term without which the squared residual grows by more than this factor is beyond doubt.
            pub const STRONG: f64 = 10.0;
            /// A model whose squared residual is within this factor of the best may be the better one on more rows.
            pub const CLOSE: f64 = 1.15;
        }

        /// See [`crate::dynamic::search::contenders`].
        pub mod contenders {
            /// Effects that are fitted in every round, and starts of them that are followed to their end.
            pub const REFITTED: usize = 8;
            /// Further starts, each of another effect, that are refitted for what they explain before whitening.
            pub const REFITTED_PLAINLY: usize = 2;
            /// How many times as much a start must explain before whitening as those from which its effect is tried already. By
            /// judgement: of a mode beside a resonance it was more than fifteen times; with any more at all dry friction of one
            /// among 60 recordings became Stribeck's.
            pub const PLAINLY_BETTER: f64 = 2.0;
            /// What the start of an effect must promise to be fitted, in −2 log likelihood: a third of what an effect must gain, since a
            /// start is not yet an estimate.
            pub const LEAST_PROMISE: f64 = 9.0;
            /// Steps after which contenders are compared.
            pub const HEAT: usize = 8;
            /// Factor of the squared residual by which one is out then.
            pub const BEHIND: f64 = 4.0;
            /// Steps of an estimate of a start.
            pub const SHORT: usize = 4;
        }
    }

    /// See [`crate::dynamic::simulate`].
    pub mod simulate {
        /// Rows over which the velocity at the start of the lead is taken.
        pub const SLOPE_ROWS: usize = 8;
    }

    /// See [`crate::dynamic::spectrum`].
    pub mod spectrum {

        /// See [`crate::dynamic::spectrum::distortion`].
        pub mod distortion {
            /// Part of the strongest drive line below which a line is free, for the detection of distortion.
            pub const FREE: f64 = 1e-5;
        }

        /// See [`crate::dynamic::spectrum::experiments`].
        pub mod experiments {
            /// Part of the strongest line's power below which a line counts as not excited.
            pub const EXCITED: f64 = 1e-5;
        }

        /// See [`crate::dynamic::spectrum::growth`].
        pub mod growth {
            /// Resonances that are followed.
            pub const RESONANCES: usize = 3;
            /// Lines on either side over which a peak stands out.
            pub const REACH: usize = 8;
        }
    }

    /// See [`crate::dynamic::start`].
    pub mod start {
        /// Rounds of the instrumental variables.
        pub const ROUNDS: usize = 4;
        /// Bandwidths of the first filter, as multiples of the rate at which the position moves.
        pub const WIDTHS: [f64; 4] = [0.5, 1.0, 2.0, 5.0];
    }

    /// See [`crate::dynamic::verdict`].
    pub mod verdict {
        /// −2 log likelihood by which a second explanation may fall short and remain an alternative.
        pub const ALTERNATIVE_MARGIN: f64 = 10.0;
        /// The same, as a part of the residual's variance, where the model is known to be imperfect: there the
        /// difference of two likelihoods says more of the imperfection than of the two.
        pub const IMPERFECT_MARGIN: f64 = 0.05;
        /// Structure that is left counts from this part of the residual's variance on.
        pub const LEFT_PART: f64 = 0.005;
        /// −2 log likelihood that a family of shapes has to gain, and for every shape beyond the first.
        pub const LEFT_GAIN: f64 = 30.0;
        pub const LEFT_GAIN_PER_SHAPE: f64 = 6.0;
        /// Structure that is left, as a part of what the effects explain, from which on they are not the physics
        /// but something like it: an effect with the right formula leaves nothing that is worth a hundredth. Only what shows
        /// itself as structure counts: faults of the data, or a noise that is not the same all the time, say nothing against it.
        pub const MIMICRY: f64 = 0.01;
        /// A variance beyond all others whose product with the square of a slope is still a number.
        pub const WITHOUT_END: f64 = 1e200;
    }

    /// See [`crate::dynamic::drive_path`].
    pub mod drive_path {
        /// A part of a step that is shorter changes nothing.
        pub const LEAST_PART: f64 = 1e-12;
    }
}

/// See [`crate::effects`].
pub mod effects {

    /// See [`crate::effects::Effect`].
    pub mod effect {
        /// What the stated direction must explain beyond the play of the readings, in −2 log likelihood: a correction can follow
        /// the readings, and has to be told the direction.
        pub const RELUCTANCE: f64 = 12.0;
        /// Motion from which on the play is taken to have turned over, in standard deviations of a reading: more than two
        /// readings differ by chance.
        pub const MOVED: f64 = 6.0;
        /// Steepest slope that harmonics of the true angle may have together: from 1 on the reading would stand still or run
        /// back while the sensor moves, and no correction could undo it. Before that the harmonics follow the reference itself,
        /// which stands in the error, rather than an error of the sensor.
        pub const STEEPEST: f64 = 0.9;
    }

    /// See [`crate::effects::grid`].
    pub mod grid {
        /// Ratio of the ends of a parameter's range from which on it is searched on a logarithmic scale. By judgement.
        pub const LOGARITHMIC: f64 = 10.0;
        /// Starts over the range of each parameter, as many as a thermal lag has over its own.
        pub const STARTS: usize = 8;
        /// Most rows that stand for all at which a step may begin.
        pub const MOST_ROWS: usize = 160;
    }

    /// See [`crate::effects::report`].
    pub mod report {
        /// Steps of the steady loop from the middle to either end.
        pub const LOOP_STEPS: i32 = 34;
    }
}

/// See [`crate::explain`].
pub mod explain {
    /// Change of the correlation that leaves the calibration as it is.
    pub const SAME_CORRELATION: f64 = 0.08;
    /// Part of what it stands for that a generic curve may leave: a tenth of its square.
    pub const MISFIT_OF_A_CURVE: f64 = 0.1;
    /// Other effects that would do as well, from which on a name beside a curve says nothing.
    pub const ANY_WILL_DO: usize = 5;
    /// Multiple of the noise floor from which on a mismatch is gross: on some hundred rows a signal to noise of ninety, far
    /// beyond what hides in noise.
    pub const GROSS: f64 = 6.0;
    /// Order up to which a sensor's characteristic is followed before a mismatch is called gross: with a straight line, every
    /// curved characteristic was one, and searched twice; with the highest order, the periodic error of a short scale was none.
    pub const CHARACTERISTIC: usize = 3;
    /// Stages in which gross mismatches are explained, the part of what was left that each must leave at most, and the
    /// part of the whole that all of them may.
    pub const STAGES: usize = 6;
    pub const STAGE_GAIN: f64 = 0.8;
    pub const MOSTLY: f64 = 0.75;
    /// Part of the mismatch's variance by which explanations do nearly as well: what an ideal play misses of a real one.
    pub const NEARLY: f64 = 0.02;
    /// Correlation of neighbouring residuals beyond which they are one.
    pub const LONGEST_MEMORY: f64 = 0.98;
    /// Rows of a held-out pass count as unmeasured: their σ, in multiples of the floor.
    pub const UNMEASURED: f64 = 1e6;
}

/// See [`crate::fleet`].
pub mod fleet {
    /// False alarms of each question that is asked of a fleet, over all effects, parameters and units. Half of the 1 % that
    /// `trials fleet` allows: with 0.01 seven of 600 fleets, of which lots mean nothing, were said to differ by lot.
    pub const FALSE_ALARMS: f64 = 0.005;
    /// Units from which on a parameter is pooled: with fewer its spread is hardly known.
    pub const FEWEST_UNITS: usize = 5;
    /// Effects that a fleet shows, at most. By judgement: a reader can weigh so many.
    pub const MOST_SHARED: usize = 8;
    /// Part of the strongest effect's t that an alternative reaches. By judgement.
    pub const NEARLY_AS_STRONG: f64 = 0.9;
    /// Steps within a decade at which a time constant or a width is set: neighbours share most of what they explain.
    pub const SET_SHAPES: [f64; 2] = [1.0, 3.0];
    /// Part of a column's square that base and unnamed terms must leave for it to be tried: less is rounding.
    pub const OWN: f64 = 1e-6;
    /// Units among which one can depart, at least. By judgement.
    pub const FEWEST_TO_DEPART_FROM: usize = 10;
    /// The median of |z| of normal numbers.
    pub const NORMAL_QUARTILE: f64 = 0.674_489_75;
    /// Degrees of freedom of a spread by the median deviation, for each of the usual: its efficiency. In simulation false
    /// alarms at 1 % are 0.1 % of 10 units, 0.7 % of 50 and 0.8 % of 200.
    pub const MEDIAN_FREEDOM: f64 = 0.37;
    /// Halvings of an interval in which a variance lies: beyond, doubles hardly change.
    pub const HALVINGS: usize = 60;
}

/// See [`crate::generic`].
pub mod generic {
    /// How sharply what sets in at one value of an observable sets in, as a part of half its range.
    pub const ONSET: f64 = 0.06;
    /// Most ripples over the stroke.
    pub const MOST_RIPPLES: f64 = 48.0;
    /// Half periods over the recording of the waves in time that are looked for.
    pub const WAVES: std::ops::RangeInclusive<usize> = 4..=40;

    /// See [`crate::generic::screen`].
    pub mod screen {
        /// Further columns that take part in the search, at most. By judgement: more than a recording of one device has of
        /// sensors that matter. Of 200 recordings of white noise beside 300 columns of noise, half of them slow, three raised an
        /// alarm; an effect of ρ 9 in a slow one of them was located in 11 of 67, beside that column alone in 8 of 20.
        pub const MOST_COLUMNS: usize = 12;
    }
}

/// See [`crate::hand_on`].
pub mod hand_on {
    /// Part of a range by which another recording may exceed it: far less than a step.
    pub const MARGIN: f64 = 0.005;
    /// Part of the recorded range of a column by which a form without a name goes on beyond it. Of 122 made recordings with
    /// such a form (`trials beyond --trials 10 --nulls 10 --motion 0 --seed 482978382`) 97 have nine tenths of the gain on a
    /// fresh recording where it ends with the range, 106 with a quarter and 106 without an end. One that was made
    /// worse before loses a little more: its gain falls from -1.37 to -1.49.
    pub const BEYOND: f64 = 0.25;
    /// So many times what a form adds within the recorded range it may add beyond it. By judgement: a straight line and a
    /// square over the whole range stay below.
    pub const GROWS: f64 = 2.5;
    /// So many times nearer to the mean of what it follows than to what it follows is the state of a lag that begins at that
    /// mean on other recordings. Set by 408 simulated recordings of physics without a name (`trials beyond --trials 12 --seed
    /// 58301946`): of 350 that count, 228 have nine tenths of the gain, as many as if every lag began at the first value, and 9
    /// instead of 11 of the 408 are made worse; with 1 these are 223 and 10.
    pub const MUCH_NEARER: f64 = 3.0;
    /// How much likelier, in −2 log likelihood, a lag that begins at its first value, or at zero, makes a recording than one that
    /// begins by the rule above, where the recording shows how it began. By judgement: as much as another effect must do
    /// worse to be no alternative, and half as much again.
    pub const SEEN: f64 = 10.0;
}

/// See [`crate::held_out`].
pub mod held_out {
    /// Most folds.
    pub const FOLDS: usize = 4;
    /// Most blocks of a single move, and of a recording with a single pass of a direction. Where the latter had one block for
    /// every twenty rows, the polynomial erred by more than the noise floor allows: of ten recordings of nothing with three passes of some thirty rows
    /// (`trials beyond`, seeds 306659279 and 366804510) three were said to have structure; with twelve, none.
    pub const BLOCKS: usize = 12;
    /// Fewest rows of a block of a single move, by judgement: no other pass tells what belongs into a gap.
    pub const ROWS_OF_A_MOVE: usize = 20;
    /// Fewest rows of a block where there are several passes: few, since of a step within one nobody can tell the row.
    pub const ROWS_OF_A_BLOCK: usize = 2;
    /// Part of the stroke within which a held-out reading must have a reading that is not held out.
    pub const COVERED: f64 = 1.0 / 40.0;
    /// Part of the readings that must have one; else blocks are held out instead of passes.
    pub const JUDGED: f64 = 0.5;
    /// Part of a pass's rows up to which a direction is none of the pass.
    pub const FEW_OF_A_PASS: f64 = 0.1;
    /// Part of the range of what an effect adds in the other rows by which it may lie outside it in held-out ones. By
    /// judgement: a temperature that drifts evenly over four or more passes lies a third outside.
    pub const BEYOND: f64 = 0.4;
}

/// See [`crate::intervals`].
pub mod intervals {
    /// Parts into which the range of a shape parameter is divided at first, where the effect does not say over what
    /// distance its signature stays much the same.
    pub const PARTS: f64 = 96.0;
    /// The same where three or more are free. By judgement: 96 of each took four minutes for a recording of 450 rows.
    pub const PARTS_OF_MANY: f64 = 12.0;
    /// Most cells that are divided further at a time, those that hold most, once no place can hide between them; the others are
    /// taken as they are, some too high and some too low. By judgement: without it one interval took minutes.
    pub const MOST_DIVIDED: usize = 300;
    /// The same before. By judgement: in a recording without noise something may hide at every division, and without it the
    /// cells took 15 GB.
    pub const MOST_SEARCHED: usize = 3000;
    /// Fall of the log likelihood below the largest at which nothing more is expected.
    pub const NEGLIGIBLE: f64 = 9.0;
    /// Fall of the log likelihood with which a shape does nearly as well as the likeliest: two standard deviations.
    pub const NEARLY: f64 = 2.0;
    /// Parts of the posterior between which a shape stays where it was found, by judgement: where the likelihood is symmetric the
    /// likeliest shape is at one half; where nothing was read between two ends it is at an end, or a little within it.
    pub const CENTRAL: [f64; 2] = [0.1, 0.9];
    /// Part of what an effect adds that base and other effects cannot make, for a shape to take the place of the one that was
    /// found. By judgement: a wave of which they make all but a four-hundredth had an amplitude 400 times as large as needed.
    pub const LEAST_OWN: f64 = 0.1;
    /// Part of the largest log likelihood that the middle of a first cell may miss of the best place in it: a fall with
    /// the square of the distance, so that each halving leaves a quarter. By judgement: of a bump that is 0.35 widths off
    /// in its place and a sixth in its width it is 0.07 without a base, some times that beside one of order 9.
    pub const HIDDEN: f64 = 0.3;
    /// Change of the log likelihood over a cell below which it is not divided any further, and most divisions.
    pub const UNEVEN: f64 = 0.7;
    pub const DIVISIONS: i32 = 12;
    /// Rows about a step's best place whose likelihood is looked at.
    pub const STEP_REACH: usize = 60;
    /// Part of a column's length that must be left beside the others for its amplitude to mean anything.
    pub const DETERMINED: f64 = 1e-5;
}

/// See [`crate::judge`].
pub mod judge {
    /// Least part of the gain on fitted rows that held-out ones must show for anything to be handed on. Of 420 answers with a
    /// gain (`trials beyond`, seeds 1429631257 and 2741331192) three showed less: two made a fresh recording worse.
    pub const OF_FITTED: f64 = 0.2;
    /// Most that effects which were chosen with all readings may leave of held-out ones, over what they leave of fitted ones. Of
    /// 66 such answers (`trials beyond`, seeds 166880394, 573398419 and 1337678861) four left more: three had made a fresh
    /// recording worse, one of them five times, and one had helped.
    pub const OF_HELD_OUT: f64 = 1.3;
    /// Least part of the squares which an effect explains here that would have gone by what other recordings get of it, which
    /// know nothing of what is missing. By judgement: of four lags that began elsewhere it is about 0.5 to 0.7.
    pub const OF_OTHERS: f64 = 0.4;
    /// Part of a form's column about its mean that one step explains, from which on it is one. By judgement: a thermostat that
    /// switched once is above 0.99. Of 40 recordings of a reference that switches by itself three had terms for firmware
    /// without it, two of them such thermostats.
    pub const OF_ONE_STEP: f64 = 0.9;
    /// Ends of an interval beyond which nothing is determined.
    pub const BOUNDLESS: f64 = 1e12;
    /// Widths of its interval by which an estimate may lie outside without a sentence in `judged`. By judgement: beyond, search
    /// and interval stand at different places.
    pub const BESIDE: f64 = 1.0;
    /// Correlation of neighbouring readings from which on noise has a memory, and how much more than the scatter about the
    /// saturated model it may be. By judgement: of 250 simulated recordings of correlated noise alone four left 1.30 to 1.41
    /// times that scatter.
    pub const REMEMBERS: f64 = 0.1;
    pub const FOLLOWED: f64 = 1.5;
    /// How far above the reference's stated accuracy a noise floor may lie: the sensor's own noise adds to the
    /// reference's. By judgement: simulated recordings have half the stated accuracy.
    pub const ABOVE_ACCURACY: f64 = 5.0;
}

/// See [`crate::lasting`].
pub mod lasting {
    /// Effects that are held against noise that lasts in the place of one that does not stand above it: by judgement, the
    /// next ones hardly differ.
    pub const TRIED: usize = 8;
    /// Most that is asked of one effect or form alone in noise that lasts, in −2 log likelihood: what the strongest form gains in
    /// one of two hundred recordings of nothing. Of 577 in flicker, random walk, popcorn and bursts (`trials beyond`, seeds
    /// 29471836, 84736251 and 60814725) the highest gains were 32.6, 31.0, 27.8, 26.9, 26.2 and 24.2.
    pub const BY_CHANCE: f64 = 27.0;
    /// By how much other noise must be likelier than that of the search for an explanation to be fitted in it, in −2 log
    /// likelihood: odds of a hundred and fifty, by judgement.
    pub const LIKELIER: f64 = 10.0;
}

/// See [`crate::model`].
pub mod model {
    /// Surprise at which further orders of the base are kept: some ten blocks are tried, and one in fifteen
    /// recordings may keep one by chance.
    pub const ORDER_SURPRISE: f64 = 5.0;
}

/// See [`crate::noise`].
pub mod noise {
    /// Where the redescending influence function leaves the straight line, starts to fall, and is zero, in σ
    /// (Hampel's three-part function): a Gaussian row is practically never touched.
    pub const HAMPEL: (f64, f64, f64) = (3.0, 4.5, 8.0);
    /// Rows to either side that a row is compared with.
    pub const ALONE: usize = 2;
    /// The scale is at least such that nine tenths of the residuals lie within this many of it (Gaussian: 1.64).
    pub const MOST_CLEANED: f64 = 2.5;
    /// Gain in −2 log likelihood that a dependence of the variance must bring, per parameter. Bursts must bring as much over
    /// outliers: of 160 simulated sequences of white or heavy-tailed noise none gained more, of 40 with bursts three in four did.
    pub const VARIANCE_GAIN: f64 = 6.6;
    /// See [`crate::bursts`].
    pub mod bursts {
        /// How many times the quiet scatter a burst has at least, by judgement.
        pub const LEAST_FACTOR: f64 = 2.0;
        /// Readings that a burst has at least on average: what is alone is an outlier.
        pub const LEAST_LENGTH: f64 = 2.0;
        /// Part of the time that bursts take at most, by judgement: what is more common is no burst.
        pub const MOST_PART: f64 = 0.3;
        /// Part that a reading's noise has of its predecessor's, from which on no bursts are sought, by judgement: in three of 1400
        /// simulated calibrations noise of 0.96 and more passed for bursts, and an alarm was raised.
        pub const MOST_REMEMBERED: f64 = 0.5;
        /// Rounds of the estimate: after six times as many the factor and the gain were the same to a part in a thousand, in
        /// each of six recordings.
        pub const ROUNDS: usize = 10;
    }
}

/// See [`crate::observe`].
pub mod observe {
    /// Fewest rows of which anything is said.
    pub const FEWEST_ROWS: usize = 16;
}

/// See [`crate::reach`].
pub mod reach {
    /// Part of an effect that is handed on to other recordings in any case: of its square a four-hundredth.
    pub const LITTLE: f64 = 0.05;
    /// Part of an effect that the first of two others must explain for the two to be tried in its place. By judgement: it
    /// only spares the search where nothing slow is near.
    pub const HALF: f64 = 0.5;
}

/// See [`crate::refit`].
pub mod refit {
    /// Slope of the harmonics below which nothing is gained on rows that were searched one by one, and from which on no
    /// equation may be left.
    pub const STEEP: (f64, f64) = (0.05, 0.98);
    /// Steps, and the relative gain below which they end.
    pub const STEPS: usize = 12;
    pub const GAIN: f64 = 1e-9;
    /// Rows beyond which the fit of their means is good enough: each step solves the equation for every row.
    pub const MOST_ROWS: usize = 100_000;
    /// Most harmonics, and the part of what was left that one more may leave at most: among some thousand rows chance takes
    /// a thousandth.
    pub const MOST_HARMONICS: usize = 12;
    pub const HARMONIC_GAIN: f64 = 0.99;
}

/// See [`crate::report`].
pub mod report {
    /// Most observables that get a chart of the residual, by judgement.
    pub const MOST_CHARTS: usize = 4;
    /// See [`crate::report::charts`].
    pub mod charts {
        /// Bins of the running mean.
        pub const BINS: usize = 24;
    }
    /// See [`crate::report::map`].
    pub mod map {
        /// Ranges per observable.
        pub const RANGES: usize = 10;
        /// Deviation in units of its uncertainty at which a cell has its full colour.
        pub const FULL: f64 = 8.0;
        /// Height of an observable in pixels, by judgement: two rows of cells, 17 each, and the gap to the next.
        pub const LINE: usize = 46;
        /// Width of the names in pixels, by judgement.
        pub const LEFT: usize = 178;
        /// Width of a cell in pixels, its gap included, by judgement.
        pub const CELL: usize = 38;
    }
    /// See [`crate::report::spectra`].
    pub mod spectra {
        /// Points of a curve.
        pub const POINTS: usize = 300;
        /// Amplitudes that get a spectrum of their own, at most.
        pub const MOST_AMPLITUDES: usize = 4;
        /// Lines on either side of a resonance, at least.
        pub const LEAST_LINES: usize = 6;
        /// Points of the response at a resonance, about: error bars are told apart.
        pub const RESONANCE: usize = 60;
    }
    /// See [`crate::report::surface`].
    pub mod surface {
        /// Least readings of a cell that is shown.
        pub const LEAST: usize = 3;
        /// Half-width of the local polynomial as a part of the natural period.
        pub const REACH: f64 = 0.06;
    }
    /// See [`crate::report::traces`].
    pub mod traces {
        /// Rows that are shown closely.
        pub const CLOSE: usize = 160;
        /// Points of the residual's envelope.
        pub const ENVELOPE: usize = 240;
    }
}

/// See [`crate::rows`].
pub mod rows {
    /// So many times the usual time between readings is a pause, in which a column may do anything. By judgement: moving back
    /// to the first stop takes nine times as long as going on to the next in the simulated recordings.
    pub const PAUSE: f64 = 5.0;
    /// Part of the readings after which there is such a gap that makes it the schedule's and no pause, by judgement.
    pub const COMMON: f64 = 0.2;
    /// Most pauses, by judgement: what came in so many is no state of its own in each. With 2855 pauses between passes a lag of
    /// that many amplitudes took 6.6 GB.
    pub const MOST_PAUSES: f64 = 100.0;
    /// Readings closer than this part of the largest distance between neighbours are of one position.
    pub const SAME_PLACE: f64 = 0.05;
}

/// See [`crate::screened`].
pub mod screened {
    /// Rows that are diagnosed, at most: a hundred times as many as any effect needs, and what memory is there for beside
    /// the recording itself.
    pub const MOST_ROWS: usize = 1_000_000;
    /// Part of the rows left out by which the choice moves from pass to pass, so that all passes together hold every angle.
    pub const GOLDEN: f64 = 0.618_033_988_749_895;
}

/// See [`crate::search`].
pub mod search {
    /// What a generic term must explain beyond a catalogued one to be preferred: a curve always follows an
    /// effect's signature, and a χ² of its further columns must not be enough to unseat the physics.
    pub const GENERIC_HANDICAP: f64 = 5.0;
    /// The same for every column beyond the first.
    pub const HANDICAP_PER_COLUMN: f64 = 1.5;
    /// What every shape parameter must explain in addition: of two explanations that nearly tie, the simpler, of
    /// which the richer one often is a limiting case (a lag without delay, a warm-up that never ends).
    pub const SHAPE_PRICE: f64 = 3.0;
    /// How much more than on the grid a shape may explain once refined: what the grid lost, a third, generously. For every shape
    /// parameter, a thermostat of three is refined until it follows a reference that switches by itself, which a test forbids.
    pub const GRID_LOSS: f64 = 1.5;
    /// The same of the parabola through a top of the grid and its neighbours: a tenth, by judgement.
    pub const TOP_LOSS: f64 = 1.1;
    /// Tops of the grid that are refined. Angles read in two windows forty window widths apart give a period's likelihood a
    /// dozen tops within a tenth of the highest.
    pub const MOST_RIVALS: usize = 16;
    /// Part by which a refined top may miss the highest and still be tried again with further harmonics, and how many are:
    /// a cycle more or less between two windows 20 mm apart costs 0.2 % in windows of half a millimetre, three cost 1.8 %.
    pub const NEAR_TIE: f64 = 0.02;
    pub const MOST_TIED: usize = 6;

    /// See [`crate::search::beside`].
    pub mod beside {
        /// Most sets that are kept; the oldest goes first.
        pub const MOST_KEPT: usize = 48;
    }

    /// See [`crate::search::refine`].
    pub mod refine {
        /// Precision of a shape, as a part of half the grid's spacing: where candidates are compared, of what they explain
        /// a few ten-thousandths are lost by the first, and where a set is refined.
        pub const ROUGH: f64 = 2e-2;
        pub const FINE: f64 = 2e-3;
        /// Part of a step that is left once the top lies between its ends and was looked for there.
        pub const SHRUNK: f64 = 0.3;
    }

    /// See [`crate::search::remainder`].
    pub mod remainder {
        /// Part of the models with all the right names that are said to leave something.
        pub const MISFIT: f64 = 0.03;
        /// Probability over the whole search below which structure is beyond doubt, however the noise is correlated: an alarm that
        /// noise of a long memory raised must still be able to fall when that memory is measured.
        pub const BEYOND_DOUBT: f64 = 1e-5;
    }

    /// See [`crate::search::select`].
    pub mod select {
        /// Most terms in a model.
        pub const MOST_TERMS: usize = 6;
        /// Generic terms after which the search stops: what is left is located well enough to be looked into.
        pub const MOST_GENERIC: usize = 2;
        /// Terms up to which one is tried in the place of two.
        pub const MOST_FOR_PAIRS: usize = 3;
        /// Contenders for the first of two terms that are exchanged at once.
        pub const FIRST_OF_PAIRS: usize = 6;
        /// Merit by which an exchange must win.
        pub const EXCHANGE_MARGIN: f64 = 0.3;
        /// Merit that a joint refinement may bring at most, for a set to be worth refining.
        pub const NEAR: f64 = 12.0;
        /// Families that are refined before they are compared, at most.
        pub const REFINED: usize = 5;
    }
}

/// See [`crate::slow_channel`].
pub mod slow_channel {
    /// Variance of a step over a typical gap relative to that of the reading's noise: lowest, highest and how many.
    pub const RATIOS: (f64, f64, usize) = (1e-5, 1e4, 19);
    /// Rows for every reading of the channel, at least, and fewest readings while recording, from which on it counts as
    /// held between them. By judgement: once a minute beside rows every few seconds.
    pub const REPEATED: usize = 3;
    pub const FEWEST_UPDATES: usize = 5;
}

/// See [`crate::steps`].
pub mod steps {
    /// Rows to either side that are looked at.
    pub const REACH: usize = 16;
    /// Height in σ of a reading from which the single row decides.
    pub const HIGH: f64 = 2.5;
    /// Part of the readings that may be gross outliers, and how many times wider they scatter.
    pub const OUTLIERS: (f64, f64) = (0.05, 6.0);
}

/// See [`crate::verdict`].
pub mod verdict {
    /// What a second explanation may fall short of the best, in −2 log likelihood, to remain an alternative:
    /// between two explanations that are equally good in truth the difference rarely exceeds it.
    pub const ALTERNATIVE_MARGIN: f64 = 7.0;
    /// Largest log odds of another explanation beside the named one: more is certainty.
    pub const MOST_LOG_ODDS: f64 = 30.0;
    /// Most alternatives that are listed: a reader can weigh so many, and where more fit, the recording tells nothing of them.
    pub const MOST_ALTERNATIVES: usize = 5;
    /// What a thermometer's noise takes from an explanation, in its share of the thermometer's variance, allowing for
    /// what it adds to another; and the largest such part.
    pub const BLUR: f64 = 4.0;
    pub const MOST_BLURRED: f64 = 0.5;
    /// Part of a contribution's largest deviation above which a row belongs to its range.
    pub const RANGE_PART: f64 = 0.25;
}
