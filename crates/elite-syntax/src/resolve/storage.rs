//! Second pass: which variables are shared, and a slot for each.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use messages::text;

use super::collect::{NameInfo, Scope, ScopeKind, Scopes};
use super::{FrameLayout, ScopeLayout, Storage, WORK_PER_MENTION};
use crate::ast::ScopeId;
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::{DiagnosticList, quoted};
use crate::source::Span;
use crate::work_budget::{WORK_PER_DROP, WorkBudget};

/// The scope a name belongs to; None is the module, so a global or builtin.
type Owner = Option<ScopeId>;

/// The implicit variable of a class body that `super()` uses.
const CLASS_CELL: &str = "__class__";
/// Under which name the cell with the class lies among the slots of its body, which may bind `__class__` itself.
const CELL_SLOT: &str = ".class";

struct SlotAllocator<'s, 'p> {
    scopes: &'s mut Scopes<'p>,
    diagnostics: &'s mut DiagnosticList,
    /// By scope: names of it that inner frames share.
    captured: Vec<BTreeSet<Box<str>>>,
    /// By frame: the closure, in the order of first need, with the owner of each name.
    free: Vec<ClosureLayout>,
    /// By frame: the comprehensions that run in it.
    inlined: Vec<Vec<ScopeId>>,
}

#[derive(Clone, Default)]
struct ClosureLayout {
    names: Vec<(Box<str>, ScopeId)>,
    index: BTreeMap<Box<str>, u32>,
}

/// The slots of one frame.
#[derive(Default)]
struct FrameSlots {
    names: Vec<(ScopeId, Box<str>)>,
    index: BTreeMap<(ScopeId, Box<str>), u32>,
    /// By scope: its slots, which lie side by side.
    ranges: BTreeMap<ScopeId, Range<u32>>,
}

impl FrameSlots {
    fn push(&mut self, scope: ScopeId, name: &str) {
        let slot = self.names.len() as u32;
        self.index.insert((scope, name.into()), slot);
        self.ranges.entry(scope).or_insert(slot..slot).end = slot + 1;
        self.names.push((scope, name.into()));
    }

    fn find(&self, scope: ScopeId, name: &str) -> Option<u32> {
        self.index.get(&(scope, name.into())).copied()
    }
}

pub(super) fn assign(
    scopes: &mut Scopes<'_>,
    diagnostics: &mut DiagnosticList,
) -> Vec<Option<ScopeLayout>> {
    let count = scopes.scopes.len();
    let budget = scopes.budget;
    let mut assigner = SlotAllocator {
        scopes,
        diagnostics,
        captured: table(count, budget),
        free: table(count, budget),
        inlined: table(count, budget),
    };
    let ids: Vec<ScopeId> = (0..count as u32).map(ScopeId).collect();
    for id in &ids {
        assigner.charge_name();
        let frame = assigner.frame_of(*id);
        if frame != *id {
            assigner.inlined[frame.0 as usize].push(*id);
        }
    }
    for id in &ids {
        assigner.find_shared(*id);
    }
    let slots: Vec<FrameSlots> = ids.iter().map(|id| assigner.slots_of_frame(*id)).collect();
    let places = ids.iter().map(|id| assigner.places_of(*id, &slots));
    let places = places.collect();
    assigner.release(slots);
    places
}

/// What is said of a `nonlocal` whose name no function around binds.
fn unbound_nonlocal(name: &str, span: Span) -> Diagnostic {
    let message = text!(
        "no binding for nonlocal '{}' found",
        "找不到 nonlocal '{}' 的绑定",
        quoted(name)
    );
    Diagnostic::error("syntax", span, message)
}

/// Finds those without giving names places.
pub(super) fn unbound_nonlocals(scopes: &Scopes<'_>, found: &mut DiagnosticList) {
    for (place, scope) in scopes.scopes.iter().enumerate() {
        let id = scopes.id_at(place);
        for info in scope.iter().flat_map(|scope| &scope.names) {
            if let Some(span) = info.nonlocal
                && scopes.owner(id, &info.name).is_none()
            {
                found.push(unbound_nonlocal(&info.name, span));
            }
        }
    }
}

/// A table with an empty entry for each scope.
fn table<T: Default>(count: usize, budget: &WorkBudget<'_>) -> Vec<T> {
    let entry = |_| {
        budget.charge(size_of::<T>());
        T::default()
    };
    (0..count).map(entry).collect()
}

