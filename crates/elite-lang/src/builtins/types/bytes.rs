//! `bytes` and `bytearray`.
//!
//! What depends on the alphabet or on white space is ASCII only. Searching, taking apart, columns and hexadecimal
//! digits are in files of their own.

use std::rc::Rc;

use super::bytes_hex::{from_hex, hex};
use super::bytes_layout::{self, BytesAlignment};
use super::bytes_parts;
use super::bytes_search::{self, SearchEnd};
use super::string::TitleCaseCheck;
use super::{BoundFn, class_method, constructor, methods, wrong_receiver};
use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, InterpreterState};
use crate::limits::chunked::{CHUNK, WORK_PER_BYTE};
use crate::value::bytes::BytesRef;
use crate::value::function::WrappedFunction;
use crate::value::symbol::known;
use crate::value::{ByteArray, Bytes, Class, R, Value, ValueVec};

/// White space of bytes.
pub(super) const SPACES: &[u8] = b" \t\n\r\x0b\x0c";

pub(super) fn install(core: &Rc<InterpreterState>) {
    let types = &core.types;
    constructor(
        core,
        &types.bytes,
        "source? encoding? errors?",
        |ev, args| {
            let is_object = args[1].is_unbound() && args[2].is_unbound();
            if is_object && let Some(made) = own_bytes(ev, &args[0])? {
                return Ok(made);
            }
            data(ev, args, "bytes").map(|data| Value::Bytes(Rc::new(Bytes::new(data))))
        },
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
            Value::StaticMethod(WrappedFunction::around(maketrans)),
        );
    }
    super::methods(
        core,
        &types.bytes,
        &[("__bytes__", "", |ev, args| Ok(ev.unwrap_builtin(&args[0])))],
    );
    class_method(core, &types.bytes, "fromhex", "string /", |ev, args| {
        let data = from_hex(ev, &args[1])?;
        ev.of_class(&args[0], Value::Bytes(Rc::new(Bytes::new(data))))
    });
    class_method(core, &types.bytearray, "fromhex", "string /", |ev, args| {
        let data = from_hex(ev, &args[1])?;
        ev.of_class(&args[0], bytearray(data))
    });
    install_mutable(core, &types.bytearray);
}

pub(super) fn bytearray(data: Vec<u8>) -> Value {
    Value::ByteArray(Rc::new(ByteArray::new(data)))
}

/// What the constructors make of their arguments.
fn data(ev: &Evaluator<'_>, args: &[Value], type_name: &str) -> R<Vec<u8>> {
    ev.check_codec_arguments(type_name, &args[1], &args[2])?;
    let source = args[0].if_given();
    let text = source.map(|source| ev.unwrap_builtin(source));
    if let Some(Value::Str(text)) = text {
        if args[1].is_unbound() {
            return Err(ev.type_error("string argument without an encoding"));
        }
        return ev.encode(&text, &args[1], &args[2]);
    }
    if args[1].if_given().is_some() {
        return Err(ev.type_error("encoding without a string argument"));
    }
    if args[2].if_given().is_some() {
        return Err(ev.type_error("errors without a string argument"));
    }
    let Some(source) = source else {
        return Ok(Vec::new());
    };
    let has_bytes = matches!(source, Value::Instance(instance)
        if type_name == "bytes" && instance.class.lookup(known::BYTES).is_some());
    if has_bytes || !ev.has_index(source) {
        return of_object(ev, source, type_name);
    }
    let count = match ev.sized_index(source, ExceptionKind::OverflowError) {
        // An object whose `__index__` refuses may still have items.
        Err(raised) if ev.is_kind(&raised, ExceptionKind::TypeError) => {
            return of_object(ev, source, type_name);
        }
        count => usize::try_from(count?),
    };
    let count = count.map_err(|_| ev.value_error("negative count"))?;
    ev.check_allocation(count)?;
    Ok(vec![0; count])
}

