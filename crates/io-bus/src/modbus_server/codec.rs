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
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The reply proper to a request proper, both in hex.
    fn reply(image: &PortImage, request: &str) -> String {
        let request: Vec<u8> = request
            .split_whitespace()
            .map(|byte| u8::from_str_radix(byte, 16).unwrap())
            .collect();
        let reply = reply_to(&request, image);
        let reply: Vec<String> = reply.iter().map(|byte| format!("{byte:02x}")).collect();
        reply.join(" ")
    }

    struct Nothing(motion_api::Registers);

    impl Controller for Nothing {
        fn state(&self) -> motion_api::RobotState {
            motion_api::RobotState::at_start(Default::default(), 0.004)
        }
        fn registers(&self) -> &motion_api::Registers {
            &self.0
        }
        fn change(&self, _: motion_api::IoChange) -> bool {
            false
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn any_request_to_the_map_is_answered(function in prop_oneof![Just(1_u8), Just(2), Just(3), Just(4), Just(5), Just(6), Just(15), Just(16), Just(22), Just(23), any::<u8>()], address in prop_oneof![1000..1600_u16, any::<u16>()], rest in proptest::collection::vec(prop_oneof![Just(0_u8), Just(1), Just(2), any::<u8>()], 0..12)) {
            let mut request = vec![function];
            request.extend(address.to_be_bytes());
            request.extend(&rest);
            let mut message = vec![0, 1, 0, 0, 0, (request.len() + 1) as u8, 255];
            message.extend(&request);
            let reply = answer_with(&message, &PortImage::default(), Some(&Nothing(Default::default())));
            prop_assert!(reply.len() >= 9 && reply.len() <= ADU_BYTES_MAX);
            prop_assert_eq!(reply[7] & 0x7F, function & 0x7F);
        }
    }

    #[test]
    fn the_map_begins_at_1000_and_outputs_that_cannot_be_set_are_busy() {
        let nothing = Nothing(Default::default());
        let ask = |request: &[u8]| {
            let message = [&[0, 1, 0, 0, 0, request.len() as u8 + 1, 255], request].concat();
            answer_with(&message, &PortImage::default(), Some(&nothing))[7..].to_vec()
        };
        assert_eq!(ask(&[3, 0x03, 0xFC, 0, 1]), [3, 2, 0, 7]); // 1020: running
        assert_eq!(ask(&[4, 0x03, 0xFC, 0, 1]), [4, 2, 0, 7]);
        assert_eq!(ask(&[4, 0, 0, 0, 1]), [0x84, 2]);
        assert_eq!(ask(&[5, 0x03, 0xE8, 0xFF, 0]), [0x85, 6]);
        assert_eq!(
            ask(&[16, 0x04, 0xB0, 0, 2, 4, 0, 0, 0, 9]),
            [16, 0x04, 0xB0, 0, 2]
        );
        assert_eq!(nothing.0.input.integer(0), 9);
        assert_eq!(ask(&[3, 0, 0, 0, 1]), [3, 2, 0, 0]); // the flat registers as ever
    }

    #[test]
    fn the_golden_message_is_answered_with_its_transaction_and_unit() {
        let image = PortImage::default();
        image.write_register(2, 0x1234).unwrap();
        let request = [0xAB, 0xCD, 0, 0, 0, 6, 0x11, 3, 0, 2, 0, 1];
        assert_eq!(message_bytes(&request[..6]), Ok(None));
        assert_eq!(message_bytes(&request), Ok(Some(12)));
        assert_eq!(
            answer(&request, &image),
            [0xAB, 0xCD, 0, 0, 0, 5, 0x11, 3, 2, 0x12, 0x34]
        );
    }

    #[test]
    fn every_function_reads_and_writes_the_image() {
        let image = PortImage::default();
        for (request, expected) in [
            ("05 00 03 ff 00", "05 00 03 ff 00"),
            ("0f 00 08 00 0a 02 05 02", "0f 00 08 00 0a"),
            ("01 00 00 00 12", "01 03 08 05 02"),
            ("01 00 78 00 08", "01 01 00"),
            ("06 00 ff 80 01", "06 00 ff 80 01"),
            ("10 00 00 00 02 04 00 0a 01 02", "10 00 00 00 02"),
            ("03 00 00 00 02", "03 04 00 0a 01 02"),
            ("16 00 01 00 f2 00 25", "16 00 01 00 f2 00 25"),
            ("03 00 01 00 01", "03 02 00 07"),
            ("17 00 00 00 02 00 01 00 01 02 00 09", "17 04 00 0a 00 09"),
            ("05 00 03 00 00", "05 00 03 00 00"),
        ] {
            assert_eq!(reply(&image, request), expected, "{request}");
        }
        assert_eq!(image.read_bit(3), Ok(false));
        assert_eq!(image.read_bit(8), Ok(true));
        assert_eq!(image.read_bit(17), Ok(true));
        assert_eq!(image.read_register(255), Ok(0x8001));
    }

    #[test]
    fn unknown_functions_are_exception_1() {
        let image = PortImage::default();
        for request in [
            "02 00 00 00 01",
            "04 00 00 00 01",
            "2b 0e 01 00",
            "41",
            "07",
            "11",
        ] {
            let function = u8::from_str_radix(&request[..2], 16).unwrap() | 0x80;
            assert_eq!(
                reply(&image, request),
                format!("{function:02x} 01"),
                "{request}"
            );
        }
        assert_eq!(reply(&image, "83 00"), "83 01");
        assert_eq!(reply(&image, ""), "80 01");
    }

    #[test]
    fn addresses_outside_are_exception_2_and_change_nothing() {
        let image = PortImage::default();
        for request in [
            "01 00 80 00 01",
            "01 00 7f 00 02",
            "01 ff ff 07 d0",
            "03 01 00 00 01",
            "03 00 ff 00 02",
            "05 00 80 ff 00",
            "06 01 00 00 01",
            "0f 00 7f 00 02 01 03",
            "10 00 ff 00 02 04 00 01 00 02",
            "16 01 00 00 00 00 01",
            "17 00 00 00 01 00 ff 00 02 04 00 01 00 02",
            "17 00 ff 00 02 00 00 00 01 02 00 01",
        ] {
            assert!(
                reply(&image, request).ends_with(" 02"),
                "{request}: {}",
                reply(&image, request)
            );
        }
        let values = image.lock();
        assert!(values.registers.iter().all(|word| *word == 0) && !values.coils.contains(&true));
    }

    #[test]
    fn bad_counts_are_exception_3_even_at_addresses_outside() {
        let image = PortImage::default();
        for request in [
            "01 00 00 00 00",
            "01 ff ff 07 d1",
            "03 00 00 00 00",
            "03 ff ff 00 7e",
            "05 00 00 00 01",
            "0f 00 00 00 00 00",
            "0f 00 00 00 09 01 ff",
            "0f 00 00 00 08 02 ff ff",
            "0f 00 00 00 08 01",
            "10 00 00 00 00 00",
            "10 00 00 00 02 02 00 01",
            "10 00 00 00 01 02 00",
            "10 00 00 80 01 02 00 00",
            "17 00 00 00 00 00 00 00 01 02 00 01",
            "17 00 00 00 01 00 00 00 00 00",
            "01 00 00 00",
            "03 00 00 00 01 00",
            "06",
        ] {
            assert!(
                reply(&image, request).ends_with(" 03"),
                "{request}: {}",
                reply(&image, request)
            );
        }
    }

    #[test]
    fn a_header_that_is_none_is_refused() {
        assert_eq!(
            message_bytes(&[0, 0, 0, 1, 0, 6, 1]),
            Err(NotModbus::Protocol(1))
        );
        assert_eq!(
            message_bytes(&[0, 0, 0, 0, 0, 1, 1]),
            Err(NotModbus::Length(1))
        );
        assert_eq!(
            message_bytes(&[0, 0, 0, 0, 0, 255, 1]),
            Err(NotModbus::Length(255))
        );
        assert_eq!(
            message_bytes(&[0, 0, 0, 0, 0, 254, 1]),
            Ok(Some(ADU_BYTES_MAX))
        );
        let error = message_bytes(b"GET / HTTP/1.1").unwrap_err();
        assert_eq!(error, NotModbus::Protocol(u16::from_be_bytes(*b"T ")));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]
        #[test]
        fn any_request_gets_an_answer_that_fits(
            function in prop_oneof![Just(1u8), Just(3), Just(5), Just(6), Just(15), Just(16), Just(22), Just(23), any::<u8>()],
            fields in proptest::collection::vec(prop_oneof![3 => 0u8..4, 1 => any::<u8>()], 0..20),
        ) {
            let image = PortImage::default();
            let pdu = [&[function][..], &fields].concat();
            let length = (1 + pdu.len()) as u16;
            let message = [&[0, 7, 0, 0][..], &length.to_be_bytes(), &[255], &pdu].concat();
            prop_assert_eq!(message_bytes(&message), Ok(Some(message.len())));
            let answer = answer(&message, &image);
            prop_assert_eq!(message_bytes(&answer), Ok(Some(answer.len())));
            prop_assert!(answer[7] == function || answer[7] == function | 0x80);
        }
    }
}
