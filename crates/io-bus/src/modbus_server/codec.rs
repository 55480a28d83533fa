//! Modbus requests on a [`PortImage`]: request bytes in, reply bytes out. Pure but for the image.
//!
//! Written here rather than taken from tokio-modbus: its server closes the connection, or in a debug build panics, on
//! a byte count that does not fit, where a controller has to answer with exception 3. References are sections of the
//! MODBUS Application Protocol Specification V1.1b3.

use core::ops::Range;

use super::state_map::{self, Controller};
use crate::port_image::{COILS, PortImage, REGISTERS, Values};

/// Bytes before the request proper: transaction, protocol, length, unit.
pub const HEADER_BYTES: usize = 7;

/// Longest request or reply proper (4.1).
const PDU_BYTES_MAX: usize = 253;

/// Longest message with its header.
pub const ADU_BYTES_MAX: usize = HEADER_BYTES + PDU_BYTES_MAX;

/// Most values in one request (6.1, 6.3, 6.11, 6.12, 6.17).
const READ_COILS_MAX: usize = 2000;
const READ_REGISTERS_MAX: usize = 125;
const WRITE_COILS_MAX: usize = 1968;
const WRITE_REGISTERS_MAX: usize = 123;
const READ_WRITE_REGISTERS_MAX: usize = 121;

/// The stream cannot be Modbus TCP; there is no way to find the next request in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotModbus {
    /// Not 0.
    #[error("protocol number {0} instead of 0")]
    Protocol(u16),
    /// Shorter than a unit and a function, or longer than the protocol allows.
    #[error("length {0}, allowed are 2 to 254")]
    Length(u16),
}

/// How many bytes the message takes that begins with `received`, header included; `None` until the header is there.
///
/// # Errors
/// [`NotModbus`] where the header is none.
pub fn message_bytes(received: &[u8]) -> Result<Option<usize>, NotModbus> {
    let Some(header) = received.first_chunk::<HEADER_BYTES>() else {
        return Ok(None);
    };
    let [_, _, p1, p0, l1, l0, _unit] = *header;
    let (protocol, length) = (u16::from_be_bytes([p1, p0]), u16::from_be_bytes([l1, l0]));
    if protocol != 0 {
        return Err(NotModbus::Protocol(protocol));
    }
    match usize::from(length) {
        2.. if usize::from(length) <= 1 + PDU_BYTES_MAX => Ok(Some(6 + usize::from(length))),
        _ => Err(NotModbus::Length(length)),
    }
}

/// The reply to one whole message, as long as [`message_bytes`] said.
pub fn answer(message: &[u8], image: &PortImage) -> Vec<u8> {
    answer_with(message, image, None)
}

/// The same, with the map of `controller` from address 1000 on.
pub fn answer_with(
    message: &[u8],
    image: &PortImage,
    controller: Option<&dyn Controller>,
) -> Vec<u8> {
    let (header, request) = message.split_at(HEADER_BYTES.min(message.len()));
    let reply = controller
        .and_then(|controller| reply_from_map(request, controller))
        .unwrap_or_else(|| reply_to(request, image));
    // A reply is never longer than a request proper may be.
    let length = u16::try_from(1 + reply.len()).unwrap_or(u16::MAX);
    let mut out = Vec::with_capacity(HEADER_BYTES + reply.len());
    out.extend(header.iter().take(4)); // transaction and protocol as received
    out.extend(length.to_be_bytes());
    out.extend(header.iter().skip(6)); // unit as received: every one is this controller
    out.extend(reply);
    out
}

/// Why a request is refused (7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[allow(clippy::enum_variant_names, reason = "the names of the specification")]
enum Exception {
    IllegalFunction = 1,
    IllegalAddress = 2,
    IllegalValue = 3,
    Busy = 6,
}

fn reply_to(request: &[u8], image: &PortImage) -> Vec<u8> {
    let (&function, fields) = request.split_first().unwrap_or((&0, &[]));
    let mut values = image.lock();
    let body = match function {
        1 => read_coils(fields, &values),
        3 => read_registers(fields, &values),
        5 => write_coil(fields, &mut values),
        6 => write_register(fields, &mut values),
        15 => write_coils(fields, &mut values),
        16 => write_registers(fields, &mut values),
        22 => mask_register(fields, &mut values),
        23 => read_write_registers(fields, &mut values),
        _ => Err(Exception::IllegalFunction),
    };
    match body {
        Ok(body) => [&[function][..], &body].concat(),
        Err(exception) => vec![function | 0x80, exception as u8],
    }
}

