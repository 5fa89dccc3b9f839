//! Rows of a table that nothing reads: a part of a term may come to nothing in the end, after its table was made.

use super::builder::{ErrorAccount, Known, Tracked, whole};
use crate::exact::Interval;
use crate::program::{Op, Operand, Program, Step};

/// Takes out the rows that no written step reads, and the steps that were to read them.
pub(super) fn drop_rows(program: &mut Program, account: &mut ErrorAccount) {
    let written = program.written_steps();
    let mut rows = 0;
    let mut unread = vec![false; program.steps.len()];
    for step in 0..program.steps.len() {
        let kept = written.binary_search(&step).is_ok();
        let operands = program.steps[step].op.operands();
        unread[step] = !kept && operands.iter().any(|of| matches!(of, Operand::Step(i) if unread[*i]));
        let (Some(known), Op::Index { add, by, .. }) =
            (account.steps.get_mut(&step), &mut program.steps[step].op)
        else {
            continue;
        };
        if kept {
            *add -= rows << *by;
            known.result.range = &known.result.range - &Interval::from_int(rows);
        } else {
            let (first, last) = whole(&known.result.range);
            program.table.drain((first - rows) as usize..=(last - rows) as usize);
            rows += last + 1 - first;
            unread[step] = true;
        }
    }
    let left: Vec<usize> = (0..unread.len()).filter(|step| !unread[*step]).collect();
    let place = |step: usize| left.partition_point(|other| *other < step);
    let moved = |operand: Operand| match operand {
        Operand::Step(step) => Operand::Step(place(step)),
        other => other,
    };
    let tracked = |word: &Tracked| Tracked { operand: moved(word.operand), ..word.clone() };
    let step = |step: &usize| Step { op: program.steps[*step].op.on(moved), ..program.steps[*step].clone() };
    program.steps = left.iter().map(step).collect();
    for word in &mut program.state {
        (word.start, word.next) = (moved(word.start), moved(word.next));
    }
    for step in [&mut program.reading, &mut program.clamped, &mut program.variable] {
        *step = place(*step);
    }
    let known = |(step, known): (&usize, &Known)| {
        let reads = known.reads.iter().map(tracked).collect();
        (!unread[*step]).then(|| (place(*step), Known { result: tracked(&known.result), reads }))
    };
    account.steps = account.steps.iter().filter_map(known).collect();
    account.sum = tracked(&account.sum);
}
