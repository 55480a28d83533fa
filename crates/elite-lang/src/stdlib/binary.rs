//! `_struct`: values to bytes and back by a format, as C lays out structures.

use std::cell::RefCell;
use std::rc::Rc;

use num_bigint::BigInt;

use super::define::{ModuleBuilder, native_class};
use crate::builtins::Args;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::chunked::{BULK_CHUNK, WORK_PER_BYTE, bulk_work};
use crate::value::int::Int;
use crate::value::{Bytes, R, Unwind, Value};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    let exception = module
        .core()
        .types
        .exception(ExceptionKind::Exception)
        .clone();
    module.derived_class("error", &exception, &[])?;
    module.raw("pack", pack);
    module.functions(&[
        ("calcsize", "format /", |ev, args| {
            let format = StructFormat::cached(ev, &args[0])?;
            Ok(Value::Int(format.size as i64))
        }),
        ("unpack", "format buffer /", |ev, args| {
            unpack(ev, &args[0], &args[1], None)
        }),
        ("unpack_from", "format buffer offset?", |ev, args| {
            let from = args[2].if_given().unwrap_or(&Value::Int(0));
            unpack(ev, &args[0], &args[1], Some(from))
        }),
    ]);
    Ok(())
}

/// Largest structure.
const SIZE_MAX: usize = 64 << 20;

/// Formats that are kept, how long their texts and how many their fields may be.
const KEPT: usize = 16;
const KEPT_TEXT: usize = 64;
const KEPT_FIELDS: usize = 64;

/// A format with its text.
type CachedFormat = (Box<[u8]>, Rc<StructFormat>);

/// Formats that were used lately, by their texts.
#[derive(Default)]
pub struct FormatCache(RefCell<Vec<CachedFormat>>);

impl FormatCache {
    fn find(&self, text: &[u8]) -> Option<Rc<StructFormat>> {
        let kept = self.0.borrow();
        let found = kept.iter().find(|(known, _)| **known == *text);
        found.map(|(_, format)| format.clone())
    }

    fn keep(&self, text: &[u8], format: &Rc<StructFormat>) {
        if text.len() > KEPT_TEXT || format.fields.len() > KEPT_FIELDS {
            return;
        }
        let mut kept = self.0.borrow_mut();
        kept.truncate(KEPT - 1);
        kept.insert(0, (text.into(), format.clone()));
    }
}

/// What a format says.
pub struct StructFormat {
    little: bool,
    native: bool,
    /// Kind, how often (for `s` and `p` the length), offset.
    fields: Vec<(u8, usize, usize)>,
    /// Values it takes.
    values: usize,
    size: usize,
}

#[cold]
fn fail(ev: &Evaluator<'_>, message: impl Into<String>) -> Unwind {
    let made = native_class(ev, "_struct.error")
        .and_then(|class| ev.call1(&Value::Class(class), Value::str(message.into())));
    match made {
        Ok(Value::Instance(exception)) => Unwind::Exception(exception),
        Ok(_) => ev.value_error("bad error class"),
        Err(raised) => raised,
    }
}

/// Bytes of one item in the native and in the standard layout; native ones are aligned to their size.
fn width(code: u8, native: bool) -> Option<usize> {
    Some(match code {
        b'x' | b'c' | b'b' | b'B' | b'?' | b's' | b'p' => 1,
        b'h' | b'H' | b'e' => 2,
        b'i' | b'I' | b'f' => 4,
        b'l' | b'L' => {
            if native {
                8
            } else {
                4
            }
        }
        b'q' | b'Q' | b'd' => 8,
        b'n' | b'N' | b'P' if native => 8,
        _ => return None,
    })
}

impl StructFormat {
    fn cached(ev: &Evaluator<'_>, format: &Value) -> R<Rc<StructFormat>> {
        let formats = &ev.core.module_state.formats;
        if let Value::Str(text) = format
            && let Some(known) = formats.find(text.as_str().as_bytes())
        {
            return Ok(known);
        }
        let text = match ev.unwrap_builtin(format) {
            Value::Str(text) => ev.encode(&text, &Value::str("ascii"), &Value::Unbound)?,
            other => match ev.bytes_like(&other) {
                Some(data) => ev.copy_bytes(&data)?,
                None => {
                    let name = ev.core.types.name_of(&other);
                    return Err(ev.type_error(format!(
                        "Struct() argument 1 must be a str or bytes object, not {name}"
                    )));
                }
            },
        };
        let format = Rc::new(StructFormat::parse(ev, &text)?);
        formats.keep(&text, &format);
        Ok(format)
    }

