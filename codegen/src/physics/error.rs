//! Why the terms of a coefficients file cannot be generated.

use crate::bound::Overflows;
use crate::reference::TooSteep;

fitter::errors! {
    /// See the module.
    #[derive(Debug, Clone, PartialEq)]
    pub enum PhysicsError {
        Further(it: String) =>
            says("the further input `{it}` cannot be understood")
            mend("give the column, its valid range and how it arrives, for example temperature_c=15..35 (a Q31 word) \
                or temperature_c=15..35:counts:12:0.05:-400 (bits, gain, the count that stands for zero)") by(further);
        Box { observable: String, from: f64, to: f64, reaches: (f64, f64) } =>
            says("`{observable}` as described reaches {}…{} only, its box is {from}…{to}", reaches.0, reaches.1);
        GivenTwice(it: String) =>
            says("the further input {it} is given twice") mend("describe each input once") by(further);
        Taken(it: String) =>
            says("the further input {it} would have the name of another argument of the routine")
            mend("give the column another name") by(further);
        BeyondRecorded { observable: String, from: f64, to: f64, recorded: (f64, f64) } =>
            says("the range {from}…{to} of `{observable}` is wider than the recording, which covers {}…{}: nothing is \
                known of the effects beyond", recorded.0, recorded.1)
            mend("narrow it, or allow to extrapolate") by(further) by(extrapolate);
        Needs { effect: String, kind: &'static str, observable: String } =>
            says("the term `{kind}` of {effect} needs `{observable}` at run time")
            mend("describe that input, or leave the effect out")
            by(further = format_args!("{observable}=FROM..TO")) by(without = effect);
        Unread(it: String) =>
            says("no term of the coefficients reads the further input `{it}`") mend("leave it out") by(further);
        NoSuchEffect { option: &'static str, effect: String, there: String } =>
            says("{effect}: the coefficients have no term of that effect{there}") by_name(option);
        KeptAndLeftOut(it: String) =>
            says("{it} is both to be kept and to be left out: one contradicts the other") by(keep) by(without);
        NotKept { effect: String, why: &'static str } => says("{effect} cannot be kept: {why}") by(keep);
        Twice { effect: String, kind: &'static str } =>
            says("the coefficients have two terms `{kind}` of {effect} with the same parameters: they \
                correct the same error twice")
            mend("take one of them out");
        Means { observable: String, first: String, second: String, means: (f64, f64) } =>
            says("{first} counts `{observable}` from {}, {second} from {}: terms of one recording have one \
                reference, so these contradict each other", means.0, means.1)
            mend("diagnose again, or leave one out") by(without);
        NotGenerated { effect: String, kind: &'static str, why: String } =>
            says("the term `{kind}` of {effect} cannot be generated{why}")
            mend("leave it out, and the heads of the files will say so") by(without = effect);
        Format(it: &'static str) =>
            says("terms of further physics need the format q31 or q31-split, not {it}")
            mend("choose one of these") by(format);
        /// A word of a term leaves its type, however coarse the sum is.
        Leaves { effect: String, kind: &'static str, cause: Overflows } =>
            says("the term `{kind}` of {effect} does not fit words of 32 bits: {cause}")
            mend("narrow the ranges of what it reads, or leave it out") by(further) by(without = effect);
        TooLarge => says("a coefficient of a term is too large for words of 32 bits");
        Period(it: f64) =>
            says("the time between two calls of the routine is {it} s") mend("give a time above zero") by(period_s);
        NeedsPeriod { effect: String, kind: &'static str } =>
            says("the term `{kind}` of {effect} needs the time between two calls of the routine")
            mend("give it, or leave the effect out") by(period_s) by(without = effect);
    }
    from { TooSteep(TooSteep), Overflows(Overflows) }
}

impl PhysicsError {
    /// The same of the term of an effect and a kind.
    #[must_use]
    pub fn of(self, (effect, kind): (&str, &'static str)) -> PhysicsError {
        let effect = effect.to_string();
        match self {
            PhysicsError::Overflows(cause) => PhysicsError::Leaves { effect, kind, cause },
            PhysicsError::TooLarge => {
                let why = ": a coefficient is too large for words of 32 bits".into();
                PhysicsError::NotGenerated { effect, kind, why }
            }
            other => other,
        }
    }
}
