//! Lines on their way to standard error: queued, written by a thread of their own, and lost rather than waited for.
//!
//! Owns the bounds (bytes that wait, length of a line), the count of what was lost, and how a line looks that others
//! had a say in: nothing in it can move a terminal's cursor or pretend to be a line of ours.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::sync::Arc;
use std::time::{Duration, Instant};

use parking_lot::{Condvar, Mutex, MutexGuard};

use supervision::{ThreadSupervisor, injection};

use crate::options::LogFormat;

/// Bytes that wait for whoever reads standard error.
const WAITING_BYTES_MAX: usize = 4 << 20;

/// Longest line, or event of several lines; what is longer is cut with a mark.
const EVENT_BYTES_MAX: usize = 64 << 10;

/// What stands before the second and every further line of an event: an event of its own begins with its time.
const CONTINUATION_INDENT: &str = "    ";

/// The queue. Clones share it.
#[derive(Clone)]
pub struct LogQueue {
    shared: Arc<LogBuffer>,
}

#[derive(Default)]
struct LogBuffer {
    state: Mutex<QueueState>,
    changed: Condvar,
}

#[derive(Default)]
struct QueueState {
    waiting: VecDeque<Vec<u8>>,
    bytes: usize,
    is_writing: bool,
    lost: u64,
}

impl LogQueue {
    /// Starts the thread that writes to `out`.
    ///
    /// # Errors
    /// The operating system gives no thread.
    pub fn start(mut out: impl Write + Send + 'static) -> io::Result<Self> {
        let queue = Self {
            shared: Arc::default(),
        };
        let writing = queue.clone();
        ThreadSupervisor::default().start_service("log", move || writing.write_all(&mut out))?;
        Ok(queue)
    }

    /// Adds an event as it stands; waits for nobody.
    pub fn push(&self, event: Vec<u8>) {
        let mut state = self.state();
        if state.bytes + event.len() > WAITING_BYTES_MAX {
            state.lost += 1;
            return;
        }
        state.bytes += event.len();
        state.waiting.push_back(event);
        drop(state);
        self.shared.changed.notify_all();
    }

    /// Events that nobody will read: there was no room, or standard error is closed.
    pub fn lost(&self) -> u64 {
        self.state().lost
    }

    /// Waits until everything is written, at most so long.
    pub fn flush_within(&self, patience: Duration) {
        let deadline = Instant::now() + patience;
        let mut state = self.state();
        while state.is_writing || !state.waiting.is_empty() {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return;
            }
            self.shared.changed.wait_for(&mut state, left);
        }
    }

    fn write_all(&self, out: &mut impl Write) {
        let mut state = self.state();
        state.is_writing = false;
        loop {
            let Some(event) = state.waiting.pop_front() else {
                self.shared.changed.notify_all();
                self.shared.changed.wait(&mut state);
                continue;
            };
            state.bytes -= event.len();
            state.is_writing = true;
            drop(state);
            injection::point("log");
            let written = out.write_all(&event).and_then(|()| out.flush());
            state = self.state();
            state.is_writing = false;
            state.lost += u64::from(written.is_err());
        }
    }

    fn state(&self) -> MutexGuard<'_, QueueState> {
        self.shared.state.lock()
    }
}

/// What the log's formatter writes: one event a call.
pub struct EventWriter {
    /// Queue that the lines go to.
    pub queue: LogQueue,
    /// The formatter colours lines: its escape sequences stay. It has escaped those of others itself.
    pub coloured: bool,
    /// How the formatter writes events.
    pub format: LogFormat,
}

