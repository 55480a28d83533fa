//! Assignments.

use std::marker::PhantomData;
use std::rc::Rc;

use elite_syntax::Span;
use elite_syntax::ast::BinaryOp;

use super::target::{AttributeTarget, ItemTarget, LocalOrTarget, Target, Unpack};
use crate::eval::expr::binary::{Operator, op};
use crate::eval::expr::names::{Const, LocalVar, Readable};
use crate::eval::expr::operand::{Operand, by_operand};
use crate::eval::run::with_slots;
use crate::eval::words::{PairOf, next_dropping};
use crate::eval::{
    BoxExpr, DynStmt, Evaluator, ExprNode, Flow, Frame, StmtNode, TraceExt, attempt,
};
use crate::limits::deferred_drop::NodeList;
use crate::ops::arith::fast;
use crate::value::{List, R, Value};

/// `name = value` for a local name, by what the value is.
pub struct AssignLocal<V> {
    slot: u32,
    value: V,
}

impl<V: ExprNode> StmtNode for AssignLocal<V> {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        if !V::HAS_TRY_LOAD {
            return self.exec_general(ev, f);
        }
        match self.value.try_load(f) {
            Some(value) => {
                next_dropping(std::mem::replace(&mut f.slots[self.slot as usize], value))
            }
            None => self.evaluate(ev, f).whole(),
        }
    }
}

impl<V: ExprNode> AssignLocal<V> {
    #[inline(never)]
    fn evaluate(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> PairOf<Flow> {
        PairOf::pack(self.exec_general(ev, f))
    }

    #[inline(always)]
    fn exec_general(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let value = attempt!(self.value.eval(ev, f));
        next_dropping(std::mem::replace(&mut f.slots[self.slot as usize], value))
    }
}

/// The statement `name = value` for a local name.
pub fn assign_local(slot: u32, value: Operand) -> Box<dyn DynStmt> {
    by_operand!(value, value => Box::new(AssignLocal { slot, value }))
}

/// `a = b = value`
pub struct Assign {
    /// The targets, left to right.
    pub targets: NodeList<Box<dyn Target>>,
    /// The value.
    pub value: Operand,
}

impl StmtNode for Assign {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let value = attempt!(self.value.eval(ev, f));
        let Some((last, before)) = self.targets.split_last() else {
            return Flow::Next;
        };
        for target in before {
            attempt!(target.assign(ev, f, value.clone()));
        }
        last.assign(ev, f, value).into()
    }
}

/// Two targets that are assigned to at once.
trait PairTarget {
    /// Puts the values there.
    fn assign(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, values: (Value, Value)) -> Flow;
}

/// Any targets, in turn.
impl PairTarget for [LocalOrTarget; 2] {
    #[inline(always)]
    fn assign(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, values: (Value, Value)) -> Flow {
        attempt!(self[0].assign(ev, f, values.0));
        self[1].assign(ev, f, values.1).into()
    }
}

/// Two local names: the last one first, as CPython does.
struct ReversedSlots([u32; 2]);

impl PairTarget for ReversedSlots {
    #[inline(always)]
    fn assign(&self, _: &Evaluator<'_>, f: &mut Frame<'_>, values: (Value, Value)) -> Flow {
        let [first, second] = self.0.map(|slot| slot as usize);
        f.slots[second].put(values.1);
        f.slots[first].put(values.0);
        Flow::Next
    }
}

/// `a, b = x, y`: the values are taken first, no tuple is made.
struct AssignPair<T, V, W> {
    targets: T,
    values: (V, W),
}

impl<T: PairTarget, V: ExprNode, W: ExprNode> StmtNode for AssignPair<T, V, W> {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let first = attempt!(self.values.0.eval(ev, f));
        let second = attempt!(self.values.1.eval(ev, f));
        self.targets.assign(ev, f, (first, second))
    }
}

