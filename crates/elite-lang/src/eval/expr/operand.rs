//! Parts of nodes that are most often a local variable or a constant: those are read in place, without a further node.

use super::attribute::Attribute;
use super::item::Item;
use super::names::{Const, FreeVar, GlobalVar, LocalVar, Readable};
use crate::eval::{BoxExpr, DynExpr, Evaluator, ExprNode, Frame};
use crate::value::{CellVar, R, Value};

/// A part of a node, as `lower` found it.
pub enum Operand {
    /// A local variable.
    Local(LocalVar),
    /// A constant.
    Const(Value),
    /// A variable of an outer function.
    Free(FreeVar),
    /// A global variable.
    Global(GlobalVar),
    /// An attribute.
    Attribute(Box<Attribute>),
    /// An item of a container.
    Item(Box<Item>),
    /// Anything else.
    Expr(BoxExpr),
}

impl Operand {
    /// Makes a boxed expression of the operand.
    pub fn into_expr(self) -> BoxExpr {
        match self {
            Operand::Local(local) => Box::new(local),
            Operand::Const(value) => Box::new(Const(value)),
            Operand::Free(free) => Box::new(free),
            Operand::Global(global) => Box::new(global),
            Operand::Attribute(attribute) => attribute,
            Operand::Item(item) => item,
            Operand::Expr(expr) => expr,
        }
    }

    /// Evaluates the operand.
    #[inline(always)]
    pub fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        match self {
            Operand::Local(local) => local.eval(ev, f),
            Operand::Const(value) => Ok(value.clone()),
            Operand::Free(free) => free.eval_words(ev, f).whole(),
            Operand::Global(global) => global.eval_words(ev, f).whole(),
            Operand::Attribute(attribute) => attribute.eval_words(ev, f).whole(),
            Operand::Item(item) => item.eval_words(ev, f).whole(),
            Operand::Expr(expr) => expr.eval(ev, f),
        }
    }

    /// Evaluates the operand and asks for its truth.
    #[inline(always)]
    pub fn truth(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<bool> {
        match self {
            Operand::Local(local) => local.truth_words(ev, f).into(),
            Operand::Const(value) => ev.truth(value),
            Operand::Free(free) => free.truth_words(ev, f).into(),
            Operand::Global(global) => global.truth_words(ev, f).into(),
            Operand::Attribute(attribute) => attribute.truth_words(ev, f).into(),
            Operand::Item(item) => item.truth_words(ev, f).into(),
            Operand::Expr(expr) => expr.truth(ev, f),
        }
    }

    /// The operand for use where others may change variables meanwhile: such variables are boxed as expressions.
    pub fn without_cells(self) -> Operand {
        match self {
            Operand::Free(_) | Operand::Global(_) | Operand::Attribute(_) | Operand::Item(_) => {
                Operand::Expr(self.into_expr())
            }
            Operand::Local(_) | Operand::Const(_) | Operand::Expr(_) => self,
        }
    }

    /// The value of a local variable or a constant, found without evaluating anything; `Unbound` if it is not bound.
    #[inline(always)]
    pub fn peek<'v>(&'v self, f: &'v Frame<'_>) -> Option<&'v Value> {
        match self {
            Operand::Local(local) => Some(local.peek(f)),
            Operand::Const(value) => Some(value),
            Operand::Free(_)
            | Operand::Global(_)
            | Operand::Attribute(_)
            | Operand::Item(_)
            | Operand::Expr(_) => None,
        }
    }

    /// The value of a local variable or a constant, found without evaluating anything, if it is bound.
    #[inline(always)]
    pub fn bound_ref<'v>(&'v self, f: &'v Frame<'_>) -> Option<&'v Value> {
        self.peek(f).filter(|value| !value.is_unbound())
    }

    /// Where its value lies, if that is found without evaluating anything and it is bound.
    ///
    /// # Safety
    /// The caller promises what `ScriptCell::get_unguarded` asks: while the reference is in use values are only read
    /// and copied.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub unsafe fn value_ref<'v>(&'v self, f: &'v Frame<'_>) -> Option<&'v Value> {
        // SAFETY: the caller's promise.
        unsafe {
            match self {
                Operand::Local(local) => Some(local.peek(f)).filter(|value| !value.is_unbound()),
                Operand::Const(value) => Some(value),
                Operand::Free(free) => free.reach(f),
                Operand::Global(global) => global.reach(f),
                Operand::Attribute(attribute) => attribute.reach(f),
                Operand::Item(item) => item.reach(f),
                Operand::Expr(_) => None,
            }
        }
    }

    /// What `with_value` makes of the value of a variable, a constant, an attribute that lies in an instance or an item
    /// of a list or tuple, which is not copied; None for anything else. No script code may run meanwhile, and the list
    /// that an item is from must not be changed.
    #[inline(always)]
    pub fn with_value<T>(&self, f: &Frame<'_>, look: impl FnOnce(&Value) -> T) -> Option<T> {
        match self {
            Operand::Local(local) => Some(look(local.peek(f))),
            Operand::Const(value) => Some(look(value)),
            Operand::Free(free) => {
                let cell = &f.function.closure[free.index as usize];
                Some(look(&cell.value.borrow()))
            }
            Operand::Global(global) => {
                let value = global.cell.value.borrow();
                Some(match value.is_unbound() {
                    false => look(&value),
                    true => look(&global.builtin.value.borrow()),
                })
            }
            Operand::Attribute(attribute) => attribute.look(f, look),
            Operand::Item(item) => {
                let (mut look, mut seen) = (Some(look), None);
                item.show(f, &mut |value| seen = look.take().map(|look| look(value)));
                seen
            }
            Operand::Expr(_) => None,
        }
    }

    /// What `look` makes of the value of a variable, a constant or an attribute that lies in an instance; None for an
    /// item or any other expression. No script code may run meanwhile.
    #[inline(always)]
    pub fn with_variable<T>(&self, f: &Frame<'_>, look: impl FnOnce(&Value) -> T) -> Option<T> {
        match self {
            Operand::Item(_) | Operand::Expr(_) => None,
            near => near.with_value(f, look),
        }
    }

    /// A copy of its value, if that can be looked at without evaluating anything and is bound.
    #[inline]
    pub fn try_clone(&self, f: &Frame<'_>) -> Option<Value> {
        // SAFETY: copying a value counts one reference more and does nothing else.
        #[allow(unsafe_code)]
        unsafe { self.value_ref(f) }.cloned()
    }

    /// The variable of an outer function or of the module that it is; its value may be `Unbound`.
    #[inline(always)]
    pub fn shared<'v>(&'v self, f: &'v Frame<'_>) -> Option<&'v CellVar> {
        match self {
            Operand::Free(free) => Some(&f.function.closure[free.index as usize]),
            Operand::Global(global) => Some(&global.cell),
            Operand::Local(_)
            | Operand::Const(_)
            | Operand::Attribute(_)
            | Operand::Item(_)
            | Operand::Expr(_) => None,
        }
    }
}

