//! What a name is made of: the characters that Unicode lists for it (XID_Start and XID_Continue), and the underscore.

/// Whether a name may begin with a character.
#[inline]
pub fn begins_name(c: char) -> bool {
    c == '_' || unicode_ident::is_xid_start(c)
}

/// Whether a name may go on with a character.
#[inline]
pub fn continues_name(c: char) -> bool {
    // Unicode has these only since 15.1: two joiners without width, two middle dots.
    unicode_ident::is_xid_continue(c)
        && !matches!(c, '\u{200c}' | '\u{200d}' | '\u{30fb}' | '\u{ff65}')
}

/// Whether a text is a name (`str.isidentifier`).
pub fn is_name(text: &str) -> bool {
    text.starts_with(begins_name) && text.chars().all(continues_name)
}
