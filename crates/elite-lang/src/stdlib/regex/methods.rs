//! Methods of `re.Pattern`.

use std::cell::RefCell;
use std::rc::Rc;

use super::found::make_match;
use super::parse::flag;
use super::{MatchRange, Mode, Pattern, Scanner, Subject};
use crate::eval::Evaluator;
use crate::stdlib::define::{MethodDef, with_data};
use crate::value::iter::{LibraryIterator, NativeIter};
use crate::value::{Bytes, Iter, R, ScriptCell, Value, ValueVec};

pub(super) fn with_pattern(
    ev: &Evaluator<'_>,
    args: &[Value],
    act: impl FnOnce(&Rc<Pattern>) -> R,
) -> R {
    with_data(ev, &args[0], |pattern: &Rc<Pattern>| act(pattern))
}

fn range(ev: &Evaluator<'_>, text: &Subject, pos: &Value, endpos: &Value) -> R<(usize, usize)> {
    let start = pos.if_given().map_or(Ok(0), |pos| ev.clamped_index(pos))?;
    let end = match endpos.if_given() {
        Some(end) => text.offset(ev.clamped_index(end)?),
        None => text.len(),
    };
    Ok((text.offset(start), end))
}

fn match_once(ev: &Evaluator<'_>, args: &[Value], mode: Mode) -> R {
    with_pattern(ev, args, |pattern| {
        let text = Subject::of(ev, pattern, &args[1])?;
        let range = range(ev, &text, &args[2], &args[3])?;
        let (start, end) = range;
        let within = MatchRange {
            start,
            end,
            mode,
            advance: false,
        };
        match pattern.find(ev, &text, within)? {
            Some(spans) => make_match(ev, &args[0], pattern, &text, range, spans),
            None => Ok(Value::None),
        }
    })
}

fn scanner(
    ev: &Evaluator<'_>,
    pattern: &Rc<Pattern>,
    text: &Value,
    pos: &Value,
    endpos: &Value,
) -> R<Scanner> {
    let text = Subject::of(ev, pattern, text)?;
    let (at, end) = range(ev, &text, pos, endpos)?;
    Ok(Scanner {
        pattern: pattern.clone(),
        text,
        at,
        end,
        advance: false,
    })
}

/// The matches in a text, one after the other.
struct Finds {
    pattern: ScriptCell<Value>,
    range: (usize, usize),
    scanner: RefCell<Scanner>,
}

impl LibraryIterator for Finds {
    fn next(&self, ev: &Evaluator<'_>) -> R<Option<Value>> {
        // A search may let another thread run; that one must not step the same iterator.
        let Ok(mut stepped) = self.scanner.try_borrow_mut() else {
            return Err(ev.value_error("iterator already executing"));
        };
        let found = stepped.next(ev)?;
        drop(stepped);
        let scanner = self.scanner.borrow();
        let (pattern, text) = (&scanner.pattern, &scanner.text);
        let make = |spans| make_match(ev, &self.pattern.get(), pattern, text, self.range, spans);
        found.map(make).transpose()
    }

    fn visit(&self, each: &mut dyn FnMut(&Value)) {
        if let Some(pattern) = self.pattern.try_borrow() {
            each(&pattern);
        }
        if let Ok(scanner) = self.scanner.try_borrow() {
            scanner.text.visit(each);
        }
    }

    fn clear(&self, held: &mut Vec<Value>) {
        held.push(self.pattern.take());
        if let Ok(mut scanner) = self.scanner.try_borrow_mut() {
            scanner.end = 0;
            held.push(scanner.text.take());
        }
    }
}

