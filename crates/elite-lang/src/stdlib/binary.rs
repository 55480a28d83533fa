//! `_struct`: values to bytes and back by a format, as C lays out structures.

use num_bigint::{BigInt, Sign};

use super::define::Builder;
use crate::eval::Evaluator;
use crate::eval::bulk::{EACH, STRIDE, many};
use crate::value::int::Int;
use crate::value::{Bytes, R, Raised, Value};

pub(super) fn fill(module: &Builder<'_, '_>) -> R<()> {
    module.functions(&[
        ("_size", "format error /", |ev, args| {
            Ok(Value::Int(
                Format::parse(ev, &args[0], &args[1])?.size as i64,
            ))
        }),
        ("_pack", "format values error /", pack),
        ("_unpack", "format data offset error /", unpack),
    ]);
    Ok(())
}

/// Largest structure.
const SIZE_MAX: usize = 64 << 20;

struct Format {
    little: bool,
    native: bool,
    /// Kind, how often (for `s` and `p` the length), offset.
    fields: Vec<(u8, usize, usize)>,
    /// Values it takes.
    values: usize,
    size: usize,
}

#[cold]
fn fail(ev: &Evaluator<'_>, class: &Value, message: impl Into<String>) -> Raised {
    match ev.call1(class, Value::str(message.into())) {
        Ok(Value::Instance(exception)) => Raised::Exception(exception),
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

impl Format {
    fn parse(ev: &Evaluator<'_>, format: &Value, error: &Value) -> R<Format> {
        let text = match ev.plain(format) {
            Value::Str(text) => ev.copied_bytes(text.as_str().as_bytes())?,
            other => match ev.bytes_like(&other) {
                Some(data) => ev.copied_bytes(&data)?,
                None => {
                    let name = ev.core.types.name_of(&other);
                    return Err(ev.type_error(format!(
                        "Struct() argument 1 must be a str or bytes object, not {name}"
                    )));
                }
            },
        };
        let (native, aligned, little, codes) = match text.first() {
            Some(b'<') => (false, false, true, &text[1..]),
            Some(b'>' | b'!') => (false, false, false, &text[1..]),
            Some(b'=') => (false, false, true, &text[1..]),
            Some(b'@') => (true, true, true, &text[1..]),
            _ => (true, true, true, &text[..]),
        };
        let mut made = Format {
            little,
            native,
            fields: Vec::new(),
            values: 0,
            size: 0,
        };
        let mut count: Option<usize> = None;
        for code in codes {
            ev.worked(EACH)?;
            if code.is_ascii_digit() {
                let digit = usize::from(code - b'0');
                let next = count.unwrap_or(0) * 10 + digit;
                if next > SIZE_MAX {
                    return Err(fail(ev, error, "total struct size too long"));
                }
                count = Some(next);
                continue;
            }
            if code.is_ascii_whitespace() {
                if count.is_some() {
                    return Err(fail(ev, error, "bad char in struct format"));
                }
                continue;
            }
            let Some(width) = width(*code, native) else {
                return Err(fail(ev, error, "bad char in struct format"));
            };
            let times = count.take().unwrap_or(1);
            if aligned {
                made.size = made.size.next_multiple_of(width);
            }
            let total = made.size + width * times;
            if total > SIZE_MAX {
                return Err(fail(ev, error, "total struct size too long"));
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
                        ev.worked(EACH)?;
                        made.fields.push((*code, width, made.size + index * width));
                    }
                    made.values += times;
                }
            }
            made.size = total;
        }
        if count.is_some() {
            return Err(fail(
                ev,
                error,
                "repeat count given without format specifier",
            ));
        }
        Ok(made)
    }
}

fn pack(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let error = args[2].clone();
    let format = Format::parse(ev, &args[0], &error)?;
    let values = ev.collect(&args[1])?;
    if values.len() != format.values {
        let (wanted, got) = (format.values, values.len());
        return Err(fail(
            ev,
            &error,
            format!("pack expected {wanted} items for packing (got {got})"),
        ));
    }
    let mut out = vec![0; format.size];
    for ((code, width, offset), value) in format.fields.iter().zip(&values) {
        ev.worked(4 * EACH)?;
        let place = &mut out[*offset..*offset + *width];
        pack_one(ev, *code, format.native, value, place, &error)?;
        if format.little && !matches!(code, b's' | b'p' | b'c') {
            place.reverse();
        }
    }
    Ok(Value::Bytes(std::rc::Rc::new(Bytes::new(out))))
}

