//! One search for cycles, slice by slice.
//!
//! It is trial deletion (Lins 1992; Bacon and Rajan 2001, without the concurrency): walk from what was noted, count the
//! references that come from within, and keep what has more, with all it reaches. No script code may run between the
//! slices of one search. No step of a slice works on more than a part of a container, and none copies a table of
//! everything seen, so a slice takes a few milliseconds at most, however much there is to see.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use super::graph::{references, take_apart, visit};
use super::{Cycles, KINDS};
use crate::value::Value;

/// Objects a search looks at; where there are more it gives up, so that its memory is bounded.
const OBJECTS_MAX: usize = 1 << 20;
/// References and objects a slice looks at.
const SLICE: usize = 2048;
/// Nodes in one block: tables grow by blocks, because moving a big one would take long.
const BLOCK: usize = 1024;
const SHARDS: usize = 1024;

/// One object of a search.
struct Node {
    value: Value,
    /// References from other objects of the search.
    within: u32,
    lives: bool,
}

/// Addresses are well spread after one multiplication.
#[derive(Default)]
struct AddressHasher(u64);

impl Hasher for AddressHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes
            .iter()
            .for_each(|byte| self.write_usize(usize::from(*byte)));
    }

    fn write_usize(&mut self, address: usize) {
        self.0 = mixed(address).rotate_left(32);
    }
}

