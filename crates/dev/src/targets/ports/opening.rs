//! The first bytes on a port with a protocol of its own: the same verdict in any pieces, nothing of a browser's let in,
//! nothing of anybody else's lost.

use server::ports::opening::{Opening, Verdict};

/// Methods that any browser can be made to send.
const OF_BROWSERS: [&[u8]; 4] = [b"GET ", b"POST ", b"OPTIONS ", b"CONNECT "];

/// The verdict, and what was let through.
fn verdict<'a>(pieces: impl Iterator<Item = &'a [u8]>) -> (Verdict, Vec<u8>) {
    let (mut opening, mut ours) = (Opening::default(), Vec::new());
    let mut verdict = Verdict::Undecided;
    for piece in pieces {
        match verdict {
            Verdict::Undecided => verdict = opening.take(piece, &mut ours),
            Verdict::Ours => ours.extend_from_slice(piece),
            Verdict::Intruder(_) => break,
        }
    }
    if verdict == Verdict::Undecided {
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
        Verdict::Intruder(_) => assert!(ours.trim_ascii().is_empty(), "{ours:?}"),
        Verdict::Ours | Verdict::Undecided => {
            assert_eq!(ours, data);
            let is_request = OF_BROWSERS.iter().any(|method| start.starts_with(method));
            assert!(!is_request, "a request is let in");
        }
    }
}
