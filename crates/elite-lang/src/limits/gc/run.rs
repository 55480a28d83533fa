//! One search for cycles, slice by slice.
//!
//! It is trial deletion (Lins 1992; Bacon and Rajan 2001, without the concurrency): walk from what was noted, count the
//! references that come from within, and keep what has more, with all it reaches. No script code may run between the
//! slices of one search. No step of a slice works on more than a part of a container, and none copies a table of
//! everything seen, so a slice takes a few milliseconds at most, however much there is to see.

use hashbrown::HashTable;

use super::candidates::{GcCandidates, KINDS};
use super::traverse::{age_of, clear_references, has_finalizer, is_leaf, references, visit};
use crate::value::Value;

/// What one object takes in the tables of a search, about.
pub(super) const BYTES_OF_NODE: usize = 40;
/// References and objects a slice looks at.
const SLICE: usize = 2048;
/// Nodes in one block: tables grow by blocks, because moving a big one would take long.
const BLOCK: usize = 1024;
const SHARDS: usize = 1024;

/// One object of a search.
struct GcNode {
    value: Value,
    /// References from other objects of the search.
    internal_refs: u32,
    is_reachable: bool,
}

/// Addresses are well spread after one multiplication.
fn hash_address(address: usize) -> u64 {
    (address as u64)
        .wrapping_mul(0x9E37_79B9_7F4A_7C15)
        .rotate_left(32)
}

/// Numbers of nodes, by the address of their values.
type Shard = HashTable<u32>;

fn shard_of(hash: u64) -> usize {
    // The tables themselves go by the lowest and the highest bits.
    hash as usize >> 20 & (SHARDS - 1)
}

fn address_of(blocks: &[Vec<GcNode>], index: u32) -> Option<usize> {
    let index = index as usize;
    blocks
        .get(index / BLOCK)?
        .get(index % BLOCK)?
        .value
        .address()
}

/// What a search does next.
enum GcPhase {
    /// Enters what was noted.
    AddCandidates {
        kind: usize,
        index: usize,
    },
    /// Enters what the nodes refer to; within node `next` from entry `from` on.
    CountInternalRefs {
        next: usize,
        from: usize,
    },
    /// Marks nodes that are referred to from elsewhere.
    MarkRoots {
        next: usize,
    },
    /// Marks what those reach: the walk through all nodes stands at `next`; `aside` are those to visit before it goes
    /// on, with the entry to go on at. There may be as many of them as there are nodes, so they stay where they are.
    Propagate {
        next: usize,
        aside: Vec<(u32, usize)>,
    },
    /// Ends generators that are not marked: their `finally` blocks may save what they refer to.
    Finalize {
        next: usize,
        ended: bool,
    },
    /// Takes apart what is not marked.
    Clear {
        next: usize,
    },
    /// What is in use grows old, and the nodes are let go.
    Release,
    /// What was noted grows old.
    Promote {
        kind: usize,
        count: usize,
    },
    Done,
}

/// A search.
pub(super) struct GcRun {
    /// Whether the search follows what is old as well.
    all: bool,
    /// Objects it looks at; where there are more it gives up, so that its memory is bounded.
    most: usize,
    gave_up: bool,
    blocks: Vec<Vec<GcNode>>,
    count: usize,
    alive: usize,
    places: Vec<Shard>,
    /// Young ones of each kind that it has entered.
    entered: [usize; KINDS],
    phase: GcPhase,
}

impl GcRun {
    /// A search of everything, or of what is not old, that looks at no more than `most` objects.
    pub(super) fn new(all: bool, most: usize) -> Self {
        GcRun {
            all,
            most,
            gave_up: false,
            blocks: Vec::new(),
            count: 0,
            alive: 0,
            places: (0..SHARDS).map(|_| Shard::default()).collect(),
            entered: [0; KINDS],
            phase: GcPhase::AddCandidates {
                kind: 0,
                index: usize::MAX,
            },
        }
    }

    pub(super) fn is_of_all(&self) -> bool {
        self.all
    }

