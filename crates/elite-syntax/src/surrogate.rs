//! Surrogates in texts. Python's texts are code points, and half a pair is one; ours are UTF-8, which has no such
//! thing. So the surrogates U+D800 to U+DFFF lie in texts as 2048 characters of the private plane 16, U+10E000 to
//! U+10E7FF, which therefore cannot be had themselves. Whoever turns characters into numbers, or into bytes, or the
//! other way round, comes here; nobody else has to know.

/// The first code point of a surrogate, and how many there are.
const FIRST: u32 = 0xd800;
const COUNT: u32 = 0x800;
/// The character that stands for the first surrogate.
const STANDIN: u32 = 0x10_e000;

/// The code point of a character, for scripts.
#[inline]
pub fn code_of(c: char) -> u32 {
    match c as u32 {
        code @ STANDIN.. if code < STANDIN + COUNT => code - STANDIN + FIRST,
        code => code,
    }
}

/// The character of a code point; None if there is none, which are numbers beyond 0x10FFFF and those that stand for
/// surrogates.
#[inline]
pub fn char_of(code: u32) -> Option<char> {
    match code {
        FIRST..0xe000 => char::from_u32(code - FIRST + STANDIN),
        STANDIN.. if code < STANDIN + COUNT => None,
        _ => char::from_u32(code),
    }
}

/// Whether a character stands for a surrogate.
#[inline]
pub fn is_surrogate(c: char) -> bool {
    (STANDIN..STANDIN + COUNT).contains(&(c as u32))
}

/// Whether a text may hold a surrogate: all of them begin with these bytes.
pub fn may_have_surrogates(text: &str) -> bool {
    memchr::memmem::find(text.as_bytes(), &[0xf4, 0x8e]).is_some() && text.chars().any(is_surrogate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surrogates_go_there_and_back() {
        for code in (0..0x11_0000).filter(|code| !(STANDIN..STANDIN + COUNT).contains(code)) {
            let c = char_of(code).unwrap();
            assert_eq!(code_of(c), code);
            assert_eq!(is_surrogate(c), (0xd800..0xe000).contains(&code));
        }
        assert_eq!(char_of(STANDIN), None);
        assert_eq!(char_of(0x11_0000), None);
        assert!(may_have_surrogates("a\u{10e000}"));
        assert!(!may_have_surrogates("a\u{10e800}"));
    }
}
