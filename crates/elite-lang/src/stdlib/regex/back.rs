//! What an attempt can step back to, and the parts of it that are kept there: repeated characters and groups, and what
//! matches by itself.

use super::attempt::MatchRequest;
use super::letters::{CaseFolding, key};
use super::program::{NOWHERE, Op, RegexProgram, Repeat, VISIT};
use crate::eval::Evaluator;
use crate::value::R;

/// Operations between two looks at the clock of `Evaluator::charge`.
const CHARGE_INTERVAL: usize = 256;

/// What there is to step back to.
pub(super) enum BacktrackEntry {
    /// Another way to go on.
    Way { at: usize, place: usize },
    /// A repeated character: one fewer, down to `least`.
    Fewer {
        at: usize,
        least: usize,
        place: usize,
    },
    /// A repeated character: one more, of `left`.
    More { at: usize, place: usize, left: u32 },
    /// What a slot was.
    Slot { slot: usize, place: usize },
    /// What a repeated group was at.
    Round { number: usize, round: RepeatState },
    /// Something that matches by itself began here.
    Border { at: usize, place: usize },
}

/// Where a repeated group is.
#[derive(Clone, Copy)]
pub(super) struct RepeatState {
    /// How often it has ended.
    pub(super) count: u32,
    /// Where its last optional round began.
    pub(super) last: usize,
}

/// What is kept between searches, so that they need not make it.
#[derive(Default)]
pub(super) struct Scratch {
    pub(super) slots: Vec<usize>,
    pub(super) rounds: Vec<RepeatState>,
    pub(super) back: Vec<BacktrackEntry>,
    /// Where in `back` the borders are.
    pub(super) borders: Vec<usize>,
}

/// One search.
pub(super) struct Backtracker<'r, 'y> {
    pub(super) ev: &'r Evaluator<'y>,
    pub(super) program: &'r RegexProgram,
    pub(super) search: MatchRequest<'r>,
    pub(super) scratch: &'r mut Scratch,
    /// Operations until it has taken too long.
    pub(super) left: usize,
    /// Operations since the last look at the clock.
    pub(super) steps: usize,
}

impl Backtracker<'_, '_> {
    /// Counts operations; whether there are any left.
    #[inline]
    pub(super) fn charge_steps(&mut self, steps: usize) -> R<bool> {
        self.steps += steps;
        if self.steps < CHARGE_INTERVAL {
            return Ok(true);
        }
        let steps = std::mem::take(&mut self.steps);
        self.left = self.left.saturating_sub(steps);
        self.ev.charge(steps * VISIT)?;
        Ok(self.left > 0)
    }

    #[inline]
    pub(super) fn push(&mut self, back: BacktrackEntry) -> R<()> {
        self.ev.grow(&mut self.scratch.back, 1)?;
        self.scratch.back.push(back);
        Ok(())
    }

    /// Where to go on instead; None if there is no other way.
    pub(super) fn step_back(&mut self) -> R<Option<(usize, usize)>> {
        while let Some(back) = self.scratch.back.pop() {
            self.charge_steps(1)?;
            match back {
                BacktrackEntry::Way { at, place } => return Ok(Some((at, place))),
                BacktrackEntry::Fewer { at, least, place } => {
                    // Between `least` and here there are characters only.
                    let place = self
                        .search
                        .hay
                        .char_before(place)
                        .map_or(least, |(_, at)| at);
                    if place > least {
                        self.scratch
                            .back
                            .push(BacktrackEntry::Fewer { at, least, place });
                    }
                    return Ok(Some((at, place)));
                }
                BacktrackEntry::More { at, place, left } => {
                    let op = self.program.ops[at - 1];
                    if let Some((c, next)) = self.search.hay.char_at(place)
                        && self.program.takes(op, c)
                    {
                        if left > 1 {
                            let left = if left == u32::MAX { left } else { left - 1 };
                            self.scratch.back.push(BacktrackEntry::More {
                                at,
                                place: next,
                                left,
                            });
                        }
                        return Ok(Some((at, next)));
                    }
                }
                BacktrackEntry::Slot { slot, place } => self.scratch.slots[slot] = place,
                BacktrackEntry::Round { number, round } => self.scratch.rounds[number] = round,
                BacktrackEntry::Border { at, place } => {
                    self.scratch.borders.pop();
                    if let Op::Look(number) = self.program.ops[at] {
                        let look = self.program.looks[number as usize];
                        if look.negated {
                            return Ok(Some((at + 2 + look.length as usize, place)));
                        }
                    }
                }
            }
        }
        Ok(None)
    }

    pub(super) fn set_slot(&mut self, slot: usize, place: usize) -> R<()> {
        let before = self.scratch.slots[slot];
        self.push(BacktrackEntry::Slot {
            slot,
            place: before,
        })?;
        self.scratch.slots[slot] = place;
        Ok(())
    }

    pub(super) fn set_round(&mut self, number: usize, round: RepeatState) -> R<()> {
        let before = self.scratch.rounds[number];
        self.push(BacktrackEntry::Round {
            number,
            round: before,
        })?;
        self.scratch.rounds[number] = round;
        Ok(())
    }