/// The reply to a request that concerns the map; `None` for any other.
fn reply_from_map(request: &[u8], controller: &dyn Controller) -> Option<Vec<u8>> {
    let (&function, fields) = request.split_first()?;
    let (address, rest) = fields.split_first_chunk::<2>()?;
    let address = u16::from_be_bytes(*address);
    // Inputs have no other place.
    if address < state_map::FIRST && !matches!(function, 2 | 4) {
        return None;
    }
    let body = match function {
        1 | 2 => words(rest).and_then(|[count]| {
            check_count(count, READ_COILS_MAX)?;
            let levels = state_map::read_bits(controller, function == 1, address, count)?;
            Ok(bits_body(&levels))
        }),
        3 | 4 => words(rest).and_then(|[count]| {
            check_count(count, READ_REGISTERS_MAX)?;
            let values = state_map::read_registers(controller, address, count)?;
            Ok(registers_body(&values))
        }),
        5 => words(rest).and_then(|[level]| match level {
            0x0000 | 0xFF00 => {
                write_map_coils(controller, address, &[level != 0]).map(|()| fields.to_vec())
            }
            _ => Err(Exception::IllegalValue),
        }),
        6 => words(rest).and_then(|[value]| {
            state_map::write_registers(controller, address, &[value])?;
            Ok(fields.to_vec())
        }),
        15 => map_coils(rest).and_then(|levels| {
            write_map_coils(controller, address, &levels)?;
            Ok(fields[..4].to_vec())
        }),
        16 => map_registers(rest).and_then(|values| {
            state_map::write_registers(controller, address, &values)?;
            Ok(fields[..4].to_vec())
        }),
        22 => words(rest).and_then(|[and_mask, or_mask]: [u16; 2]| {
            let old = state_map::read_registers(controller, address, 1)?[0];
            let new = old & and_mask | or_mask & !and_mask;
            state_map::write_registers(controller, address, &[new])?;
            Ok(fields.to_vec())
        }),
        // Reading and writing at once is for the flat registers.
        23 => Err(Exception::IllegalAddress),
        _ => Err(Exception::IllegalFunction),
    };
    Some(match body {
        Ok(body) => [&[function][..], &body].concat(),
        Err(exception) => vec![function | 0x80, exception as u8],
    })
}

impl From<state_map::NoSuchAddress> for Exception {
    fn from(_: state_map::NoSuchAddress) -> Self {
        Self::IllegalAddress
    }
}

fn write_map_coils(
    controller: &dyn Controller,
    address: u16,
    levels: &[bool],
) -> Result<(), Exception> {
    match state_map::write_bits(controller, address, levels)? {
        true => Ok(()),
        false => Err(Exception::Busy),
    }
}

/// The levels after count and byte count.
fn map_coils(fields: &[u8]) -> Result<Vec<bool>, Exception> {
    let (head, packed) = fields.split_at_checked(3).ok_or(Exception::IllegalValue)?;
    let [count] = words(&head[..2])?;
    check_count(count, WRITE_COILS_MAX)?;
    let bytes = usize::from(count).div_ceil(8);
    if usize::from(head[2]) != bytes || packed.len() != bytes {
        return Err(Exception::IllegalValue);
    }
    let level = |k: usize| packed[k / 8] >> (k % 8) & 1 == 1;
    Ok((0..usize::from(count)).map(level).collect())
}

/// The values after count and byte count.
fn map_registers(fields: &[u8]) -> Result<Vec<u16>, Exception> {
    let (head, data) = fields.split_at_checked(3).ok_or(Exception::IllegalValue)?;
    let [count] = words(&head[..2])?;
    check_count(count, WRITE_REGISTERS_MAX)?;
    register_data(count, head[2], data)
}

type Body = Result<Vec<u8>, Exception>;

fn read_coils(fields: &[u8], values: &Values) -> Body {
    let [address, count] = words(fields)?;
    let coils = &values.coils[span(address, count, READ_COILS_MAX, COILS)?];
    Ok(bits_body(coils))
}

fn bits_body(levels: &[bool]) -> Vec<u8> {
    let mut body = vec![0; 1 + levels.len().div_ceil(8)];
    body[0] = (body.len() - 1) as u8; // at most 250 bytes
    for (index, _) in levels.iter().enumerate().filter(|(_, level)| **level) {
        body[1 + index / 8] |= 1 << (index % 8);
    }
    body
}

fn read_registers(fields: &[u8], values: &Values) -> Body {
    let [address, count] = words(fields)?;
    Ok(registers_body(
        &values.registers[span(address, count, READ_REGISTERS_MAX, REGISTERS)?],
    ))
}