/// What the `__bytes__` of an object gives, which may be of a class derived from `bytes`.
fn own_bytes(ev: &Evaluator<'_>, source: &Value) -> R<Option<Value>> {
    let Value::Instance(_) = source else {
        return Ok(None);
    };
    let Some(made) = ev.special(source, known::BYTES, &mut [])? else {
        return Ok(None);
    };
    if let Value::Bytes(_) = ev.unwrap_builtin(&made) {
        return Ok(Some(made));
    }
    let name = ev.core.types.name_of(&made);
    Err(ev.type_error(format!("__bytes__ returned non-bytes (type {name})")))
}

/// The bytes of an object that is no text: its own, or those that it has as items.
pub fn of_object(ev: &Evaluator<'_>, source: &Value, type_name: &str) -> R<Vec<u8>> {
    if type_name == "bytes"
        && let Some(made) = own_bytes(ev, source)?
        && let Some(data) = ev.bytes_like(&made)
    {
        return ev.copy_bytes(&data);
    }
    if let Some(data) = ev.bytes_like(source) {
        return ev.copy_bytes(&data);
    }
    let refusal = || {
        let name = ev.core.types.name_of(source);
        format!("cannot convert '{name}' object to {type_name}")
    };
    if let Value::Str(_) = ev.unwrap_builtin(source) {
        return Err(ev.type_error(refusal()));
    }
    let items = ev.iter_or(source, refusal)?;
    if type_name == "bytes" {
        ev.ask_length(source)?;
    }
    ev.collect_as(&items, |item| {
        let byte = u8::try_from(ev.clamped_index(item)?);
        byte.map_err(|_| {
            ev.value_error(format!("{} must be in range(0, 256)", byte_word(type_name)))
        })
    })
}

fn byte_word(type_name: &str) -> &'static str {
    if type_name == "bytes" {
        "bytes"
    } else {
        "byte"
    }
}