impl Write for EventWriter {
    fn write(&mut self, event: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(event);
        let text = text.trim_end_matches('\n');
        let shown = match self.format {
            LogFormat::Text => sanitize(text, self.coloured, CONTINUATION_INDENT),
            LogFormat::Json => harmless_object(text),
        };
        self.queue.push(shown.into_bytes());
        Ok(event.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The text with a line end, cut to its bound, without a character that a terminal would obey. Lines after the first
/// begin with `goes_on`.
pub fn sanitize(text: &str, keeps_escapes: bool, goes_on: &str) -> String {
    let end = text.floor_char_boundary(EVENT_BYTES_MAX);
    let mut shown = String::with_capacity(end + 1);
    for letter in text[..end].chars() {
        match letter {
            '\n' => {
                shown.push('\n');
                shown.push_str(goes_on);
            }
            '\t' => shown.push('\t'),
            '\x1b' if keeps_escapes => shown.push(letter),
            // What turns the direction of writing hides text as well as any escape sequence.
            '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{2028}' | '\u{2029}' => {
                shown.extend(letter.escape_unicode());
            }
            _ if letter.is_control() => shown.extend(letter.escape_default()),
            _ => shown.push(letter),
        }
    }
    if end < text.len() {
        // Writing to a string cannot fail.
        let _ = write!(shown, " ... ({} bytes more)", text.len() - end);
    }
    shown.push('\n');
    shown
}

/// A JSON object on one line, within the bound as well: where it is longer its texts are cut with a mark, and what
/// cannot be cut so becomes the text of another object. Inside of strings, the only place where they may stand,
/// characters that a terminal would obey are escaped as JSON has it.
pub fn harmless_object(text: &str) -> String {
    let cut;
    let mut whole = text;
    if text.len() > EVENT_BYTES_MAX {
        cut = shorter_object(text);
        whole = &cut;
    }
    let mut shown = String::with_capacity(whole.len() + 1);
    for letter in whole.chars() {
        let number = u32::from(letter);
        let is_hidden = letter.is_control()
            || matches!(number, 0x202a..=0x202e | 0x2066..=0x2069 | 0x2028 | 0x2029);
        if is_hidden {
            // All of them have four digits at most. Writing to a string cannot fail.
            let _ = write!(shown, "\\u{number:04x}");
        } else {
            shown.push(letter);
        }
    }
    shown.push('\n');
    shown
}

/// An object whose texts are so short that it keeps the bound.
fn shorter_object(text: &str) -> String {
    let mut keep = EVENT_BYTES_MAX / 2;
    if let Ok(mut object) = serde_json::from_str::<serde_json::Value>(text) {
        while keep >= 64 {
            shorten(&mut object, keep);
            let whole = object.to_string();
            if whole.len() <= EVENT_BYTES_MAX {
                return whole;
            }
            keep /= 2;
        }
    }
    let (start, more) = text.split_at(text.floor_char_boundary(EVENT_BYTES_MAX / 8));
    let message = format!("{start} ... ({} bytes more)", more.len());
    serde_json::json!({ "message": message }).to_string()
}

/// Cuts the texts in a value that are longer than this.
fn shorten(value: &mut serde_json::Value, most: usize) {
    match value {
        serde_json::Value::String(text) if text.len() > most => {
            let end = text.floor_char_boundary(most - most / 4);
            let more = text.len() - end;
            text.truncate(end);
            // Writing to a string cannot fail.
            let _ = write!(text, " ... ({more} bytes more)");
        }
        serde_json::Value::Array(items) => items.iter_mut().for_each(|item| shorten(item, most)),
        serde_json::Value::Object(fields) => {
            fields.values_mut().for_each(|field| shorten(field, most));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    /// Takes what it is given only when it is told to.
    struct Gate(mpsc::Receiver<io::Result<()>>, Arc<Mutex<Vec<u8>>>);

    impl Write for Gate {
        fn write(&mut self, data: &[u8]) -> io::Result<usize> {
            self.0.recv().unwrap_or(Ok(()))?;
            self.1.lock().extend_from_slice(data);
            Ok(data.len())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_reader_that_does_not_read_costs_lines_and_nothing_else() {
        let (open, gate) = mpsc::channel();
        let written = Arc::<Mutex<Vec<u8>>>::default();
        let queue = LogQueue::start(Gate(gate, written.clone())).unwrap();
        let line = vec![b'x'; 64 << 10];
        for _ in 0..200 {
            queue.push(line.clone());
        }
        let room = WAITING_BYTES_MAX / line.len();
        let lost = queue.lost() as usize;
        // One line may be in the writer's hands.
        assert!((200 - room - 1..=200 - room).contains(&lost), "{lost}");
        queue.flush_within(Duration::from_millis(5));
        drop(open);
        queue.flush_within(Duration::from_secs(10));
        assert_eq!(written.lock().len(), (200 - lost) * line.len());
    }

    #[test]
    fn a_closed_reader_costs_lines_and_the_next_one_is_tried() {
        let (open, gate) = mpsc::channel();
        let written = Arc::<Mutex<Vec<u8>>>::default();
        let queue = LogQueue::start(Gate(gate, written.clone())).unwrap();
        open.send(Err(io::ErrorKind::BrokenPipe.into())).unwrap();
        drop(open);
        queue.push(b"lost\n".to_vec());
        queue.push(b"kept\n".to_vec());
        queue.flush_within(Duration::from_secs(10));
        assert_eq!(queue.lost(), 1);
        assert_eq!(*written.lock(), b"kept\n");
    }

    #[test]
    fn no_text_of_others_moves_the_cursor_or_looks_like_a_line_of_ours() {
        let forged =
            "bad name: a\r\n2026-01-01T00:00:00Z  INFO all is well\x1b[2J\u{9b}1m\u{202e}\0";
        assert_eq!(
            sanitize(forged, false, CONTINUATION_INDENT),
            "bad name: a\\r\n    2026-01-01T00:00:00Z  INFO all is well\\u{1b}[2J\\u{9b}1m\\u{202e}\\u{0}\n"
        );
        assert_eq!(
            sanitize("\x1b[31mERROR\x1b[0m ü\t1", true, ""),
            "\x1b[31mERROR\x1b[0m ü\t1\n"
        );
        let long = "é".repeat(EVENT_BYTES_MAX);
        let cut = sanitize(&long, false, "");
        assert!(
            cut.ends_with(" ... (65536 bytes more)\n"),
            "{}",
            &cut[cut.len() - 40..]
        );
    }

    #[test]
    fn objects_stay_objects_whatever_is_in_them() {
        let read = |shown: &str| -> serde_json::Value {
            assert!(shown.len() <= 6 * EVENT_BYTES_MAX && shown.ends_with('\n'));
            assert_eq!(shown.lines().count(), 1);
            assert!(!shown.trim_end().contains(char::is_control), "{shown:?}");
            serde_json::from_str(shown).unwrap()
        };
        let message = "a\u{7f}b\u{9b}1m\u{202e}c\n\r\t\u{1b}[2J\u{0}\u{2028}\"\\é";
        let object = serde_json::json!({"level": "INFO", "message": message});
        let shown = harmless_object(&object.to_string());
        assert_eq!(read(&shown), object);

        for long in [
            "é".repeat(EVENT_BYTES_MAX),
            "\u{1}".repeat(EVENT_BYTES_MAX),
            "\"".repeat(90_000),
        ] {
            let object =
                serde_json::json!({"level": "INFO", "message": long, "spans": [{"name": long}]});
            let shown = read(&harmless_object(&object.to_string()));
            assert_eq!(shown["level"], "INFO");
            assert!(shown["message"].as_str().unwrap().ends_with("bytes more)"));
        }
        let many: Vec<u32> = (0..40_000).collect();
        let shown = read(&harmless_object(
            &serde_json::json!({ "numbers": many }).to_string(),
        ));
        assert!(shown["message"].as_str().unwrap().ends_with("bytes more)"));
        let shown = read(&harmless_object(&"x".repeat(EVENT_BYTES_MAX + 1)));
        assert!(shown["message"].is_string());
    }
}
