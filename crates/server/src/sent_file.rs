//! What `send` tells a controller of ours of the file behind a program: its name, and where its lines are.
//!
//! Port 30001 takes text alone, and a file of plain statements has to go into a function first. A comment behind the
//! head of the `def` says how to take that back, so that messages, the recording and debuggers speak of the file. Other
//! controllers read past a comment.

use elite_runtime::{Preset, ProgramText};
use serde::{Deserialize, Serialize};

use crate::ports::script_text::StringTracker;

/// How the comment begins.
const MARK: &str = "# eliteserver send ";

/// Longest name of a file, bytes; a longer one is cut.
const NAME_BYTES_MAX: usize = 200;

/// The comment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SentFile {
    /// Name of the file.
    file: String,
    /// Where the file's text is.
    #[serde(flatten)]
    at: Extent,
}

/// How the text of a file lies in what is sent.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Extent {
    /// The file is the block; its `def` stands in this line of the file, from 1.
    Block(u32),
    /// The file is the body of the block, from this line of the block on, each line moved right by a tab, and these
    /// globals are set before it.
    Body {
        /// First line, from 1.
        from: u32,
        /// `NAME=VALUE`
        set: Vec<String>,
    },
}

impl SentFile {
    /// A file of this name; in which folder it is concerns nobody else.
    pub(crate) fn new(name: &str, at: Extent) -> Self {
        let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
        let name = &name[..name.floor_char_boundary(NAME_BYTES_MAX)];
        Self {
            file: name.replace(char::is_control, " "),
            at,
        }
    }

    /// The text with the comment behind the head of its `def`; `None` where the head does not end with its line.
    pub(crate) fn mark(&self, text: &str) -> Option<String> {
        let begin = text
            .lines()
            .scan(0, |at, line| {
                let begin = *at;
                *at += line.len() + 1;
                Some((begin, line))
            })
            .find(|(_, line)| line.starts_with("def "));
        let (begin, head) = begin?;
        let comment = serde_json::to_string(self).ok()?;
        let end = begin + head.len();
        head.ends_with(':')
            .then(|| format!("{}  {MARK}{comment}{}", &text[..end], &text[end..]))
    }

    /// The comment in the head of a program.
    fn in_head(text: &str) -> Option<Self> {
        let (_, comment) = text.lines().next()?.split_once(MARK)?;
        let found: Self = serde_json::from_str(comment).ok()?;
        let is_name = !found.file.is_empty()
            && found.file.len() <= NAME_BYTES_MAX
            && !found.file.contains(char::is_control);
        is_name.then_some(found)
    }

    /// The file that was sent, with its globals. Whatever does not fit is no such comment: the program runs as it came.
    pub(crate) fn behind(text: &str) -> Option<(ProgramText, Vec<Preset>)> {
        let found = Self::in_head(text)?;
        let (text, presets) = match found.at {
            Extent::Block(line) => (moved_down(text, line)?, Vec::new()),
            Extent::Body { from, set } => (body(text, from)?, Preset::parse_all(&set).ok()?),
        };
        let name = found.file;
        Some((ProgramText { name, text }, presets))
    }
}

/// The block with blank lines before it, so that its head stands in this line.
fn moved_down(text: &str, line: u32) -> Option<String> {
    let before = usize::try_from(line.checked_sub(1)?).ok()?;
    // No more lines than a file could have that fits the port.
    (before <= crate::ports::primary::framing::PROGRAM_BYTES_MAX)
        .then(|| "\n".repeat(before) + text)
}

/// The lines from this one to the last but one, moved back left; those in the middle of a text were not moved.
fn body(text: &str, from: u32) -> Option<String> {
    let skipped = usize::try_from(from.checked_sub(1)?).ok()?;
    let text = text.trim_end_matches('\n');
    let (text, end) = text.rsplit_once('\n')?;
    if skipped == 0 || end != "end" {
        return None;
    }
    let mut strings = StringTracker::default();
    let mut body = String::with_capacity(text.len());
    for line in text.split('\n').skip(skipped) {
        let line = match strings.in_string() {
            true => line,
            false => line.strip_prefix('\t')?,
        };
        body.push_str(line);
        body.push('\n');
        line.bytes()
            .chain([b'\n'])
            .for_each(|byte| strings.feed(byte));
    }
    Some(body)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_file_that_is_one_block_keeps_its_lines() {
        let sent = SentFile::new("a b#\".script", Extent::Block(3));
        let marked = sent.mark("# a\n\ndef f():\n  pass\nend\n").unwrap();
        // The port gives blocks from their heads on.
        let block = &marked[marked.find("def").unwrap()..];
        let (program, presets) = SentFile::behind(block).unwrap();
        assert_eq!(program.name, "a b#\".script");
        assert!(program.text.starts_with("\n\ndef f():  # "), "{program:?}");
        assert!(program.text.ends_with("\n  pass\nend\n") && presets.is_empty());
        assert_eq!(sent.mark("def f(a,\n  b=1):\n  pass\nend\n"), None);
    }

    #[test]
    fn what_is_no_such_comment_leaves_the_program_as_it_is() {
        for text in [
            "def f():\n  pass\nend\n",
            "def f():  # eliteserver send\n  pass\nend\n",
            "def f():  # eliteserver send {}\n  pass\nend\n",
            "def f():  # eliteserver send {\"file\":\"\",\"block\":1}\n  pass\nend\n",
            "def f():  # eliteserver send {\"file\":\"a\\nb\",\"block\":1}\n  pass\nend\n",
            "def f():  # eliteserver send {\"file\":\"a\",\"block\":0}\n  pass\nend\n",
            "def f():  # eliteserver send {\"file\":\"a\",\"block\":4294967295}\n  pass\nend\n",
            "def f():  # eliteserver send {\"file\":\"a\",\"body\":{\"from\":1,\"set\":[]}}\n\tpass\nend\n",
            "def f():  # eliteserver send {\"file\":\"a\",\"body\":{\"from\":2,\"set\":[]}}\n  pass\nend\n",
            "def f():  # eliteserver send {\"file\":\"a\",\"body\":{\"from\":2,\"set\":[\"a\"]}}\n\tpass\nend\n",
            "def f():  # eliteserver send {\"file\":\"a\",\"body\":{\"from\":2,\"set\":[]}}\n\tpass\n",
        ] {
            assert!(SentFile::behind(text).is_none(), "{text}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]
        #[test]
        fn any_text_of_a_port_is_looked_at(text in ".{0,30}", number in any::<u32>(), body in "[\t\"'a\n]{0,40}") {
            let _ = SentFile::behind(&text);
            let head = format!("def f():  {MARK}{{\"file\":\"x\",\"body\":{{\"from\":{number},\"set\":[]}}}}");
            let _ = SentFile::behind(&format!("{head}\n{body}\nend\n"));
        }
    }
}