impl Scopes<'_> {
    /// The scope that the name, seen from `id`, belongs to.
    pub(super) fn owner(&self, id: ScopeId, name: &str) -> Owner {
        let scope = self.get(id)?;
        let info = scope.name(name);
        if scope.kind == ScopeKind::Module || info.is_some_and(|info| info.global.is_some()) {
            return None;
        }
        if info.is_some_and(|info| info.bound && info.nonlocal.is_none()) {
            return Some(id);
        }
        self.outer_owner(scope.parent?, name)
    }

    fn outer_owner(&self, from: ScopeId, name: &str) -> Owner {
        let mut at = Some(from);
        while let Some(id) = at {
            let scope = self.get(id)?;
            match scope.kind {
                ScopeKind::Module => return None,
                ScopeKind::Class if name == CLASS_CELL => return Some(id),
                ScopeKind::Class => {}
                ScopeKind::Function | ScopeKind::Comprehension => match scope.name(name) {
                    Some(NameInfo {
                        global: Some(_), ..
                    }) => return None,
                    Some(NameInfo {
                        bound: true,
                        nonlocal: None,
                        ..
                    }) => return Some(id),
                    _ => {}
                },
            }
            at = scope.parent;
        }
        None
    }
}

impl SlotAllocator<'_, '_> {
    /// Drops the tables, with pauses: many names take long.
    fn release(self, slots: Vec<FrameSlots>) {
        let budget = self.scopes.budget;
        for frame in slots {
            budget.drop_each(frame.names);
            budget.drop_each(frame.index);
            budget.drop_each(frame.ranges);
        }
        for names in self.captured {
            budget.charge(WORK_PER_DROP);
            budget.drop_each(names);
        }
        for closure in self.free {
            budget.charge(WORK_PER_DROP);
            budget.drop_each(closure.names);
            budget.drop_each(closure.index);
        }
        budget.drop_each(self.inlined);
    }

    /// Counts the work for a name; whether to go on.
    fn charge_name(&self) -> bool {
        self.scopes.budget.charge(WORK_PER_MENTION);
        !self.scopes.budget.is_aborted()
    }

    fn scope(&self, id: ScopeId) -> Option<&Scope> {
        self.scopes.get(id)
    }

    /// The scope whose frame the code of `id` runs in.
    fn frame_of(&self, id: ScopeId) -> ScopeId {
        let mut id = id;
        while let Some(Scope {
            kind: ScopeKind::Comprehension,
            parent: Some(parent),
            ..
        }) = self.scope(id)
        {
            id = *parent;
        }
        id
    }

    /// Notes, for every name of scope `id`, whether it crosses frames.
    fn find_shared(&mut self, id: ScopeId) {
        let count = self.scope(id).map_or(0, |scope| scope.names.len());
        for index in 0..count {
            if !self.charge_name() {
                return;
            }
            let Some(info) = self.scope(id).and_then(|scope| scope.names.get(index)) else {
                return;
            };
            let info = info.clone();
            let owner = self.scopes.owner(id, &info.name);
            if let (Some(span), None) = (info.nonlocal, owner) {
                self.diagnostics.push(unbound_nonlocal(&info.name, span));
            }
            let Some(owner) = owner else { continue };
            let own_class_name = owner == id && info.name.as_ref() != CLASS_CELL;
            let is_class = self
                .scope(owner)
                .is_some_and(|scope| scope.kind == ScopeKind::Class);
            if is_class && own_class_name {
                continue;
            }
            self.share(id, owner, &info.name);
        }
    }

    fn share(&mut self, from: ScopeId, owner: ScopeId, name: &str) {
        let target = self.frame_of(owner);
        let mut frame = self.frame_of(from);
        while frame != target {
            let closure = &mut self.free[frame.0 as usize];
            if !closure.index.contains_key(name) {
                closure
                    .index
                    .insert(name.into(), closure.names.len() as u32);
                closure.names.push((name.into(), owner));
            }
            self.captured[owner.0 as usize].insert(name.into());
            let Some(parent) = self.scope(frame).and_then(|scope| scope.parent) else {
                return;
            };
            frame = self.frame_of(parent);
        }
    }

    /// The slots of the frame of `id`, as (scope, name); empty if `id` has no frame.
    fn slots_of_frame(&self, id: ScopeId) -> FrameSlots {
        let mut slots = FrameSlots::default();
        self.charge_name();
        let Some(scope) = self.scope(id) else {
            return slots;
        };
        match scope.kind {
            ScopeKind::Comprehension => return slots,
            ScopeKind::Module => {}
            ScopeKind::Function | ScopeKind::Class => {
                let local = |info: &&NameInfo| {
                    info.bound && info.global.is_none() && info.nonlocal.is_none()
                };
                // Parameters come first.
                for parameter in [true, false] {
                    let those = |info: &&NameInfo| info.parameter == parameter;
                    for info in scope.names.iter().filter(local).filter(those) {
                        if self.charge_name() {
                            slots.push(id, &info.name);
                        }
                    }
                }
            }
        }
        if scope.kind == ScopeKind::Class && self.is_captured(id, CLASS_CELL) {
            slots.push(id, CELL_SLOT);
        }
        for inner in &self.inlined[id.0 as usize] {
            let names = self.scope(*inner).map_or(&[][..], |scope| &scope.names);
            names
                .iter()
                .filter(|info| info.bound && self.charge_name())
                .for_each(|info| slots.push(*inner, &info.name));
        }
        slots
    }

