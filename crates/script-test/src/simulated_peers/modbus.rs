//! A Modbus device that a test plays: coils and registers by address, as it was given them and as they were written.
//!
//! Sections are those of the MODBUS Application Protocol Specification V1.1b3. Discrete inputs are the coils, input
//! registers the registers: a device of a test has one table of each.

use std::collections::BTreeMap;

/// Transaction, protocol, length, unit.
const HEADER_BYTES: usize = 7;
/// Longest request proper (4.1), with the unit.
const LENGTH_MAX: usize = 254;

/// The tables.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ModbusDevice {
    pub coils: BTreeMap<u16, bool>,
    pub registers: BTreeMap<u16, u16>,
}

/// What a request asks for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ModbusRequest {
    pub function: u8,
    pub address: u16,
    /// Number of values that are read, or the values that are written.
    pub values: Vec<u16>,
}

#[derive(Clone, Copy, Debug)]
#[allow(clippy::enum_variant_names, reason = "the names of the specification")]
enum Exception {
    IllegalFunction = 1,
    IllegalAddress = 2,
    IllegalValue = 3,
}

/// Length of the message that `unread` begins with, once it is whole.
pub(super) fn message_bytes(unread: &[u8]) -> Result<Option<usize>, ()> {
    let Some([_, _, p1, p0, l1, l0, _]) = unread.first_chunk::<HEADER_BYTES>() else {
        return Ok(None);
    };
    let length = usize::from(u16::from_be_bytes([*l1, *l0]));
    if [*p1, *p0] != [0, 0] || !(2..=LENGTH_MAX).contains(&length) {
        return Err(());
    }
    let whole = HEADER_BYTES - 1 + length;
    Ok((unread.len() >= whole).then_some(whole))
}

impl ModbusDevice {
    /// The reply to a whole message.
    pub(super) fn answer(&mut self, message: &[u8]) -> Vec<u8> {
        let (header, request) = message.split_at(HEADER_BYTES.min(message.len()));
        let function = request.first().copied().unwrap_or_default();
        let reply = match self.reply(request) {
            Ok(body) => [&[function][..], &body].concat(),
            Err(exception) => vec![function | 0x80, exception as u8],
        };
        let length = u16::try_from(1 + reply.len()).unwrap_or(u16::MAX);
        let mut out = header.iter().take(4).copied().collect::<Vec<u8>>();
        out.extend(length.to_be_bytes());
        out.extend(header.iter().skip(6));
        out.extend(reply);
        out
    }

    fn reply(&mut self, request: &[u8]) -> Result<Vec<u8>, Exception> {
        let asked = ModbusRequest::read(request).ok_or(Exception::IllegalValue)?;
        let ModbusRequest {
            function,
            address,
            values,
        } = &asked;
        let echo = || request.get(1..5).map(<[u8]>::to_vec).unwrap_or_default();
        match function {
            1 | 2 => {
                let count = read_count(values, 2000)?;
                let mut bits = vec![0_u8; count.div_ceil(8)];
                for (n, at) in addresses(*address, count)?.enumerate() {
                    let level = self.coils.get(&at).ok_or(Exception::IllegalAddress)?;
                    bits[n / 8] |= u8::from(*level) << (n % 8);
                }
                Ok([&[bits.len() as u8][..], &bits].concat())
            }
            3 | 4 => {
                let count = read_count(values, 125)?;
                let mut out = vec![2 * count as u8];
                for at in addresses(*address, count)? {
                    let value = self.registers.get(&at).ok_or(Exception::IllegalAddress)?;
                    out.extend(value.to_be_bytes());
                }
                Ok(out)
            }
            5 | 15 => {
                let found: Vec<u16> = addresses(*address, values.len())?.collect();
                if found.iter().any(|at| !self.coils.contains_key(at)) {
                    return Err(Exception::IllegalAddress);
                }
                let levels = values.iter().map(|value| *value != 0);
                self.coils.extend(found.into_iter().zip(levels));
                Ok(echo())
            }
            6 | 16 => {
                let found: Vec<u16> = addresses(*address, values.len())?.collect();
                if found.iter().any(|at| !self.registers.contains_key(at)) {
                    return Err(Exception::IllegalAddress);
                }
                self.registers
                    .extend(found.into_iter().zip(values.iter().copied()));
                Ok(echo())
            }
            _ => Err(Exception::IllegalFunction),
        }
    }
}

fn read_count(values: &[u16], most: usize) -> Result<usize, Exception> {
    let count = values.first().copied().map_or(0, usize::from);
    match (1..=most).contains(&count) {
        true => Ok(count),
        false => Err(Exception::IllegalValue),
    }
}

