//! Modbus requests on [`Tables`]: request bytes in, reply bytes out. Pure but for the tables.
//!
//! Written here rather than taken from tokio-modbus: its server closes the connection, or in a debug build panics, on
//! a byte count that does not fit, where a controller has to answer with exception 3. References are sections of the
//! MODBUS Application Protocol Specification V1.1b3.

use super::tables::{ModbusException, Slaves, Space, Tables};
use crate::modbus::pdu::EXCEPTION_FLAG;
use messages::Localized;

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error, Localized)]
pub enum ModbusFrameError {
    /// The protocol number is not 0.
    #[error("protocol number {0} instead of 0")]
    #[zh("协议号为 {0}，应为 0")]
    Protocol(u16),
    /// Shorter than a unit and a function, or longer than the protocol allows.
    #[error("length {0}, allowed are 2 to 254")]
    #[zh("长度 {0}，允许 2 到 254")]
    Length(u16),
}

/// How many bytes the message takes that begins with `received`, header included; `None` until the header is there.
///
/// # Errors
/// [`ModbusFrameError`] where the header is none.
pub fn message_bytes(received: &[u8]) -> Result<Option<usize>, ModbusFrameError> {
    let Some(header) = received.first_chunk::<HEADER_BYTES>() else {
        return Ok(None);
    };
    let [_, _, p1, p0, l1, l0, _unit] = *header;
    let (protocol, length) = (u16::from_be_bytes([p1, p0]), u16::from_be_bytes([l1, l0]));
    if protocol != 0 {
        return Err(ModbusFrameError::Protocol(protocol));
    }
    match usize::from(length) {
        2.. if usize::from(length) <= 1 + PDU_BYTES_MAX => Ok(Some(6 + usize::from(length))),
        _ => Err(ModbusFrameError::Length(length)),
    }
}

/// The reply to one whole message, as long as [`message_bytes`] said.
pub fn build_reply(message: &[u8], tables: &dyn Tables) -> Vec<u8> {
    build_reply_with(message, |_, request| reply_to(request, tables))
}

/// The reply to one whole message of the slave whose number it has. The only slave also answers to 0 and 255, which
/// clients send where a connection leads to one device.
pub fn build_slave_reply(message: &[u8], slaves: &Slaves) -> Vec<u8> {
    build_reply_with(message, |unit, request| {
        let only = match (unit, slaves.len()) {
            (0 | 255, 1) => slaves.values().next(),
            _ => None,
        };
        match slaves.get(&unit).or(only) {
            Some(tables) => reply_to(request, tables.as_ref()),
            None => exception(request, ModbusException::NoTargetDevice),
        }
    })
}

fn build_reply_with(message: &[u8], reply_of: impl FnOnce(u8, &[u8]) -> Vec<u8>) -> Vec<u8> {
    let (header, request) = message.split_at(HEADER_BYTES.min(message.len()));
    let reply = reply_of(header.last().copied().unwrap_or(0), request);
    // A reply is never longer than a request proper may be.
    let length = u16::try_from(1 + reply.len()).unwrap_or(u16::MAX);
    let mut out = Vec::with_capacity(HEADER_BYTES + reply.len());
    out.extend(header.iter().take(4)); // transaction and protocol as received
    out.extend(length.to_be_bytes());
    out.extend(header.iter().skip(6)); // unit as received
    out.extend(reply);
    out
}

type ReplyBody = Result<Vec<u8>, ModbusException>;

/// The reply proper to a request proper.
pub(crate) fn reply_to(request: &[u8], tables: &dyn Tables) -> Vec<u8> {
    let (&function, fields) = request.split_first().unwrap_or((&0, &[]));
    let body = match function {
        other if !tables.has_function(other) => Err(ModbusException::IllegalFunction),
        1 => read_bits(fields, tables, Space::Outputs),
        2 => read_bits(fields, tables, Space::Inputs),
        3 => read_words(fields, tables, Space::Outputs),
        4 => read_words(fields, tables, Space::Inputs),
        5 => write_coil(fields, tables),
        6 => write_register(fields, tables),
        15 => write_coils(fields, tables),
        16 => write_registers(fields, tables),
        22 => mask_register(fields, tables),
        23 => read_write_registers(fields, tables),
        _ => Err(ModbusException::IllegalFunction),
    };
    match body {
        Ok(body) => [&[function][..], &body].concat(),
        Err(reason) => exception(request, reason),
    }
}

fn exception(request: &[u8], reason: ModbusException) -> Vec<u8> {
    let function = request.first().copied().unwrap_or(0);
    vec![function | EXCEPTION_FLAG, reason as u8]
}

