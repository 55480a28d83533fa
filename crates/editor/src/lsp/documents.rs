//! The texts that the client has open: their edits, and the analysis of what they hold now.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use elite_syntax::Span;
use ls_types::{Position, Range, TextDocumentContentChangeEvent, Uri};
use messages::Localized;

use super::positions::{Encoding, LineIndex};
use crate::analysis::{Analysis, TextKind};

/// Before findings of a long text are told, typing pauses for so long; those of others are told at once.
const PAUSE: Duration = Duration::from_millis(50);
/// Texts up to this length, in bytes, are not long: little of them is read anew.
const SHORT_MAX: usize = 512 << 10;
/// Whoever never pauses gets them after so long.
const PAUSE_MAX: Duration = Duration::from_millis(500);
/// Texts that can be open at once.
const OPEN_MAX: usize = 1000;
/// Longest text, in bytes.
const TEXT_MAX: usize = 32 << 20;

/// A reason why an order about a document is not carried out.
#[derive(Debug, thiserror::Error, Localized)]
pub enum DocumentError {
    /// Nobody opened it.
    #[error("the document {0} is not open")]
    #[zh("文档 {0} 没有打开")]
    NotOpen(String),
    /// There are too many.
    #[error("{OPEN_MAX} documents are open, more are not taken")]
    #[zh("已打开 {OPEN_MAX} 个文档，不再接受更多")]
    TooMany,
    /// The change would make the document too long.
    #[error("the document would have {0} bytes, at most {TEXT_MAX} are taken")]
    #[zh("文档将有 {0} 字节，最多接受 {TEXT_MAX} 字节")]
    TooLong(usize),
}

/// An open text.
pub struct Document {
    /// Address of the document.
    pub uri: Uri,
    /// Version of the document, counted by the client.
    pub version: i32,
    /// The text.
    pub text: String,
    /// Beginnings of the lines of the text.
    pub lines: LineIndex,
    /// What it is for.
    pub kind: TextKind,
    /// When its findings are to be told, and since when they wait.
    pub due: Option<(Instant, Instant)>,
    analysis: Option<Arc<Analysis>>,
    /// `analysis` is of a text before the last changes.
    is_stale: bool,
}

impl Document {
    /// The analysis of the text as it is now.
    pub fn analysis(&mut self) -> Arc<Analysis> {
        let analysis = match self.analysis.take() {
            Some(known) if !self.is_stale => known,
            known => Arc::new(match known.and_then(Arc::into_inner) {
                Some(known) => known.change(&self.text),
                None => Analysis::of(self.uri.as_str(), &self.text, self.kind),
            }),
        };
        self.is_stale = false;
        self.analysis = Some(analysis.clone());
        analysis
    }

    /// The byte at a position.
    pub fn offset(&self, position: Position, encoding: Encoding) -> u32 {
        self.lines.offset(&self.text, position, encoding)
    }

    /// The range of a span.
    pub fn range(&self, span: Span, encoding: Encoding) -> Range {
        self.lines.range(&self.text, span, encoding)
    }

    fn edit(
        &mut self,
        change: &TextDocumentContentChangeEvent,
        encoding: Encoding,
    ) -> Result<(), DocumentError> {
        let text = match change.range {
            None => change.text.clone(),
            Some(range) => {
                let (a, b) = (
                    self.offset(range.start, encoding),
                    self.offset(range.end, encoding),
                );
                let (start, end) = (a.min(b) as usize, a.max(b) as usize);
                let mut text = std::mem::take(&mut self.text);
                text.replace_range(start..end, &change.text);
                text
            }
        };
        let length = text.len();
        let fits = length <= TEXT_MAX;
        self.text = if fits { text } else { String::new() };
        self.lines = LineIndex::of(&self.text);
        self.is_stale = true;
        match fits {
            true => Ok(()),
            false => Err(DocumentError::TooLong(length)),
        }
    }
}

/// All open texts.
#[derive(Default)]
pub struct Documents {
    /// What columns count.
    pub encoding: Encoding,
    open: BTreeMap<String, Document>,
}

impl Documents {
    /// Takes a text.
    ///
    /// # Errors
    /// There are too many, or it is too long.
    pub fn open(&mut self, uri: Uri, version: i32, text: String) -> Result<(), DocumentError> {
        if self.open.len() >= OPEN_MAX && !self.open.contains_key(uri.as_str()) {
            return Err(DocumentError::TooMany);
        }
        if text.len() > TEXT_MAX {
            return Err(DocumentError::TooLong(text.len()));
        }
        let path = uri.to_file_path().map(|path| path.into_owned());
        let now = Instant::now();
        let document = Document {
            version,
            lines: LineIndex::of(&text),
            text,
            kind: TextKind::of_path(&path.unwrap_or_default()),
            due: Some((now, now)),
            analysis: None,
            is_stale: false,
            uri: uri.clone(),
        };
        self.open.insert(uri.as_str().to_owned(), document);
        Ok(())
    }

    /// Changes a text.
    ///
    /// # Errors
    /// It is not open, or becomes too long.
    pub fn change(
        &mut self,
        uri: &Uri,
        version: i32,
        changes: &[TextDocumentContentChangeEvent],
    ) -> Result<(), DocumentError> {
        let encoding = self.encoding;
        let document = self.get(uri)?;
        let result = changes
            .iter()
            .try_for_each(|change| document.edit(change, encoding));
        document.version = version;
        let now = Instant::now();
        let since = document.due.map_or(now, |(_, since)| since);
        let pause = match document.text.len() <= SHORT_MAX {
            true => Duration::ZERO,
            false => PAUSE,
        };
        document.due = Some(((now + pause).min(since + PAUSE_MAX), since));
        result
    }

    /// Forgets a text; whether it was open.
    pub fn close(&mut self, uri: &Uri) -> bool {
        self.open.remove(uri.as_str()).is_some()
    }

    /// An open text.
    ///
    /// # Errors
    /// It is not open.
    pub fn get(&mut self, uri: &Uri) -> Result<&mut Document, DocumentError> {
        let document = self.open.get_mut(uri.as_str());
        document.ok_or_else(|| DocumentError::NotOpen(uri.as_str().to_owned()))
    }

    /// All open texts.
    pub fn all(&mut self) -> impl Iterator<Item = &mut Document> {
        self.open.values_mut()
    }

    /// Time when findings are to be told next.
    pub fn next_due(&self) -> Option<Instant> {
        let due = self.open.values().filter_map(|document| document.due);
        due.map(|(at, _)| at).min()
    }

    /// A text whose findings are due at `now`.
    pub fn take_due(&mut self, now: Instant) -> Option<&mut Document> {
        let mut due = self.open.values_mut();
        let found = due.find(|document| document.due.is_some_and(|(at, _)| at <= now))?;
        found.due = None;
        Some(found)
    }
}