/// Writes one value, big end first.
fn pack_one(
    ev: &Evaluator<'_>,
    code: u8,
    native: bool,
    value: &Value,
    place: &mut [u8],
    error: &Value,
) -> R<()> {
    match code {
        b'?' => place[0] = u8::from(ev.truth(value)?),
        b'f' | b'd' | b'e' => {
            let Ok(float) = ev.to_f64(value) else {
                return Err(fail(ev, error, "required argument is not a float"));
            };
            match code {
                b'd' => place.copy_from_slice(&float.to_be_bytes()),
                b'f' => {
                    let single = float as f32;
                    // The native format lets C convert, which makes it infinite.
                    if !native && single.is_infinite() && float.is_finite() {
                        let text = "float too large to pack with f format";
                        return Err(ev.raise(crate::errors::ExceptionKind::OverflowError, text));
                    }
                    place.copy_from_slice(&single.to_be_bytes());
                }
                _ => {
                    let Some(half) = half_from_f64(float) else {
                        let text = "float too large to pack with e format";
                        return Err(ev.raise(crate::errors::ExceptionKind::OverflowError, text));
                    };
                    place.copy_from_slice(&half.to_be_bytes());
                }
            }
        }
        b'c' => match ev.bytes_like(value).as_deref() {
            Some([byte]) => place[0] = *byte,
            _ => {
                return Err(fail(
                    ev,
                    error,
                    "char format requires a bytes object of length 1",
                ));
            }
        },
        b's' | b'p' => {
            let Some(data) = ev.bytes_like(value) else {
                return Err(fail(
                    ev,
                    error,
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
            for (to, from) in body[..length].chunks_mut(STRIDE).zip(data.chunks(STRIDE)) {
                to.copy_from_slice(&from[..to.len()]);
                ev.worked(many(to.len()))?;
            }
        }
        _ => pack_int(ev, code, native, value, place, error)?,
    }
    Ok(())
}

fn pack_int(
    ev: &Evaluator<'_>,
    code: u8,
    native: bool,
    value: &Value,
    place: &mut [u8],
    error: &Value,
) -> R<()> {
    let Ok(int) = ev.to_int(value) else {
        return Err(fail(ev, error, "required argument is not an integer"));
    };
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
        None if bits < 64 && matches!(int, Int::Big(_)) => {
            Err(fail(ev, error, "argument out of range"))
        }
        None if unsigned && bits >= 32 && int.is_negative() => {
            Err(fail(ev, error, "argument out of range"))
        }
        None if bits == 64 && unsigned => Err(fail(ev, error, "argument out of range")),
        None if bits == 64 && native => Err(fail(ev, error, "argument out of range")),
        None if bits == 64 => Err(fail(ev, error, "int too large to convert")),
        None => {
            let code = char::from(code);
            let text = format!("'{code}' format requires {least} <= number <= {most}");
            let text = if matches!(code, 'b' | 'B') {
                let kind = if unsigned { "ubyte" } else { "byte" };
                format!("{kind} format requires {least} <= number <= {most}")
            } else if matches!(code, 'h' | 'H') {
                let kind = if unsigned { "ushort" } else { "short" };
                format!("{kind} format requires {least} <= number <= {most}")
            } else {
                text
            };
            Err(fail(ev, error, text))
        }
    }
}

fn unpack(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let error = args[3].clone();
    let format = Format::parse(ev, &args[0], &error)?;
    let Some(data) = ev.bytes_like(&args[1]) else {
        let name = ev.core.types.name_of(&args[1]);
        return Err(ev.type_error(format!("a bytes-like object is required, not '{name}'")));
    };
    let data = match args[2] {
        Value::None => {
            if data.len() != format.size {
                return Err(fail(
                    ev,
                    &error,
                    format!("unpack requires a buffer of {} bytes", format.size),
                ));
            }
            &data[..]
        }
        _ => {
            let (given, length) = (ev.index(&args[2])?, data.len() as i64);
            let offset = if given < 0 { given + length } else { given };
            let left = length - offset;
            if offset < 0 {
                return Err(fail(
                    ev,
                    &error,
                    format!("offset {given} out of range for {length}-byte buffer"),
                ));
            }
            if left < format.size as i64 {
                let (size, needed) = (format.size, offset + format.size as i64);
                let text = format!(
                    "unpack_from requires a buffer of at least {needed} bytes for unpacking {size} bytes at offset {offset} (actual buffer size is {length})"
                );
                return Err(fail(ev, &error, text));
            }
            &data[offset as usize..]
        }
    };
    // Each field is a number or a text of its own.
    ev.ask_for_pieces(data.len(), || format.fields.len())?;
    let mut values = Vec::with_capacity(format.fields.len());
    for (code, width, offset) in &format.fields {
        ev.worked(4 * EACH)?;
        let mut field = ev.copied_bytes(&data[*offset..*offset + *width])?;
        if format.little && !matches!(code, b's' | b'p' | b'c') {
            field.reverse();
        }
        values.push(unpack_one(*code, field));
    }
    Ok(Value::tuple(values))
}

/// Reads one value from bytes, big end first.
fn unpack_one(code: u8, field: Vec<u8>) -> Value {
    let unsigned = || {
        field
            .iter()
            .fold(0u64, |value, byte| value << 8 | u64::from(*byte))
    };
    match code {
        b'?' => Value::Bool(field.iter().any(|byte| *byte != 0)),
        b'd' => Value::Float(f64::from_bits(unsigned())),
        b'f' => Value::Float(f64::from(f32::from_bits(unsigned() as u32))),
        b'e' => Value::Float(f64_from_half(unsigned() as u16)),
        b'c' | b's' => Value::Bytes(std::rc::Rc::new(Bytes::new(field))),
        b'p' => {
            let length = field.first().map_or(0, |length| usize::from(*length));
            let body = field.get(1..).unwrap_or_default();
            Value::Bytes(std::rc::Rc::new(Bytes::new(
                body[..length.min(body.len())].to_vec(),
            )))
        }
        code if code.is_ascii_uppercase() => {
            Value::bigint(BigInt::from_bytes_be(Sign::Plus, &field))
        }
        _ => Value::bigint(BigInt::from_signed_bytes_be(&field)),
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
