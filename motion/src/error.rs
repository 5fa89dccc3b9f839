//! Why a simulation ends early.

use crate::values::EffectError;

/// A number to six digits, for a message.
fn short(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

fitter::errors! {
    /// See the module.
    #[derive(Debug, Clone, PartialEq)]
    pub enum RunError {
        RunsAway { t_s: f64 } =>
            says("the simulation runs away {t_s:.4} s after its start: the plant is unstable with these numbers")
            mend("check signs and units");
        Stalls { t_s: f64, reason: String } =>
            says("the simulation does not get on {t_s:.4} s after its start ({reason})")
            mend("a time constant may be far shorter than the time between samples");
        TooManySteps { steps: f64, most: f64, duration_s: f64, sample_s: f64 } =>
            says("the simulation would take about {steps:.1e} steps of integration for {} s of rows {} s \
                apart, at most {most:.1e} are made: the plant moves far faster than the rows follow each \
                other", short(*duration_s), short(*sample_s))
            mend("check the units of `t_s` and of the plant's numbers, or record with shorter steps");
        TooLarge { states: usize, most: usize } =>
            says("the plant has {states} states, at most {most} can be simulated") mend("leave effects out");
        Inertia { id: String } =>
            says("effect `{id}` acts on an inertia, which a `linear` plant has not")
            expected("one of the drive or of the read-out, or `kind = \"second-order\"`");
        Drives { expected: usize, found: usize } =>
            says("the plant has {expected} drives and the recording {found}")
            mend("give a recording of the same plant");
        Rate { expected: f64, found: f64 } =>
            says("the plant's matrices hold for a sample every {expected} s, and the recording has one every \
                {found} s")
            mend("record at that rate, or identify the plant again");
        Loop { reason: String } =>
            says("effect `rayleigh_hysteresis`: {reason}") mend("give the plant as `diagnose` wrote it");
        Unstable { row: usize } =>
            says("the simulation runs away at sample {row}: the plant's matrices are unstable");
    }
    from { Effect(EffectError) }
}