    /// Objects it has found in use.
    pub(super) fn alive_count(&self) -> usize {
        self.alive
    }

    /// Objects it has seen.
    pub(super) fn seen_count(&self) -> usize {
        self.count
    }

    /// Does a slice of the work; whether the search is over.
    pub(super) fn slice(&mut self, noted: &GcCandidates) -> bool {
        let mut left = SLICE;
        while left > 0 {
            let phase = std::mem::replace(&mut self.phase, GcPhase::Done);
            self.phase = match phase {
                GcPhase::Done => return true,
                GcPhase::AddCandidates { kind, index } => {
                    self.add_candidates(noted, kind, index, &mut left)
                }
                GcPhase::CountInternalRefs { next, from } => self.walk(next, from, &mut left),
                GcPhase::MarkRoots { next } => self.mark(next, &mut left),
                GcPhase::Propagate { next, aside } => self.spread(next, aside, &mut left),
                GcPhase::Finalize { next, ended } => self.end_generators(next, ended, &mut left),
                GcPhase::Clear { next } => self.take_apart(next, &mut left),
                GcPhase::Release => {
                    left = left.saturating_sub(BLOCK);
                    match self.blocks.pop() {
                        Some(block) => {
                            self.let_go(block);
                            GcPhase::Release
                        }
                        None => GcPhase::Promote {
                            kind: 0,
                            count: self.entered[0],
                        },
                    }
                }
                GcPhase::Promote { kind, count } => {
                    left = left.saturating_sub(BLOCK);
                    match noted.promote(kind, count, BLOCK) {
                        0 if kind + 1 == KINDS => GcPhase::Done,
                        0 => GcPhase::Promote {
                            kind: kind + 1,
                            count: self.entered[kind + 1],
                        },
                        count => GcPhase::Promote { kind, count },
                    }
                }
            };
        }
        matches!(self.phase, GcPhase::Done)
    }

    /// What a block's objects are from now on: old, if they are in use.
    fn let_go(&mut self, block: Vec<GcNode>) {
        if self.gave_up {
            return;
        }
        for node in block.iter().filter(|node| node.is_reachable) {
            self.alive += 1;
            if let Some(old) = age_of(&node.value) {
                old.set(true);
            }
        }
    }

    /// Drops a few of the nodes of a search that was given up; whether that was all.
    pub(super) fn drop_some(&mut self) -> bool {
        for _ in 0..SLICE / BLOCK {
            drop(self.blocks.pop());
        }
        self.blocks.is_empty()
    }

    fn node(&mut self, index: usize) -> Option<&mut GcNode> {
        self.blocks.get_mut(index / BLOCK)?.get_mut(index % BLOCK)
    }

    fn place(&self, address: usize) -> Option<u32> {
        let hash = hash_address(address);
        let blocks = &self.blocks;
        self.places[shard_of(hash)]
            .find(hash, |index| address_of(blocks, *index) == Some(address))
            .copied()
    }

    /// The node of a value, a new one if there is none; None for what the search does not follow.
    fn enter(&mut self, value: &Value) -> Option<&mut GcNode> {
        let (Some(_), Some(address)) = (references(value), value.address()) else {
            return None;
        };
        if is_leaf(value) || !self.all && age_of(value).is_some_and(|old| old.get()) {
            return None;
        }
        let hash = hash_address(address);
        let blocks = &self.blocks;
        let shard = &mut self.places[shard_of(hash)];
        let known = shard.find(hash, |index| address_of(blocks, *index) == Some(address));
        let index = match known {
            Some(index) => *index,
            None => {
                let fresh = self.count as u32;
                // A moved table of addresses needs their hashes again.
                let again = |index: &u32| address_of(blocks, *index).map_or(0, hash_address);
                shard.insert_unique(hash, fresh, again);
                if self.count.is_multiple_of(BLOCK) {
                    self.blocks.push(Vec::with_capacity(BLOCK));
                }
                self.blocks.last_mut()?.push(GcNode {
                    value: value.clone(),
                    internal_refs: 0,
                    is_reachable: false,
                });
                self.count += 1;
                fresh
            }
        };
        self.node(index as usize)
    }

