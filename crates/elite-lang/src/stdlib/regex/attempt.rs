//! Runs a program at one place after the other, the first way first, and steps back where it fails.
//!
//! What there is to step back to is on a stack of its own, which the memory account knows, and every few operations
//! others have their turn. A program whose states can be walked is left to `walk` after so many operations for each
//! byte of the text; one whose states cannot is an error after some more, where CPython would go on stepping back for
//! years.

use super::Spans;
use super::back::{BacktrackEntry, Backtracker, RepeatState, Scratch};
use super::program::{Haystack, NOWHERE, Op, RegexProgram, Repeat, offset_from};
use super::walk;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::value::R;

/// Operations that one search may take before the states of the program are walked: a constant, and a share for each
/// byte.
const BACKTRACK_BUDGET: (usize, usize) = (10_000, 16);
/// Operations that a program without such states may take before it is an error: a constant, and a share for each byte.
const STEPS_MAX: (usize, usize) = (10_000_000, 1_000);

/// Where to search, and for what.
#[derive(Clone, Copy)]
pub(super) struct MatchRequest<'t> {
    pub(super) hay: Haystack<'t>,
    pub(super) start: usize,
    /// The match has to begin at `start`.
    pub(super) anchored: bool,
    /// The match has to end where the text does.
    pub(super) full: bool,
    /// An empty match at `start` is none.
    pub(super) not_empty: bool,
}

impl MatchRequest<'_> {
    /// Whether what begins and ends there is what is looked for.
    pub(super) fn wants(&self, from: usize, to: usize) -> bool {
        let ends_early = self.full && to != self.hay.len();
        let is_none = self.not_empty && from == to && to == self.start;
        !ends_early && !is_none
    }
}

/// How an attempt ended.
enum AttemptResult {
    Found,
    Failed,
    /// The attempt has taken too long.
    Spent,
}

/// The groups of the first match, the whole first.
pub(super) fn find(
    ev: &Evaluator<'_>,
    program: &RegexProgram,
    search: MatchRequest<'_>,
    scratch: &mut Scratch,
) -> R<Option<Spans>> {
    ev.safepoint()?;
    let length = search.hay.len() - search.start;
    let steps = |(always, each): (usize, usize)| each.saturating_mul(length).saturating_add(always);
    let mut run = Backtracker {
        ev,
        program,
        search,
        scratch,
        left: steps(BACKTRACK_BUDGET),
        steps: 0,
    };
    let mut may_walk = true;
    let mut at = search.start;
    loop {
        if !search.anchored {
            at = program.skip(ev, search.hay, at)?;
        }
        match run.attempt(at)? {
            AttemptResult::Found => {
                return Spans::of(ev, &run.scratch.slots).map(Some);
            }
            AttemptResult::Failed => {}
            AttemptResult::Spent if may_walk => {
                may_walk = false;
                if let Some(found) = walk::find(ev, program, search, at)? {
                    return Ok(found);
                }
                run.left = steps(STEPS_MAX);
                continue;
            }
            AttemptResult::Spent => {
                let text = format!(
                    "the regular expression takes more than {} steps on this text",
                    steps(STEPS_MAX)
                );
                return Err(ev.raise(ExceptionKind::RuntimeError, text));
            }
        }
        match search.hay.char_at(at) {
            Some((_, next)) if !search.anchored => at = next,
            _ => return Ok(None),
        }
    }
}

