//! Walks all states of a program at the same time, character by character.
//!
//! Thompson's way (1968), with Pike's to keep the groups: in the order of their priority, which gives what stepping
//! back would give, in time that grows with the text only. Programs with look-around, references, `(?>` or counted
//! groups have no such states. Where a group in a repetition matches nothing, what it keeps may differ from what
//! stepping back keeps.

use std::ops::Range;

use super::Spans;
use super::attempt::MatchRequest;
use super::program::{NOWHERE, Op, RegexProgram, VISIT, offset_from};
use crate::eval::Evaluator;
use crate::value::R;

/// States times places of groups.
const CELLS_MAX: usize = 1 << 19;
/// Work between two looks at the clock of `Evaluator::charge`.
const CHARGE_INTERVAL: usize = 1 << 12;

/// A state: an operation, and how often it has been repeated if it is repeated.
#[derive(Clone, Copy, PartialEq, Eq)]
struct NfaState {
    at: usize,
    count: usize,
}

/// The states that are alive at one place, best first, each with the places of its groups.
struct StateSet {
    order: Vec<NfaState>,
    /// By number of the state: its place in `order`, if it is there.
    index: Vec<u32>,
    places: Vec<usize>,
}

/// What is left to do for the states that are reached without a character.
enum ClosureTask {
    Explore(NfaState),
    /// A repeated character that is worth less than what follows it.
    Wait(NfaState),
    /// A group's place is what it was.
    Restore(usize, usize),
}

struct NfaSimulation<'w, 'y> {
    ev: &'w Evaluator<'y>,
    program: &'w RegexProgram,
    search: MatchRequest<'w>,
    /// The number of the first state of each operation.
    first: Vec<u32>,
    places: Vec<usize>,
    open: Vec<ClosureTask>,
    work: usize,
}

/// The first match from a place on; None if the program cannot be walked.
pub(super) fn find(
    ev: &Evaluator<'_>,
    program: &RegexProgram,
    search: MatchRequest<'_>,
    from: usize,
) -> R<Option<Option<Spans>>> {
    let Some((first, states)) = number(ev, program)? else {
        return Ok(None);
    };
    let cells = states.saturating_mul(program.slots);
    if cells > CELLS_MAX {
        return Ok(None);
    }
    let alive = || -> R<StateSet> {
        let mut index = ev.try_with_capacity(states)?;
        index.resize(states, 0);
        let mut places = ev.try_with_capacity(cells)?;
        places.resize(cells, NOWHERE);
        ev.charge(cells)?;
        Ok(StateSet {
            order: Vec::new(),
            index,
            places,
        })
    };
    let (mut now, mut next) = (alive()?, alive()?);
    let mut walk = NfaSimulation {
        ev,
        program,
        search,
        first,
        places: vec![NOWHERE; program.slots],
        open: Vec::new(),
        work: 0,
    };
    let mut found: Option<Vec<usize>> = None;
    let mut at = from;
    loop {
        let may_begin = found.is_none() && (!search.anchored || at == from);
        if now.order.is_empty() {
            if !may_begin {
                break;
            }
            if !search.anchored {
                at = program.skip(ev, search.hay, at)?;
            }
        }
        if may_begin {
            walk.places.fill(NOWHERE);
            walk.places[0] = at;
            walk.reach(at, NfaState { at: 0, count: 0 }, &mut now)?;
        }
        let after = search.hay.char_at(at);
        for place in 0..now.order.len() {
            let state = now.order[place];
            walk.visit()?;
            if let Op::Match = program.ops[state.at] {
                let own = walk.capture_range(state);
                let begin = now.places[own.start];
                if !search.wants(begin, at) {
                    continue;
                }
                let mut places = now.places[own].to_vec();
                places[1] = at;
                found = Some(places);
                // States behind a match are worth less, so they are dropped.
                break;
            }
            let Some((c, end)) = after else { continue };
            let Some((op, to)) = walk.consume(state) else {
                continue;
            };
            if program.takes(op, c) {
                let own = walk.capture_range(state);
                walk.places.copy_from_slice(&now.places[own]);
                walk.reach(end, to, &mut next)?;
            }
        }
        std::mem::swap(&mut now, &mut next);
        next.order.clear();
        match after {
            Some((_, end)) => at = end,
            None => break,
        }
    }
    let found = found.map(|places| Spans::of(ev, &places));
    found.transpose().map(Some)
}