fn addresses(first: u16, count: usize) -> Result<impl Iterator<Item = u16>, Exception> {
    let end = usize::from(first) + count;
    match end <= 1 + usize::from(u16::MAX) {
        true => Ok((usize::from(first)..end).map(|at| at as u16)),
        false => Err(Exception::IllegalAddress),
    }
}

impl ModbusRequest {
    /// Of a request proper; `None` where its bytes do not fit its function.
    pub(crate) fn read(request: &[u8]) -> Option<Self> {
        let (&function, fields) = request.split_first()?;
        let word = |at: usize| Some(u16::from_be_bytes([*fields.get(at)?, *fields.get(at + 1)?]));
        let address = word(0).unwrap_or_default();
        let values = match function {
            1..=4 => vec![word(2)?],
            5 => match word(2)? {
                0 => vec![0],
                0xFF00 => vec![1],
                _ => return None,
            },
            6 => vec![word(2)?],
            15 => {
                let (count, data) = (usize::from(word(2)?), fields.get(5..)?);
                let fits = (1..=1968).contains(&count) && data.len() == count.div_ceil(8);
                let bit = |n: usize| u16::from(data[n / 8] >> (n % 8) & 1);
                fits.then(|| (0..count).map(bit).collect())?
            }
            16 => {
                let (count, data) = (usize::from(word(2)?), fields.get(5..)?);
                let fits = (1..=123).contains(&count) && data.len() == 2 * count;
                let (words, _) = data.as_chunks::<2>();
                fits.then(|| words.iter().map(|w| u16::from_be_bytes(*w)).collect())?
            }
            _ => Vec::new(),
        };
        Some(Self {
            function,
            address,
            values,
        })
    }

    /// The request that a whole message holds.
    pub(crate) fn of_message(message: &[u8]) -> Option<Self> {
        Self::read(message.get(HEADER_BYTES..)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coils_and_registers_are_read_and_written_where_they_are() {
        let mut device = ModbusDevice {
            coils: (0..10).map(|n| (n, n % 3 == 0)).collect(),
            registers: [(100, 7), (101, 0x1234)].into(),
        };
        let mut ask = |request: &[u8]| {
            let length = (request.len() + 1) as u8;
            let message = [&[0, 9, 0, 0, 0, length, 1][..], request].concat();
            assert_eq!(message_bytes(&message), Ok(Some(message.len())));
            let reply = device.answer(&message);
            assert_eq!((reply[..4].to_vec(), reply[6]), (vec![0, 9, 0, 0], 1));
            assert_eq!(usize::from(reply[5]), reply.len() - 6);
            reply[7..].to_vec()
        };
        assert_eq!(ask(&[1, 0, 0, 0, 10]), [1, 2, 0b0100_1001, 0b10]);
        assert_eq!(ask(&[3, 0, 100, 0, 2]), [3, 4, 0, 7, 0x12, 0x34]);
        assert_eq!(ask(&[5, 0, 1, 0xFF, 0]), [5, 0, 1, 0xFF, 0]);
        assert_eq!(ask(&[2, 0, 0, 0, 2]), [2, 1, 0b11]);
        assert_eq!(ask(&[16, 0, 100, 0, 2, 4, 0, 1, 0, 2]), [16, 0, 100, 0, 2]);
        assert_eq!(ask(&[4, 0, 100, 0, 2]), [4, 4, 0, 1, 0, 2]);
        assert_eq!(ask(&[6, 0, 101, 0, 9]), [6, 0, 101, 0, 9]);
        assert_eq!(ask(&[15, 0, 8, 0, 2, 1, 0b10]), [15, 0, 8, 0, 2]);
        for (request, exception) in [
            (&[3, 0, 102, 0, 1][..], 2),
            (&[3, 0, 100, 0, 0], 3),
            (&[5, 0, 1, 0xFF, 1], 3),
            (&[16, 0, 100, 0, 2, 4, 0, 1], 3),
            (&[43, 14, 1, 0], 1),
        ] {
            assert_eq!(ask(request), [request[0] | 0x80, exception], "{request:?}");
        }
    }

    #[test]
    fn what_is_no_modbus_is_not_waited_for() {
        assert_eq!(message_bytes(&[0, 0, 0, 0]), Ok(None));
        assert_eq!(message_bytes(&[0, 0, 0, 1, 0, 6, 1]), Err(()));
        assert_eq!(message_bytes(&[0, 0, 0, 0, 0, 1, 1]), Err(()));
        assert_eq!(message_bytes(&[0, 0, 0, 0, 9, 9, 1]), Err(()));
    }
}
