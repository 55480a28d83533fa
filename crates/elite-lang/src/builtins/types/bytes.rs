//! `bytes` and `bytearray`.
//!
//! Most methods are those of `str` on the same bytes read as Latin-1; what depends on the alphabet or on white space
//! is ASCII only and written out here.

use std::rc::Rc;

use super::{BoundFn, class_method, constructor, methods, wrong_receiver};
use crate::errors::ExceptionKind;
use crate::eval::{Core, Evaluator};
use crate::value::symbol::known;
use crate::value::{ByteArray, Bytes, Class, R, Value};

/// White space of bytes, as an argument for `strip`.
const SPACES: &str = " \t\n\r\x0b\x0c";

pub(super) fn install(core: &Rc<Core>) {
    let types = &core.types;
    constructor(
        core,
        &types.bytes,
        "source? encoding? errors?",
        |ev, args| data(ev, args, "bytes").map(|data| Value::Bytes(Rc::new(Bytes::new(data)))),
    );
    constructor(
        core,
        &types.bytearray,
        "source? encoding? errors?",
        |ev, args| data(ev, args, "bytearray").map(bytearray),
    );
    for class in [&types.bytes, &types.bytearray] {
        install_shared(core, class);
        let maketrans = crate::builtins::Builtin::bound(core, "maketrans", "from to /", maketrans);
        class.set(
            core.symbols.intern("maketrans"),
            Value::StaticMethod(Rc::new(maketrans)),
        );
    }
    class_method(core, &types.bytes, "fromhex", "string /", |ev, args| {
        from_hex(ev, &args[1]).map(|data| Value::Bytes(Rc::new(Bytes::new(data))))
    });
    class_method(core, &types.bytearray, "fromhex", "string /", |ev, args| {
        from_hex(ev, &args[1]).map(bytearray)
    });
    install_mutable(core, &types.bytearray);
}

fn bytearray(data: Vec<u8>) -> Value {
    Value::ByteArray(Rc::new(ByteArray::new(data)))
}

fn data(ev: &Evaluator<'_>, args: &[Value], type_name: &str) -> R<Vec<u8>> {
    let Some(source) = args[0].given() else {
        return Ok(Vec::new());
    };
    if !matches!(ev.plain(source), Value::Str(_)) {
        if args[1].given().is_some() {
            return Err(ev.type_error("encoding without a string argument"));
        }
        if args[2].given().is_some() {
            return Err(ev.type_error("errors without a string argument"));
        }
    }
    match ev.plain(source) {
        Value::Instance(instance) if instance.class.lookup(known::BYTES).is_some() => {
            let made = ev
                .special(source, known::BYTES, &mut [])?
                .unwrap_or_default();
            ev.bytes_like(&made).ok_or_else(|| {
                let name = ev.core.types.name_of(&made);
                ev.type_error(format!("__bytes__ returned non-bytes (type {name})"))
            })
        }
        Value::Instance(instance) if instance.class.lookup(known::INDEX).is_some() => {
            let count = ev.index(source)?;
            let count = usize::try_from(count).map_err(|_| ev.value_error("negative count"))?;
            ev.check_allocation(count)?;
            Ok(vec![0; count])
        }
        Value::Bool(flag) => Ok(vec![0; usize::from(flag)]),
        Value::Str(text) => {
            if args[1].is_unbound() {
                return Err(ev.type_error("string argument without an encoding"));
            }
            ev.encode(&text, &args[1], &args[2])
        }
        Value::Int(count) => {
            let count = usize::try_from(count).map_err(|_| ev.value_error("negative count"))?;
            ev.check_allocation(count)?;
            Ok(vec![0; count])
        }
        other => match ev.bytes_like(&other) {
            Some(data) => Ok(data),
            None if ev.iter(source).is_err() => {
                let name = ev.core.types.name_of(source);
                Err(ev.type_error(format!("cannot convert '{name}' object to {type_name}")))
            }
            None => {
                let error =
                    || ev.value_error(format!("{} must be in range(0, 256)", byte_word(type_name)));
                ev.collect_as(source, |item| {
                    u8::try_from(ev.index(item)?).map_err(|_| error())
                })
            }
        },
    }
}

fn byte_word(type_name: &str) -> &'static str {
    if type_name == "bytes" {
        "bytes"
    } else {
        "byte"
    }
}