    fn parse(ev: &Evaluator<'_>, text: &[u8]) -> R<StructFormat> {
        let (native, aligned, little, codes) = match text.first() {
            Some(b'<') => (false, false, true, &text[1..]),
            Some(b'>' | b'!') => (false, false, false, &text[1..]),
            Some(b'=') => (false, false, true, &text[1..]),
            Some(b'@') => (true, true, true, &text[1..]),
            _ => (true, true, true, text),
        };
        let mut made = StructFormat {
            little,
            native,
            fields: Vec::new(),
            values: 0,
            size: 0,
        };
        let mut count: Option<usize> = None;
        for code in codes {
            ev.charge(WORK_PER_BYTE)?;
            if code.is_ascii_digit() {
                let digit = usize::from(code - b'0');
                let next = count.unwrap_or(0) * 10 + digit;
                if next > SIZE_MAX {
                    return Err(fail(ev, "total struct size too long"));
                }
                count = Some(next);
                continue;
            }
            if code.is_ascii_whitespace() {
                if count.is_some() {
                    return Err(fail(ev, "bad char in struct format"));
                }
                continue;
            }
            let Some(width) = width(*code, native) else {
                return Err(fail(ev, "bad char in struct format"));
            };
            let times = count.take().unwrap_or(1);
            if aligned {
                made.size = made.size.next_multiple_of(width);
            }
            let total = made.size + width * times;
            if total > SIZE_MAX {
                return Err(fail(ev, "total struct size too long"));
            }
            match code {
                b'x' => {}
                b's' | b'p' => {
                    made.fields.push((*code, times, made.size));
                    made.values += 1;
                }
                _ => {
                    ev.grow(&mut made.fields, times)?;
                    for index in 0..times {
                        ev.charge(WORK_PER_BYTE)?;
                        made.fields.push((*code, width, made.size + index * width));
                    }
                    made.values += times;
                }
            }
            made.size = total;
        }
        if count.is_some() {
            return Err(fail(ev, "repeat count given without format specifier"));
        }
        Ok(made)
    }
}

fn pack(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    if !args.keywords.is_empty() {
        return Err(ev.type_error("_struct.pack() takes no keyword arguments"));
    }
    let Some((format, values)) = args.positional.split_first() else {
        return Err(ev.type_error("pack expected at least 1 argument, got 0"));
    };
    let format = StructFormat::cached(ev, format)?;
    if values.len() != format.values {
        let (wanted, got) = (format.values, values.len());
        let text = format!("pack expected {wanted} items for packing (got {got})");
        return Err(fail(ev, text));
    }
    ev.check_allocation(format.size)?;
    let mut out = vec![0; format.size];
    for ((code, width, offset), value) in format.fields.iter().zip(values) {
        ev.charge(4 * WORK_PER_BYTE)?;
        let place = &mut out[*offset..*offset + *width];
        pack_one(ev, *code, &format, value, place)?;
        if format.little && !matches!(code, b's' | b'p' | b'c') {
            place.reverse();
        }
    }
    Ok(Value::Bytes(Rc::new(Bytes::new(out))))
}