/// Numbers the states: that of the first one of each operation, and how many there are. None if there is something that
/// has no states.
fn number(ev: &Evaluator<'_>, program: &RegexProgram) -> R<Option<(Vec<u32>, usize)>> {
    let mut first = ev.try_with_capacity(program.ops.len())?;
    let mut states: usize = 0;
    for op in &program.ops {
        ev.charge(VISIT)?;
        first.push(states as u32);
        states += match op {
            Op::RepeatSingle(number) => {
                let repeat = program.repeats[*number as usize];
                let last = if repeat.most == u32::MAX {
                    repeat.least
                } else {
                    repeat.most
                };
                last as usize + 1
            }
            Op::RepeatBegin(number) => {
                let repeat = program.repeats[*number as usize];
                if repeat.least > 1 || repeat.most != u32::MAX {
                    return Ok(None);
                }
                1
            }
            Op::Reference(..) | Op::Look(_) | Op::Atomic | Op::Cut | Op::If(..) => return Ok(None),
            _ => 1,
        };
        if states > CELLS_MAX {
            return Ok(None);
        }
    }
    Ok(Some((first, states)))
}

impl NfaSimulation<'_, '_> {
    #[inline]
    fn visit(&mut self) -> R<()> {
        self.work += VISIT;
        if self.work < CHARGE_INTERVAL {
            return Ok(());
        }
        self.ev.charge(std::mem::take(&mut self.work))
    }

    fn set(&mut self, slot: usize, place: usize) -> R<()> {
        self.ev.grow(&mut self.open, 1)?;
        self.open
            .push(ClosureTask::Restore(slot, self.places[slot]));
        self.places[slot] = place;
        Ok(())
    }

    /// Where the places of its groups are.
    fn capture_range(&self, state: NfaState) -> Range<usize> {
        let slots = self.program.slots;
        let own = self.index(state) * slots;
        own..own + slots
    }

    fn index(&self, state: NfaState) -> usize {
        self.first[state.at] as usize + state.count
    }

    /// What a state takes, and the state after that.
    fn consume(&self, state: NfaState) -> Option<(Op, NfaState)> {
        let (at, count) = (state.at, state.count + 1);
        let op = self.program.ops[at];
        let Op::RepeatSingle(number) = op else {
            let after = NfaState {
                at: at + 1,
                count: 0,
            };
            return Some((op, after));
        };
        let repeat = self.program.repeats[number as usize];
        let count = match repeat.most {
            u32::MAX => count.min(repeat.least as usize),
            most if count > most as usize => return None,
            _ => count,
        };
        Some((self.program.ops[at + 1], NfaState { at, count }))
    }

    /// Keeps a state for the next character; whether it is a new one.
    fn add(&mut self, state: NfaState, alive: &mut StateSet) -> R<bool> {
        let index = self.index(state);
        if alive.order.get(alive.index[index] as usize) == Some(&state) {
            return Ok(false);
        }
        self.ev.grow(&mut alive.order, 1)?;
        alive.index[index] = alive.order.len() as u32;
        alive.order.push(state);
        if self.program.is_single(state.at) {
            let own = self.capture_range(state);
            alive.places[own].copy_from_slice(&self.places);
        }
        Ok(true)
    }