impl Backtracker<'_, '_> {
    fn attempt(&mut self, from: usize) -> R<AttemptResult> {
        let (program, hay) = (self.program, self.search.hay);
        let scratch = &mut *self.scratch;
        scratch.back.clear();
        scratch.borders.clear();
        scratch.slots.clear();
        self.ev.grow(&mut scratch.slots, program.slots)?;
        scratch.slots.resize(program.slots, NOWHERE);
        let round = RepeatState {
            count: 0,
            last: NOWHERE,
        };
        scratch.rounds.clear();
        self.ev.grow(&mut scratch.rounds, program.repeats.len())?;
        scratch.rounds.resize(program.repeats.len(), round);
        let kept = program.slots + 2 * program.repeats.len();
        if !self.charge_steps(1 + kept / 16)? {
            return Ok(AttemptResult::Spent);
        }
        let (mut at, mut place) = (0, from);
        loop {
            if !self.charge_steps(1)? {
                return Ok(AttemptResult::Spent);
            }
            let op = program.ops[at];
            let goes_on = match op {
                Op::Char(_) | Op::Fold(..) | Op::Set(_) | Op::Any | Op::NotNewline => {
                    match hay.char_at(place) {
                        Some((c, next)) if program.takes(op, c) => {
                            (at, place) = (at + 1, next);
                            true
                        }
                        _ => false,
                    }
                }
                Op::Assert(assert) => {
                    at += 1;
                    program.holds(assert, hay, place)
                }
                Op::Split(other) => {
                    let at_other = offset_from(at, other);
                    self.push(BacktrackEntry::Way {
                        at: at_other,
                        place,
                    })?;
                    at += 1;
                    true
                }
                Op::Jump(to) => {
                    at = offset_from(at, to);
                    true
                }
                Op::Save(slot) => {
                    let slot = slot as usize;
                    self.set_slot(slot, place)?;
                    if slot % 2 == 1 {
                        self.set_slot(program.slots - 1, slot / 2)?;
                    }
                    at += 1;
                    true
                }
                Op::Reference(group, case) => {
                    at += 1;
                    match self.same_text(group as usize, case, place)? {
                        Some(end) => {
                            place = end;
                            true
                        }
                        None => false,
                    }
                }
                Op::RepeatSingle(number) => {
                    let next = self.repeat_single(program.repeats[number as usize], at, place)?;
                    match next {
                        Some(next) => {
                            (at, place) = (at + 2, next);
                            true
                        }
                        None => false,
                    }
                }
                Op::RepeatBegin(number) => {
                    self.set_round(number as usize, round)?;
                    let Repeat { least, length, .. } = program.repeats[number as usize];
                    // Without a round that has to be, it begins as if one had ended.
                    at += 1;
                    if least == 0 {
                        at += length as usize;
                        (at, place) = self.decide(number as usize, at, place)?;
                    }
                    true
                }
                Op::RepeatEnd(number) => {
                    let number = number as usize;
                    let mut round = self.scratch.rounds[number];
                    round.count = round.count.saturating_add(1);
                    self.set_round(number, round)?;
                    (at, place) = self.decide(number, at, place)?;
                    true
                }
                Op::Look(number) => {
                    let look = program.looks[number as usize];
                    let after = at + 2 + look.length as usize;
                    match self.back_by(look.back, place)? {
                        Some(begin) => {
                            self.begin_atomic(at, place)?;
                            (at, place) = (at + 1, begin);
                            true
                        }
                        None => {
                            at = after;
                            look.negated
                        }
                    }
                }
                Op::Atomic => {
                    self.begin_atomic(at, place)?;
                    at += 1;
                    true
                }
                Op::Cut => match self.end_atomic()? {
                    Some((begin, before)) => {
                        at += 1;
                        match program.ops[begin] {
                            Op::Look(number) if program.looks[number as usize].negated => {
                                self.undo_alone();
                                false
                            }
                            Op::Look(_) => {
                                self.keep_alone()?;
                                place = before;
                                true
                            }
                            _ => {
                                self.keep_alone()?;
                                true
                            }
                        }
                    }
                    None => false,
                },
                Op::If(group, other) => {
                    at = match self.group(group as usize) {
                        Some(_) => at + 1,
                        None => offset_from(at, other),
                    };
                    true
                }
                Op::Match => {
                    if self.search.wants(from, place) {
                        self.scratch.slots[0] = from;
                        self.scratch.slots[1] = place;
                        return Ok(AttemptResult::Found);
                    }
                    false
                }
            };
            if goes_on {
                continue;
            }
            match self.step_back()? {
                Some(next) => (at, place) = next,
                None => return Ok(AttemptResult::Failed),
            }
        }
    }
}
