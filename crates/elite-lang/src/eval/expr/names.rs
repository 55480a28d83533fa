//! Constants and variables.

use std::rc::Rc;

use elite_syntax::Span;

use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, ExprNode, Frame, TraceExt};
use crate::value::{CellVar, R, Symbol, Unwind, Value};

/// An operand whose value can be looked at without evaluating anything.
pub trait Readable {
    /// The value; `Unbound` if the variable is not bound.
    fn peek<'v>(&'v self, f: &'v Frame<'_>) -> &'v Value;

    /// The error for an unbound variable.
    fn check(&self, ev: &Evaluator<'_>, f: &Frame<'_>) -> R<()>;
}

/// A constant.
pub struct Const(pub Value);

impl Readable for Const {
    #[inline(always)]
    fn peek<'v>(&'v self, _: &'v Frame<'_>) -> &'v Value {
        &self.0
    }

    #[inline(always)]
    fn check(&self, _: &Evaluator<'_>, _: &Frame<'_>) -> R<()> {
        Ok(())
    }
}

impl ExprNode for Const {
    #[inline(always)]
    fn eval(&self, _: &Evaluator<'_>, _: &mut Frame<'_>) -> R {
        Ok(self.0.clone())
    }

    const HAS_TRY_LOAD: bool = true;

    #[inline(always)]
    fn try_load(&self, _: &Frame<'_>) -> Option<Value> {
        Some(self.0.clone())
    }
}

/// A local variable.
#[derive(Clone, Copy)]
pub struct LocalVar {
    /// The slot of the variable in the frame.
    pub slot: u32,
    /// The place in the text where the variable is read.
    pub span: Span,
}

impl Readable for LocalVar {
    #[inline(always)]
    fn peek<'v>(&'v self, f: &'v Frame<'_>) -> &'v Value {
        &f.slots[self.slot as usize]
    }

    #[inline(always)]
    fn check(&self, ev: &Evaluator<'_>, f: &Frame<'_>) -> R<()> {
        if f.slots[self.slot as usize].is_unbound() {
            return Err(unbound_local(ev, f, self.slot, self.span));
        }
        Ok(())
    }
}

impl ExprNode for LocalVar {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        match &f.slots[self.slot as usize] {
            Value::Unbound => Err(unbound_local(ev, f, self.slot, self.span)),
            value => Ok(value.clone()),
        }
    }

    #[inline(always)]
    fn truth(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<bool> {
        match &f.slots[self.slot as usize] {
            Value::Unbound => Err(unbound_local(ev, f, self.slot, self.span)),
            Value::Bool(flag) => Ok(*flag),
            Value::Instance(_) => {
                let value = f.slots[self.slot as usize].clone();
                ev.truth(&value).trace_at(ev, f, self.span)
            }
            value => ev.truth(value),
        }
    }

    const HAS_TRY_LOAD: bool = true;

    #[inline(always)]
    fn try_load(&self, f: &Frame<'_>) -> Option<Value> {
        match &f.slots[self.slot as usize] {
            Value::Unbound => None,
            value => Some(value.clone()),
        }
    }
}

#[cold]
#[inline(never)]
fn unbound_local(ev: &Evaluator<'_>, f: &Frame<'_>, slot: u32, span: Span) -> Unwind {
    let name = ev
        .core
        .symbols
        .name(f.function.code.slot_names[slot as usize]);
    let text =
        format!("cannot access local variable '{name}' where it is not associated with a value");
    ev.trace(f, span, ev.raise(ExceptionKind::UnboundLocalError, text))
}

/// A local variable that inner functions share.
pub struct LocalCell {
    /// The slot with the cell.
    pub slot: u32,
    /// The place in the text where the variable is read.
    pub span: Span,
}

impl ExprNode for LocalCell {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        if let Value::Cell(cell) = &f.slots[self.slot as usize]
            && let value = cell.value.borrow()
            && !value.is_unbound()
        {
            return Ok(value.clone());
        }
        Err(unbound_local(ev, f, self.slot, self.span))
    }
}

/// A variable of an outer function.
pub struct FreeVar {
    /// Index in the closure.
    pub index: u32,
    /// The place in the text where the variable is read.
    pub span: Span,
}

impl FreeVar {
    /// Where its value lies, if it is bound.
    ///
    /// # Safety
    /// The caller promises what `ScriptCell::get_unguarded` asks.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn reach<'v>(&'v self, f: &'v Frame<'_>) -> Option<&'v Value> {
        let cell = &f.function.closure[self.index as usize];
        // SAFETY: the caller's promise.
        unsafe { cell.value.get_unguarded() }.filter(|value| !value.is_unbound())
    }
}

