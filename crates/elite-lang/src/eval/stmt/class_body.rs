//! What is special about the body of a class: its names may go through a namespace of the metaclass, and annotations
//! are kept.
//!
//! The names lie in slots, as those of a function do. The slot behind the last one holds the object that `__prepare__`
//! of the metaclass returned if that is no plain dictionary: it sees each name that is bound, and may keep another
//! value.

use std::rc::Rc;

use elite_syntax::Span;

use super::target::Target;
use crate::errors::ExceptionKind;
use crate::eval::{BoxExpr, DynStmt, Evaluator, Flow, Frame, StmtNode, TraceExt, attempt};
use crate::value::{Dict, R, Unwind, Value};

/// A name of a class body.
pub struct ClassSlot {
    /// The slot of the name in the frame of the body.
    pub slot: u32,
    /// The place in the text.
    pub span: Span,
}

impl Target for ClassSlot {
    fn assign(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, value: Value) -> R<()> {
        let mut value = value;
        if let Some(namespace @ Value::Instance(_)) = f.slots.last().cloned() {
            let name = f.function.code.slot_names[self.slot as usize];
            let name = ev.core.symbols.to_value(name);
            ev.set_item(&namespace, &name, value)
                .trace_at(ev, f, self.span)?;
            value = ev.item(&namespace, &name).trace_at(ev, f, self.span)?;
        }
        let old = std::mem::replace(&mut f.slots[self.slot as usize], value);
        drop(old);
        Ok(())
    }

    fn delete(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<()> {
        let name = f.function.code.slot_names[self.slot as usize];
        if std::mem::take(&mut f.slots[self.slot as usize]).is_unbound() {
            let text = format!("name '{}' is not defined", ev.core.symbols.name(name));
            return Err(ev.raise(ExceptionKind::NameError, text)).trace_at(ev, f, self.span);
        }
        if let Some(namespace @ Value::Instance(_)) = f.slots.last().cloned() {
            let name = ev.core.symbols.to_value(name);
            ev.delete_item(&namespace, &name)
                .trace_at(ev, f, self.span)?;
        }
        Ok(())
    }
}

/// `name: annotation` in a class body. What cannot be evaluated is kept as its text, so that an annotation never stops
/// a program.
pub struct AnnotatedAssign {
    /// The assignment it comes with.
    pub assign: Option<Box<dyn DynStmt>>,
    /// Where `__annotations__` of the body is.
    pub annotations: u32,
    /// The annotated name.
    pub name: Value,
    /// The annotation.
    pub annotation: BoxExpr,
    /// The annotation as it is written.
    pub text: Value,
}

impl StmtNode for AnnotatedAssign {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        if let Some(assign) = &self.assign {
            match assign.exec(ev, f) {
                Flow::Next => {}
                end => return end,
            }
        }
        let annotation = match self.annotation.eval(ev, f) {
            Ok(value) => value,
            Err(Unwind::Exception(_)) => self.text.clone(),
            Err(Unwind::Stop) => return Flow::Raise(Unwind::Stop),
        };
        let place = &mut f.slots[self.annotations as usize];
        if place.is_unbound() {
            *place = Value::Dict(Rc::new(Dict::new()));
        }
        let annotations = place.clone();
        attempt!(ev.set_item(&annotations, &self.name, annotation));
        Flow::Next
    }
}
