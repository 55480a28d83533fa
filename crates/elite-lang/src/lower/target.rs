//! Targets.

use elite_syntax::Span;
use elite_syntax::ast::{self, ExprKind};
use elite_syntax::resolve::Storage;

use super::Lower;
use super::expr::keeps_locals;
use crate::eval::stmt::class_body::ClassSlot;
use crate::eval::stmt::loops::LoopTarget;
use crate::eval::stmt::target::{
    AttributeTarget, CellRef, ItemTarget, LocalOrTarget, MappingTarget, SharedTarget, SlotTarget,
    Target, Unpack,
};
use crate::limits::deferred_drop::NodeList;
use crate::value::Value;

impl Lower<'_> {
    pub(super) fn target(&mut self, target: &ast::Expr) -> Box<dyn Target> {
        let span = target.span;
        match &target.kind {
            ExprKind::Name(name) => self.name_target(name, span),
            ExprKind::Attribute { .. } => Box::new(self.attribute_target(target)),
            ExprKind::Subscript { .. } => Box::new(self.item_target(target)),
            ExprKind::Starred(inner) => self.target(inner),
            ExprKind::Tuple(items) | ExprKind::List(items) => Box::new(self.unpack(items, span)),
            // The parser accepts no other targets.
            _ => Box::new(Unpack {
                targets: NodeList::default(),
                star: None,
                span,
            }),
        }
    }

    pub(super) fn unpack(&mut self, items: &[ast::Expr], span: Span) -> Unpack {
        let star = items
            .iter()
            .position(|item| matches!(item.kind, ExprKind::Starred(_)));
        let targets = items.iter().map(|item| self.destination(item)).collect();
        Unpack {
            targets,
            star,
            span,
        }
    }

    /// The slots of targets that are all local names.
    pub(super) fn local_slots<const N: usize>(&mut self, items: &[ast::Expr]) -> Option<[u32; N]> {
        let items: &[ast::Expr; N] = items.try_into().ok()?;
        let mut slots = [0; N];
        for (slot, item) in slots.iter_mut().zip(items) {
            match &item.kind {
                ExprKind::Name(name) => match self.place(name) {
                    Storage::Local(local) => *slot = local,
                    _ => return None,
                },
                _ => return None,
            }
        }
        Some(slots)
    }

    /// A target, as what it is.
    pub(super) fn destination(&mut self, target: &ast::Expr) -> LocalOrTarget {
        if let ExprKind::Name(name) = &target.kind
            && let Storage::Local(slot) = self.place(name)
        {
            let span = target.span;
            return LocalOrTarget::Local(SlotTarget { slot, span });
        }
        LocalOrTarget::Other(self.target(target))
    }

    /// What a loop binds.
    pub(super) fn loop_target(&mut self, target: &ast::Expr) -> LoopTarget {
        if let ExprKind::Name(name) = &target.kind
            && let Storage::Local(slot) = self.place(name)
        {
            return LoopTarget::Slot(slot);
        }
        if let ExprKind::Tuple(items) | ExprKind::List(items) = &target.kind
            && let [first, second] = &items[..]
            && !matches!(first.kind, ExprKind::Starred(_))
            && !matches!(second.kind, ExprKind::Starred(_))
        {
            return LoopTarget::Pair(Unpack {
                targets: [self.destination(first), self.destination(second)]
                    .into_iter()
                    .collect(),
                star: None,
                span: target.span,
            });
        }
        LoopTarget::Other(self.target(target))
    }

    pub(super) fn targets(&mut self, targets: &[ast::Expr]) -> NodeList<Box<dyn Target>> {
        targets.iter().map(|target| self.target(target)).collect()
    }

    /// The item that `target` is.
    pub(super) fn item_target(&mut self, target: &ast::Expr) -> ItemTarget {
        let (value, index) = match &target.kind {
            ExprKind::Subscript { value, index } => (&**value, &**index),
            // Only called for items.
            _ => (target, target),
        };
        ItemTarget {
            keeps: keeps_locals(index),
            value: self.operand(value),
            index: self.operand(index),
            span: target.span,
        }
    }

    /// The attribute that `target` is.
    pub(super) fn attribute_target(&mut self, target: &ast::Expr) -> AttributeTarget {
        let ExprKind::Attribute { value, name } = &target.kind else {
            // Only called for attributes.
            let value = self.operand(target);
            let name = self.symbol("");
            return AttributeTarget {
                value,
                name,
                span: target.span,
                cache: Default::default(),
            };
        };
        let (value, name) = (self.operand(value), self.symbol(&name.name));
        AttributeTarget {
            value,
            name,
            span: target.span,
            cache: Default::default(),
        }
    }

    pub(super) fn name_target(&mut self, name: &str, span: Span) -> Box<dyn Target> {
        if let Some(slot) = self.mapping(name, true) {
            let key = Value::str(name);
            return Box::new(MappingTarget { slot, key, span });
        }
        let place = match self.place(name) {
            Storage::Local(slot) => return Box::new(SlotTarget { slot, span }),
            Storage::Class(slot) => return Box::new(ClassSlot { slot, span }),
            Storage::Cell(slot) => CellRef::Cell(slot),
            Storage::Free(index) => CellRef::Free(index),
            Storage::Global => {
                let name = self.symbol(name);
                CellRef::Global(self.variable(name), name)
            }
        };
        Box::new(SharedTarget { place, span })
    }
}
