//! Whether a record of an MCAP file has room for what its lengths promise.
//!
//! Looked at before a record is parsed: the parser makes room for a text before it sees that there is none.

use mcap::records::op;

/// Entries of a map of texts; a recording's own have twenty.
const MAX_ENTRIES: usize = 1000;

/// True when every text, map and block of bytes of the record ends within it. Records of other kinds have none.
pub(crate) fn is_within_bounds(opcode: u8, record: &[u8]) -> bool {
    let mut rest = ByteCursor(record);
    let all = match opcode {
        op::SCHEMA => rest.skip(2).and_then(|()| rest.block()).and_then(|_| {
            rest.block()?;
            rest.block()
        }),
        op::CHANNEL => rest.skip(4).and_then(|()| {
            rest.block()?;
            rest.block()?;
            rest.map()
        }),
        op::ATTACHMENT => rest.skip(16).and_then(|()| {
            rest.block()?;
            rest.block()?;
            rest.content_and_checksum()
        }),
        op::METADATA => rest.block().and_then(|_| rest.map()),
        op::CHUNK => rest.skip(28).and_then(|()| rest.block()),
        _ => Some(&[][..]),
    };
    all.is_some()
}

/// What of a record was not looked at yet.
struct ByteCursor<'a>(&'a [u8]);

impl<'a> ByteCursor<'a> {
    fn skip(&mut self, bytes: usize) -> Option<()> {
        self.0 = self.0.get(bytes..)?;
        Some(())
    }

    /// A text, or other bytes with their length before them.
    fn block(&mut self) -> Option<&'a [u8]> {
        let length = u32::from_le_bytes(*self.0.first_chunk()?);
        let (block, rest) = self.0[4..].split_at_checked(usize::try_from(length).ok()?)?;
        self.0 = rest;
        Some(block)
    }

    /// Bytes with their length in eight bytes before them and a checksum behind them, which end the record.
    fn content_and_checksum(&mut self) -> Option<&'a [u8]> {
        let length = usize::try_from(u64::from_le_bytes(*self.0.first_chunk()?)).ok()?;
        let (content, rest) = self.0[8..].split_at_checked(length)?;
        self.0 = rest;
        (rest.len() == 4).then_some(content)
    }

    /// A map from text to text.
    fn map(&mut self) -> Option<&'a [u8]> {
        let all = self.block()?;
        let mut entries = ByteCursor(all);
        for _ in 0..MAX_ENTRIES {
            if entries.0.is_empty() {
                return Some(all);
            }
            entries.block()?;
            entries.block()?;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(text: &str) -> Vec<u8> {
        [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
    }

    #[test]
    fn a_length_that_leads_out_of_the_record_is_found_wherever_it_stands() {
        let map = text(&String::from_utf8([text("key"), text("value")].concat()).unwrap());
        let (n, m) = (text("name"), text("more"));
        for (opcode, record, lengths) in [
            (
                op::SCHEMA,
                [&[1, 0][..], &n, &m, &n].concat(),
                vec![2, 10, 18],
            ),
            (
                op::CHANNEL,
                [&[1, 0, 0, 0][..], &n, &m, &map].concat(),
                vec![4, 12, 20, 24, 31],
            ),
            (op::METADATA, [&n[..], &map].concat(), vec![0, 8, 12, 19]),
            (op::CHUNK, [&[0; 28][..], &n, &[0; 8]].concat(), vec![28]),
            (
                op::ATTACHMENT,
                [&[0; 16][..], &n, &m, &2_u64.to_le_bytes(), b"ab", &[0; 4]].concat(),
                vec![16, 24, 32],
            ),
        ] {
            assert!(is_within_bounds(opcode, &record), "{opcode}");
            for at in lengths {
                for wrong in [200_u32, u32::MAX, 1 << 31] {
                    let mut record = record.clone();
                    record[at..at + 4].copy_from_slice(&wrong.to_le_bytes());
                    assert!(!is_within_bounds(opcode, &record), "{opcode} at {at}");
                }
            }
            let shortest = if opcode == op::CHUNK {
                record.len() - 8
            } else {
                record.len()
            };
            for length in 0..shortest {
                assert!(
                    !is_within_bounds(opcode, &record[..length]),
                    "{opcode} of {length} bytes"
                );
            }
        }
        let many = text(&"\0\0\0\0\0\0\0\0".repeat(MAX_ENTRIES + 1));
        assert!(!is_within_bounds(op::METADATA, &[n, many].concat()));
        assert!(is_within_bounds(op::MESSAGE, b""));
    }
}
