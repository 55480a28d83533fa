//! Calls with stars, and what the arguments of any call mean: gathering them as Python does, with its messages.

use std::collections::HashSet;

use elite_syntax::Span;
use smallvec::SmallVec;

use crate::errors::ExceptionKind;
use crate::eval::{BoxExpr, Evaluator, ExprNode, Frame, TraceExt};
use crate::limits::deferred_drop::NodeList;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::symbol::{TempSymbol, known};
use crate::value::{Dict, R, Symbol, Unwind, Value, ValueVec};

/// An argument of a call with stars or keywords.
pub enum CallArg {
    /// By position.
    Positional(BoxExpr),
    /// `*iterable`
    Star(BoxExpr),
    /// By name.
    Keyword(Symbol, BoxExpr),
    /// `**mapping`
    DoubleStar(BoxExpr),
}

/// A call with stars or keywords.
pub struct CallUnpacked {
    /// What is called.
    pub function: BoxExpr,
    /// With what, in the order of the text.
    pub args: NodeList<CallArg>,
    /// The place in the text.
    pub span: Span,
}

impl ExprNode for CallUnpacked {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let callee = self.function.eval(ev, f)?;
        if let [before @ .., CallArg::Star(last)] = &*self.args
            && before
                .iter()
                .all(|arg| matches!(arg, CallArg::Positional(_)))
        {
            return self.forward(&callee, before, last, ev, f);
        }
        let mut positional = ValueVec::from(Vec::with_capacity(self.args.len()));
        let (mut keywords, mut names) = (ValueVec::default(), Vec::new());
        let gathered = gather(
            &self.args,
            &callee,
            ev,
            f,
            self.span,
            &mut positional,
            &mut keywords,
            &mut names,
        );
        let result = gathered.and_then(|()| {
            ev.call_from(&callee, &mut positional, &keywords, Some(&mut *f))
                .trace_at(ev, f, self.span)
        });
        // Many names are forgotten bit by bit.
        for name in names {
            drop(name);
            ev.charge(4 * WORK_PER_VALUE)?;
        }
        result
    }
}

/// Arguments by position that are most often few.
type InlineArgs = SmallVec<[Value; 8]>;

impl CallUnpacked {
    /// `callee(a, b, *last)`
    #[inline(never)]
    fn forward(
        &self,
        callee: &Value,
        before: &[CallArg],
        last: &BoxExpr,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
    ) -> R {
        let mut args = InlineArgs::new();
        for arg in before {
            if let CallArg::Positional(expr) = arg {
                args.push(expr.eval(ev, f)?);
            }
        }
        let iterable = last.eval(ev, f)?;
        if !extend_at_once(&iterable, |items| args.extend(items.iter().cloned())) {
            let items =
                collect(&iterable, before.is_empty(), callee, ev).trace_at(ev, f, self.span)?;
            let mut args = ValueVec::from(args.into_vec());
            ev.append_values(items, &mut args)
                .trace_at(ev, f, self.span)?;
            let result = ev.call_from(callee, &mut args, &[], Some(&mut *f));
            return result.trace_at(ev, f, self.span);
        }
        iterable.drop_inline();
        if let Value::Function(function) = callee {
            return ev
                .call_function(function, &mut args, &[])
                .trace_at(ev, f, self.span);
        }
        ev.call_from(callee, &mut args, &[], Some(&mut *f))
            .trace_at(ev, f, self.span)
    }
}

/// Hands the items of a short tuple or list over; whether it is one.
#[inline]
fn extend_at_once(iterable: &Value, extend: impl FnOnce(&[Value])) -> bool {
    match iterable {
        Value::Tuple(tuple) if tuple.items().len() <= UNPACK_CHUNK => extend(tuple.items()),
        Value::List(list) if list.len() <= UNPACK_CHUNK => extend(&list.borrow()),
        _ => return false,
    }
    true
}

/// The items of `*iterable`; `single` if there are no other arguments by position.
fn collect(iterable: &Value, single: bool, callee: &Value, ev: &Evaluator<'_>) -> R<ValueVec> {
    ev.collect(iterable).map_err(|raised| {
        let raised = ev.not_unpackable(raised, iterable);
        let is_none = !ev.has_iteration(iterable);
        if single && is_none && ev.is_kind(&raised, ExceptionKind::TypeError) {
            let (label, name) = (ev.callee_label(callee), ev.core.types.name_of(iterable));
            return ev.type_error(format!(
                "{label} argument after * must be an iterable, not {name}"
            ));
        }
        raised
    })
}

/// Longest tuple or list whose items are copied at once, without an iterator.
const UNPACK_CHUNK: usize = 64;