/// Whatever kind it is of.
impl ExprNode for Operand {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        Operand::eval(self, ev, f)
    }
}

/// Makes a node of an operand, of a type of its own for each kind: nothing is left to ask then when the node runs.
macro_rules! by_operand {
    ($operand:expr, $value:ident => $node:expr) => {
        match $operand {
            $crate::eval::expr::operand::Operand::Local($value) => $node,
            $crate::eval::expr::operand::Operand::Const(value) => {
                let $value = $crate::eval::expr::names::Const(value);
                $node
            }
            $crate::eval::expr::operand::Operand::Free($value) => $node,
            $crate::eval::expr::operand::Operand::Global($value) => $node,
            $crate::eval::expr::operand::Operand::Attribute(value) => {
                let $value = *value;
                $node
            }
            $crate::eval::expr::operand::Operand::Item(value) => {
                let $value = *value;
                $node
            }
            $crate::eval::expr::operand::Operand::Expr($value) => $node,
        }
    };
}
pub(crate) use by_operand;

/// Declares a node of two operands by their kinds, for an operator as a type, with a constructor.
macro_rules! two_operands {
    ($(#[$doc:meta])* $name:ident<$op:ident $(, $kind:ident)*> { left: $left:ty, right: $right:ty }) => {
        $(#[$doc])*
        struct $name<$op $(, $kind)*> {
            left: $left,
            right: $right,
            span: Span,
            op: PhantomData<$op>,
        }

        impl<$op $(, $kind)*> $name<$op $(, $kind)*> {
            fn boxed(left: $left, right: $right, span: Span) -> Box<Self> {
                Box::new($name { left, right, span, op: PhantomData })
            }
        }
    };
}
pub(crate) use two_operands;
