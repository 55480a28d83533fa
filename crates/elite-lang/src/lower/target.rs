//! Targets.

use super::Lower;
use super::expr::keeps_locals;
use crate::ast::{self, ExprKind};
use crate::eval::stmt::class_body::ClassSlot;
use crate::eval::stmt::loops::LoopTarget;
use crate::eval::stmt::target::{
    AttributeTarget, Destination, ItemTarget, MappedTarget, Shared, SharedTarget, Slot, Target,
    Unpack,
};
use crate::resolve::Place;
use crate::source::Span;
use crate::value::Value;
use crate::value::trash::Nodes;

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
                targets: Nodes::default(),
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
                    Place::Local(local) => *slot = local,
                    _ => return None,
                },
                _ => return None,
            }
        }
        Some(slots)
    }

    /// A target, as what it is.
    pub(super) fn destination(&mut self, target: &ast::Expr) -> Destination {
        if let ExprKind::Name(name) = &target.kind
            && let Place::Local(slot) = self.place(name)
        {
            let span = target.span;
            return Destination::Local(Slot { slot, span });
        }
        Destination::Other(self.target(target))
    }

    /// What a loop binds.
    pub(super) fn loop_target(&mut self, target: &ast::Expr) -> LoopTarget {
        if let ExprKind::Name(name) = &target.kind
            && let Place::Local(slot) = self.place(name)
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

    pub(super) fn targets(&mut self, targets: &[ast::Expr]) -> Nodes<Box<dyn Target>> {
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
            return Box::new(MappedTarget { slot, key, span });
        }
        let place = match self.place(name) {
            Place::Local(slot) => return Box::new(Slot { slot, span }),
            Place::Class(slot) => return Box::new(ClassSlot { slot, span }),
            Place::Cell(slot) => Shared::Cell(slot),
            Place::Free(index) => Shared::Free(index),
            Place::Global => {
                let name = self.symbol(name);
                Shared::Global(self.variable(name), name)
            }
        };
        Box::new(SharedTarget { place, span })
    }
}