/// Methods of both types. The result is of the receiver's type.
fn install_shared(core: &Rc<Core>, class: &Class) {
    const BY_TEXT: &[(&str, &str, BoundFn)] = &[
        ("replace", "old new count? /", |ev, args| {
            by_text(ev, args, "replace")
        }),
        ("split", "sep? maxsplit?", |ev, args| {
            split(ev, args, "split")
        }),
        ("rsplit", "sep? maxsplit?", |ev, args| {
            split(ev, args, "rsplit")
        }),
        ("partition", "sep /", |ev, args| {
            by_text(ev, args, "partition")
        }),
        ("rpartition", "sep /", |ev, args| {
            by_text(ev, args, "rpartition")
        }),
        ("find", "sub start? end? /", |ev, args| {
            by_text(ev, args, "find")
        }),
        ("rfind", "sub start? end? /", |ev, args| {
            by_text(ev, args, "rfind")
        }),
        ("index", "sub start? end? /", |ev, args| {
            by_text(ev, args, "index")
        }),
        ("rindex", "sub start? end? /", |ev, args| {
            by_text(ev, args, "rindex")
        }),
        ("count", "sub start? end? /", |ev, args| {
            by_text(ev, args, "count")
        }),
        ("startswith", "prefix start? end? /", |ev, args| {
            by_text(ev, args, "startswith")
        }),
        ("endswith", "suffix start? end? /", |ev, args| {
            by_text(ev, args, "endswith")
        }),
        ("removeprefix", "prefix /", |ev, args| {
            by_text(ev, args, "removeprefix")
        }),
        ("removesuffix", "suffix /", |ev, args| {
            by_text(ev, args, "removesuffix")
        }),
        ("center", "width fillchar? /", |ev, args| {
            by_text(ev, args, "center")
        }),
        ("ljust", "width fillchar? /", |ev, args| {
            by_text(ev, args, "ljust")
        }),
        ("rjust", "width fillchar? /", |ev, args| {
            by_text(ev, args, "rjust")
        }),
        ("zfill", "width /", |ev, args| by_text(ev, args, "zfill")),
        ("expandtabs", "tabsize?", |ev, args| {
            by_text(ev, args, "expandtabs")
        }),
        ("strip", "chars? /", |ev, args| strip(ev, args, "strip")),
        ("lstrip", "chars? /", |ev, args| strip(ev, args, "lstrip")),
        ("rstrip", "chars? /", |ev, args| strip(ev, args, "rstrip")),
        ("join", "iterable /", join),
        ("splitlines", "keepends?", splitlines),
    ];
    methods(core, class, BY_TEXT);
    methods(
        core,
        class,
        &[
            ("upper", "", |ev, args| {
                mapped(ev, args, |byte, _| byte.to_ascii_uppercase())
            }),
            ("lower", "", |ev, args| {
                mapped(ev, args, |byte, _| byte.to_ascii_lowercase())
            }),
            ("swapcase", "", |ev, args| {
                mapped(ev, args, |byte, _| swap(byte))
            }),
            ("title", "", |ev, args| {
                mapped(ev, args, |byte, before| {
                    match before.is_some_and(|b| b.is_ascii_alphabetic()) {
                        true => byte.to_ascii_lowercase(),
                        false => byte.to_ascii_uppercase(),
                    }
                })
            }),
            ("capitalize", "", |ev, args| {
                mapped(ev, args, |byte, before| match before {
                    Some(_) => byte.to_ascii_lowercase(),
                    None => byte.to_ascii_uppercase(),
                })
            }),
            ("isalpha", "", |ev, args| {
                all(ev, args, |byte| byte.is_ascii_alphabetic())
            }),
            ("isdigit", "", |ev, args| {
                all(ev, args, |byte| byte.is_ascii_digit())
            }),
            ("isalnum", "", |ev, args| {
                all(ev, args, |byte| byte.is_ascii_alphanumeric())
            }),
            ("isspace", "", |ev, args| {
                all(ev, args, |byte| SPACES.as_bytes().contains(&byte))
            }),
            ("isascii", "", |ev, args| {
                Ok(Value::Bool(receiver(ev, &args[0])?.is_ascii()))
            }),
            ("isupper", "", |ev, args| {
                cased(ev, args, u8::is_ascii_uppercase, u8::is_ascii_lowercase)
            }),
            ("islower", "", |ev, args| {
                cased(ev, args, u8::is_ascii_lowercase, u8::is_ascii_uppercase)
            }),
            ("istitle", "", |ev, args| {
                let text: String = receiver(ev, &args[0])?
                    .iter()
                    .map(|byte| {
                        if byte.is_ascii() {
                            char::from(*byte)
                        } else {
                            ' '
                        }
                    })
                    .collect();
                let title = super::string_methods::is_title(&text);
                Ok(Value::Bool(title))
            }),
            ("translate", "table / delete?", translate),
            ("decode", "encoding? errors?", |ev, args| {
                ev.decode(&receiver(ev, &args[0])?, &args[1], &args[2])
            }),
            ("hex", "sep? bytes_per_sep?", hex),
        ],
    );
}

