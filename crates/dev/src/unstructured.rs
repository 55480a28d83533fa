//! Bytes as a source of decisions: what a generator builds is a function of its bytes, so an input of a fuzzer, a seed
//! and a kept finding are all the same thing, and a shorter input is a simpler one.

/// Decisions, taken from bytes in order. When they are used up every decision is the first choice.
pub struct Unstructured<'a> {
    bytes: &'a [u8],
}

impl<'a> Unstructured<'a> {
    /// Decisions from these bytes.
    pub fn new(bytes: &'a [u8]) -> Self {
        Unstructured { bytes }
    }

    /// Whether all bytes are used.
    pub fn is_used_up(&self) -> bool {
        self.bytes.is_empty()
    }

    /// The next byte, 0 at the end.
    pub fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.bytes.split_first() else {
            return 0;
        };
        self.bytes = rest;
        *first
    }

    /// A number below `end`, which is at most 65536; 0 if `end` is.
    pub fn below(&mut self, end: usize) -> usize {
        let number = if end <= 256 {
            usize::from(self.byte())
        } else {
            usize::from(self.byte()) << 8 | usize::from(self.byte())
        };
        number.checked_rem(end).unwrap_or(0)
    }

    /// Whether one of `many` came up; false at the end.
    pub fn one_in(&mut self, many: usize) -> bool {
        !self.is_used_up() && self.below(many) == many - 1
    }

    /// One of these, which are not none.
    pub fn pick<'t, T: ?Sized>(&mut self, choices: &[&'t T]) -> &'t T {
        choices[self.below(choices.len())]
    }
}