/// Methods of both types. The result is of the receiver's type.
fn install_shared(core: &Rc<InterpreterState>, class: &Class) {
    const METHODS: &[(&str, &str, BoundFn)] = &[
        ("replace", "old new count? /", |ev, args| {
            bytes_parts::replace(ev, args)
        }),
        ("split", "sep? maxsplit?", |ev, args| {
            bytes_parts::split(ev, args, SearchEnd::Left)
        }),
        ("rsplit", "sep? maxsplit?", |ev, args| {
            bytes_parts::split(ev, args, SearchEnd::Right)
        }),
        ("partition", "sep /", |ev, args| {
            bytes_parts::partition(ev, args, SearchEnd::Left)
        }),
        ("rpartition", "sep /", |ev, args| {
            bytes_parts::partition(ev, args, SearchEnd::Right)
        }),
        ("find", "sub start? end? /", |ev, args| {
            bytes_search::find(ev, args, SearchEnd::Left, false)
        }),
        ("rfind", "sub start? end? /", |ev, args| {
            bytes_search::find(ev, args, SearchEnd::Right, false)
        }),
        ("index", "sub start? end? /", |ev, args| {
            bytes_search::find(ev, args, SearchEnd::Left, true)
        }),
        ("rindex", "sub start? end? /", |ev, args| {
            bytes_search::find(ev, args, SearchEnd::Right, true)
        }),
        ("count", "sub start? end? /", |ev, args| {
            bytes_search::count(ev, args)
        }),
        ("startswith", "prefix start? end? /", |ev, args| {
            bytes_search::affix(ev, args, SearchEnd::Left)
        }),
        ("endswith", "suffix start? end? /", |ev, args| {
            bytes_search::affix(ev, args, SearchEnd::Right)
        }),
        ("removeprefix", "prefix /", |ev, args| {
            bytes_parts::without_affix(ev, args, SearchEnd::Left)
        }),
        ("removesuffix", "suffix /", |ev, args| {
            bytes_parts::without_affix(ev, args, SearchEnd::Right)
        }),
        ("strip", "chars? /", |ev, args| {
            bytes_parts::strip(ev, args, None)
        }),
        ("lstrip", "chars? /", |ev, args| {
            bytes_parts::strip(ev, args, Some(SearchEnd::Left))
        }),
        ("rstrip", "chars? /", |ev, args| {
            bytes_parts::strip(ev, args, Some(SearchEnd::Right))
        }),
        ("center", "width fillchar? /", |ev, args| {
            bytes_layout::pad(ev, args, "center", BytesAlignment::Centre)
        }),
        ("ljust", "width fillchar? /", |ev, args| {
            bytes_layout::pad(ev, args, "ljust", BytesAlignment::Left)
        }),
        ("rjust", "width fillchar? /", |ev, args| {
            bytes_layout::pad(ev, args, "rjust", BytesAlignment::Right)
        }),
        ("zfill", "width /", |ev, args| bytes_layout::zfill(ev, args)),
        ("expandtabs", "tabsize?", |ev, args| {
            bytes_layout::expandtabs(ev, args)
        }),
        ("join", "iterable /", join),
        ("splitlines", "keepends?", splitlines),
    ];
    methods(core, class, METHODS);
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
                all(ev, args, |byte| SPACES.contains(&byte))
            }),
            ("isascii", "", |ev, args| {
                let data = receiver(ev, &args[0])?;
                Ok(Value::Bool(ev.all_bytes(&data, u8::is_ascii)?))
            }),
            ("isupper", "", |ev, args| {
                cased(ev, args, u8::is_ascii_uppercase, u8::is_ascii_lowercase)
            }),
            ("islower", "", |ev, args| {
                cased(ev, args, u8::is_ascii_lowercase, u8::is_ascii_uppercase)
            }),
            ("istitle", "", |ev, args| {
                let data = receiver(ev, &args[0])?;
                let mut title = TitleCaseCheck::default();
                for piece in data.chunks(CHUNK) {
                    let ascii = piece.iter().map(|byte| match byte.is_ascii() {
                        true => char::from(*byte),
                        false => ' ',
                    });
                    if !title.goes_on(ascii) {
                        return Ok(Value::Bool(false));
                    }
                    ev.charge(piece.len() * WORK_PER_BYTE)?;
                }
                Ok(Value::Bool(title.is_one()))
            }),
            ("translate", "table / delete?", translate),
            ("decode", "encoding? errors?", |ev, args| {
                ev.decode(&receiver(ev, &args[0])?, &args[1], &args[2])
            }),
            ("hex", "sep? bytes_per_sep?", hex),
        ],
    );
}

