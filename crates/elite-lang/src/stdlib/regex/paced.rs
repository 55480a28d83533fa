//! Searches of long texts with safepoints on the way.
//!
//! fancy-regex searches a text at once, so where that would take long the states of the expression are walked here (Thompson
//! 1968; Pike's way to keep the groups): all at the same time, byte by byte, in the order of their priority, which gives what
//! backtracking would give. Expressions with look-around or back-references have no such states; they are tried at one place
//! after the other.

use std::cell::Cell;

use regex_automata::nfa::thompson::{NFA, State};
use regex_automata::util::look::Look;
use regex_automata::util::primitives::StateID;
use regex_automata::util::syntax;

use super::Spans;
use crate::eval::Evaluator;
use crate::value::R;

/// What `translate` makes of Python's `$`: a look-ahead, but one that a state can be made of.
const END: &str = "(?=\\n?\\z)";
/// Stands for it: an assertion that `translate` never makes.
const END_STATE: &str = "(?Rm:$)";
/// The same for `\\b` among ASCII characters.
const BORDER: &str = "(?:(?<=[a-zA-Z0-9_])(?![a-zA-Z0-9_])|(?<![a-zA-Z0-9_])(?=[a-zA-Z0-9_]))";
const BORDER_STATE: &str = "(?-u:\\b)";
/// Work for one visit of a state, and for a byte that nothing begins with.
const VISIT: usize = 24;
const SKIPPED: usize = 2;
/// Work between two looks at the clock of `Evaluator::worked`.
const SOME: usize = 1 << 12;
/// No place in a text.
const NOWHERE: usize = usize::MAX;

/// The states of an expression.
pub(super) struct Machine {
    nfa: NFA,
    /// The bytes that a match can begin with; None if it may be empty.
    first: Option<Box<[bool; 256]>>,
    /// Places of groups that each thread keeps.
    slots: usize,
    is_text: bool,
    tables: Cell<Option<Box<Tables>>>,
}

/// Where to search, and for what.
#[derive(Clone, Copy)]
pub(super) struct Search<'t> {
    /// The text up to where it counts as ended.
    pub(super) text: &'t [u8],
    pub(super) start: usize,
    /// The match has to begin at `start`.
    pub(super) anchored: bool,
    /// An empty match is none.
    pub(super) not_empty: bool,
}

/// The states that are alive at one place, best first, each with the places of its groups.
struct Alive {
    order: Vec<StateID>,
    /// By state: its place in `order`, if it is there.
    index: Vec<u32>,
    places: Vec<usize>,
}

struct Tables {
    now: Alive,
    next: Alive,
    open: Vec<Open>,
}

/// What is left to do for the states that are reached without a byte.
enum Open {
    Explore(StateID),
    /// A group's place is what it was.
    Restore(usize, usize),
}

impl Alive {
    fn new(states: usize, slots: usize) -> Self {
        Alive {
            order: Vec::new(),
            index: vec![0; states],
            places: vec![NOWHERE; states * slots],
        }
    }

    fn holds(&self, state: StateID) -> bool {
        self.order.get(self.index[state.as_usize()] as usize) == Some(&state)
    }

    fn add(&mut self, state: StateID) {
        self.index[state.as_usize()] = self.order.len() as u32;
        self.order.push(state);
    }
}

impl Machine {
    /// The states of a translated pattern with so many groups; None if it has none.
    pub(super) fn new(pattern: &str, groups: usize, is_bytes: bool) -> Option<Machine> {
        let syntax = syntax::Config::new().utf8(!is_bytes).unicode(!is_bytes);
        let config = NFA::config()
            .utf8(!is_bytes)
            .nfa_size_limit(Some(super::SIZE_MAX));
        let mut compiler = NFA::compiler();
        compiler.syntax(syntax).configure(config);
        let pattern = pattern
            .replace(END, END_STATE)
            .replace(BORDER, BORDER_STATE);
        let nfa = compiler.build(&pattern).ok()?;
        let first = first_bytes(&nfa);
        Some(Machine {
            nfa,
            first,
            slots: 2 * (groups + 1),
            is_text: !is_bytes,
            tables: Cell::default(),
        })
    }

    /// The places of the groups of the first match, the whole first.
    pub(super) fn find(&self, ev: &Evaluator<'_>, search: Search<'_>) -> R<Option<Spans>> {
        let states = self.nfa.states().len();
        let kept = self.tables.take();
        let mut tables = match kept {
            Some(tables) => tables,
            None => {
                ev.check_allocation(2 * states * (self.slots * size_of::<usize>() + 8))?;
                Box::new(Tables {
                    now: Alive::new(states, self.slots),
                    next: Alive::new(states, self.slots),
                    open: Vec::new(),
                })
            }
        };
        tables.now.order.clear();
        let found = self.walk(ev, search, &mut tables);
        self.tables.set(Some(tables));
        Ok(found?.map(|places| {
            let span = |pair: &[usize]| match pair {
                [start, end] if *start != NOWHERE && *end != NOWHERE => Some((*start, *end)),
                _ => None,
            };
            places.chunks(2).map(span).collect()
        }))
    }