pub(super) const PATTERN: &[MethodDef] = &[
    ("search", "string pos? endpos?", |ev, args| {
        match_once(ev, args, Mode::Search)
    }),
    ("match", "string pos? endpos?", |ev, args| {
        match_once(ev, args, Mode::Match)
    }),
    ("fullmatch", "string pos? endpos?", |ev, args| {
        match_once(ev, args, Mode::Full)
    }),
    ("findall", "string pos? endpos?", |ev, args| {
        with_pattern(ev, args, |pattern| {
            let mut scanner = scanner(ev, pattern, &args[1], &args[2], &args[3])?;
            let empty = scanner.text.slice(ev, (0, 0))?;
            let mut found = Vec::new();
            while let Some(spans) = scanner.next(ev)? {
                let text = |span: &Option<(usize, usize)>| match span {
                    Some(span) => scanner.text.slice(ev, *span),
                    None => Ok(empty.clone()),
                };
                found.push(match spans.len() {
                    1 => text(&spans[0])?,
                    2 => text(&spans[1])?,
                    _ => Value::tuple(spans[1..].iter().map(text).collect::<R<_>>()?),
                });
                ev.grow(&mut found, 1)?;
                ev.check_memory()?;
            }
            Ok(Value::list(found))
        })
    }),
    ("finditer", "string pos? endpos?", |ev, args| {
        with_pattern(ev, args, |pattern| {
            let scanner = scanner(ev, pattern, &args[1], &args[2], &args[3])?;
            let finds = Finds {
                pattern: ScriptCell::new(args[0].clone()),
                range: (scanner.at, scanner.end),
                scanner: RefCell::new(scanner),
            };
            let class = ev.core.types.callable_iterator.clone();
            Ok(Value::Iter(Rc::new(Iter::Native(NativeIter::new(
                class, finds,
            )))))
        })
    }),
    ("split", "string maxsplit?", |ev, args| {
        let most = args[2]
            .if_given()
            .map_or(Ok(0), |most| ev.clamped_index(most))?;
        with_pattern(ev, args, |pattern| {
            let mut scanner = scanner(ev, pattern, &args[1], &Value::Unbound, &Value::Unbound)?;
            let (mut parts, mut from, mut count) = (Vec::new(), 0, 0);
            while most == 0 || count < most {
                let Some(spans) = scanner.next(ev)? else {
                    break;
                };
                let (start, end) = spans[0].unwrap_or_default();
                ev.grow(&mut parts, spans.len())?;
                parts.push(scanner.text.slice(ev, (from, start))?);
                for span in &spans[1..] {
                    parts.push(match span {
                        Some(span) => scanner.text.slice(ev, *span)?,
                        None => Value::None,
                    });
                }
                ev.check_memory()?;
                from = end;
                count += 1;
            }
            parts.push(scanner.text.slice(ev, (from, scanner.text.len()))?);
            Ok(Value::list(parts))
        })
    }),
    // `repl` is a function, or a list of texts and group numbers made from a template.
    ("_subn", "repl string count", |ev, args| {
        let most = ev.clamped_index(&args[3])?;
        with_pattern(ev, args, |pattern| substitute(ev, pattern, args, most))
    }),
    ("sub", "repl string count?", |ev, args| {
        let pair = with_template(ev, args)?;
        ev.item(&pair, &Value::Int(0))
    }),
    ("subn", "repl string count?", with_template),
    ("__repr__", "", |ev, args| {
        with_pattern(ev, args, |pattern| {
            let source: String = ev.repr(&pattern.source)?.chars().take(200).collect();
            let own = pattern.parsed.flags & !if pattern.is_bytes { 0 } else { flag::UNICODE };
            let names = [
                (flag::IGNORECASE, "re.IGNORECASE"),
                (flag::LOCALE, "re.LOCALE"),
                (flag::MULTILINE, "re.MULTILINE"),
                (flag::DOTALL, "re.DOTALL"),
                (flag::VERBOSE, "re.VERBOSE"),
                (flag::ASCII, "re.ASCII"),
            ];
            let set: Vec<&str> = names
                .iter()
                .filter(|(bit, _)| own & bit != 0)
                .map(|(_, name)| *name)
                .collect();
            let flags = if set.is_empty() {
                String::new()
            } else {
                format!(", {}", set.join("|"))
            };
            Ok(Value::str(format!("re.compile({source}{flags})")))
        })
    }),
    ("__eq__", "other /", |ev, args| {
        let same = args[0].is(&args[1])
            || with_data(ev, &args[0], |a: &Rc<Pattern>| {
                let other = with_data(ev, &args[1], |b: &Rc<Pattern>| Ok(b.clone()));
                Ok(other.is_ok_and(|b| {
                    a.parsed.flags == b.parsed.flags
                        && ev.equal(&a.source, &b.source).unwrap_or(false)
                }))
            })?;
        Ok(Value::Bool(same))
    }),
    ("__hash__", "", |ev, args| {
        with_pattern(ev, args, |pattern| {
            ev.hash(&pattern.source).map(|hash| Value::Int(hash as i64))
        })
    }),
    ("__copy__", "", |_, args| Ok(args[0].clone())),
    ("__deepcopy__", "memo /", |_, args| Ok(args[0].clone())),
];

