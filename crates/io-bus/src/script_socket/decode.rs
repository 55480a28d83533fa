//! Texts and numbers in the bytes that a peer of a script's socket has sent. Pure: knows no socket and no clock.
//!
//! Each function looks into the bytes that were not read yet, takes what belongs to its result, and says when more is
//! needed. With `is_last` no more will come: then it takes what there is.

/// Most bytes of text one read gives (manual 7.1.9).
pub const TEXT_BYTES_MAX: usize = 2047;

/// Longest frame of numbers in parentheses that is waited for.
const FRAME_BYTES_MAX: usize = 4096;

/// What a search in the unread bytes has found.
#[derive(Debug, PartialEq)]
pub enum ParseOutcome<T> {
    /// The result; its bytes are gone from the buffer.
    Done(T),
    /// More bytes are needed.
    NeedMoreBytes,
}

/// There is nothing to be found: for good, or not yet.
fn empty_result<T: Default>(is_last: bool) -> ParseOutcome<T> {
    if is_last {
        ParseOutcome::Done(T::default())
    } else {
        ParseOutcome::NeedMoreBytes
    }
}

fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    if wanted.is_empty() {
        return Some(0);
    }
    bytes.windows(wanted.len()).position(|part| part == wanted)
}

/// Drops what stands before the first parenthesis.
fn skip_to_frame(unread: &mut Vec<u8>) {
    let begin = unread.iter().position(|byte| *byte == b'(');
    unread.drain(..begin.unwrap_or(unread.len()));
}

/// Up to `count` numbers of the first frame `(1.5, 2, 3)`; none when what stands in it are no numbers. What stands
/// before the frame is dropped.
pub fn floats(unread: &mut Vec<u8>, count: usize, is_last: bool) -> ParseOutcome<Vec<f64>> {
    skip_to_frame(unread);
    let Some(end) = unread.iter().position(|byte| *byte == b')') else {
        // No frame is longer: what began earlier is none.
        let excess = unread.len().saturating_sub(FRAME_BYTES_MAX);
        unread.drain(..excess);
        skip_to_frame(unread);
        return empty_result(is_last);
    };
    let frame: Vec<u8> = unread.drain(..=end).collect();
    let frame = String::from_utf8_lossy(&frame[1..end]);
    let fields = frame.split([',', ' ', '\t', '\r', '\n']);
    let numbers: Result<Vec<f64>, _> = fields
        .filter(|field| !field.is_empty())
        .take(count)
        .map(str::parse)
        .collect();
    ParseOutcome::Done(numbers.unwrap_or_default())
}

/// The text after `prefix` and before `suffix`, either may be empty. At most [`TEXT_BYTES_MAX`] bytes; the rest stays.
pub fn text(
    unread: &mut Vec<u8>,
    prefix: &[u8],
    suffix: &[u8],
    is_last: bool,
) -> ParseOutcome<String> {
    let Some(at) = find(unread, prefix) else {
        // The prefix may have come in part; before it nothing is wanted.
        let keep = unread.len().min(prefix.len().saturating_sub(1));
        if unread.len() > TEXT_BYTES_MAX {
            unread.drain(..unread.len() - keep);
        }
        return empty_result(is_last);
    };
    let begin = at + prefix.len();
    let rest = &unread[begin..];
    let (length, taken) = if suffix.is_empty() {
        let length = rest.len().min(TEXT_BYTES_MAX);
        (length, length)
    } else {
        match find(rest, suffix) {
            Some(length) if length <= TEXT_BYTES_MAX => (length, length + suffix.len()),
            // Longer than one read gives: the first part now, the rest with the next read.
            _ if rest.len() >= TEXT_BYTES_MAX + suffix.len() => (TEXT_BYTES_MAX, TEXT_BYTES_MAX),
            _ => return empty_result(is_last),
        }
    };
    if length == 0 && suffix.is_empty() {
        return empty_result(is_last);
    }
    // A character that was cut in two stays whole for the next read.
    let (length, taken) = match std::str::from_utf8(&rest[..length]) {
        Err(cut) if cut.error_len().is_none() && cut.valid_up_to() > 0 && taken == length => {
            (cut.valid_up_to(), cut.valid_up_to())
        }
        _ => (length, taken),
    };
    let found = String::from_utf8_lossy(&rest[..length]).into_owned();
    unread.drain(..begin + taken);
    ParseOutcome::Done(found)
}

/// A decimal integer, cut to 32 bits at the ends; `None` when it is none.
pub fn parse_saturating_i32(text: &str) -> Option<i32> {
    let text = text.trim();
    let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
    if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    let limit = if text.starts_with('-') {
        i32::MIN
    } else {
        i32::MAX
    };
    Some(text.parse().unwrap_or(limit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_parentheses_without_an_end_the_last_few_are_kept() {
        let mut unread = vec![b'('; 60_000];
        assert_eq!(floats(&mut unread, 3, false), ParseOutcome::NeedMoreBytes);
        assert_eq!(unread.len(), FRAME_BYTES_MAX);
        unread.extend(b"(((1, 2) (3, 4)");
        assert_eq!(floats(&mut unread, 3, false), ParseOutcome::Done(vec![]));
        assert_eq!(
            floats(&mut unread, 3, false),
            ParseOutcome::Done(vec![3.0, 4.0])
        );
    }
}