/// `a, b = b, a` for two local names.
struct SwapLocals {
    slots: [u32; 2],
    /// The general form of the statement, for names that are not bound.
    pair: AssignPair<ReversedSlots, LocalVar, LocalVar>,
}

impl StmtNode for SwapLocals {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let [a, b] = self.slots.map(|slot| slot as usize);
        if f.slots[a].is_unbound() || f.slots[b].is_unbound() {
            return self.pair.exec_words(ev, f).whole();
        }
        f.slots.swap(a, b);
        Flow::Next
    }
}

/// The statement `a, b = x, y`.
pub fn assign_pair(targets: [LocalOrTarget; 2], values: (Operand, Operand)) -> Box<dyn DynStmt> {
    by_values(targets, values)
}

/// The statement `a, b = x, y` for the local names in two slots, of which the last one is assigned to first.
pub fn assign_last_first(slots: [u32; 2], values: (Operand, Operand)) -> Box<dyn DynStmt> {
    let targets = ReversedSlots(slots);
    match values {
        (Operand::Local(a), Operand::Local(b)) if slots == [b.slot, a.slot] => {
            Box::new(SwapLocals {
                slots,
                pair: AssignPair {
                    targets,
                    values: (a, b),
                },
            })
        }
        values => by_values(targets, values),
    }
}

/// A node of its own for the commonest kinds of values.
fn by_values(targets: impl PairTarget + 'static, values: (Operand, Operand)) -> Box<dyn DynStmt> {
    use Operand::{Expr, Local};
    match values {
        (Local(a), Local(b)) => Box::new(AssignPair {
            targets,
            values: (a, b),
        }),
        (Local(a), Expr(b)) => Box::new(AssignPair {
            targets,
            values: (a, b),
        }),
        (Expr(a), Local(b)) => Box::new(AssignPair {
            targets,
            values: (a, b),
        }),
        values => Box::new(AssignPair { targets, values }),
    }
}

/// `a, b = value` for `N` local names: the items of a tuple or list of as many are put there without a detour.
pub struct AssignItems<const N: usize> {
    /// The slots of the names.
    pub slots: [u32; N],
    /// What is unpacked.
    pub value: Operand,
    /// The names as targets of the general form, for any other value.
    pub targets: Unpack,
}

impl<const N: usize> StmtNode for AssignItems<N> {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        if let Operand::Local(local) = &self.value
            && self.take_apart(local, f)
        {
            return Flow::Next;
        }
        self.evaluate(ev, f).whole()
    }
}

impl<const N: usize> AssignItems<N> {
    /// Unpacks a tuple of as many items in a local variable; whether it is one, and another variable than those it goes
    /// to.
    #[inline(always)]
    fn take_apart(&self, local: &LocalVar, f: &mut Frame<'_>) -> bool {
        let Value::Tuple(tuple) = local.peek(f) else {
            return false;
        };
        let items: *const [Value] = tuple.items();
        if items.len() != N || self.slots.contains(&local.slot) {
            return false;
        }
        // SAFETY: the variable keeps the tuple as long as nothing else is put there, and nobody but this statement has
        // the frame's variables. A tuple never changes.
        #[allow(unsafe_code)]
        let items = unsafe { &*items };
        self.put(items, f);
        true
    }