impl ExprNode for FreeVar {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        match self.try_load(f) {
            Some(value) => Ok(value),
            None => Err(unbound_free(ev, f, self.index, self.span)),
        }
    }

    const HAS_TRY_LOAD: bool = true;

    #[inline(always)]
    fn try_load(&self, f: &Frame<'_>) -> Option<Value> {
        // SAFETY: copying a value counts one reference more and does nothing else.
        #[allow(unsafe_code)]
        unsafe { self.reach(f) }.cloned()
    }
}

#[cold]
#[inline(never)]
fn unbound_free(ev: &Evaluator<'_>, f: &Frame<'_>, index: u32, span: Span) -> Unwind {
    let name = ev
        .core
        .symbols
        .name(f.function.code.free_names[index as usize]);
    let text = format!(
        "cannot access free variable '{name}' where it is not associated with a value in enclosing scope"
    );
    ev.trace(f, span, ev.raise(ExceptionKind::NameError, text))
}

/// A global variable, or the builtin of that name while it is unbound.
pub struct GlobalVar {
    /// The global variable.
    pub cell: Rc<CellVar>,
    /// The builtin.
    pub builtin: Rc<CellVar>,
    /// The name.
    pub name: Symbol,
    /// The place in the text where the variable is read.
    pub span: Span,
}

impl GlobalVar {
    /// The variable's value; a `NameError` if nothing defines the name.
    #[inline]
    pub fn value(&self, ev: &Evaluator<'_>, f: &Frame<'_>) -> R {
        match self.try_load(f) {
            Some(value) => Ok(value),
            None => implicit_module_or_error(ev, f, self.name, self.span),
        }
    }

    /// Where its value lies, if it or the builtin of that name is bound.
    ///
    /// # Safety
    /// The caller promises what `ScriptCell::get_unguarded` asks.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn reach<'v>(&'v self, _: &'v Frame<'_>) -> Option<&'v Value> {
        // SAFETY: the caller's promise.
        unsafe {
            match self.cell.value.get_unguarded() {
                Some(value) if !value.is_unbound() => Some(value),
                _ => { self.builtin.value.get_unguarded() }.filter(|value| !value.is_unbound()),
            }
        }
    }
}

/// The value of a name that nothing defines: some modules are there without import.
#[cold]
#[inline(never)]
fn implicit_module_or_error(ev: &Evaluator<'_>, f: &Frame<'_>, name: Symbol, span: Span) -> R {
    if let Some(module) = crate::stdlib::implicit_module(ev, name)? {
        return Ok(module);
    }
    let name = ev.core.symbols.name(name);
    Err(ev.trace(
        f,
        span,
        ev.raise_about(
            ExceptionKind::NameError,
            format!("name '{name}' is not defined"),
            &name,
        ),
    ))
}

impl ExprNode for GlobalVar {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        self.value(ev, f)
    }

    const HAS_TRY_LOAD: bool = true;

    #[inline(always)]
    fn try_load(&self, f: &Frame<'_>) -> Option<Value> {
        // SAFETY: copying a value counts one reference more and does nothing else.
        #[allow(unsafe_code)]
        unsafe { self.reach(f) }.cloned()
    }
}

/// A name bound in a class body: its slot, or the global while that is unbound.
pub struct ClassBodyName {
    /// Slot of the class body.
    pub slot: u32,
    /// The global of that name.
    pub global: GlobalVar,
}

impl ExprNode for ClassBodyName {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        match &f.slots[self.slot as usize] {
            Value::Unbound => self.global.value(ev, f),
            value => Ok(value.clone()),
        }
    }
}

/// A name at the top level of a text that runs in a mapping of a script: what the mapping has, or the global.
pub struct MappingName {
    /// The slot with the mapping.
    pub slot: u32,
    /// The name.
    pub key: Value,
    /// The global of that name.
    pub global: GlobalVar,
}

impl ExprNode for MappingName {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let mapping = f.slots[self.slot as usize].clone();
        let found = match &mapping {
            Value::Dict(dict) => ev.dict_get(dict, &self.key),
            other => ev.item_or_none(other, &self.key),
        };
        match found.trace_at(ev, f, self.global.span)? {
            Some(value) => Ok(value),
            None => self.global.value(ev, f),
        }
    }
}

impl Evaluator<'_> {
    /// The item of a mapping; None if it says `KeyError`.
    fn item_or_none(&self, mapping: &Value, key: &Value) -> R<Option<Value>> {
        match self.item(mapping, key) {
            Ok(value) => Ok(Some(value)),
            Err(raised) if self.is_kind(&raised, ExceptionKind::KeyError) => Ok(None),
            Err(raised) => Err(raised),
        }
    }
}

/// `name := value`
pub struct NamedExpr {
    /// What is bound.
    pub target: Box<dyn crate::eval::stmt::target::Target>,
    /// To what.
    pub value: crate::eval::BoxExpr,
}

impl ExprNode for NamedExpr {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let value = self.value.eval(ev, f)?;
        self.target.assign(ev, f, value.clone())?;
        Ok(value)
    }
}