fn install_mutable(core: &Rc<Core>, class: &Class) {
    methods(
        core,
        class,
        &[
            ("append", "item /", |ev, args| {
                let byte = ev.byte(&args[1])?;
                let bytes = mutable(ev, &args[0])?;
                ev.grow_bytes(&bytes, 1)?;
                bytes.data.change(|data| data.push(byte));
                Ok(Value::None)
            }),
            ("extend", "iterable /", |ev, args| {
                let more = match ev.bytes_like(&args[1]) {
                    Some(more) => more,
                    None if ev.iter(&args[1]).is_err() => {
                        let name = ev.core.types.name_of(&args[1]);
                        return Err(ev.type_error(format!("can't extend bytearray with {name}")));
                    }
                    None => ev.collect_bytes(&args[1])?,
                };
                let bytes = mutable(ev, &args[0])?;
                ev.grow_bytes(&bytes, more.len())?;
                bytes.data.change(|data| data.extend(more));
                Ok(Value::None)
            }),
            ("insert", "index item /", |ev, args| {
                let bytes = mutable(ev, &args[0])?;
                let index = ev.clamped_index(&args[1])?;
                let byte = ev.byte(&args[2])?;
                ev.grow_bytes(&bytes, 1)?;
                bytes.data.change(|data| {
                    data.insert(super::insertion_place(index, data.len()), byte);
                });
                Ok(Value::None)
            }),
            ("pop", "index? /", |ev, args| {
                let bytes = mutable(ev, &args[0])?;
                let index = args[1].given().map_or(Ok(-1), |index| ev.index(index))?;
                let popped = bytes.data.change(|data| {
                    let place = ev.place(index, data.len())?;
                    Some(data.remove(place))
                });
                match popped {
                    Some(byte) => Ok(Value::Int(i64::from(byte))),
                    None if bytes.data.borrow().is_empty() => {
                        Err(ev.raise(ExceptionKind::IndexError, "pop from empty bytearray"))
                    }
                    None => Err(ev.raise(ExceptionKind::IndexError, "pop index out of range")),
                }
            }),
            ("remove", "value /", |ev, args| {
                let (bytes, byte) = (mutable(ev, &args[0])?, ev.byte(&args[1])?);
                let removed = bytes.data.change(|data| {
                    let index = data.iter().position(|other| *other == byte)?;
                    Some(data.remove(index))
                });
                match removed {
                    Some(_) => Ok(Value::None),
                    None => Err(ev.value_error("value not found in bytearray")),
                }
            }),
            ("clear", "", |ev, args| {
                mutable(ev, &args[0])?.data.change(Vec::clear);
                Ok(Value::None)
            }),
            ("reverse", "", |ev, args| {
                mutable(ev, &args[0])?.data.change(|data| data.reverse());
                Ok(Value::None)
            }),
            ("copy", "", |ev, args| {
                Ok(bytearray(mutable(ev, &args[0])?.data.get()))
            }),
            ("__init__", "source? encoding? errors?", |ev, args| {
                let data = data(ev, &args[1..], "bytearray")?;
                let bytes = mutable(ev, &args[0])?;
                bytes.data.put(data);
                Ok(Value::None)
            }),
        ],
    );
}

fn receiver(ev: &Evaluator<'_>, value: &Value) -> R<Vec<u8>> {
    ev.bytes_like(value)
        .ok_or_else(|| wrong_receiver(ev, "bytes", value))
}

fn mutable(ev: &Evaluator<'_>, value: &Value) -> R<Rc<ByteArray>> {
    match ev.plain(value) {
        Value::ByteArray(bytes) => Ok(bytes),
        other => Err(wrong_receiver(ev, "bytearray", &other)),
    }
}

