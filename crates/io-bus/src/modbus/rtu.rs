//! Modbus on a serial line: frames with a checksum, and the search for a reply among whatever a line carries.
//!
//! (MODBUS over Serial Line Specification V1.02, 2.5.) Lengths are known from the request, so the silence between
//! frames is not needed to find them; a pty or a TCP gateway would not keep it.

use super::pdu::{EXCEPTION_FLAG, Request};

/// Longest frame.
pub const FRAME_BYTES_MAX: usize = 256;

/// Checksum of a frame, low byte first on the line (2.5.1.2).
pub fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |mut crc, byte| {
        crc ^= u16::from(*byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 {
                crc >> 1 ^ 0xA001
            } else {
                crc >> 1
            };
        }
        crc
    })
}

/// The frame of a request.
pub fn encode(slave: u8, request: &Request) -> Vec<u8> {
    let mut frame = vec![slave];
    frame.extend(request.encode());
    frame.extend(crc(&frame).to_le_bytes());
    frame
}

/// The reply proper to `request` in what was received: the first frame with the right slave, function, length and
/// checksum. Everything else is passed over. `None` when it is not (completely) there.
pub fn find_reply<'a>(received: &'a [u8], slave: u8, request: &Request) -> Option<&'a [u8]> {
    let function = request.function();
    (0..received.len()).find_map(|start| {
        let rest = &received[start..];
        if rest.first() != Some(&slave) {
            return None;
        }
        let length = match rest.get(1) {
            Some(code) if *code == function | EXCEPTION_FLAG => 2,
            Some(code) if *code == function => request.reply_bytes()?,
            _ => return None,
        };
        let frame = rest.get(..1 + length + 2)?;
        let (body, sum) = frame.split_at(1 + length);
        (crc(body).to_le_bytes() == sum).then(|| &body[1..])
    })
}

#[cfg(test)]
mod tests {
    use super::super::pdu::Table;
    use super::*;
    use proptest::prelude::*;

    const READ: Request = Request::Read {
        table: Table::HoldingRegisters,
        address: 0,
        count: 2,
    };

    #[test]
    fn the_frame_of_the_specification_has_its_checksum() {
        // 02 07: the example of appendix B gives 41 12.
        assert_eq!(crc(&[0x02, 0x07]).to_le_bytes(), [0x41, 0x12]);
        let frame = encode(1, &READ);
        assert_eq!(frame, [1, 3, 0, 0, 0, 2, 0xC4, 0x0B]);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn a_reply_is_found_behind_garbage_and_only_when_it_is_whole(
            garbage in proptest::collection::vec(any::<u8>(), 0..40),
            values: [u16; 2],
            cut in 1..8_usize,
        ) {
            let mut reply = vec![9, 3, 4];
            reply.extend(values.iter().flat_map(|v| v.to_be_bytes()));
            reply.extend(crc(&reply).to_le_bytes());
            prop_assume!(find_reply(&garbage, 9, &READ).is_none());
            let line = [garbage.clone(), reply.clone()].concat();
            let found = find_reply(&line, 9, &READ);
            prop_assert_eq!(found, Some(&reply[1..7]));
            let part = &line[..line.len() - cut];
            prop_assert_eq!(find_reply(part, 9, &READ), None);
            let mut damaged = reply;
            damaged[cut] ^= 0x10;
            prop_assert_eq!(find_reply(&damaged, 9, &READ), None);
        }

        #[test]
        fn any_line_noise_is_searched_without_harm(
            noise in proptest::collection::vec(prop_oneof![Just(9_u8), Just(3), Just(0x83), any::<u8>()], 0..300),
        ) {
            let _ = find_reply(&noise, 9, &READ);
        }
    }
}