fn install_mutable(core: &Rc<InterpreterState>, class: &Class) {
    methods(
        core,
        class,
        &[
            ("append", "item /", |ev, args| {
                let byte = ev.byte(&args[1])?;
                let bytes = mutable(ev, &args[0])?;
                ev.grow_bytes(&bytes, 1)?;
                bytes.append(|data| data.push(byte));
                Ok(Value::None)
            }),
            ("extend", "iterable /", |ev, args| {
                let more = match ev.bytes_like(&args[1]) {
                    Some(more) => more,
                    None => {
                        let items = ev.iter_or(&args[1], || {
                            let name = ev.core.types.name_of(&args[1]);
                            format!("can't extend bytearray with {name}")
                        })?;
                        // CPython makes room for as many as there will be, so the object is asked how many.
                        if let Value::Instance(instance) = &args[1]
                            && instance.class.lookup(known::LEN).is_some()
                            && let Err(raised) = ev.len(&args[1])
                            && !ev.is_kind(&raised, ExceptionKind::TypeError)
                        {
                            return Err(raised);
                        }
                        BytesRef::Snapshot(Rc::new(ev.collect_bytes(&items)?.into()))
                    }
                };
                let bytes = mutable(ev, &args[0])?;
                ev.extend_bytes(&bytes, more)?;
                Ok(Value::None)
            }),
            ("insert", "index item /", |ev, args| {
                let bytes = mutable(ev, &args[0])?;
                let index = ev.index(&args[1])?;
                let byte = ev.byte(&args[2])?;
                let place = |length| super::insertion_place(index, length);
                ev.grow_bytes(&bytes, 1)?;
                bytes.change(|data| data.insert(place(data.len()), byte));
                Ok(Value::None)
            }),
            ("pop", "index? /", |ev, args| {
                let bytes = mutable(ev, &args[0])?;
                let index = args[1].if_given().map_or(Ok(-1), |index| ev.index(index))?;
                ev.grow_bytes(&bytes, 0)?;
                let popped = remove_byte(&bytes, |length| ev.place(index, length));
                match popped {
                    Some(byte) => Ok(Value::Int(i64::from(byte))),
                    None if bytes.is_empty() => {
                        Err(ev.raise(ExceptionKind::IndexError, "pop from empty bytearray"))
                    }
                    None => Err(ev.raise(ExceptionKind::IndexError, "pop index out of range")),
                }
            }),
            ("remove", "value /", |ev, args| {
                let (bytes, byte) = (mutable(ev, &args[0])?, ev.byte(&args[1])?);
                let place = ev.find_bytes(&bytes.snapshot(), &[byte])?;
                ev.grow_bytes(&bytes, 0)?;
                match place {
                    Some(index) => {
                        bytes.change(|data| (index < data.len()).then(|| data.remove(index)));
                        Ok(Value::None)
                    }
                    None => Err(ev.value_error("value not found in bytearray")),
                }
            }),
            ("clear", "", |ev, args| {
                mutable(ev, &args[0])?.put(Vec::new());
                Ok(Value::None)
            }),
            ("reverse", "", |ev, args| {
                let bytes = mutable(ev, &args[0])?;
                ev.grow_bytes(&bytes, 0)?;
                bytes.change(|data| data.reverse());
                Ok(Value::None)
            }),
            ("copy", "", |ev, args| {
                let bytes = mutable(ev, &args[0])?.snapshot();
                Ok(bytearray(ev.copy_bytes(&bytes)?))
            }),
            ("__init__", "source? encoding? errors?", |ev, args| {
                let data = data(ev, &args[1..], "bytearray")?;
                let bytes = mutable(ev, &args[0])?;
                bytes.put(data);
                Ok(Value::None)
            }),
        ],
    );
}

pub(super) fn receiver(ev: &Evaluator<'_>, value: &Value) -> R<BytesRef> {
    ev.bytes_like(value)
        .ok_or_else(|| wrong_receiver(ev, "bytes", value))
}

fn mutable(ev: &Evaluator<'_>, value: &Value) -> R<Rc<ByteArray>> {
    match ev.unwrap_builtin(value) {
        Value::ByteArray(bytes) => Ok(bytes),
        other => Err(wrong_receiver(ev, "bytearray", &other)),
    }
}

/// Bytes of the receiver's type.
pub(super) fn like(ev: &Evaluator<'_>, receiver: &Value, data: Vec<u8>) -> Value {
    match ev.unwrap_builtin(receiver) {
        Value::ByteArray(_) => bytearray(data),
        _ => Value::Bytes(Rc::new(Bytes::new(data))),
    }
}