/// Bytes of the receiver's type.
fn like(ev: &Evaluator<'_>, receiver: &Value, data: Vec<u8>) -> Value {
    match ev.plain(receiver) {
        Value::ByteArray(_) => bytearray(data),
        _ => Value::Bytes(Rc::new(Bytes::new(data))),
    }
}

/// Bytes as text of the same codes; anything else as it is, strings refused.
fn to_text(ev: &Evaluator<'_>, value: &Value) -> R {
    match value {
        Value::Str(_) => Err(ev.type_error("a bytes-like object is required, not 'str'")),
        Value::Tuple(tuple) => {
            let items: R<Vec<Value>> = tuple.items().iter().map(|item| to_text(ev, item)).collect();
            items.map(Value::tuple)
        }
        other => Ok(match ev.bytes_like(other) {
            Some(data) => Value::str(
                data.iter()
                    .map(|byte| char::from(*byte))
                    .collect::<String>(),
            ),
            None => other.clone(),
        }),
    }
}

fn from_text(ev: &Evaluator<'_>, receiver: &Value, value: Value) -> Value {
    let each = |items: &[Value]| {
        items
            .iter()
            .map(|item| from_text(ev, receiver, item.clone()))
            .collect()
    };
    match &value {
        Value::Str(text) => like(
            ev,
            receiver,
            text.as_str().chars().map(|c| c as u32 as u8).collect(),
        ),
        Value::List(list) => Value::list(each(&list.borrow())),
        Value::Tuple(tuple) => Value::tuple(each(tuple.items())),
        _ => value,
    }
}

/// The method of `str` with this name, on bytes read as Latin-1.
fn by_text(ev: &Evaluator<'_>, args: &mut [Value], name: &str) -> R {
    settle(ev, args, name)?;
    let method = ev
        .core
        .types
        .str
        .lookup(ev.core.symbols.intern(name))
        .unwrap_or_default();
    // A single byte may be given as a number where one is searched for.
    let searches = matches!(name, "find" | "rfind" | "index" | "rindex" | "count");
    let affix = matches!(name, "startswith" | "endswith");
    let as_text = |(index, arg): (usize, &Value)| match arg {
        Value::Int(_) if searches && index == 1 => {
            Ok(Value::str(char::from(ev.byte(arg)?).to_string()))
        }
        other if index == 1 && (searches || affix) => to_text(ev, other)
            .and_then(|text| {
                if matches!(text, Value::Str(_) | Value::Tuple(_)) {
                    return Ok(text);
                }
                Err(ev.type_error(""))
            })
            .map_err(|_| {
                let name_of = ev.core.types.name_of(other);
                ev.type_error(if searches {
                    format!("argument should be integer or bytes-like object, not '{name_of}'")
                } else {
                    format!("{name} first arg must be bytes or a tuple of bytes, not {name_of}")
                })
            }),
        other => to_text(ev, other),
    };
    let given = args.iter().take_while(|arg| !arg.is_unbound()).enumerate();
    let texts: R<Vec<Value>> = given.map(as_text).collect();
    let result = ev.call(&method, &mut texts?, &[]).map_err(|raised| {
        if matches!(name, "index" | "rindex") && ev.is_kind(&raised, ExceptionKind::ValueError) {
            return ev.value_error("subsection not found");
        }
        raised
    })?;
    Ok(from_text(ev, &args[0], result))
}

/// Asks the objects among the arguments that stand for integers, each once and before the bytes are looked at.
fn settle(ev: &Evaluator<'_>, args: &mut [Value], name: &str) -> R<()> {
    let places: &[usize] = match name {
        "find" | "rfind" | "index" | "rindex" | "count" => &[2, 3, 1],
        "startswith" | "endswith" => &[2, 3],
        "center" | "ljust" | "rjust" | "zfill" | "expandtabs" => &[1],
        "split" | "rsplit" => &[2],
        "replace" => &[3],
        _ => &[],
    };
    for place in places {
        if let Some(arg) = args.get_mut(*place)
            && matches!(arg, Value::Instance(_))
            && ev.bytes_like(arg).is_none()
            && ev.has_index(arg)
        {
            *arg = ev.to_int(arg)?.into_value();
        }
    }
    Ok(())
}

