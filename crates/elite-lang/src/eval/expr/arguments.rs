//! Calls with stars, and what the arguments of any call mean: gathering them as Python does, with its messages.

use std::collections::HashSet;

use crate::errors::ExceptionKind;
use crate::eval::pace::VALUE;
use crate::eval::{Evaluator, Expr, Expression, Frame, Located};
use crate::source::Span;
use crate::value::symbol::{Passing, known};
use crate::value::trash::Nodes;
use crate::value::{Dict, R, Raised, Symbol, Value, Values};

/// An argument of a call with stars or keywords.
pub enum CallArg {
    /// By position.
    Positional(Expr),
    /// `*iterable`
    Star(Expr),
    /// By name.
    Keyword(Symbol, Expr),
    /// `**mapping`
    DoubleStar(Expr),
}

/// A call with stars or keywords.
pub struct CallWith {
    /// What is called.
    pub function: Expr,
    /// With what, in the order of the text.
    pub args: Nodes<CallArg>,
    /// Where it is written.
    pub span: Span,
}

impl Expression for CallWith {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let callee = self.function.eval(ev, f)?;
        let mut positional = Values::from(Vec::with_capacity(self.args.len()));
        let (mut keywords, mut names) = (Values::default(), Vec::new());
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
                .at(ev, f, self.span)
        });
        // Many names are forgotten bit by bit.
        for name in names {
            drop(name);
            ev.worked(VALUE)?;
        }
        result
    }
}

/// So many items are copied at once.
const FEW: usize = 64;

/// Evaluates arguments with stars and keywords; `names` keeps the names of the keywords while they are in use. `callee` is
/// only for messages.
#[allow(clippy::too_many_arguments)] // three of them are results
pub fn gather<'e>(
    args: &[CallArg],
    callee: &Value,
    ev: &'e Evaluator<'_>,
    f: &mut Frame<'_>,
    span: Span,
    positional: &mut Vec<Value>,
    keywords: &mut Vec<(Symbol, Value)>,
    names: &mut Vec<Passing<'e>>,
) -> R<()> {
    let single = args
        .iter()
        .filter(|arg| matches!(arg, CallArg::Positional(_) | CallArg::Star(_)))
        .count()
        == 1;
    for arg in args {
        match arg {
            CallArg::Positional(expr) => positional.push(expr.eval(ev, f)?),
            CallArg::Star(expr) => {
                let iterable = expr.eval(ev, f)?;
                match &iterable {
                    Value::Tuple(tuple) if tuple.items().len() <= FEW => {
                        positional.extend_from_slice(tuple.items());
                        continue;
                    }
                    Value::List(list) if list.len() <= FEW => {
                        positional.extend_from_slice(&list.borrow());
                        continue;
                    }
                    _ => {}
                }
                let items = ev.collect(&iterable).map_err(|raised| {
                    let raised = ev.not_unpackable(raised, &iterable);
                    let plain = !matches!(
                        iterable,
                        Value::Instance(_) | Value::Iter(_) | Value::Generator(_)
                    );
                    if single && plain && ev.is_kind(&raised, ExceptionKind::TypeError) {
                        let (label, name) =
                            (ev.callee_label(callee), ev.core.types.name_of(&iterable));
                        return ev.type_error(format!(
                            "{label} argument after * must be an iterable, not {name}"
                        ));
                    }
                    raised
                });
                let items = items.at(ev, f, span)?;
                ev.append_values(items, positional).at(ev, f, span)?;
            }
            CallArg::Keyword(name, expr) => {
                let value = expr.eval(ev, f)?;
                add_keyword(*name, value, callee, ev, keywords).at(ev, f, span)?;
            }
            CallArg::DoubleStar(expr) => {
                let mapping = expr.eval(ev, f)?;
                gather_mapping(&mapping, callee, ev, keywords, names).at(ev, f, span)?;
            }
        }
    }
    Ok(())
}

fn gather_mapping<'e>(
    mapping: &Value,
    callee: &Value,
    ev: &'e Evaluator<'_>,
    keywords: &mut Vec<(Symbol, Value)>,
    names: &mut Vec<Passing<'e>>,
) -> R<()> {
    let dict = Dict::new();
    ev.update_from_mapping(&dict, mapping).map_err(|raised| {
        let no_mapping = match mapping {
            Value::Instance(instance) => {
                instance.extended().is_none() && instance.class.lookup(known::KEYS).is_none()
            }
            _ => true,
        };
        if ev.is_kind(&raised, ExceptionKind::TypeError) && no_mapping {
            let (label, name) = (ev.callee_label(callee), ev.core.types.name_of(mapping));
            return ev.type_error(format!(
                "{label} argument after ** must be a mapping, not {name}"
            ));
        }
        raised
    })?;
    let mut given = Given::default();
    for (_, key, value) in ev.entries(&dict)? {
        ev.worked(NAME)?;
        let Value::Str(text) = ev.plain(&key) else {
            return Err(ev.type_error("keywords must be strings"));
        };
        let name = ev.ask_name(text.as_str())?;
        if given.has(*name, keywords) {
            return Err(given_twice(*name, callee, ev));
        }
        keywords.push((*name, value));
        names.push(name);
    }
    Ok(())
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
const NAME: usize = 16 * VALUE;
/// So many names are looked through; more of them are kept in a table.
const LOOKED_THROUGH: usize = 16;

/// Names that are given already, where they may be many.
#[derive(Default)]
struct Given {
    names: HashSet<Symbol>,
    /// Keywords that `names` has.
    noted: usize,
}

impl Given {
    /// Whether one of the keywords has this name. Few are looked through.
    fn has(&mut self, name: Symbol, keywords: &[(Symbol, Value)]) -> bool {
        if keywords.len() <= LOOKED_THROUGH {
            return keywords.iter().any(|(other, _)| *other == name);
        }
        let more = &keywords[self.noted.min(keywords.len())..];
        self.names.extend(more.iter().map(|(name, _)| *name));
        self.noted = keywords.len();
        self.names.contains(&name)
    }
}

#[cold]
fn given_twice(name: Symbol, callee: &Value, ev: &Evaluator<'_>) -> Raised {
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