    fn add_candidates(
        &mut self,
        noted: &GcCandidates,
        mut kind: usize,
        mut index: usize,
        left: &mut usize,
    ) -> GcPhase {
        while *left > 0 {
            *left -= 1;
            if index == usize::MAX {
                let (old, young) = noted.ages(kind);
                self.entered[kind] = young;
                index = if self.all { 0 } else { old };
            }
            match noted.at(kind, index) {
                Ok(value) => {
                    index += 1;
                    if let Some(value) = value {
                        self.enter(&value);
                    }
                }
                Err(()) if kind + 1 < KINDS => (kind, index) = (kind + 1, usize::MAX),
                Err(()) => return GcPhase::CountInternalRefs { next: 0, from: 0 },
            }
        }
        GcPhase::AddCandidates { kind, index }
    }

    fn walk(&mut self, mut next: usize, mut from: usize, left: &mut usize) -> GcPhase {
        while *left > 0 {
            if self.count > self.most {
                self.gave_up = true;
                return GcPhase::Release;
            }
            let Some(node) = self.node(next) else {
                return GcPhase::MarkRoots { next: 0 };
            };
            let value = node.value.clone();
            let mut seen = 1;
            let more = visit(&value, from, &mut |child| {
                seen += 1;
                if let Some(node) = self.enter(child) {
                    node.internal_refs += 1;
                }
            });
            *left = left.saturating_sub(seen);
            match more {
                Some(entry) => from = entry,
                None => (next, from) = (next + 1, 0),
            }
        }
        GcPhase::CountInternalRefs { next, from }
    }

    fn mark(&mut self, mut next: usize, left: &mut usize) -> GcPhase {
        while *left > 0 {
            *left -= 1;
            let Some(node) = self.node(next) else {
                break;
            };
            // One reference is the search's own.
            node.is_reachable = references(&node.value)
                .is_some_and(|count| count - 1 > node.internal_refs as usize);
            next += 1;
        }
        if next < self.count {
            return GcPhase::MarkRoots { next };
        }
        GcPhase::Propagate {
            next: 0,
            aside: Vec::new(),
        }
    }

    /// Marks what living nodes reach. Nodes are taken in order; those that come to life behind the one being looked at
    /// are put aside and taken first.
    fn spread(
        &mut self,
        mut next: usize,
        mut aside: Vec<(u32, usize)>,
        left: &mut usize,
    ) -> GcPhase {
        while *left > 0 {
            let (index, from) = match aside.pop() {
                Some(entry) => entry,
                None => {
                    *left -= 1;
                    match self.node(next) {
                        None => {
                            return GcPhase::Finalize {
                                next: 0,
                                ended: false,
                            };
                        }
                        Some(node) if node.is_reachable => {
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
                    && !node.is_reachable
                {
                    node.is_reachable = true;
                    // Objects ahead are met on the way.
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
        GcPhase::Propagate { next, aside }
    }

    fn end_generators(&mut self, mut next: usize, mut ended: bool, left: &mut usize) -> GcPhase {
        while *left > 0 {
            let Some(node) = self.node(next) else {
                // The next search finds out what their last statements have left.
                return match ended {
                    true => GcPhase::Release,
                    false => GcPhase::Clear { next: 0 },
                };
            };
            next += 1;
            *left -= 1;
            if !node.is_reachable && has_finalizer(&node.value) {
                let value = node.value.clone();
                clear_references(&value);
                ended = true;
                *left = left.saturating_sub(64);
            }
        }
        GcPhase::Finalize { next, ended }
    }

    fn take_apart(&mut self, mut next: usize, left: &mut usize) -> GcPhase {
        while *left > 0 {
            let Some(node) = self.node(next) else {
                return GcPhase::Release;
            };
            next += 1;
            *left = left.saturating_sub(if node.is_reachable { 1 } else { 8 });
            if !node.is_reachable {
                let value = node.value.clone();
                clear_references(&value);
            }
        }
        GcPhase::Clear { next }
    }
}