fn join(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let separator = receiver(ev, &args[0])?;
    let mut out = Vec::new();
    let message = || "can only join an iterable".to_owned();
    let items = match &args[1] {
        object @ Value::Instance(_) => ev.collect_rest(&ev.iter_or(object, message)?)?,
        other => ev.collect_or(other, message)?,
    };
    for (index, item) in items.iter().enumerate() {
        let Some(data) = ev.bytes_like(item) else {
            let name = ev.core.types.name_of(item);
            let text = format!("sequence item {index}: expected a bytes-like object, {name} found");
            return Err(ev.type_error(text));
        };
        if index > 0 {
            ev.push_bytes(&mut out, &separator)?;
        }
        ev.push_bytes(&mut out, &data)?;
        ev.charge(WORK_PER_BYTE)?;
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
    let removed = match args[2].if_given() {
        Some(value) => ev
            .bytes_like(value)
            .ok_or_else(|| not_bytes_like(ev, value))?,
        None => BytesRef::default(),
    };
    let mut is_removed = [false; 256];
    for piece in removed.chunks(CHUNK) {
        for byte in piece {
            is_removed[usize::from(*byte)] = true;
        }
        ev.charge(piece.len())?;
    }
    let out = ev.map_bytes(&data, |piece, out| {
        let kept = piece.iter().filter(|byte| !is_removed[usize::from(**byte)]);
        out.extend(kept.map(|byte| match &table {
            Some(table) => table[usize::from(*byte)],
            None => *byte,
        }));
    })?;
    Ok(like(ev, &args[0], out))
}

pub(super) fn not_bytes_like(ev: &Evaluator<'_>, value: &Value) -> crate::value::Unwind {
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
    for (from, to) in from.chunks(CHUNK).zip(to.chunks(CHUNK)) {
        for (from, to) in from.iter().zip(to) {
            table[usize::from(*from)] = *to;
        }
        ev.charge(from.len() * WORK_PER_BYTE)?;
    }
    Ok(Value::Bytes(Rc::new(Bytes::new(table))))
}

fn splitlines(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let keep = args[1].if_given().map_or(Ok(0), |value| ev.c_int(value))? != 0;
    let data = receiver(ev, &args[0])?;
    let is_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
    let mut lines = ValueVec::default();
    let mut rest = &data[..];
    while !rest.is_empty() {
        let mut line = 0;
        for piece in rest.chunks(CHUNK) {
            let found = piece.iter().position(is_end);
            line += found.unwrap_or(piece.len());
            ev.charge(found.unwrap_or(piece.len()))?;
            if found.is_some() {
                break;
            }
        }
        let end = match rest[line..].starts_with(b"\r\n") {
            true => line + 2,
            false => (line + 1).min(rest.len()),
        };
        ev.grow(&mut *lines, 1)?;
        let part = &rest[..if keep { end } else { line }];
        lines.push(like(ev, &args[0], ev.copy_bytes(part)?));
        ev.check_memory()?;
        ev.charge(WORK_PER_BYTE)?;
        rest = &rest[end..];
    }
    Ok(lines.into_list())
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
    let mut before = None;
    let out = ev.map_bytes(&data, |piece, out| {
        out.extend(piece.iter().map(|byte| {
            let mapped = map(*byte, before);
            before = Some(*byte);
            mapped
        }));
    })?;
    Ok(like(ev, &args[0], out))
}

fn all(ev: &Evaluator<'_>, args: &[Value], test: impl Fn(u8) -> bool) -> R {
    let data = receiver(ev, &args[0])?;
    let all = !data.is_empty() && ev.all_bytes(&data, |byte| test(*byte))?;
    Ok(Value::Bool(all))
}

fn cased(ev: &Evaluator<'_>, args: &[Value], wanted: fn(&u8) -> bool, other: fn(&u8) -> bool) -> R {
    let data = receiver(ev, &args[0])?;
    let none = |test: fn(&u8) -> bool| ev.all_bytes(&data, |byte| !test(byte));
    Ok(Value::Bool(!none(wanted)? && none(other)?))
}

/// Takes a byte out, if there is one at that place.
pub(crate) fn remove_byte(
    bytes: &ByteArray,
    place: impl FnOnce(usize) -> Option<usize>,
) -> Option<u8> {
    let place = place(bytes.len())?;
    if place == 0 {
        let first = bytes.borrow().first().copied();
        bytes.cut_front(1);
        return first;
    }
    Some(bytes.change(|data| data.remove(place)))
}