fn registers_body(registers: &[u16]) -> Vec<u8> {
    let mut body = vec![(2 * registers.len()) as u8]; // at most 125 registers
    body.extend(registers.iter().flat_map(|word| word.to_be_bytes()));
    body
}

fn write_coil(fields: &[u8], values: &mut Values) -> Body {
    let [address, level] = words(fields)?;
    let level = match level {
        0x0000 => false,
        0xFF00 => true,
        _ => return Err(Exception::IllegalValue),
    };
    let index = span(address, 1, 1, COILS)?.start;
    values.coils[index] = level;
    Ok(fields.to_vec())
}

fn write_register(fields: &[u8], values: &mut Values) -> Body {
    let [address, word] = words(fields)?;
    let index = span(address, 1, 1, REGISTERS)?.start;
    values.registers[index] = word;
    Ok(fields.to_vec())
}

fn write_coils(fields: &[u8], values: &mut Values) -> Body {
    let (head, packed) = fields.split_at_checked(5).ok_or(Exception::IllegalValue)?;
    let [address, count] = words(&head[..4])?;
    let bytes = usize::from(count).div_ceil(8);
    if usize::from(head[4]) != bytes || packed.len() != bytes {
        return Err(Exception::IllegalValue);
    }
    let span = span(address, count, WRITE_COILS_MAX, COILS)?;
    for (index, coil) in values.coils[span].iter_mut().enumerate() {
        *coil = packed[index / 8] >> (index % 8) & 1 == 1;
    }
    Ok(head[..4].to_vec())
}

fn write_registers(fields: &[u8], values: &mut Values) -> Body {
    let (head, data) = fields.split_at_checked(5).ok_or(Exception::IllegalValue)?;
    let [address, count] = words(&head[..4])?;
    let data = register_data(count, head[4], data)?;
    let span = span(address, count, WRITE_REGISTERS_MAX, REGISTERS)?;
    values.registers[span].copy_from_slice(&data);
    Ok(head[..4].to_vec())
}

fn mask_register(fields: &[u8], values: &mut Values) -> Body {
    let [address, and_mask, or_mask] = words(fields)?;
    let register = &mut values.registers[span(address, 1, 1, REGISTERS)?.start];
    *register = (*register & and_mask) | (or_mask & !and_mask);
    Ok(fields.to_vec())
}

/// Writes first, then reads (6.17).
fn read_write_registers(fields: &[u8], values: &mut Values) -> Body {
    let (head, data) = fields.split_at_checked(9).ok_or(Exception::IllegalValue)?;
    let [read_address, read_count, write_address, write_count] = words(&head[..8])?;
    let data = register_data(write_count, head[8], data)?;
    check_count(read_count, READ_REGISTERS_MAX)?;
    check_count(write_count, READ_WRITE_REGISTERS_MAX)?;
    let read = span(read_address, read_count, READ_REGISTERS_MAX, REGISTERS)?;
    let write = span(
        write_address,
        write_count,
        READ_WRITE_REGISTERS_MAX,
        REGISTERS,
    )?;
    values.registers[write].copy_from_slice(&data);
    Ok(registers_body(&values.registers[read]))
}

/// Exactly `N` words.
fn words<const N: usize>(fields: &[u8]) -> Result<[u16; N], Exception> {
    let (words, rest) = fields.as_chunks::<2>();
    match <[[u8; 2]; N]>::try_from(words) {
        Ok(words) if rest.is_empty() => Ok(words.map(u16::from_be_bytes)),
        _ => Err(Exception::IllegalValue),
    }
}

/// The words that follow a byte count; exactly `count`.
fn register_data(count: u16, byte_count: u8, data: &[u8]) -> Result<Vec<u16>, Exception> {
    let (words, rest) = data.as_chunks::<2>();
    let fits = usize::from(byte_count) == data.len() && words.len() == usize::from(count);
    if !fits || !rest.is_empty() {
        return Err(Exception::IllegalValue);
    }
    Ok(words.iter().map(|word| u16::from_be_bytes(*word)).collect())
}

fn check_count(count: u16, max: usize) -> Result<(), Exception> {
    match usize::from(count) {
        count if (1..=max).contains(&count) => Ok(()),
        _ => Err(Exception::IllegalValue),
    }
}

/// The indices of `count` values from `address`; first the count is checked, then the addresses, as the specification
/// draws it.
fn span(address: u16, count: u16, max: usize, size: usize) -> Result<Range<usize>, Exception> {
    check_count(count, max)?;
    let start = usize::from(address);
    let end = start + usize::from(count);
    if end > size {
        return Err(Exception::IllegalAddress);
    }
    Ok(start..end)
}

#[cfg(test)]
mod tests;