    /// Unpacks something else.
    #[inline(never)]
    fn evaluate(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> PairOf<Flow> {
        PairOf::pack(self.evaluated(ev, f))
    }

    #[inline(always)]
    fn evaluated(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let value = attempt!(self.value.eval(ev, f));
        match &value {
            Value::Tuple(tuple) if tuple.items().len() == N => self.put(tuple.items(), f),
            Value::List(list) => match items_of::<N>(list) {
                Some(items) => self.put(&items, f),
                None => return self.targets.assign(ev, f, value).into(),
            },
            _ => return self.targets.assign(ev, f, value).into(),
        }
        value.drop_inline();
        Flow::Next
    }

    #[inline(always)]
    fn put(&self, items: &[Value], f: &mut Frame<'_>) {
        for (slot, item) in self.slots.iter().zip(items) {
            f.slots[*slot as usize].put(item.clone());
        }
    }
}

/// The items of a list of that many. All are taken before the first is put anywhere: what leaves there may change the
/// list.
#[inline]
fn items_of<const N: usize>(list: &List) -> Option<[Value; N]> {
    let items = list.borrow();
    let items: &[Value; N] = items.as_slice().try_into().ok()?;
    Some(items.clone())
}

/// `a, b, c, … = x, y, z, …`: the values are taken first, no tuple is made.
pub struct AssignTargets {
    /// The targets.
    pub targets: Box<[LocalOrTarget]>,
    /// The values, one for each target.
    pub values: Box<[Operand]>,
    /// The last target is assigned to first.
    pub last_first: bool,
}

impl StmtNode for AssignTargets {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let done = with_slots(self.values.len(), |places| {
            for (place, value) in places.iter_mut().zip(&self.values) {
                place.fill(value.eval(ev, f)?);
            }
            let mut assign = |(target, value): (&LocalOrTarget, &mut Value)| {
                target.assign(ev, f, std::mem::take(value))
            };
            let mut pairs = self.targets.iter().zip(places);
            match self.last_first {
                true => pairs.rev().try_for_each(&mut assign),
                false => pairs.try_for_each(&mut assign),
            }
        });
        done.into()
    }
}

/// `object.name = value`, by what the value is.
struct AssignAttribute<V> {
    target: AttributeTarget,
    value: V,
}

impl<V: ExprNode> StmtNode for AssignAttribute<V> {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        if !V::HAS_TRY_LOAD {
            return self.evaluated(ev, f);
        }
        if let Operand::Local(local) = &self.target.value
            && let Value::Instance(instance) = local.peek(f)
            && let Some(value) = self.value.try_load(f)
        {
            return match self.target.replace_at_once(instance, value) {
                Ok(old) => next_dropping(old),
                Err(value) => self.assign(PairOf::pack(value), ev, f).whole(),
            };
        }
        self.evaluate(ev, f).whole()
    }
}

impl<V: ExprNode> AssignAttribute<V> {
    #[inline(never)]
    fn evaluate(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> PairOf<Flow> {
        PairOf::pack(self.evaluated(ev, f))
    }

    #[inline(always)]
    fn evaluated(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let value = attempt!(self.value.eval(ev, f));
        if let Operand::Local(local) = &self.target.value
            && let Value::Instance(instance) = local.peek(f)
        {
            return match self.target.replace_at_once(instance, value) {
                Ok(old) => next_dropping(old),
                Err(value) => self.assign(PairOf::pack(value), ev, f).whole(),
            };
        }
        self.assign(PairOf::pack(value), ev, f).whole()
    }

    #[inline(never)]
    fn assign(&self, value: PairOf<Value>, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> PairOf<Flow> {
        PairOf::pack(self.target.assign(ev, f, value.whole()).into())
    }
}

/// The statement `object.name = value`.
pub fn assign_attribute(target: AttributeTarget, value: Operand) -> Box<dyn DynStmt> {
    by_operand!(value, value => Box::new(AssignAttribute { target, value }))
}

/// `container[index] = value`, by what the value is.
struct AssignItem<V> {
    target: ItemTarget,
    value: V,
}

impl<V: ExprNode> StmtNode for AssignItem<V> {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let value = attempt!(self.value.eval(ev, f));
        if let Some(Value::Int(at)) = self.target.index.peek(f)
            && let Operand::Local(local) = &self.target.value
            && let Value::List(list) = local.peek(f)
            && (list.gc_tracked.get() || !value.can_hold_values())
        {
            return match list.replace_at(*at, value) {
                Ok(old) => {
                    old.drop_inline();
                    Flow::Next
                }
                Err(value) => self.target.assign_words(ev, f, PairOf::pack(value)).into(),
            };
        }
        self.target.assign_words(ev, f, PairOf::pack(value)).into()
    }
}

/// The statement `container[index] = value`.
pub fn assign_item(target: ItemTarget, value: Operand) -> Box<dyn DynStmt> {
    by_operand!(value, value => Box::new(AssignItem { target, value }))
}

/// `name op= value` for a local name, the value being something that can be looked at.
struct AugLocalPeek<O, B> {
    slot: u32,
    value: B,
    span: Span,
    local: crate::eval::expr::names::LocalVar,
    op: PhantomData<O>,
}

impl<O: Operator, B: Readable> StmtNode for AugLocalPeek<O, B> {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let slot = self.slot as usize;
        if let Some(value) = fast(O::OP, &f.slots[slot], self.value.peek(f)) {
            f.slots[slot].put(value);
            return Flow::Next;
        }
        attempt!(self.local.check(ev, f));
        attempt!(self.value.check(ev, f));
        let value = self.value.peek(f).clone();
        slow_local(O::OP, slot, &value, ev, f, self.span).into()
    }
}