fn mixed(address: usize) -> u64 {
    (address as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
}

type Shard = HashMap<usize, u32, BuildHasherDefault<AddressHasher>>;

/// What a search does next.
enum Phase {
    /// Enters what was noted.
    Enter {
        kind: usize,
        index: usize,
    },
    /// Enters what the nodes refer to; within node `next` from entry `from` on.
    Walk {
        next: usize,
        from: usize,
    },
    /// Marks nodes that are referred to from elsewhere.
    Mark {
        next: usize,
    },
    /// Marks what those reach: nodes to visit, with the entry to go on at.
    Spread {
        open: Vec<(u32, usize)>,
    },
    /// Takes apart what is not marked.
    TakeApart {
        next: usize,
    },
    /// Lets go of the nodes.
    LetGo,
    /// Forgets what has died.
    Forget {
        kind: usize,
        read: usize,
        write: usize,
    },
    Over,
}

/// A search.
pub(super) struct Search {
    blocks: Vec<Vec<Node>>,
    count: usize,
    places: Vec<Shard>,
    phase: Phase,
}

impl Default for Search {
    fn default() -> Self {
        Search {
            blocks: Vec::new(),
            count: 0,
            places: (0..SHARDS).map(|_| Shard::default()).collect(),
            phase: Phase::Enter { kind: 0, index: 0 },
        }
    }
}

impl Search {
    /// Objects it has seen.
    pub(super) fn seen(&self) -> usize {
        self.count
    }

    /// Does a slice of the work; whether the search is over.
    pub(super) fn slice(&mut self, cycles: &Cycles) -> bool {
        let mut left = SLICE;
        while left > 0 {
            let phase = std::mem::replace(&mut self.phase, Phase::Over);
            self.phase = match phase {
                Phase::Over => return true,
                Phase::Enter { kind, index } => self.enter_noted(cycles, kind, index, &mut left),
                Phase::Walk { next, from } => self.walk(next, from, &mut left),
                Phase::Mark { next } => self.mark(next, &mut left),
                Phase::Spread { open } => self.spread(open, &mut left),
                Phase::TakeApart { next } => self.take_apart(next, &mut left),
                Phase::LetGo => {
                    left = left.saturating_sub(BLOCK);
                    match self.blocks.pop() {
                        Some(block) => {
                            drop(block);
                            Phase::LetGo
                        }
                        None => Phase::Forget {
                            kind: 0,
                            read: 0,
                            write: 0,
                        },
                    }
                }
                Phase::Forget {
                    kind,
                    mut read,
                    mut write,
                } => {
                    left = left.saturating_sub(BLOCK);
                    match cycles.forget_dead(kind, &mut read, &mut write, BLOCK) {
                        true => Phase::Forget { kind, read, write },
                        false if kind + 1 < KINDS => Phase::Forget {
                            kind: kind + 1,
                            read: 0,
                            write: 0,
                        },
                        false => Phase::Over,
                    }
                }
            };
        }
        matches!(self.phase, Phase::Over)
    }

    /// Drops a few of the nodes of a search that was given up; whether that was all.
    pub(super) fn drop_some(&mut self) -> bool {
        for _ in 0..SLICE / BLOCK {
            drop(self.blocks.pop());
        }
        self.blocks.is_empty()
    }

    fn node(&mut self, index: usize) -> Option<&mut Node> {
        self.blocks.get_mut(index / BLOCK)?.get_mut(index % BLOCK)
    }

    fn place(&self, address: usize) -> Option<u32> {
        self.places[mixed(address) as usize >> 54]
            .get(&address)
            .copied()
    }

    /// The node of a value, a new one if there is none; None for what the search does not follow.
    fn enter(&mut self, value: &Value) -> Option<&mut Node> {
        let (Some(_), Some(address)) = (references(value), value.address()) else {
            return None;
        };
        let shard = &mut self.places[mixed(address) as usize >> 54];
        let fresh = self.count as u32;
        let index = *shard.entry(address).or_insert(fresh);
        if index == fresh {
            if self.count.is_multiple_of(BLOCK) {
                self.blocks.push(Vec::with_capacity(BLOCK));
            }
            self.blocks.last_mut()?.push(Node {
                value: value.clone(),
                within: 0,
                lives: false,
            });
            self.count += 1;
        }
        self.node(index as usize)
    }

    fn enter_noted(
        &mut self,
        cycles: &Cycles,
        mut kind: usize,
        mut index: usize,
        left: &mut usize,
    ) -> Phase {
        while *left > 0 {
            *left -= 1;
            match cycles.noted(kind, index) {
                Ok(value) => {
                    index += 1;
                    if let Some(value) = value {
                        self.enter(&value);
                    }
                }
                Err(()) if kind + 1 < KINDS => (kind, index) = (kind + 1, 0),
                Err(()) => return Phase::Walk { next: 0, from: 0 },
            }
        }
        Phase::Enter { kind, index }
    }

    fn walk(&mut self, mut next: usize, mut from: usize, left: &mut usize) -> Phase {
        while *left > 0 {
            if self.count > OBJECTS_MAX {
                return Phase::LetGo;
            }
            let Some(node) = self.node(next) else {
                return Phase::Mark { next: 0 };
            };
            let value = node.value.clone();
            let mut seen = 1;
            let more = visit(&value, from, &mut |child| {
                seen += 1;
                if let Some(node) = self.enter(child) {
                    node.within += 1;
                }
            });
            *left = left.saturating_sub(seen);
            match more {
                Some(entry) => from = entry,
                None => (next, from) = (next + 1, 0),
            }
        }
        Phase::Walk { next, from }
    }

    fn mark(&mut self, mut next: usize, left: &mut usize) -> Phase {
        while *left > 0 {
            *left -= 1;
            let Some(node) = self.node(next) else {
                break;
            };
            // One reference is the search's own.
            node.lives =
                references(&node.value).is_some_and(|count| count - 1 > node.within as usize);
            next += 1;
        }
        if next < self.count {
            return Phase::Mark { next };
        }
        let open = Vec::new();
        Phase::Spread { open }
    }

    /// Marks what living nodes reach. Nodes are taken in order; those that come to life behind the one being looked at are
    /// put aside and taken first.
    fn spread(&mut self, mut open: Vec<(u32, usize)>, left: &mut usize) -> Phase {
        // The last entry is where the walk through all nodes stands.
        let mut next = open.first().map_or(0, |(next, _)| *next as usize);
        let mut aside = open.split_off(open.len().min(1));
        while *left > 0 {
            let (index, from) = match aside.pop() {
                Some(entry) => entry,
                None => {
                    *left -= 1;
                    match self.node(next) {
                        None => return Phase::TakeApart { next: 0 },
                        Some(node) if node.lives => {
                            next += 1;
                            (next as u32 - 1, 0)
                        }
                        Some(_) => {
                            next += 1;
                            continue;
                        }
                    }
                }
            };
            let Some(node) = self.node(index as usize) else {
                continue;
            };
            let value = node.value.clone();
            let mut seen = 1;
            let more = visit(&value, from, &mut |child| {
                seen += 1;
                if references(child).is_none() {
                    return;
                }
                let place = child.address().and_then(|address| self.place(address));
                let Some(place) = place else { return };
                if let Some(node) = self.node(place as usize)
                    && !node.lives
                {
                    node.lives = true;
                    // Those ahead are met on the way.
                    if (place as usize) < next {
                        aside.push((place, 0));
                    }
                }
            });
            *left = left.saturating_sub(seen);
            if let Some(entry) = more {
                aside.push((index, entry));
            }
        }
        let mut open = vec![(next as u32, 0)];
        open.append(&mut aside);
        Phase::Spread { open }
    }

    fn take_apart(&mut self, mut next: usize, left: &mut usize) -> Phase {
        while *left > 0 {
            let Some(node) = self.node(next) else {
                return Phase::LetGo;
            };
            next += 1;
            *left = left.saturating_sub(if node.lives { 1 } else { 8 });
            if !node.lives {
                let value = node.value.clone();
                take_apart(&value);
            }
        }
        Phase::TakeApart { next }
    }
}
