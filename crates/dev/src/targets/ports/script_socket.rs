//! What a peer of a script's socket sends: frames of numbers and texts, the same in any pieces, and bounded memory.

use io_bus::script_socket::decode::{
    ParseOutcome, TEXT_BYTES_MAX, floats, parse_saturating_i32, text,
};

/// Every result of a reader that looks again after each piece, and what is left unread.
fn all<T>(pieces: &[&[u8]], mut look: impl FnMut(&mut Vec<u8>, bool) -> ParseOutcome<T>) -> Vec<T> {
    let (mut unread, mut results) = (Vec::new(), Vec::new());
    for piece in pieces {
        unread.extend_from_slice(piece);
        loop {
            let before = unread.len();
            match look(&mut unread, false) {
                ParseOutcome::Done(result) if unread.len() < before => results.push(result),
                _ => break,
            }
        }
    }
    let ParseOutcome::Done(last) = look(&mut unread, true) else {
        panic!("the last look always has a result");
    };
    results.push(last);
    results
}

pub(super) fn judge(data: &[u8]) {
    let Some((&[cut, marks, count], bytes)) = data.split_first_chunk::<3>() else {
        return;
    };
    let pieces: Vec<&[u8]> = bytes.chunks(usize::from(cut).max(1)).collect();
    let count = usize::from(count % 33);
    for numbers in all(&pieces, |unread, is_last| floats(unread, count, is_last)) {
        assert!(numbers.len() <= count);
    }
    let prefix: &[u8] = [&b""[..], b"<", b"<<", b"GET "][usize::from(marks & 3)];
    let suffix: &[u8] = [&b""[..], b">", b"\r\n", b"((("][usize::from(marks >> 2 & 3)];
    let texts = all(&pieces, |unread, is_last| {
        text(unread, prefix, suffix, is_last)
    });
    for text in &texts {
        // A byte that is no UTF-8 becomes a character of three.
        assert!(text.len() <= 3 * TEXT_BYTES_MAX);
    }
    if bytes.len() <= TEXT_BYTES_MAX && !suffix.is_empty() {
        let whole = all(&[bytes], |unread, is_last| {
            text(unread, prefix, suffix, is_last)
        });
        assert_eq!(whole, texts);
    }
    let _ = parse_saturating_i32(&String::from_utf8_lossy(bytes));
}
