//! What is typed, as what goes to port 30020: one line a statement.
//!
//! Lines are put together as the port itself does it. A block of several lines becomes the one line that the manual
//! knows (2.1.1): a `;` stands for a line end, the blanks behind it for the indentation. So a function that is typed is
//! defined, as one in that form is, and not called, as a block of lines is by controllers that take one.

use messages::Localized;
use thiserror::Error;

use crate::ports::interpreter::codec::{BLOCK_BYTES_MAX, StatementFrame, StatementFramer};
use crate::ports::script_text::StringTracker;

/// Tabs reach to the next multiple.
const TAB: usize = 8;

/// Lines on their way to statements.
#[derive(Debug, Default)]
pub(super) struct StatementReader {
    framer: StatementFramer,
}

/// A text that cannot be a statement; each is a sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error, Localized)]
pub(super) enum StatementError {
    #[error("a text over several lines cannot stand in a block: the port takes one line")]
    #[zh("多行文本不能放在块中：端口只接收一行")]
    LongText,
    #[error("a block has at most {} KiB", BLOCK_BYTES_MAX / 1024)]
    #[zh("一个块最多 {} KiB", BLOCK_BYTES_MAX / 1024)]
    TooLong,
}

impl StatementReader {
    /// Takes a line without its end; the statement that it completes, if it does.
    pub(super) fn line(&mut self, line: &str) -> Option<Result<String, StatementError>> {
        if !self.is_open() && line.trim_start().starts_with('#') {
            return None;
        }
        let mut frames = Vec::new();
        self.framer.push(line.as_bytes(), &mut frames);
        self.framer.push(b"\n", &mut frames);
        first(frames)
    }

    /// Whether a block waits for its `end`.
    pub(super) fn is_open(&self) -> bool {
        !self.framer.is_between()
    }

    /// Nothing more comes: an open block is complete.
    pub(super) fn finish(&mut self) -> Option<Result<String, StatementError>> {
        let mut frames = Vec::new();
        self.framer.finish(&mut frames);
        self.forget();
        first(frames)
    }

    /// Throws away an open block.
    pub(super) fn forget(&mut self) {
        self.framer = StatementFramer::default();
    }
}

fn first(frames: Vec<StatementFrame>) -> Option<Result<String, StatementError>> {
    frames.into_iter().next().map(|frame| match frame {
        StatementFrame::Statement(text) if text.contains('\n') => one_line(&text),
        StatementFrame::Statement(text) => Ok(text),
        StatementFrame::Command(word) => Ok(word.word().to_owned()),
        StatementFrame::Rejected(_) => Err(StatementError::TooLong),
    })
}

/// A block as one line.
fn one_line(text: &str) -> Result<String, StatementError> {
    let mut joined = LineJoiner::default();
    let mut strings = StringTracker::default();
    let mut depth = 0_u32;
    let mut escaped = false;
    for character in text.chars().chain(['\n']) {
        let was_code = strings.in_code_now();
        let mut bytes = [0; 4];
        for byte in character.encode_utf8(&mut bytes).bytes() {
            strings.feed(byte);
        }
        let after_backslash = core::mem::replace(&mut escaped, character == '\\' && was_code);
        match character {
            '\n' if strings.in_string() => return Err(StatementError::LongText),
            '\n' if after_backslash => joined.part.truncate(joined.part.len() - 1),
            '\n' if depth > 0 => joined.part.push(' '),
            '\n' => joined.end_line(),
            ';' if was_code && depth == 0 => joined.end_part(),
            // In a comment; a string that ends here is in code before and after.
            _ if was_code && character == '#' => {}
            _ if !strings.in_code_now() && !strings.in_string() => {}
            _ => {
                if was_code {
                    match character {
                        '(' | '[' | '{' => depth += 1,
                        ')' | ']' | '}' => depth = depth.saturating_sub(1),
                        _ => {}
                    }
                }
                joined.part.push(character);
            }
        }
    }
    Ok(joined.out)
}

/// Lines put behind each other.
#[derive(Default)]
struct LineJoiner {
    out: String,
    /// What has come of the statement.
    part: String,
    /// Indentation of the line that `part` stands in.
    indent: Option<usize>,
}

impl LineJoiner {
    /// A `;`: what follows stands as far right as the line does.
    fn end_part(&mut self) {
        let code = self.part.trim_start();
        let blanks = &self.part[..self.part.len() - code.len()];
        let own = blanks.chars().fold(0, |column, blank| match blank {
            '\t' => (column / TAB + 1) * TAB,
            _ => column + 1,
        });
        let code = code.trim_end();
        if !code.is_empty() {
            let indent = *self.indent.get_or_insert(own);
            self.out.extend(core::iter::repeat_n(' ', indent));
            self.out.push_str(code);
            self.out.push(';');
        }
        self.part.clear();
    }

