//! The first bytes on a port with a protocol of its own: the same verdict in any pieces, nothing of a browser's let in,
//! nothing of anybody else's lost.

use server::ports::protocol_sniffer::{ProtocolSniffer, SniffResult};

/// Methods that any browser can be made to send.
const OF_BROWSERS: [&[u8]; 4] = [b"GET ", b"POST ", b"OPTIONS ", b"CONNECT "];

/// The verdict, and what was let through.
fn verdict<'a>(pieces: impl Iterator<Item = &'a [u8]>) -> (SniffResult, Vec<u8>) {
    let (mut opening, mut ours) = (ProtocolSniffer::default(), Vec::new());
    let mut verdict = SniffResult::Undecided;
    for piece in pieces {
        match verdict {
            SniffResult::Undecided => verdict = opening.take(piece, &mut ours),
            SniffResult::Ours => ours.extend_from_slice(piece),
            SniffResult::Intruder(_) => break,
        }
    }
    if verdict == SniffResult::Undecided {
        opening.give_back(&mut ours);
    }
    (verdict, ours)
}

pub(super) fn judge(data: &[u8]) {
    let whole = verdict([data].into_iter());
    assert_eq!(whole, verdict(data.chunks(1)));
    assert_eq!(whole, verdict(data.chunks(3)));
    let (verdict, ours) = whole;
    let start = data.trim_ascii_start();
    match verdict {
        SniffResult::Intruder(_) => assert!(ours.trim_ascii().is_empty(), "{ours:?}"),
        SniffResult::Ours | SniffResult::Undecided => {
            assert_eq!(ours, data);
            let is_request = OF_BROWSERS.iter().any(|method| start.starts_with(method));
            assert!(!is_request, "a request is let in");
        }
    }
}
