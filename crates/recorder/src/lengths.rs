//! How long what is recorded may be. What is longer is cut, with a mark that says so.
//!
//! Numbers, commands and registers are of fixed size; only texts have to be looked at. Owns the limits of each kind and
//! the mark.

/// The text of a program that runs: what a port takes at most, so a program from a client is whole.
pub const PROGRAM_TEXT_BYTES: usize = 8 << 20;
/// The text of a program that does not compile, or that comes when much text has just been recorded.
pub const SHORT_TEXT_BYTES: usize = 4 << 10;
/// A message of `/log`.
pub const MESSAGE_BYTES: usize = 64 << 10;
/// A message of a topic that is not ours; longer ones are left out, as half a message is none.
pub const EXTRA_BYTES: usize = 64 << 10;
/// The value of a variable.
pub const VALUE_BYTES: usize = 4 << 10;
/// Names: of programs, of variables and their types, of points, of the sources of messages.
pub const NAME_BYTES: usize = 256;

/// The beginning of a text that is longer than `most` bytes, with the mark behind it: together not longer than that.
/// `None` for a text that fits.
pub fn truncate_marked(text: &str, most: usize) -> Option<String> {
    if text.len() <= most {
        return None;
    }
    let mark = format!(" … [cut, {} bytes in all]", text.len());
    let mut end = most.saturating_sub(mark.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    Some(format!("{}{mark}", &text[..end]))
}

/// Shortens a text of more than `most` bytes whose end matters, for instance a report: a mark stands in the middle, and
/// most of what is kept comes behind it. `None` for a text that fits.
pub fn truncate_middle_marked(text: &str, most: usize) -> Option<String> {
    if text.len() <= most {
        return None;
    }
    let mark = format!(" … [cut, {} bytes in all] … ", text.len());
    let room = most.saturating_sub(mark.len());
    let mut head = room / 4;
    while !text.is_char_boundary(head) {
        head -= 1;
    }
    let mut tail = text.len() - (room - head);
    while !text.is_char_boundary(tail) {
        tail += 1;
    }
    Some(format!("{}{mark}{}", &text[..head], &text[tail..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_cut_in_the_middle_keeps_its_end() {
        assert_eq!(truncate_middle_marked(&"x".repeat(64), 64), None);
        for text in ["x".repeat(65), "é".repeat(60), "🦀".repeat(1000)] {
            let short = truncate_middle_marked(&format!("{text}end"), 64).unwrap();
            assert!(short.len() <= 64 && short.len() > 54, "{short}");
            assert!(
                short.contains(" … [cut, ") && short.ends_with("end"),
                "{short}"
            );
        }
    }

    #[test]
    fn what_fits_stays_and_what_does_not_is_marked() {
        assert_eq!(truncate_marked("", 64), None);
        assert_eq!(truncate_marked(&"x".repeat(64), 64), None);
        for text in ["x".repeat(65), "é".repeat(60), "🦀".repeat(1000)] {
            let short = truncate_marked(&text, 64).unwrap();
            assert!(short.len() <= 64 && short.len() > 60, "{short}");
            let whole = format!("[cut, {} bytes in all]", text.len());
            assert!(short.ends_with(&whole), "{short}");
            let kept = short.split(" …").next().unwrap();
            assert!(text.starts_with(kept) && !kept.is_empty());
        }
    }
}
