//! Finding text in text. Single bytes are by far the commonest separators.

use memchr::{memchr, memchr_iter, memmem, memrchr};

/// Byte offset of the first occurrence of `part`.
#[inline]
pub fn find(text: &str, part: &str) -> Option<usize> {
    match part.as_bytes() {
        [byte] => memchr(*byte, text.as_bytes()),
        part => memmem::find(text.as_bytes(), part),
    }
}

/// Byte offset of the last occurrence of `part`.
#[inline]
pub fn rfind(text: &str, part: &str) -> Option<usize> {
    match part.as_bytes() {
        [byte] => memrchr(*byte, text.as_bytes()),
        part => memmem::rfind(text.as_bytes(), part),
    }
}

/// Calls `each` with the parts of `text` between occurrences of `separator`, which is not empty; at most `most`
/// occurrences count.
#[inline]
pub fn split<'t>(text: &'t str, separator: &str, most: usize, mut each: impl FnMut(&'t str)) {
    let mut start = 0;
    let mut cut = |at: usize| {
        each(&text[start..at]);
        start = at + separator.len();
    };
    match separator.as_bytes() {
        [byte] => memchr_iter(*byte, text.as_bytes())
            .take(most)
            .for_each(&mut cut),
        part => memmem::find_iter(text.as_bytes(), part)
            .take(most)
            .for_each(&mut cut),
    }
    each(&text[start..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_found_and_split_as_the_standard_library_does() {
        let texts = ["", ",", "a,b,,c", "ä→ö→ü", "aaaa", "no separator", ",,"];
        for text in texts {
            for part in [",", "→", "aa", "b,", "x", "ö"] {
                assert_eq!(find(text, part), text.find(part), "{text:?} {part:?}");
                assert_eq!(rfind(text, part), text.rfind(part), "{text:?} {part:?}");
                for most in [0, 1, 2, 100] {
                    let mut parts = Vec::new();
                    split(text, part, most, |found| parts.push(found));
                    let expected: Vec<&str> = text.splitn(most + 1, part).collect();
                    assert_eq!(parts, expected, "{text:?} {part:?} {most}");
                }
            }
        }
    }
}
