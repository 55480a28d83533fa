//! The part of a text that is shown with a finding: the lines around it, long ones cut around the place. Showing a
//! finding costs the same however long the text and its lines are.

use std::ops::Range;

use crate::source::{SourceFile, Span};

/// A line with more bytes than this is cut.
const LINE_MAX: usize = 1000;
/// Bytes kept of a cut line before and behind the place.
const BEFORE: usize = 300;
const BEHIND: usize = 600;
/// Lines shown of one finding at most.
const LINES_MAX: u32 = 60;

/// Some lines of a file.
pub struct Excerpt {
    /// The text.
    pub text: String,
    /// Number of its first line in the file.
    pub first_line: u32,
    lines: Vec<ExcerptLine>,
}

/// What is kept of a line.
struct ExcerptLine {
    /// Bytes of the file.
    kept: Range<usize>,
    /// Where these bytes begin in the excerpt.
    at: usize,
    cut: bool,
}

impl Excerpt {
    /// The lines that `spans` lie on, of which the first is the finding's own; those that are too far from it are left
    /// out.
    pub fn new(file: &SourceFile, spans: &[Span]) -> Excerpt {
        let own = file.lines_of(spans.first().copied().unwrap_or_default());
        let last_allowed = own.start + LINES_MAX;
        let mut lines = own.start..own.end.min(last_allowed);
        for span in spans {
            let others = file.lines_of(*span);
            if near(&own, &others) {
                lines = lines.start.min(others.start)..lines.end.max(others.end.min(last_allowed));
            }
        }
        let mut excerpt = Excerpt {
            text: String::new(),
            first_line: lines.start,
            lines: Vec::new(),
        };
        for line in lines {
            let place = spans.iter().find_map(|span| {
                let start = file.on_a_line(span.start);
                (file.line_of(start as u32) == line).then_some(start)
            });
            excerpt.add(file, line, place);
        }
        excerpt
    }

    fn add(&mut self, file: &SourceFile, line: u32, place: Option<usize>) {
        let whole = file.line_range(line);
        let mut kept = whole.clone();
        if whole.len() > LINE_MAX {
            let place = place.unwrap_or(whole.start);
            let from = place.saturating_sub(BEFORE).max(whole.start);
            let to = (place + BEHIND).min(whole.end);
            kept = file.text().floor_char_boundary(from)..file.text().ceil_char_boundary(to);
        }
        if kept.start > whole.start {
            self.text.push('…');
        }
        let at = self.text.len();
        self.text.push_str(&file.text()[kept.clone()]);
        if kept.end < whole.end {
            self.text.push('…');
        }
        self.text.push('\n');
        let cut = kept != whole;
        self.lines.push(ExcerptLine { kept, at, cut });
    }

    /// Whether the line that `span` starts on is cut, so that columns of the excerpt are not those of the file.
    pub fn is_cut(&self, file: &SourceFile, span: Span) -> bool {
        let line = file.line_of(file.on_a_line(span.start) as u32);
        let index = line.checked_sub(self.first_line);
        index
            .and_then(|index| self.lines.get(index as usize))
            .is_some_and(|line| line.cut)
    }

    /// Where `span` lies in the excerpt; None if it starts on none of its lines.
    pub fn range_of(&self, file: &SourceFile, span: Span) -> Option<Range<usize>> {
        let start = file.on_a_line(span.start);
        let first = file.line_of(start as u32).checked_sub(self.first_line)?;
        let start = self.lines.get(first as usize)?.place(start);
        let end = file.on_a_line(span.end);
        let last = file.line_of(end as u32).saturating_sub(self.first_line);
        let end = match self.lines.get(last as usize) {
            Some(line) => line.place(end),
            None => self.text.len() - 1,
        };
        // The renderer panics on a range that cuts a character in two.
        let (start, end) = (
            self.text.floor_char_boundary(start),
            self.text.ceil_char_boundary(end),
        );
        Some(start..end.max(start))
    }
}

impl ExcerptLine {
    fn place(&self, offset: usize) -> usize {
        self.at + offset.clamp(self.kept.start, self.kept.end) - self.kept.start
    }
}

fn near(own: &Range<u32>, other: &Range<u32>) -> bool {
    other.start + LINES_MAX > own.start && other.start < own.start + LINES_MAX
}