fn strip(ev: &Evaluator<'_>, args: &mut [Value], name: &str) -> R {
    if args[1].is_unbound() || args[1].is_none() {
        args[1] = Value::Bytes(Rc::new(Bytes::new(SPACES.as_bytes().to_vec())));
    }
    by_text(ev, args, name)
}

fn split(ev: &Evaluator<'_>, args: &mut [Value], name: &str) -> R {
    settle(ev, args, name)?;
    if !args[1].is_unbound() && !args[1].is_none() {
        return by_text(ev, args, name);
    }
    // Latin-1 has two more blanks than ASCII; they are no blanks here.
    let data = receiver(ev, &args[0])?;
    let hidden: Vec<u8> = data
        .iter()
        .map(|byte| {
            if matches!(byte, 0x85 | 0xa0 | 0x1c..=0x1f) {
                b'x'
            } else {
                *byte
            }
        })
        .collect();
    args[1] = Value::None;
    let mut on_hidden: Vec<Value> = vec![Value::Bytes(Rc::new(Bytes::new(hidden)))];
    on_hidden.extend(args[1..].iter().cloned());
    let parts = by_text(ev, &mut on_hidden, name)?;
    let mut rest = 0;
    let parts = ev.collect(&parts)?;
    let restored = parts.iter().map(|part| {
        let length = ev.bytes_like(part).map_or(0, |part| part.len());
        let blanks = data[rest..]
            .iter()
            .take_while(|byte| SPACES.as_bytes().contains(byte))
            .count();
        let start = rest + blanks;
        rest = start + length;
        like(ev, &args[0], data[start..rest].to_vec())
    });
    Ok(Value::list(restored.collect()))
}

fn join(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let separator = receiver(ev, &args[0])?;
    let mut out = Vec::new();
    for (index, item) in ev.collect(&args[1])?.iter().enumerate() {
        let Some(data) = ev.bytes_like(item) else {
            let name = ev.core.types.name_of(item);
            let text = format!("sequence item {index}: expected a bytes-like object, {name} found");
            return Err(ev.type_error(text));
        };
        if index > 0 {
            out.extend_from_slice(&separator);
        }
        out.extend(data);
        ev.check_allocation(out.len())?;
    }
    Ok(like(ev, &args[0], out))
}

/// Bytes mapped by a table of 256, those in `delete` left out first.
fn translate(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let data = receiver(ev, &args[0])?;
    let table = match &args[1] {
        Value::None => None,
        other => match ev.bytes_like(other) {
            Some(table) if table.len() == 256 => Some(table),
            Some(_) => {
                return Err(ev.value_error("translation table must be 256 characters long"));
            }
            None => return Err(not_bytes_like(ev, other)),
        },
    };
    let removed = match args[2].given() {
        Some(value) => ev
            .bytes_like(value)
            .ok_or_else(|| not_bytes_like(ev, value))?,
        None => Vec::new(),
    };
    let kept = data.iter().filter(|byte| !removed.contains(byte));
    let mapped = kept.map(|byte| match &table {
        Some(table) => table[usize::from(*byte)],
        None => *byte,
    });
    Ok(like(ev, &args[0], mapped.collect()))
}

fn not_bytes_like(ev: &Evaluator<'_>, value: &Value) -> crate::value::Raised {
    let name = ev.core.types.name_of(value);
    ev.type_error(format!("a bytes-like object is required, not '{name}'"))
}

fn maketrans(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let part = |value: &Value| {
        ev.bytes_like(value)
            .ok_or_else(|| not_bytes_like(ev, value))
    };
    let (from, to) = (part(&args[0])?, part(&args[1])?);
    if from.len() != to.len() {
        return Err(ev.value_error("maketrans arguments must have same length"));
    }
    let mut table: Vec<u8> = (0..=255).collect();
    for (from, to) in from.iter().zip(to) {
        table[usize::from(*from)] = to;
    }
    Ok(Value::Bytes(Rc::new(Bytes::new(table))))
}

