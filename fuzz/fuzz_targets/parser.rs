//! Sequences of words of the language: they reach deeper into the parser than bytes do.
#![no_main]

use elite_lang::{KnownNames, SourceFile, check};
use libfuzzer_sys::fuzz_target;

/// What a byte stands for; the rest of the bytes are characters.
const WORDS: &[&str] = &[
    "def ", "f", "(", ")", ":", "\n", "\n    ", "\n        ", "\n\t", "end", "if ", "else", "elif ", "while ", "for ",
    " in ", "x", " = ", " == ", "1", "1.5", "'a'", "f'{x}'", "f'{", "}'", "\"\"\"", "[", "]", "{", "}", ", ", ";", "*",
    "**", "lambda ", "yield ", "return ", "class ", "try", "except ", "finally", "with ", " as ", "import ", "from ",
    ".", "...", "not ", " and ", " or ", " is ", "sec ", "print ", "global ", "nonlocal ", "del ", "assert ", "raise ",
    " := ", "@", " -> ", "#", "\\\n", "break", "continue", "pass", "None", "async ", "await ", "match ", "-", "~", "0x",
    "b''", "r'\\'", "!r", "{{", "}}", "/", "//", "self", "a.b", "x[1:2]", "super()", "True", ":;", "; ", " += ",
];

fuzz_target!(|data: &[u8]| {
    let text: String = data
        .iter()
        .map(|byte| match WORDS.get(usize::from(*byte)) {
            Some(word) => (*word).to_owned(),
            None => char::from(byte & 0x7f).to_string(),
        })
        .collect();
    let file = SourceFile::new("fuzz.script", text);
    // Checking is deterministic.
    let first = check(file.clone(), &KnownNames::default());
    let second = check(file, &KnownNames::default());
    assert_eq!(first, second);
});