    fn walk(
        &self,
        ev: &Evaluator<'_>,
        search: Search<'_>,
        tables: &mut Tables,
    ) -> R<Option<Vec<usize>>> {
        let Search { text, start, .. } = search;
        let mut found: Option<Vec<usize>> = None;
        let mut places = vec![NOWHERE; self.slots];
        let (mut at, mut work) = (start, 0);
        loop {
            let may_begin = found.is_none() && (!search.anchored || at == start);
            if tables.now.order.is_empty() {
                if !may_begin {
                    break;
                }
                if let Some(first) = &self.first {
                    let most = text.len().min(at + SOME / SKIPPED);
                    let rest = &text[at..most];
                    let skipped = rest.iter().position(|byte| first[usize::from(*byte)]);
                    let skipped = if search.anchored { Some(0) } else { skipped };
                    work += skipped.unwrap_or(rest.len()) * SKIPPED;
                    at += skipped.unwrap_or(rest.len());
                    if skipped.is_none() && at < text.len() {
                        ev.worked(work)?;
                        work = 0;
                        continue;
                    }
                }
            }
            // Nothing begins within a character.
            let is_cut = self.is_text && text.get(at).is_some_and(|byte| byte & 0xC0 == 0x80);
            if may_begin && !is_cut {
                let begin = self.nfa.start_anchored();
                places.fill(NOWHERE);
                work += self.reach(
                    text,
                    at,
                    begin,
                    &mut places,
                    &mut tables.now,
                    &mut tables.open,
                );
            }
            work += self.step(search, at, tables, &mut places, &mut found);
            std::mem::swap(&mut tables.now, &mut tables.next);
            tables.next.order.clear();
            if work >= SOME {
                ev.worked(work)?;
                work = 0;
            }
            if at >= text.len() {
                break;
            }
            at += 1;
        }
        ev.worked(work)?;
        Ok(found)
    }

    /// Takes the byte at `at` with all states that are alive; what that was worth.
    fn step(
        &self,
        search: Search<'_>,
        at: usize,
        tables: &mut Tables,
        places: &mut [usize],
        found: &mut Option<Vec<usize>>,
    ) -> usize {
        let Tables { now, next, open } = tables;
        let byte = search.text.get(at).copied();
        let mut work = 0;
        for id in &now.order {
            work += VISIT;
            let own = id.as_usize() * self.slots;
            let own = &now.places[own..own + self.slots];
            let to = match (self.nfa.state(*id), byte) {
                (State::Match { .. }, _) => {
                    if search.not_empty && own.first() == Some(&at) {
                        continue;
                    }
                    *found = Some(own.to_vec());
                    // Those after it are worth less.
                    break;
                }
                (State::ByteRange { trans }, Some(byte)) => {
                    trans.matches_byte(byte).then_some(trans.next)
                }
                (State::Sparse(sparse), Some(byte)) => sparse.matches_byte(byte),
                (State::Dense(dense), Some(byte)) => dense.matches_byte(byte),
                _ => None,
            };
            if let Some(to) = to {
                places.copy_from_slice(own);
                work += self.reach(search.text, at + 1, to, places, next, open);
            }
        }
        work
    }

    /// Adds a state and all that are reached from it without a byte; what that was worth.
    fn reach(
        &self,
        text: &[u8],
        at: usize,
        from: StateID,
        places: &mut [usize],
        alive: &mut Alive,
        open: &mut Vec<Open>,
    ) -> usize {
        let mut work = 0;
        open.push(Open::Explore(from));
        while let Some(next) = open.pop() {
            let mut id = match next {
                Open::Explore(id) => id,
                Open::Restore(slot, place) => {
                    places[slot] = place;
                    continue;
                }
            };
            loop {
                work += VISIT;
                if alive.holds(id) {
                    break;
                }
                alive.add(id);
                id = match self.nfa.state(id) {
                    State::Look { look, next } if self.looks(*look, text, at) => *next,
                    State::Union { alternates } => {
                        let Some((first, rest)) = alternates.split_first() else {
                            break;
                        };
                        open.extend(rest.iter().rev().map(|id| Open::Explore(*id)));
                        *first
                    }
                    State::BinaryUnion { alt1, alt2 } => {
                        open.push(Open::Explore(*alt2));
                        *alt1
                    }
                    State::Capture { next, slot, .. } => {
                        let slot = slot.as_usize();
                        if let Some(place) = places.get_mut(slot) {
                            open.push(Open::Restore(slot, *place));
                            *place = at;
                        }
                        *next
                    }
                    State::ByteRange { .. }
                    | State::Sparse(_)
                    | State::Dense(_)
                    | State::Match { .. } => {
                        let own = id.as_usize() * self.slots;
                        alive.places[own..own + self.slots].copy_from_slice(places);
                        break;
                    }
                    State::Look { .. } | State::Fail => break,
                };
            }
        }
        work
    }