    /// Whether a group is repeated once more or what follows it comes now; `char_at` is its `RerunTimeline`.
    pub(super) fn decide(&mut self, number: usize, at: usize, place: usize) -> R<(usize, usize)> {
        let repeat = self.program.repeats[number];
        let group = at - repeat.length as usize;
        let RepeatState { count, last } = self.scratch.rounds[number];
        if count < repeat.least {
            return Ok((group, place));
        }
        // A round that has found nothing is the last one.
        if count >= repeat.most || place == last {
            return Ok((at + 1, place));
        }
        let begun = RepeatState { count, last: place };
        if repeat.greedy {
            self.push(BacktrackEntry::Way { at: at + 1, place })?;
            self.set_round(number, begun)?;
            return Ok((group, place));
        }
        // Pushed after the round is set, so that stepping back to the other way finds the round like that.
        self.set_round(number, begun)?;
        self.push(BacktrackEntry::Way { at: group, place })?;
        Ok((at + 1, place))
    }

    /// A repeated character from `place` on: where it is done, with the other ways to step back to.
    pub(super) fn repeat_single(
        &mut self,
        repeat: Repeat,
        at: usize,
        place: usize,
    ) -> R<Option<usize>> {
        let (op, hay) = (self.program.ops[at + 1], self.search.hay);
        let (mut here, mut count) = (place, 0);
        let wanted = if repeat.greedy {
            repeat.most
        } else {
            repeat.least
        };
        let mut least = place;
        while count < wanted || wanted == u32::MAX {
            let Some((c, next)) = hay.char_at(here) else {
                break;
            };
            if !self.program.takes(op, c) {
                break;
            }
            here = next;
            count = count.saturating_add(1);
            if count <= repeat.least {
                least = here;
            }
            if count % CHARGE_INTERVAL as u32 == 0 {
                self.charge_steps(CHARGE_INTERVAL / 4)?;
            }
        }
        if count < repeat.least {
            return Ok(None);
        }
        if repeat.greedy && here > least {
            self.push(BacktrackEntry::Fewer {
                at: at + 2,
                least,
                place: here,
            })?;
        } else if !repeat.greedy && repeat.most > repeat.least {
            let left = match repeat.most {
                u32::MAX => u32::MAX,
                most => most - repeat.least,
            };
            self.push(BacktrackEntry::More {
                at: at + 2,
                place: here,
                left,
            })?;
        }
        Ok(Some(here))
    }

    /// What a group has found.
    pub(super) fn group(&self, group: usize) -> Option<(usize, usize)> {
        let slots = self.scratch.slots.get(2 * group..2 * group + 2)?;
        let (start, end) = (slots[0], slots[1]);
        // A group that has begun anew has no text until it ends.
        (end != NOWHERE && start <= end).then_some((start, end))
    }

    /// Where the text of a group ends if it is here again.
    pub(super) fn same_text(
        &mut self,
        group: usize,
        case: CaseFolding,
        place: usize,
    ) -> R<Option<usize>> {
        let Some((start, end)) = self.group(group) else {
            return Ok(None);
        };
        let hay = self.search.hay;
        let (mut from, mut to) = (start, place);
        while from < end {
            let (Some((a, after)), Some((b, next))) = (hay.char_at(from), hay.char_at(to)) else {
                return Ok(None);
            };
            if a != b && key(a, case) != key(b, case) {
                return Ok(None);
            }
            (from, to) = (after, next);
            self.charge_steps(1)?;
        }
        Ok(Some(to))
    }

    /// The place so many characters before another.
    pub(super) fn back_by(&mut self, count: usize, place: usize) -> R<Option<usize>> {
        let mut place = place;
        for _ in 0..count {
            match self.search.hay.char_before(place) {
                Some((_, before)) => place = before,
                None => return Ok(None),
            }
            self.charge_steps(1)?;
        }
        Ok(Some(place))
    }

    /// What follows matches by itself.
    pub(super) fn begin_atomic(&mut self, at: usize, place: usize) -> R<()> {
        let depth = self.scratch.back.len();
        self.ev.grow(&mut self.scratch.borders, 1)?;
        self.scratch.borders.push(depth);
        self.push(BacktrackEntry::Border { at, place })
    }

    /// Where what has matched by itself began.
    pub(super) fn end_atomic(&self) -> R<Option<(usize, usize)>> {
        let border = self.scratch.borders.last();
        let border = border.and_then(|depth| self.scratch.back.get(*depth));
        Ok(match border {
            Some(BacktrackEntry::Border { at, place }) => Some((*at, *place)),
            _ => None,
        })
    }

    /// Takes back what has been done since; it has matched, and should not have.
    pub(super) fn undo_alone(&mut self) {
        let Some(border) = self.scratch.borders.pop() else {
            return;
        };
        while self.scratch.back.len() > border {
            match self.scratch.back.pop() {
                Some(BacktrackEntry::Slot { slot, place }) => self.scratch.slots[slot] = place,
                Some(BacktrackEntry::Round { number, round }) => {
                    self.scratch.rounds[number] = round
                }
                _ => {}
            }
        }
    }

    /// Gives up the other ways of what has matched, and keeps what it has found.
    pub(super) fn keep_alone(&mut self) -> R<()> {
        let Some(border) = self.scratch.borders.pop() else {
            return Ok(());
        };
        let mut kept = border;
        for at in border..self.scratch.back.len() {
            if matches!(
                self.scratch.back[at],
                BacktrackEntry::Slot { .. } | BacktrackEntry::Round { .. }
            ) {
                self.scratch.back.swap(kept, at);
                kept += 1;
            }
            self.charge_steps(1)?;
        }
        self.scratch.back.truncate(kept);
        Ok(())
    }
}