/// `name op= value` for a local name.
struct AugLocal<O> {
    slot: u32,
    value: BoxExpr,
    span: Span,
    local: crate::eval::expr::names::LocalVar,
    op: PhantomData<O>,
}

impl<O: Operator> StmtNode for AugLocal<O> {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let slot = self.slot as usize;
        attempt!(self.local.check(ev, f));
        let value = attempt!(self.value.eval(ev, f));
        if let Some(value) = fast(O::OP, &f.slots[slot], &value) {
            f.slots[slot].put(value);
            return Flow::Next;
        }
        slow_local(O::OP, slot, &value, ev, f, self.span).into()
    }
}

fn slow_local(
    op: BinaryOp,
    slot: usize,
    value: &Value,
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
    span: Span,
) -> R<()> {
    if let (BinaryOp::Add, Value::Str(text), Value::Str(more)) = (op, &mut f.slots[slot], value) {
        // A string that only this variable refers to grows in place.
        if let Some(text) = Rc::get_mut(text) {
            ev.check_allocation(text.as_str().len() + more.as_str().len())?;
            text.push_str(more);
            return Ok(());
        }
    }
    let old = f.slots[slot].clone();
    let new = ev.binary_in_place(op, &old, value).trace_at(ev, f, span)?;
    f.slots[slot] = new;
    Ok(())
}

/// The statement `name op= value` for a local name.
pub fn augmented_local(
    binary: BinaryOp,
    slot: u32,
    value: Operand,
    target: Span,
    span: Span,
) -> Box<dyn DynStmt> {
    macro_rules! pick {
        ($($name:ident),*) => {
            match binary {
                $(BinaryOp::$name => specialize::<op::$name>(slot, value, target, span),)*
            }
        };
    }
    pick!(
        Add, Sub, Mul, Div, FloorDiv, Mod, Pow, MatMul, BitAnd, BitOr, BitXor, Shl, Shr
    )
}

fn specialize<O: Operator>(
    slot: u32,
    value: Operand,
    target: Span,
    span: Span,
) -> Box<dyn DynStmt> {
    let local = crate::eval::expr::names::LocalVar { slot, span: target };
    let op = PhantomData::<O>;
    match value {
        Operand::Local(value) => Box::new(AugLocalPeek {
            slot,
            value,
            span,
            local,
            op,
        }),
        Operand::Const(value) => Box::new(AugLocalPeek {
            slot,
            value: Const(value),
            span,
            local,
            op,
        }),
        other => Box::new(AugLocal {
            slot,
            value: other.into_expr(),
            span,
            local,
            op,
        }),
    }
}

/// `name op= value` for any other name.
pub struct AugName {
    /// Reads the name.
    pub read: Operand,
    /// Writes it.
    pub target: Box<dyn Target>,
    /// The operator.
    pub op: BinaryOp,
    /// The right operand.
    pub value: Operand,
    /// The place in the text.
    pub span: Span,
}

