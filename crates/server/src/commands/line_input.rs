//! Where lines come from: a terminal with editing, history and completion, or a pipe.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io::{BufRead, Read, StdinLock, stdin};
use std::path::PathBuf;
use std::rc::Rc;

use rustyline::completion::Completer;
use rustyline::error::ReadlineError;
use rustyline::highlight::Highlighter;
use rustyline::hint::Hinter;
use rustyline::history::FileHistory;
use rustyline::validate::Validator;
use rustyline::{CompletionType, Config, Context, Editor, ExternalPrinter, Helper};

use crate::ports::interpreter::codec::LINE_BYTES_MAX;

/// Lines that are remembered.
const HISTORY_MAX: usize = 2000;

/// What somebody typed.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum InputLine {
    /// A line, without its end.
    Text(String),
    /// Ctrl-C.
    Interrupt,
    /// Nothing more comes.
    End,
    /// A line that is longer than any.
    TooLong,
    /// The input cannot be read, for this reason.
    Broken(String),
}

/// A way to say something while somebody types.
pub(crate) type Notifier = Box<dyn FnMut(String) + Send>;

/// Source of lines.
pub(crate) enum LineSource {
    Terminal(Box<Terminal>),
    Pipe(StdinLock<'static>),
}

/// Names that are completed; the shell adds those that are typed.
pub(crate) type CompletionNames = Rc<RefCell<BTreeSet<String>>>;

/// What a command completes beside names, and what its history is called.
#[derive(Clone)]
pub(crate) struct LineCommands {
    /// Name of the file of the history.
    pub(crate) history: &'static str,
    /// The command's own orders at the beginning of a line, with the mark before them if they have one.
    pub(crate) orders: Vec<String>,
}

impl LineSource {
    /// The terminal as the source, if there is one on both sides; standard input otherwise.
    pub(crate) fn open(is_terminal: bool, names: &CompletionNames, own: LineCommands) -> Self {
        match is_terminal.then(|| Terminal::open(names, own)) {
            Some(Ok(terminal)) => Self::Terminal(Box::new(terminal)),
            Some(Err(error)) => {
                tracing::warn!("lines cannot be edited: {error}");
                Self::Pipe(stdin().lock())
            }
            None => Self::Pipe(stdin().lock()),
        }
    }

    pub(crate) const fn is_terminal(&self) -> bool {
        matches!(self, Self::Terminal(_))
    }

    /// Says something beside the line that is being typed, if one is.
    pub(crate) fn voice(&mut self) -> Option<Notifier> {
        let Self::Terminal(terminal) = self else {
            return None;
        };
        let mut printer = terminal.editor.create_external_printer().ok()?;
        // Whoever closed the terminal does not read it.
        Some(Box::new(move |text| drop(printer.print(text))))
    }

    /// The next line.
    pub(crate) fn next(&mut self, prompt: &str) -> InputLine {
        match self {
            Self::Terminal(terminal) => terminal.next(prompt),
            Self::Pipe(pipe) => next_of(pipe),
        }
    }
}

fn next_of(pipe: &mut impl BufRead) -> InputLine {
    let mut bytes = Vec::new();
    let most = LINE_BYTES_MAX as u64 + 2;
    match pipe.take(most).read_until(b'\n', &mut bytes) {
        Err(error) => InputLine::Broken(error.to_string()),
        Ok(0) => InputLine::End,
        Ok(count) if count as u64 == most && !bytes.ends_with(b"\n") => InputLine::TooLong,
        Ok(_) => {
            let text = String::from_utf8_lossy(&bytes);
            InputLine::Text(text.trim_end_matches(['\n', '\r']).to_owned())
        }
    }
}

/// A terminal.
pub(crate) struct Terminal {
    editor: Editor<NameCompleter, FileHistory>,
    history: Option<PathBuf>,
}

impl Terminal {
    fn open(names: &CompletionNames, own: LineCommands) -> Result<Self, ReadlineError> {
        let config = Config::builder()
            .max_history_size(HISTORY_MAX)?
            // Lines of blocks begin with blanks.
            .history_ignore_space(false)
            .completion_type(CompletionType::List)
            .auto_add_history(true)
            .build();
        let mut editor = Editor::with_config(config)?;
        let history = history_file(own.history);
        editor.set_helper(Some(NameCompleter(Rc::clone(names), own.orders)));
        if let Some(path) = &history {
            // The first time there is none.
            let _ = editor.load_history(path);
        }
        Ok(Self { editor, history })
    }

