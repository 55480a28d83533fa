//! Lines on their way to standard error: queued, written by a thread of their own, and lost rather than waited for.
//!
//! Owns the bounds (bytes that wait, length of a line), the count of what was lost, and how a line looks that others had
//! a say in: nothing in it can move a terminal's cursor or pretend to be a line of ours.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use supervision::{Faults, injection};

/// Bytes that wait for whoever reads standard error.
const WAITING_BYTES_MAX: usize = 4 << 20;

/// Longest line, or event of several lines; what is longer is cut with a mark.
const EVENT_BYTES_MAX: usize = 64 << 10;

/// What stands before the second and every further line of an event: an event of its own begins with its time.
const GOES_ON: &str = "    ";

/// The queue. Clones share it.
#[derive(Clone)]
pub struct LogQueue {
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
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
        Faults::default().start_service("log", move || writing.write_all(&mut out))?;
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
            state = self
                .shared
                .changed
                .wait_timeout(state, left)
                .unwrap_or_else(PoisonError::into_inner)
                .0;
        }
    }

    fn write_all(&self, out: &mut impl Write) {
        let mut state = self.state();
        state.is_writing = false;
        loop {
            let Some(event) = state.waiting.pop_front() else {
                self.shared.changed.notify_all();
                state = self
                    .shared
                    .changed
                    .wait(state)
                    .unwrap_or_else(PoisonError::into_inner);
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

    fn state(&self) -> MutexGuard<'_, State> {
        // Whole at every moment, so a poisoned lock is as good as any.
        self.shared
            .state
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

/// What the log's formatter writes: one event a call.
pub struct Events {
    /// Where they go.
    pub queue: LogQueue,
    /// The formatter colours lines: its escape sequences stay. It has escaped those of others itself.
    pub coloured: bool,
}

impl Write for Events {
    fn write(&mut self, event: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(event);
        let shown = harmless(text.trim_end_matches('\n'), self.coloured, GOES_ON);
        self.queue.push(shown.into_bytes());
        Ok(event.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The text with a line end, cut to its bound, without a character that a terminal would obey. Lines after the first begin
/// with `goes_on`.
pub fn harmless(text: &str, keeps_escapes: bool, goes_on: &str) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    /// Takes what it is given only when it is told to.
    struct Gate(mpsc::Receiver<io::Result<()>>, Arc<Mutex<Vec<u8>>>);

    impl Write for Gate {
        fn write(&mut self, data: &[u8]) -> io::Result<usize> {
            self.0.recv().unwrap_or(Ok(()))?;
            self.1.lock().unwrap().extend_from_slice(data);
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
        assert_eq!(written.lock().unwrap().len(), (200 - lost) * line.len());
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
        assert_eq!(*written.lock().unwrap(), b"kept\n");
    }

    #[test]
    fn no_text_of_others_moves_the_cursor_or_looks_like_a_line_of_ours() {
        let forged =
            "bad name: a\r\n2026-01-01T00:00:00Z  INFO all is well\x1b[2J\u{9b}1m\u{202e}\0";
        assert_eq!(
            harmless(forged, false, GOES_ON),
            "bad name: a\\r\n    2026-01-01T00:00:00Z  INFO all is well\\u{1b}[2J\\u{9b}1m\\u{202e}\\u{0}\n"
        );
        assert_eq!(
            harmless("\x1b[31mERROR\x1b[0m ü\t1", true, ""),
            "\x1b[31mERROR\x1b[0m ü\t1\n"
        );
        let long = "é".repeat(EVENT_BYTES_MAX);
        let cut = harmless(&long, false, "");
        assert!(
            cut.ends_with(" ... (65536 bytes more)\n"),
            "{}",
            &cut[cut.len() - 40..]
        );
    }
}