    fn end_line(&mut self) {
        self.end_part();
        self.indent = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use elite_syntax::{SourceFile, compile};
    use proptest::prelude::*;

    fn typed(lines: &str) -> Vec<Result<String, StatementError>> {
        let mut typed = StatementReader::default();
        let mut all: Vec<_> = lines.lines().filter_map(|line| typed.line(line)).collect();
        all.extend(typed.finish());
        all
    }

    #[test]
    fn a_line_is_a_statement_and_a_block_becomes_one() {
        for (lines, wanted) in [
            ("x = 1", vec!["x = 1"]),
            ("a(); b()\n\n# nothing\nabort", vec!["a(); b()", "abort"]),
            (
                "def f(a):\n  if a: # or not\n    x = '#;' ; y = 2\n\n  else:\n    g([1,\n  2])\nend\nf(1)",
                vec![
                    "def f(a):;  if a:;    x = '#;';    y = 2;  else:;    g([1,   2]);end;",
                    "f(1)",
                ],
            ),
            (
                "while True:\n\tx = 1 + \\\n\t2\n\tbreak\nend",
                vec!["while True:;        x = 1 + \t2;        break;end;"],
            ),
            // The pipe ends in a block.
            ("if x:\n f()", vec!["if x:; f();"]),
            (
                "def über():\n  textmsg('é')\nend",
                vec!["def über():;  textmsg('é');end;"],
            ),
        ] {
            let wanted: Vec<_> = wanted.into_iter().map(|text| Ok(text.to_owned())).collect();
            assert_eq!(typed(lines), wanted, "{lines}");
        }
    }

    #[test]
    fn what_cannot_be_one_line_is_refused_with_a_sentence() {
        let text = typed("def f():\n  x = '''a\nb'''\nend");
        assert_eq!(text, [Err(StatementError::LongText)]);
        let long = format!("def f():\n{}end", "  pass\n".repeat(BLOCK_BYTES_MAX / 6));
        assert_eq!(typed(&long), [Err(StatementError::TooLong)]);
        assert!(StatementError::LongText.to_string().contains("one line"));
    }

    #[test]
    fn an_open_block_can_be_thrown_away() {
        let mut typed = StatementReader::default();
        assert_eq!(typed.line("def f():"), None);
        assert!(typed.is_open());
        typed.forget();
        assert!(!typed.is_open());
        assert_eq!(typed.line("y = 2"), Some(Ok("y = 2".to_owned())));
        assert!(!typed.is_open());
    }

    /// Blocks of our grammar, a line each.
    fn body(depth: u32) -> BoxedStrategy<Vec<String>> {
        let simple = prop_oneof![
            Just("x = 1".to_owned()),
            Just("y = [1, 2] # more".to_owned()),
            Just("print('a;b', \"#\")".to_owned()),
            Just("x = 2; y = 3".to_owned()),
        ];
        let line = simple.prop_map(|line| vec![line]);
        if depth == 0 {
            return line.boxed();
        }
        let inner = (0..3_usize, proptest::collection::vec(body(depth - 1), 1..3));
        let block = inner.prop_map(|(which, parts)| {
            let mut lines = vec![["if x:", "while y < 2:", "for i in [1]:"][which].to_owned()];
            lines.extend(parts.concat().iter().map(|line| format!("  {line}")));
            lines.push("end".to_owned());
            lines
        });
        prop_oneof![line, block].boxed()
    }

    proptest! {
        #[test]
        fn a_block_and_its_one_line_are_the_same_program(parts in proptest::collection::vec(body(2), 1..4)) {
            let mut lines = vec!["def f():".to_owned()];
            lines.extend(parts.concat().iter().map(|line| format!("    {line}")));
            lines.push("end".to_owned());
            let line = typed(&lines.join("\n")).remove(0).expect("one line");
            prop_assert!(!line.contains('\n'));
            let known = elite_runtime::builtins::known_names();
            let compiled = compile(SourceFile::new("line", format!("{line}\n")), &known);
            prop_assert!(compiled.is_ok(), "{line}: {compiled:?}");
        }

        #[test]
        fn no_text_panics(text in "(?s).{0,80}|[def f():;#'\"\\\\\n\t end]{0,60}") {
            for statement in typed(&text).into_iter().flatten() {
                prop_assert!(!statement.contains('\n'));
            }
        }
    }
}