    fn next(&mut self, prompt: &str) -> InputLine {
        match self.editor.readline(prompt) {
            Ok(text) => InputLine::Text(text),
            Err(ReadlineError::Interrupted) => InputLine::Interrupt,
            Err(ReadlineError::Eof) => InputLine::End,
            Err(error) => InputLine::Broken(error.to_string()),
        }
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let Some(path) = &self.history else { return };
        let folder = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        let saved = folder.map_err(ReadlineError::from);
        if let Err(error) = saved.and_then(|()| self.editor.save_history(path)) {
            tracing::warn!("the history cannot be kept in {}: {error}", path.display());
        }
    }
}

/// Path of the history file, in the folder for such files of this system (XDG base directories); none without a home.
fn history_file(name: &str) -> Option<PathBuf> {
    let state = std::env::var_os("XDG_STATE_HOME").filter(|path| !path.is_empty());
    let home = || Some(PathBuf::from(std::env::var_os("HOME")?).join(".local/state"));
    let folder = state.map(PathBuf::from).or_else(home)?;
    Some(folder.join("eliteserver").join(name))
}

/// Completes names and a command's own orders.
struct NameCompleter(CompletionNames, Vec<String>);

impl Helper for NameCompleter {}
impl Hinter for NameCompleter {
    type Hint = String;
}
impl Highlighter for NameCompleter {}
impl Validator for NameCompleter {}

impl Completer for NameCompleter {
    type Candidate = String;

    fn complete(
        &self,
        line: &str,
        at: usize,
        _: &Context<'_>,
    ) -> rustyline::Result<(usize, Vec<String>)> {
        Ok(completed(line, at, &self.0.borrow(), &self.1))
    }
}

/// Where the word before `at` begins, and what it may become.
fn completed(
    line: &str,
    at: usize,
    names: &BTreeSet<String>,
    orders: &[String],
) -> (usize, Vec<String>) {
    let before = &line[..at];
    if !before.is_empty() && !before.contains(' ') {
        let own = orders.iter().filter(|order| order.starts_with(before));
        let own: Vec<String> = own.cloned().collect();
        if !own.is_empty() || before.starts_with(':') {
            return (0, own);
        }
    }
    let is_of_name = |c: char| c.is_alphanumeric() || c == '_';
    let start = before
        .char_indices()
        .rev()
        .take_while(|(_, c)| is_of_name(*c))
        .last()
        .map_or(at, |(index, _)| index);
    let word = &before[start..];
    if word.is_empty() {
        return (start, Vec::new());
    }
    let after = names.range(word.to_owned()..);
    let found = after.take_while(|name| name.starts_with(word));
    (start, found.cloned().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_orders_are_completed() {
        let names = ["movej", "movel", "my_speed", "é_name"].map(str::to_owned);
        let names = BTreeSet::from(names);
        let orders = [":skip", ":state", ":vars"].map(str::to_owned);
        let all = |line: &str| completed(line, line.len(), &names, &orders);
        let of = |start: usize, words: &[&str]| {
            let words = words.iter().map(|word| (*word).to_owned());
            (start, words.collect::<Vec<_>>())
        };
        assert_eq!(all("mov"), of(0, &["movej", "movel"]));
        assert_eq!(all("x = abs(my"), of(8, &["my_speed"]));
        assert_eq!(all("1 + é"), of(4, &["é_name"]));
        assert_eq!(all("movej("), of(6, &[]));
        assert_eq!(all(""), of(0, &[]));
        assert_eq!(all(":s"), of(0, &[":skip", ":state"]));
        assert_eq!(all(":vars my"), of(6, &["my_speed"]));
        assert_eq!(
            completed("movej(1)", 3, &names, &orders),
            of(0, &["movej", "movel"])
        );
    }

    #[test]
    fn a_pipe_gives_lines_whatever_is_in_it() {
        let mut long = vec![b'x'; LINE_BYTES_MAX + 10];
        long.extend(b"\nlast");
        let mut pipe: &[u8] = b"a\r\n\xff\n";
        assert_eq!(next_of(&mut pipe), InputLine::Text("a".to_owned()));
        assert_eq!(next_of(&mut pipe), InputLine::Text("\u{fffd}".to_owned()));
        assert_eq!(next_of(&mut pipe), InputLine::End);
        assert_eq!(next_of(&mut &long[..]), InputLine::TooLong);
    }
}