/// `subn` as the script module has it, which understands templates.
fn with_template(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let module = ev.import("re")?;
    let subn = ev.attribute(&module, ev.core.symbols.intern("_subn"))?;
    let count = args[3].if_given().cloned().unwrap_or(Value::Int(0));
    ev.call(
        &subn,
        &mut [args[0].clone(), args[1].clone(), args[2].clone(), count],
        &[],
    )
}

fn substitute(ev: &Evaluator<'_>, pattern: &Rc<Pattern>, args: &[Value], most: i64) -> R {
    let mut scanner = scanner(ev, pattern, &args[2], &Value::Unbound, &Value::Unbound)?;
    let template = match &args[1] {
        Value::List(list) => {
            let mut parts = ValueVec::from(ev.try_with_capacity(list.len())?);
            ev.copy_list(list, &mut parts)?;
            Some(parts)
        }
        _ => None,
    };
    let mut out: Vec<u8> = Vec::new();
    let mut pieces = 0_usize;
    let push = |out: &mut Vec<u8>, value: &Value, place: usize| match ev.unwrap_builtin(value) {
        Value::Str(text) if !pattern.is_bytes => ev.push_bytes(out, text.as_str().as_bytes()),
        other => match ev.bytes_like(&other) {
            Some(data) if pattern.is_bytes => ev.push_bytes(out, &data),
            _ => {
                let name = ev.core.types.name_of(value);
                let wanted = if pattern.is_bytes {
                    "a bytes-like object"
                } else {
                    "str instance"
                };
                Err(ev.type_error(format!(
                    "sequence item {place}: expected {wanted}, {name} found"
                )))
            }
        },
    };
    let copy = |out: &mut Vec<u8>, text: &Subject, (start, end): (usize, usize)| match text {
        Subject::Str(text, _) => ev.push_bytes(out, &text.as_str().as_bytes()[start..end]),
        Subject::Bytes(data, _) => ev.push_bytes(out, &data[start..end]),
    };
    let (mut from, mut count) = (0, 0);
    while most <= 0 || count < most {
        let Some(spans) = scanner.next(ev)? else {
            break;
        };
        let (start, end) = spans[0].unwrap_or_default();
        copy(&mut out, &scanner.text, (from, start))?;
        pieces += usize::from(start > from);
        from = end;
        count += 1;
        match &template {
            Some(parts) => {
                for part in parts {
                    match part {
                        Value::Int(group) => {
                            if let Some(span) = spans.get(*group as usize).copied().flatten() {
                                copy(&mut out, &scanner.text, span)?;
                            }
                        }
                        text => push(&mut out, text, pieces)?,
                    }
                }
                pieces += 1;
            }
            None => {
                let range = (0, scanner.text.len());
                let found = make_match(ev, &args[0], pattern, &scanner.text, range, spans)?;
                let text = ev.call1(&args[1], found)?;
                if !text.is_none() {
                    push(&mut out, &text, pieces)?;
                    pieces += 1;
                }
            }
        }
        ev.check_allocation(out.len())?;
    }
    copy(&mut out, &scanner.text, (from, scanner.text.len()))?;
    let result = if pattern.is_bytes {
        Value::Bytes(Rc::new(Bytes::new(out)))
    } else {
        // Made of whole strings only.
        let text = String::from_utf8(out);
        ev.new_str(
            text.unwrap_or_else(|wrong| String::from_utf8_lossy(wrong.as_bytes()).into_owned()),
        )?
    };
    Ok(Value::tuple(vec![result, Value::Int(count)]))
}