    /// Adds a state and all that are reached from it without a character.
    fn reach(&mut self, place: usize, from: NfaState, alive: &mut StateSet) -> R<()> {
        self.open.push(ClosureTask::Explore(from));
        while let Some(next) = self.open.pop() {
            let mut state = match next {
                ClosureTask::Explore(state) => state,
                ClosureTask::Restore(slot, place) => {
                    self.places[slot] = place;
                    continue;
                }
                ClosureTask::Wait(state) => {
                    self.add(state, alive)?;
                    continue;
                }
            };
            loop {
                self.visit()?;
                self.ev.grow(&mut self.open, 1)?;
                let at = state.at;
                if let Op::RepeatSingle(number) = self.program.ops[at]
                    && let repeat = self.program.repeats[number as usize]
                    && !repeat.greedy
                    && state.count >= repeat.least as usize
                {
                    self.open.push(ClosureTask::Wait(state));
                    state = NfaState {
                        at: at + 2,
                        count: 0,
                    };
                    continue;
                }
                if !self.add(state, alive)? {
                    break;
                }
                let to = |at| NfaState { at, count: 0 };
                state = match self.program.ops[at] {
                    Op::Assert(assert) if self.program.holds(assert, self.search.hay, place) => {
                        to(at + 1)
                    }
                    Op::Assert(_) => break,
                    Op::Split(other) => {
                        self.open
                            .push(ClosureTask::Explore(to(offset_from(at, other))));
                        to(at + 1)
                    }
                    Op::Jump(by) => to(offset_from(at, by)),
                    Op::Save(slot) => {
                        let slot = slot as usize;
                        self.set(slot, place)?;
                        if slot % 2 == 1 {
                            self.set(self.program.slots - 1, slot / 2)?;
                        }
                        to(at + 1)
                    }
                    Op::RepeatBegin(number) => {
                        let repeat = self.program.repeats[number as usize];
                        match repeat.least {
                            0 => to(at + 1 + repeat.length as usize),
                            _ => to(at + 1),
                        }
                    }
                    Op::RepeatEnd(number) => {
                        let repeat = self.program.repeats[number as usize];
                        let (group, rest) = (to(at - repeat.length as usize), to(at + 1));
                        let (first, second) = match repeat.greedy {
                            true => (group, rest),
                            false => (rest, group),
                        };
                        self.open.push(ClosureTask::Explore(second));
                        first
                    }
                    Op::RepeatSingle(number) => {
                        let repeat = self.program.repeats[number as usize];
                        if state.count < repeat.least as usize {
                            break;
                        }
                        to(at + 2)
                    }
                    _ => break,
                };
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::attempt;
    use super::super::back;
    use super::super::parse::parse;
    use super::super::program::Haystack;
    use super::*;

    /// Patterns of every construct there are states for; none with a repetition of what may be empty, where the two
    /// keep different texts of the last round.
    const PATTERNS: &[&str] = &[
        "a",
        "abc",
        "",
        "a*",
        "a*?",
        "(a|ab)(c|bcd)(d*)",
        "(a+|b)*",
        "(a+|b)*?c",
        "(a+|b)+",
        "(?:a|(b))+?b",
        "x*y",
        "[a-c]+$",
        "^a",
        "(?m)^b",
        "(?m)c$",
        "$",
        "\\bab\\b",
        "\\B",
        "\\w+",
        "(\\d+)-(\\d+)",
        ".",
        "(?s).+",
        "位",
        "[^位]+",
        "(位|b)+",
        "(?i)AB",
        "(?i)[^A]+b",
        "a{2,3}",
        "(a{2,3}?)(a*)",
        "a{2}b?",
        "(a{1,}?)b",
        "(a??)(b)",
        "(.*)(b)",
        "(.*?)(b)",
        "\\Aab\\Z",
        "(a)|(b)|(c)",
        "(?:(a)|b)*c",
        "a|b|",
        "\\s",
        "(a?)(b?)",
    ];
    const TEXTS: &[&str] = &[
        "",
        "a",
        "ab",
        "abcd",
        "aaa",
        "aab",
        "bac\nab\n",
        "x12-34 y",
        "位b位 a",
        "ABab",
        "\n",
        "a\n\nb\n",
        "cab位\n",
        "aaaaaab",
    ];

    #[test]
    fn a_walk_finds_what_stepping_back_finds() {
        crate::trials::evaluate(|ev| {
            let mut compared = 0;
            for (pattern, is_bytes) in PATTERNS.iter().flat_map(|p| [(p, false), (p, true)]) {
                let parsed = parse(ev, pattern, 0, is_bytes).ok().unwrap();
                let mut scratch = back::Scratch::default();
                for text in TEXTS {
                    let hay = match is_bytes {
                        true => Haystack::Bytes(text.as_bytes()),
                        false => Haystack::Text(text),
                    };
                    let starts =
                        (0..=text.len()).filter(|at| is_bytes || text.is_char_boundary(*at));
                    for (start, ways) in starts.flat_map(|at| (0..8).map(move |ways| (at, ways))) {
                        let search = MatchRequest {
                            hay,
                            start,
                            anchored: ways & 1 != 0,
                            full: ways & 2 != 0,
                            not_empty: ways & 4 != 0,
                        };
                        let walked = find(ev, &parsed.program, search, start)?.unwrap();
                        let stepped = attempt::find(ev, &parsed.program, search, &mut scratch)?;
                        let shown = |found: Option<Spans>| found.map(|it| (it.groups, it.last));
                        assert_eq!(
                            shown(walked),
                            shown(stepped),
                            "{pattern} in {text:?} from {start}, {ways:03b}"
                        );
                        compared += 1;
                    }
                }
            }
            assert!(compared > 20_000, "{compared}");
            Ok(())
        });
    }
}