impl StmtNode for AugName {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let old = attempt!(self.read.eval(ev, f));
        let value = attempt!(self.value.eval(ev, f));
        let new = attempt!(combine(self.op, &old, &value, ev, f, self.span));
        self.target.assign(ev, f, new).into()
    }
}

/// `object.name op= value`
pub struct AugAttribute {
    /// The attribute.
    pub target: AttributeTarget,
    /// What is known about reading it.
    pub cache: crate::eval::expr::attribute::InlineCache,
    /// The operator.
    pub op: BinaryOp,
    /// The right operand.
    pub value: Operand,
    /// Evaluating the right operand leaves local variables as they are.
    pub preserves_locals: bool,
    /// The place in the text.
    pub span: Span,
}

impl StmtNode for AugAttribute {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        if let (Operand::Local(local), true) = (&self.target.value, self.preserves_locals) {
            attempt!(local.check(ev, f));
            let old = attempt!(self.read(ev, f, local.peek(f)));
            let value = attempt!(self.value.eval(ev, f));
            let new = attempt!(combine(self.op, &old, &value, ev, f, self.span));
            return self.target.set(ev, f, local.peek(f), new).into();
        }
        let object = attempt!(self.target.value.eval(ev, f));
        let old = attempt!(self.read(ev, f, &object));
        let value = attempt!(self.value.eval(ev, f));
        let new = attempt!(combine(self.op, &old, &value, ev, f, self.span));
        self.target.set(ev, f, &object, new).into()
    }
}

impl AugAttribute {
    #[inline]
    fn read(&self, ev: &Evaluator<'_>, f: &Frame<'_>, object: &Value) -> R {
        if let Some(found) = self.cache.read(object) {
            return Ok(found);
        }
        if let Value::Instance(instance) = object
            && self.cache.get(instance.class.version()).is_none()
        {
            self.cache.learn(&instance.class, self.target.name);
        }
        ev.attribute(object, self.target.name)
            .trace_at(ev, f, self.target.span)
    }
}

/// `old op= value`
#[inline]
fn combine(
    op: BinaryOp,
    old: &Value,
    value: &Value,
    ev: &Evaluator<'_>,
    f: &Frame<'_>,
    span: Span,
) -> R {
    match fast(op, old, value) {
        Some(new) => Ok(new),
        None => ev.binary_in_place(op, old, value).trace_at(ev, f, span),
    }
}

/// `container[index] op= value`
pub struct AugItem {
    /// The container.
    pub container: Operand,
    /// The index.
    pub index: Operand,
    /// The operator.
    pub op: BinaryOp,
    /// The right operand.
    pub value: Operand,
    /// Evaluating the index and the right operand leaves local variables as they are.
    pub keeps: bool,
    /// Where the item is written.
    pub item_span: Span,
    /// Where the statement is written.
    pub span: Span,
}

impl StmtNode for AugItem {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        if let (Operand::Local(local), true) = (&self.container, self.keeps) {
            attempt!(local.check(ev, f));
            let index = attempt!(self.index.eval(ev, f));
            let old = attempt!(
                ev.item(local.peek(f), &index)
                    .trace_at(ev, f, self.item_span)
            );
            let value = attempt!(self.value.eval(ev, f));
            let new = attempt!(combine(self.op, &old, &value, ev, f, self.span));
            let set = ev.set_item(local.peek(f), &index, new);
            return set.trace_at(ev, f, self.item_span).into();
        }
        let container = attempt!(self.container.eval(ev, f));
        let index = attempt!(self.index.eval(ev, f));
        let old = attempt!(ev.item(&container, &index).trace_at(ev, f, self.item_span));
        let value = attempt!(self.value.eval(ev, f));
        let new = attempt!(combine(self.op, &old, &value, ev, f, self.span));
        ev.set_item(&container, &index, new)
            .trace_at(ev, f, self.item_span)
            .into()
    }
}