/// Evaluates arguments with stars and keywords; `names` keeps the names of the keywords while they are in use. `callee`
/// is only for messages.
#[allow(clippy::too_many_arguments)] // three of them are results
pub fn gather<'e>(
    args: &[CallArg],
    callee: &Value,
    ev: &'e Evaluator<'_>,
    f: &mut Frame<'_>,
    span: Span,
    positional: &mut Vec<Value>,
    keywords: &mut Vec<(Symbol, Value)>,
    names: &mut Vec<TempSymbol<'e>>,
) -> R<()> {
    let single = args
        .iter()
        .filter(|arg| matches!(arg, CallArg::Positional(_) | CallArg::Star(_)))
        .count()
        == 1;
    let unpack = |iterable: Value, positional: &mut Vec<Value>| {
        if extend_at_once(&iterable, |items| positional.extend_from_slice(items)) {
            return Ok(());
        }
        let items = collect(&iterable, single, callee, ev)?;
        ev.append_values(items, positional)
    };
    // Arguments by position come before those by name, also where the text has them behind. A single one with a star is
    // evaluated in its turn, but gone through last.
    let (mut alone, mut are_names) = (None, true);
    for arg in args {
        match arg {
            CallArg::Positional(expr) => positional.push(expr.eval(ev, f)?),
            CallArg::Star(expr) if single => alone = Some(expr.eval(ev, f)?),
            CallArg::Star(expr) => {
                let iterable = expr.eval(ev, f)?;
                unpack(iterable, positional).trace_at(ev, f, span)?;
            }
            CallArg::Keyword(..) | CallArg::DoubleStar(_) => {}
        }
    }
    for arg in args {
        match arg {
            CallArg::Positional(_) | CallArg::Star(_) => {}
            CallArg::Keyword(name, expr) => {
                let value = expr.eval(ev, f)?;
                add_keyword(*name, value, callee, ev, keywords).trace_at(ev, f, span)?;
            }
            CallArg::DoubleStar(expr) => {
                let mapping = expr.eval(ev, f)?;
                are_names &=
                    gather_mapping(&mapping, callee, ev, keywords, names).trace_at(ev, f, span)?;
            }
        }
    }
    if let Some(iterable) = alone {
        unpack(iterable, positional).trace_at(ev, f, span)?;
    }
    match are_names {
        true => Ok(()),
        false => Err(ev.type_error("keywords must be strings")).trace_at(ev, f, span),
    }
}

/// Adds what a mapping holds to the arguments by name; whether all its keys were names.
fn gather_mapping<'e>(
    mapping: &Value,
    callee: &Value,
    ev: &'e Evaluator<'_>,
    keywords: &mut Vec<(Symbol, Value)>,
    names: &mut Vec<TempSymbol<'e>>,
) -> R<bool> {
    let dict = Dict::new();
    ev.merge_mapping(&dict, mapping).map_err(|raised| {
        let no_mapping = match mapping {
            Value::Instance(instance) => {
                !matches!(instance.builtin_value(), Some(Value::Dict(_)))
                    && instance.class.lookup(known::KEYS).is_none()
            }
            _ => true,
        };
        // An attribute that is missing on the way says that there is no mapping, as in CPython.
        let lacks = ev.is_kind(&raised, ExceptionKind::AttributeError)
            && !matches!(ev.unwrap_builtin(mapping), Value::Dict(_));
        if lacks || ev.is_kind(&raised, ExceptionKind::TypeError) && no_mapping {
            let (label, name) = (ev.callee_label(callee), ev.core.types.name_of(mapping));
            return ev.type_error(format!(
                "{label} argument after ** must be a mapping, not {name}"
            ));
        }
        raised
    })?;
    let (mut given, mut are_texts) = (KeywordSet::default(), true);
    for (_, key, value) in ev.collect_entries(&dict)? {
        ev.charge(WORK_PER_KEYWORD)?;
        let Value::Str(text) = ev.unwrap_builtin(&key) else {
            are_texts = false;
            continue;
        };
        let name = ev.temp_symbol(text.as_str())?;
        if given.has(*name, keywords) {
            return Err(given_twice(*name, callee, ev));
        }
        keywords.push((*name, value));
        names.push(name);
    }
    Ok(are_texts)
}

fn add_keyword(
    name: Symbol,
    value: Value,
    callee: &Value,
    ev: &Evaluator<'_>,
    keywords: &mut Vec<(Symbol, Value)>,
) -> R<()> {
    if keywords.iter().any(|(other, _)| *other == name) {
        return Err(given_twice(name, callee, ev));
    }
    keywords.push((name, value));
    Ok(())
}

/// Work for a name that is given in a mapping.
const WORK_PER_KEYWORD: usize = 16 * WORK_PER_VALUE;
/// Most names that are looked through one by one; more of them are kept in a table.
const LINEAR_SCAN_MAX: usize = 16;

/// Names that are given already, where they may be many.
#[derive(Default)]
struct KeywordSet {
    names: HashSet<Symbol>,
    /// Keywords that `names` has.
    noted: usize,
}

impl KeywordSet {
    /// Whether one of the keywords has this name. Few are looked through.
    fn has(&mut self, name: Symbol, keywords: &[(Symbol, Value)]) -> bool {
        if keywords.len() <= LINEAR_SCAN_MAX {
            return keywords.iter().any(|(other, _)| *other == name);
        }
        let more = &keywords[self.noted.min(keywords.len())..];
        self.names.extend(more.iter().map(|(name, _)| *name));
        self.noted = keywords.len();
        self.names.contains(&name)
    }
}

#[cold]
fn given_twice(name: Symbol, callee: &Value, ev: &Evaluator<'_>) -> Unwind {
    let (label, name) = (ev.callee_label(callee), ev.core.symbols.name(name));
    ev.type_error(format!(
        "{label} got multiple values for keyword argument '{name}'"
    ))
}

impl Evaluator<'_> {
    /// How messages about a call name what is called.
    fn callee_label(&self, callee: &Value) -> String {
        match callee {
            Value::Function(function) => format!("__main__.{}()", function.code.qualname),
            Value::Builtin(builtin) => format!("{}()", builtin.full_label()),
            Value::BoundMethod(method) => self.callee_label(&method.function),
            Value::Class(class) if class.is_script => {
                format!("__main__.{}()", self.qualname_of(class))
            }
            Value::Class(class) => format!("{}()", class.name()),
            other => format!("{} object", self.core.types.name_of(other)),
        }
    }
}
