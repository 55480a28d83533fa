//! What the system says of an error, in words for people.

use std::io;

/// The words of an error without the number that std puts behind them: "No such file or directory".
pub fn error_text(error: &io::Error) -> String {
    let text = error.to_string();
    match error.raw_os_error() {
        Some(code) => match text.strip_suffix(&format!(" (os error {code})")) {
            Some(words) => words.to_owned(),
            None => text,
        },
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_come_without_the_number_and_own_words_as_they_are() {
        let missing = std::fs::metadata("/there/is/nothing").unwrap_err();
        assert!(missing.to_string().contains("os error"), "{missing}");
        assert!(
            !error_text(&missing).contains("os error"),
            "{}",
            error_text(&missing)
        );
        assert_eq!(
            error_text(&io::Error::other("own (os error 2)")),
            "own (os error 2)"
        );
    }
}
