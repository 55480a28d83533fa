//! Number literals.

use messages::text;

use num_bigint::BigInt;

use super::{ParseResult, Parser};
use crate::ast::{Constant, ExprKind};
use crate::lexer::TokenKind as T;

/// Digits of a decimal integer literal that are accepted (CPython: `sys.get_int_max_str_digits()`).
const INT_DIGITS_MAX: usize = 4300;

impl Parser<'_> {
    pub(super) fn number(&mut self) -> ParseResult<ExprKind> {
        let token = self.bump();
        let text: String = self.text(token).chars().filter(|c| *c != '_').collect();
        let constant = match token.kind {
            T::Int => self.integer(&text, token.span)?,
            T::Float => text.parse().ok().map(Constant::Float),
            // A name may be stuck to the number; the lexer has said so.
            _ => text
                .strip_suffix(['j', 'J'])
                .and_then(|digits| digits.parse().ok())
                .map(Constant::Imaginary),
        };
        match constant {
            Some(constant) => Ok(ExprKind::Constant(constant)),
            None => self.fail(
                token.span,
                text!("'{text}' is not a number", "'{text}' 不是数"),
            ),
        }
    }

    fn integer(&mut self, text: &str, span: crate::source::Span) -> ParseResult<Option<Constant>> {
        let (radix, digits) = match text.get(..2) {
            Some("0x" | "0X") => (16, &text[2..]),
            Some("0o" | "0O") => (8, &text[2..]),
            Some("0b" | "0B") => (2, &text[2..]),
            _ => (10, text),
        };
        if radix == 10 && digits.len() > INT_DIGITS_MAX {
            return self.fail(
                span,
                text!(
                    "this number has {} digits, {INT_DIGITS_MAX} are allowed",
                    "这个数有 {} 位，最多允许 {INT_DIGITS_MAX} 位",
                    digits.len()
                ),
            );
        }
        if radix == 10
            && digits.len() > 1
            && digits.starts_with('0')
            && digits.bytes().any(|b| b != b'0')
        {
            return self.fail(
                span,
                text!(
                    "a decimal number cannot start with 0; write octal numbers as 0o17",
                    "十进制数不能以 0 开头；八进制数请写作 0o17"
                ),
            );
        }
        if let Ok(small) = i64::from_str_radix(digits, radix) {
            return Ok(Some(Constant::Int(small)));
        }
        let all_digits = !digits.is_empty() && digits.chars().all(|c| c.is_digit(radix));
        Ok(all_digits
            .then(|| BigInt::parse_bytes(digits.as_bytes(), radix))
            .flatten()
            .map(Constant::BigInt))
    }
}