fn splitlines(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let keep = args[1].given().map_or(Ok(0), |value| ev.index(value))? != 0;
    let data = receiver(ev, &args[0])?;
    ev.ask_for_pieces(data.len(), || {
        data.iter()
            .filter(|byte| matches!(byte, b'\n' | b'\r'))
            .count()
            + 1
    })?;
    let mut lines = Vec::new();
    let mut rest = &data[..];
    while !rest.is_empty() {
        let line = rest
            .iter()
            .position(|byte| matches!(byte, b'\n' | b'\r'))
            .unwrap_or(rest.len());
        let end = (line
            + if rest[line..].starts_with(b"\r\n") {
                2
            } else {
                1
            })
        .min(rest.len());
        lines.push(like(
            ev,
            &args[0],
            rest[..if keep { end } else { line }].to_vec(),
        ));
        rest = &rest[end..];
    }
    Ok(Value::list(lines))
}

fn swap(byte: u8) -> u8 {
    if byte.is_ascii_uppercase() {
        byte.to_ascii_lowercase()
    } else {
        byte.to_ascii_uppercase()
    }
}

/// Each byte mapped, with the one before it.
fn mapped(ev: &Evaluator<'_>, args: &[Value], map: impl Fn(u8, Option<u8>) -> u8) -> R {
    let data = receiver(ev, &args[0])?;
    let before = std::iter::once(None).chain(data.iter().copied().map(Some));
    let out = data
        .iter()
        .zip(before)
        .map(|(byte, before)| map(*byte, before))
        .collect();
    Ok(like(ev, &args[0], out))
}

fn all(ev: &Evaluator<'_>, args: &[Value], test: impl Fn(u8) -> bool) -> R {
    let data = receiver(ev, &args[0])?;
    Ok(Value::Bool(!data.is_empty() && data.into_iter().all(test)))
}

fn cased(ev: &Evaluator<'_>, args: &[Value], wanted: fn(&u8) -> bool, other: fn(&u8) -> bool) -> R {
    let data = receiver(ev, &args[0])?;
    Ok(Value::Bool(
        data.iter().any(wanted) && !data.iter().any(other),
    ))
}

fn hex(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let data = receiver(ev, &args[0])?;
    let digits: Vec<String> = data.iter().map(|byte| format!("{byte:02x}")).collect();
    let Some(separator) = args[1].given() else {
        return Ok(Value::str(digits.concat()));
    };
    let separator = match (ev.plain(separator), ev.bytes_like(separator)) {
        (Value::Str(text), _) => text.as_str().to_owned(),
        (_, Some(data)) => data.iter().map(|byte| char::from(*byte)).collect(),
        (other, None) => {
            // CPython asks for its length first.
            ev.len(&other)?;
            return Err(ev.type_error("sep must be str or bytes."));
        }
    };
    if separator.chars().count() != 1 {
        return Err(ev.value_error("sep must be length 1."));
    }
    if !separator.is_ascii() {
        return Err(ev.value_error("sep must be ASCII."));
    }
    let group = args[2].given().map_or(Ok(1), |value| ev.index(value))?;
    if group == 0 {
        return Ok(Value::str(digits.concat()));
    }
    let size = usize::try_from(group.unsigned_abs()).unwrap_or(usize::MAX);
    // Groups count from the right, or from the left if the size is negative.
    let first = if group > 0 { digits.len() % size } else { 0 };
    let (head, tail) = digits.split_at(first);
    let groups = std::iter::once(head)
        .filter(|head| !head.is_empty())
        .chain(tail.chunks(size));
    Ok(Value::str(
        groups
            .map(<[String]>::concat)
            .collect::<Vec<_>>()
            .join(&separator),
    ))
}

fn from_hex(ev: &Evaluator<'_>, text: &Value) -> R<Vec<u8>> {
    let Value::Str(text) = ev.plain(text) else {
        let name = ev.core.types.name_of(text);
        return Err(ev.type_error(format!("fromhex() argument must be str, not {name}")));
    };
    let mut out = Vec::new();
    let mut chars = text
        .as_str()
        .chars()
        .enumerate()
        .filter(|(_, c)| !c.is_ascii_whitespace())
        .peekable();
    let error = |at: usize| {
        ev.value_error(format!(
            "non-hexadecimal number found in fromhex() arg at position {at}"
        ))
    };
    while let Some((at, high)) = chars.next() {
        let high = high.to_digit(16).ok_or_else(|| error(at))?;
        let (at, low) = chars.next().ok_or_else(|| error(at + 1))?;
        let low = low.to_digit(16).ok_or_else(|| error(at))?;
        out.push((high * 16 + low) as u8);
    }
    Ok(out)
}