fn read_bits(fields: &[u8], tables: &dyn Tables, space: Space) -> ReplyBody {
    let [address, count] = words(fields)?;
    check_count(count, READ_COILS_MAX)?;
    let levels = tables.read_bits(space, address, count)?;
    let mut body = vec![0; 1 + levels.len().div_ceil(8)];
    body[0] = (body.len() - 1) as u8; // at most 250 bytes
    for (index, _) in levels.iter().enumerate().filter(|(_, level)| **level) {
        body[1 + index / 8] |= 1 << (index % 8);
    }
    Ok(body)
}

fn read_words(fields: &[u8], tables: &dyn Tables, space: Space) -> ReplyBody {
    let [address, count] = words(fields)?;
    check_count(count, READ_REGISTERS_MAX)?;
    Ok(registers_body(&tables.read_words(space, address, count)?))
}

fn registers_body(registers: &[u16]) -> Vec<u8> {
    let mut body = vec![(2 * registers.len()) as u8]; // at most 125 registers
    body.extend(registers.iter().flat_map(|word| word.to_be_bytes()));
    body
}

fn write_coil(fields: &[u8], tables: &dyn Tables) -> ReplyBody {
    let [address, level] = words(fields)?;
    let level = match level {
        0x0000 => false,
        0xFF00 => true,
        _ => return Err(ModbusException::IllegalValue),
    };
    tables.write_bits(address, &[level])?;
    Ok(fields.to_vec())
}

fn write_register(fields: &[u8], tables: &dyn Tables) -> ReplyBody {
    let [address, word] = words(fields)?;
    tables.write_words(address, &[word])?;
    Ok(fields.to_vec())
}

fn write_coils(fields: &[u8], tables: &dyn Tables) -> ReplyBody {
    let (head, packed) = fields
        .split_at_checked(5)
        .ok_or(ModbusException::IllegalValue)?;
    let [address, count] = words(&head[..4])?;
    check_count(count, WRITE_COILS_MAX)?;
    let bytes = usize::from(count).div_ceil(8);
    if usize::from(head[4]) != bytes || packed.len() != bytes {
        return Err(ModbusException::IllegalValue);
    }
    let level = |k: usize| packed[k / 8] >> (k % 8) & 1 == 1;
    let levels: Vec<bool> = (0..usize::from(count)).map(level).collect();
    tables.write_bits(address, &levels)?;
    Ok(head[..4].to_vec())
}

fn write_registers(fields: &[u8], tables: &dyn Tables) -> ReplyBody {
    let (head, data) = fields
        .split_at_checked(5)
        .ok_or(ModbusException::IllegalValue)?;
    let [address, count] = words(&head[..4])?;
    check_count(count, WRITE_REGISTERS_MAX)?;
    tables.write_words(address, &register_data(count, head[4], data)?)?;
    Ok(head[..4].to_vec())
}

fn mask_register(fields: &[u8], tables: &dyn Tables) -> ReplyBody {
    let [address, and_mask, or_mask] = words(fields)?;
    tables.change_word(address, &|old| old & and_mask | or_mask & !and_mask)?;
    Ok(fields.to_vec())
}

/// Writes first, then reads (6.17). What is refused has to be known before anything is written, so it is read before as
/// well.
fn read_write_registers(fields: &[u8], tables: &dyn Tables) -> ReplyBody {
    let (head, data) = fields
        .split_at_checked(9)
        .ok_or(ModbusException::IllegalValue)?;
    let [read_address, read_count, write_address, write_count] = words(&head[..8])?;
    let data = register_data(write_count, head[8], data)?;
    check_count(read_count, READ_REGISTERS_MAX)?;
    check_count(write_count, READ_WRITE_REGISTERS_MAX)?;
    tables.read_words(Space::Outputs, read_address, read_count)?;
    tables.write_words(write_address, &data)?;
    let read = tables.read_words(Space::Outputs, read_address, read_count)?;
    Ok(registers_body(&read))
}

/// Exactly `N` words.
fn words<const N: usize>(fields: &[u8]) -> Result<[u16; N], ModbusException> {
    let (words, rest) = fields.as_chunks::<2>();
    match <[[u8; 2]; N]>::try_from(words) {
        Ok(words) if rest.is_empty() => Ok(words.map(u16::from_be_bytes)),
        _ => Err(ModbusException::IllegalValue),
    }
}

/// The words that follow a byte count; exactly `count`.
fn register_data(count: u16, byte_count: u8, data: &[u8]) -> Result<Vec<u16>, ModbusException> {
    let (words, rest) = data.as_chunks::<2>();
    let fits = usize::from(byte_count) == data.len() && words.len() == usize::from(count);
    if !fits || !rest.is_empty() {
        return Err(ModbusException::IllegalValue);
    }
    Ok(words.iter().map(|word| u16::from_be_bytes(*word)).collect())
}

/// The count is checked first, then the addresses, as the specification draws it.
fn check_count(count: u16, max: usize) -> Result<(), ModbusException> {
    match usize::from(count) {
        count if (1..=max).contains(&count) => Ok(()),
        _ => Err(ModbusException::IllegalValue),
    }
}

#[cfg(test)]
mod tests;