/// Writes one value, big end first.
fn pack_one(
    ev: &Evaluator<'_>,
    code: u8,
    format: &StructFormat,
    value: &Value,
    place: &mut [u8],
) -> R<()> {
    match code {
        b'?' => place[0] = u8::from(ev.truth(value)?),
        b'f' | b'd' | b'e' => {
            let Ok(float) = ev.to_f64(value) else {
                return Err(fail(ev, "required argument is not a float"));
            };
            match code {
                b'd' => place.copy_from_slice(&float.to_be_bytes()),
                b'f' => {
                    let single = float as f32;
                    // The native format lets C convert, which makes it infinite.
                    if !format.native && single.is_infinite() && float.is_finite() {
                        return Err(too_large(ev, value, 'f'));
                    }
                    place.copy_from_slice(&single.to_be_bytes());
                }
                _ => {
                    let Some(half) = half_from_f64(float) else {
                        return Err(too_large(ev, value, 'e'));
                    };
                    place.copy_from_slice(&half.to_be_bytes());
                }
            }
        }
        b'c' => match &ev.unwrap_builtin(value) {
            // Only this one takes no bytearray.
            Value::Bytes(bytes) if bytes.data().len() == 1 => place[0] = bytes.data()[0],
            _ => {
                return Err(fail(ev, "char format requires a bytes object of length 1"));
            }
        },
        b's' | b'p' => {
            let Some(data) = ev.bytes_like(value) else {
                return Err(fail(
                    ev,
                    format!("argument for '{}' must be a bytes object", char::from(code)),
                ));
            };
            let body = if code == b'p' && !place.is_empty() {
                let most = (place.len() - 1).min(255);
                place[0] = data.len().min(most) as u8;
                &mut place[1..]
            } else {
                place
            };
            let length = data.len().min(body.len());
            for (to, from) in body[..length]
                .chunks_mut(BULK_CHUNK)
                .zip(data.chunks(BULK_CHUNK))
            {
                to.copy_from_slice(&from[..to.len()]);
                ev.charge(bulk_work(to.len()))?;
            }
        }
        _ => pack_int(ev, code, format, value, place)?,
    }
    Ok(())
}

/// A number beyond a format of floats. Integers are refused in other words.
fn too_large(ev: &Evaluator<'_>, value: &Value, code: char) -> Unwind {
    if ev.has_index(value) {
        return fail(ev, "int too large to convert");
    }
    let text = format!("float too large to pack with {code} format");
    ev.raise(crate::errors::ExceptionKind::OverflowError, text)
}

fn pack_int(
    ev: &Evaluator<'_>,
    code: u8,
    format: &StructFormat,
    value: &Value,
    place: &mut [u8],
) -> R<()> {
    if !ev.has_index(value) {
        return Err(fail(ev, "required argument is not an integer"));
    }
    let int = ev.to_int(value)?;
    let bits = place.len() as u32 * 8;
    let unsigned = code.is_ascii_uppercase();
    let wide: Option<i128> = match &int {
        Int::Small(small) => Some(i128::from(*small)),
        Int::Big(big) => i128::try_from(&**big).ok(),
    };
    let (least, most): (i128, i128) = if code == b'P' {
        // An address: negative ones wrap.
        (-(1 << 63), (1 << 64) - 1)
    } else if unsigned {
        (0, (1 << bits) - 1)
    } else {
        (-(1 << (bits - 1)), (1 << (bits - 1)) - 1)
    };
    match wide.filter(|value| (least..=most).contains(value)) {
        Some(value) => {
            let bytes = value.to_be_bytes();
            place.copy_from_slice(&bytes[16 - place.len()..]);
            Ok(())
        }
        None if code == b'P' => Err(fail(ev, "int too large to convert")),
        // What fits the `unsigned long` of C is out of the format's range instead.
        None if bits < 64
            && matches!(int, Int::Big(_))
            && !((matches!(code, b'I' | b'L') || code == b'H' && !format.little)
                && !int.is_negative()
                && int.bits() <= 64) =>
        {
            Err(fail(ev, "argument out of range"))
        }
        None if unsigned && int.is_negative() && (bits == 32 || code == b'H' && !format.little) => {
            Err(fail(ev, "argument out of range"))
        }
        // In this machine's own order CPython packs them as the native ones.
        None if bits == 64 && format.little => Err(fail(ev, "argument out of range")),
        None if bits == 64 => Err(fail(ev, "int too large to convert")),
        None => {
            let code = char::from(code);
            let text = format!("'{code}' format requires {least} <= number <= {most}");
            let text = if matches!(code, 'b' | 'B') {
                let kind = if unsigned { "ubyte" } else { "byte" };
                format!("{kind} format requires {least} <= number <= {most}")
            } else if matches!(code, 'h' | 'H') && format.little {
                let kind = if unsigned { "ushort" } else { "short" };
                format!("{kind} format requires {least} <= number <= {most}")
            } else {
                text
            };
            Err(fail(ev, text))
        }
    }
}