    fn is_captured(&self, id: ScopeId, name: &str) -> bool {
        self.captured[id.0 as usize].contains(name)
    }

    /// Place of `name`, which belongs to `owner`, in the frame of scope `from`.
    fn place(&self, from: ScopeId, owner: Owner, name: &str, slots: &[FrameSlots]) -> Storage {
        let Some(owner) = owner else {
            return Storage::Global;
        };
        let frame = self.frame_of(from);
        if self.frame_of(owner) != frame {
            // `share` has put it there.
            return Storage::Free(
                self.free[frame.0 as usize]
                    .index
                    .get(name)
                    .copied()
                    .unwrap_or(0),
            );
        }
        // Every name that belongs to a scope has a slot in its frame.
        let in_class = self
            .scope(owner)
            .is_some_and(|scope| scope.kind == ScopeKind::Class);
        let is_cell = match name {
            CLASS_CELL if in_class => from != owner,
            name => self.is_captured(owner, name),
        };
        let name = match name {
            CLASS_CELL if is_cell && in_class => CELL_SLOT,
            name => name,
        };
        let slot = slots[frame.0 as usize].find(owner, name).unwrap_or(0);
        if is_cell {
            Storage::Cell(slot)
        } else if in_class {
            Storage::Class(slot)
        } else {
            Storage::Local(slot)
        }
    }

    fn places_of(&self, id: ScopeId, slots: &[FrameSlots]) -> Option<ScopeLayout> {
        if !self.charge_name() {
            return None;
        }
        let scope = self.scope(id)?;
        let mut places = ScopeLayout::default();
        for info in &scope.names {
            self.scopes.budget.charge(WORK_PER_MENTION);
            if !self.charge_name() {
                return None;
            }
            let owner = self.scopes.owner(id, &info.name);
            places
                .names
                .insert(info.name.clone(), self.place(id, owner, &info.name, slots));
        }
        if scope.kind == ScopeKind::Comprehension {
            let frame_slots = &slots[self.frame_of(id).0 as usize];
            for slot in frame_slots.ranges.get(&id).cloned().unwrap_or_default() {
                self.charge_name();
                places.slots.push(slot);
                let (_, name) = &frame_slots.names[slot as usize];
                if self.is_captured(id, name) {
                    places.fresh_cells.push(slot);
                }
            }
            return Some(places);
        }
        places.frame = Some(self.layout(id, scope, &slots[id.0 as usize], slots));
        Some(places)
    }

    fn layout(
        &self,
        id: ScopeId,
        scope: &Scope,
        own: &FrameSlots,
        slots: &[FrameSlots],
    ) -> FrameLayout {
        let own = &own.names;
        let is_class = scope.kind == ScopeKind::Class;
        let is_cell = |name: &str| match name {
            CELL_SLOT => true,
            CLASS_CELL if is_class => false,
            name => self.is_captured(id, name),
        };
        let cells = own
            .iter()
            .enumerate()
            .filter(|(_, (owner, name))| self.charge_name() && *owner == id && is_cell(name));
        let class_cell = own
            .iter()
            .position(|(owner, name)| *owner == id && &**name == CELL_SLOT);
        let names_of_class = own
            .iter()
            .filter(|(owner, name)| *owner == id && &**name != CELL_SLOT)
            .count();
        let parent = scope.parent.unwrap_or(id);
        let closure = self.free[id.0 as usize].names.iter().map(|(name, owner)| {
            self.charge_name();
            let place = match &**name {
                // The class around, whose body is the parent.
                CLASS_CELL if *owner == parent => {
                    let own = &slots[parent.0 as usize];
                    Storage::Cell(own.find(parent, CELL_SLOT).unwrap_or(0))
                }
                name => self.place(parent, Some(*owner), name, slots),
            };
            (name.clone(), place)
        });
        let slot_name = |(_, name): &(ScopeId, Box<str>)| {
            self.scopes.budget.charge(WORK_PER_MENTION / 4);
            name.clone()
        };
        FrameLayout {
            slot_names: own.iter().map(slot_name).collect(),
            cells: cells.map(|(slot, _)| slot as u32).collect(),
            closure: closure.collect(),
            is_generator: scope.is_generator,
            class_cell: class_cell.map(|slot| slot as u32),
            class_names: if is_class { names_of_class as u32 } else { 0 },
        }
    }
}