    fn looks(&self, look: Look, text: &[u8], at: usize) -> bool {
        match look {
            Look::EndCRLF => at == text.len() || (at + 1 == text.len() && text[at] == b'\n'),
            look => self.nfa.look_matcher().matches(look, text, at),
        }
    }
}

/// The bytes that a match can begin with; None if it may be empty.
fn first_bytes(nfa: &NFA) -> Option<Box<[bool; 256]>> {
    let mut first = Box::new([false; 256]);
    let mut seen = vec![false; nfa.states().len()];
    let mut open = vec![nfa.start_anchored()];
    while let Some(id) = open.pop() {
        if std::mem::replace(&mut seen[id.as_usize()], true) {
            continue;
        }
        match nfa.state(id) {
            State::ByteRange { trans } => mark(&mut first, trans.start, trans.end),
            State::Sparse(sparse) => {
                for trans in &*sparse.transitions {
                    mark(&mut first, trans.start, trans.end);
                }
            }
            State::Dense(dense) => {
                for byte in 0..=255 {
                    first[usize::from(byte)] |= dense.matches_byte(byte).is_some();
                }
            }
            State::Look { next, .. } | State::Capture { next, .. } => open.push(*next),
            State::Union { alternates } => open.extend(alternates.iter().copied()),
            State::BinaryUnion { alt1, alt2 } => open.extend([*alt1, *alt2]),
            State::Match { .. } => return None,
            State::Fail => {}
        }
    }
    Some(first)
}

fn mark(first: &mut [bool; 256], from: u8, to: u8) {
    first[usize::from(from)..=usize::from(to)].fill(true);
}

#[cfg(test)]
mod tests {
    use super::super::{Engine, Text, translate::translate};
    use super::*;
    use crate::value::Value;

    /// Patterns of every construct there are states for; none with a repetition of what may be empty, where the other search
    /// is of two minds about the last round.
    const PATTERNS: &[&str] = &[
        "a",
        "abc",
        "",
        "a*",
        "a*?",
        "(a|ab)(c|bcd)(d*)",
        "(a+|b)*",
        "(?:a|(b))+",
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
        "a{2,3}",
        "(a{2,3}?)(a*)",
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
    fn a_walk_finds_what_the_search_at_once_finds() {
        crate::trials::evaluate(|ev| {
            let mut compared = 0;
            for (pattern, is_bytes) in PATTERNS.iter().flat_map(|p| [(p, false), (p, true)]) {
                if is_bytes && !pattern.is_ascii() {
                    continue;
                }
                let translated = translate(pattern, 0, is_bytes).ok().unwrap();
                for not_empty in [false, true] {
                    // One that never matches is refused.
                    let made = Engine::new(&translated, &translated.pattern, is_bytes, not_empty);
                    let Ok(engine) = made else { continue };
                    let Some(machine) = engine.machine() else {
                        // Among bytes it is made of look-around.
                        assert!(is_bytes && pattern.contains("\\B"), "{}", engine.pattern);
                        continue;
                    };
                    for text in TEXTS {
                        let value = if is_bytes {
                            Value::bytes(text.as_bytes().to_vec())
                        } else {
                            Value::str(*text)
                        };
                        let text = match (&value, ev.bytes_like(&value)) {
                            (Value::Str(text), _) => Text::Str(text.clone(), value.clone()),
                            (_, data) => Text::Bytes(data.unwrap(), value.clone()),
                        };
                        for start in (0..=text.len()).filter(|at| {
                            is_bytes || std::str::from_utf8(&text.data()[*at..]).is_ok()
                        }) {
                            for anchored in [false, true] {
                                let search = Search {
                                    text: text.data(),
                                    start,
                                    anchored,
                                    not_empty,
                                };
                                let walked = machine.find(ev, search)?;
                                let at_once =
                                    engine.at_once(ev, &text, (start, text.len()), anchored)?;
                                assert_eq!(
                                    walked,
                                    at_once,
                                    "{pattern} in {:?} from {start}, {anchored}, {not_empty}",
                                    text.data()
                                );
                                compared += 1;
                            }
                        }
                    }
                }
            }
            assert!(compared > 5000);
            Ok(())
        });
    }
}