fn unpack(ev: &Evaluator<'_>, format: &Value, buffer: &Value, from: Option<&Value>) -> R {
    let format = StructFormat::cached(ev, format)?;
    let Some(data) = ev.bytes_like(buffer) else {
        let name = ev.core.types.name_of(buffer);
        return Err(ev.type_error(format!("a bytes-like object is required, not '{name}'")));
    };
    let data = match from {
        None => {
            if data.len() != format.size {
                let text = format!("unpack requires a buffer of {} bytes", format.size);
                return Err(fail(ev, text));
            }
            &data[..]
        }
        Some(from) => {
            let (given, length) = (ev.index(from)?, data.len() as i64);
            let offset = if given < 0 {
                given.saturating_add(length)
            } else {
                given
            };
            if offset < 0 {
                let text = format!("offset {given} out of range for {length}-byte buffer");
                return Err(fail(ev, text));
            }
            let left = length.saturating_sub(offset);
            if left < format.size as i64 {
                let size = format.size;
                let needed = offset.saturating_add(size as i64);
                let text = format!(
                    "unpack_from requires a buffer of at least {needed} bytes for unpacking {size} bytes at offset \
                     {offset} (actual buffer size is {length})"
                );
                return Err(fail(ev, text));
            }
            &data[offset as usize..]
        }
    };
    // Each field is a number or a text of its own.
    ev.check_split_allocation(data.len(), || format.fields.len())?;
    let mut values = Vec::with_capacity(format.fields.len());
    for (code, width, offset) in &format.fields {
        ev.charge(4 * WORK_PER_BYTE)?;
        let field = &data[*offset..*offset + *width];
        values.push(match code {
            b'c' | b's' => text_value(ev.copy_bytes(field)?),
            b'p' => {
                let (length, body) = field.split_first().map_or((0, field), |(length, body)| {
                    (usize::from(*length).min(body.len()), body)
                });
                text_value(ev.copy_bytes(&body[..length])?)
            }
            _ => number(*code, format.little, field),
        });
    }
    Ok(Value::tuple(values))
}

fn text_value(bytes: Vec<u8>) -> Value {
    Value::Bytes(Rc::new(Bytes::new(bytes)))
}

/// Reads a number of at most eight bytes.
fn number(code: u8, little: bool, field: &[u8]) -> Value {
    let place = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
    let bits = match little {
        true => field.iter().rev().fold(0, place),
        false => field.iter().fold(0, place),
    };
    match code {
        b'?' => Value::Bool(bits != 0),
        b'd' => Value::Float(f64::from_bits(bits)),
        b'f' => Value::Float(f64::from(f32::from_bits(bits as u32))),
        b'e' => Value::Float(f64_from_half(bits as u16)),
        code if code.is_ascii_uppercase() => match i64::try_from(bits) {
            Ok(int) => Value::Int(int),
            Err(_) => Value::bigint(BigInt::from(bits)),
        },
        _ => {
            let unused = 64 - 8 * field.len() as u32;
            Value::Int((bits << unused) as i64 >> unused)
        }
    }
}

/// The nearest half-precision number (IEEE 754 binary16), ties to even; None if it is out of range.
fn half_from_f64(value: f64) -> Option<u16> {
    let sign = u16::from(value.is_sign_negative()) << 15;
    if value.is_nan() {
        return Some(sign | 0x7e00);
    }
    if value.is_infinite() {
        return Some(sign | 0x7c00);
    }
    let magnitude = value.abs();
    if magnitude == 0.0 {
        return Some(sign);
    }
    // Numbers below 2^-14 share the spacing 2^-24.
    let (_, exponent) = libm::frexp(magnitude);
    let exponent = (exponent - 1).max(-14);
    let units = libm::rint(libm::ldexp(magnitude, 10 - exponent));
    let bits = units as i64 + (i64::from(exponent) + 14) * 1024;
    if units >= 1024.0 && bits >= 0x7c00 {
        None
    } else {
        Some(sign | bits as u16)
    }
}

fn f64_from_half(half: u16) -> f64 {
    let sign = if half >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(half >> 10 & 0x1f), f64::from(half & 0x3ff));
    sign * match exponent {
        0 => libm::ldexp(fraction, -24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => libm::ldexp(1024.0 + fraction, exponent - 25),
    }
}
