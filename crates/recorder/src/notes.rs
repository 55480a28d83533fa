//! Notes on their way from the script side to the recorder's thread, bounded in bytes.
//!
//! A note counts from when it is sent until it is written, wherever it waits in between. The sender waits for room or
//! goes without, as it likes; it never waits for a thread that is gone, and no longer when it is hurried.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use motion_api::{ProgramId, ThreadNumber};
use parking_lot::{Condvar, Mutex};

use crate::extra::CustomTopicId;
use crate::topics::{IoValue, LogLevel};
use crate::viewer::SceneBody;

/// What all notes on their way may have together. With the ring of records (about 6 MiB), the texts that are kept for
/// the next part and the text that is being written this stays within 64 MiB (INTERFACES 9).
const NOTES_BYTES: usize = 32 << 20;
/// What an entry of a queue and the allocations of its texts cost beside the texts.
const NOTE_BYTES: usize = 2 * size_of::<Annotation>() + 64;

/// What the script side adds to a recording. Times are simulated seconds since start.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Annotation {
    ProgramStarted {
        time: f64,
        program: ProgramId,
        name: Box<str>,
        text: Box<str>,
    },
    ScriptLine {
        time: f64,
        program: ProgramId,
        thread: ThreadNumber,
        place: ThreadPosition,
    },
    Variable {
        time: f64,
        program: ProgramId,
        name: Box<str>,
        type_name: Box<str>,
        value: Box<str>,
    },
    Log {
        time: f64,
        level: LogLevel,
        source: Box<str>,
        message: Box<str>,
        /// The message in Chinese, where that is something else.
        chinese: Option<Box<str>>,
    },
    Io {
        time: f64,
        name: Box<str>,
        value: IoValue,
    },
    Extra {
        time: f64,
        topic: CustomTopicId,
        message: Box<[u8]>,
    },
    SceneBodies {
        time: f64,
        bodies: Arc<[SceneBody]>,
    },
}

/// Where a script thread stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ThreadPosition {
    pub line: u32,
    /// Number and label of a node of the pendant's task.
    pub node: Option<(u32, Box<str>)>,
}

impl Annotation {
    pub fn time(&self) -> f64 {
        match self {
            Self::ProgramStarted { time, .. }
            | Self::ScriptLine { time, .. }
            | Self::Variable { time, .. }
            | Self::Log { time, .. }
            | Self::Io { time, .. }
            | Self::Extra { time, .. }
            | Self::SceneBodies { time, .. } => *time,
        }
    }

    /// What it costs while it waits.
    fn bytes(&self) -> usize {
        let texts = match self {
            Self::ProgramStarted { name, text, .. } => name.len() + text.len(),
            Self::ScriptLine { place, .. } => {
                place.node.as_ref().map_or(0, |(_, label)| label.len())
            }
            Self::Variable {
                name,
                type_name,
                value,
                ..
            } => name.len() + type_name.len() + value.len(),
            Self::Log {
                source,
                message,
                chinese,
                ..
            } => source.len() + message.len() + chinese.as_ref().map_or(0, |text| text.len()),
            Self::Io { name, .. } => name.len(),
            Self::Extra { message, .. } => message.len(),
            Self::SceneBodies { bodies, .. } => size_of_val::<[SceneBody]>(bodies),
        };
        NOTE_BYTES + texts
    }
}

/// The way of the notes; both ends share it.
#[derive(Debug, Default)]
pub(crate) struct AnnotationQueue {
    queue: Mutex<AnnotationQueueState>,
    /// There is room again.
    room: Condvar,
    /// There is a note.
    news: Condvar,
}

#[derive(Debug, Default)]
struct AnnotationQueueState {
    notes: VecDeque<Annotation>,
    /// Of all notes that were sent and are not written yet.
    bytes: usize,
    /// Senders that wait for room.
    blocked_senders: usize,
    /// Nobody waits for room until there is some.
    is_backpressure_off: bool,
    closed: bool,
}

/// The note was dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct AnnotationDropped;

impl AnnotationQueue {
    /// Sends a note; with `wait`, when there is room for it. Once the other end is gone, notes are forgotten.
    pub fn send(&self, note: Annotation, wait: bool) -> Result<(), AnnotationDropped> {
        let bytes = note.bytes();
        let mut queue = self.queue.lock();
        // A note larger than everything has the way for itself.
        while queue.bytes > 0 && queue.bytes + bytes > NOTES_BYTES && !queue.closed {
            if !wait || queue.is_backpressure_off {
                return Err(AnnotationDropped);
            }
            queue.blocked_senders += 1;
            // The thread may sleep on what it has: it is to write now.
            self.news.notify_one();
            self.room.wait(&mut queue);
            queue.blocked_senders -= 1;
        }
        if !queue.closed {
            queue.bytes += bytes;
            queue.notes.push_back(note);
            self.news.notify_one();
        }
        Ok(())
    }

    /// Moves all notes over.
    pub fn drain_into(&self, waiting: &mut PendingAnnotations) {
        waiting.notes.append(&mut self.queue.lock().notes);
    }

    /// Notes of so many bytes were written.
    pub fn release_written(&self, waiting: &mut PendingAnnotations) {
        let bytes = std::mem::take(&mut waiting.written);
        if bytes > 0 {
            let mut queue = self.queue.lock();
            queue.bytes = queue.bytes.saturating_sub(bytes);
            queue.is_backpressure_off = false;
            if queue.blocked_senders > 0 {
                self.room.notify_all();
            }
        }
    }

    /// Whoever waits for room goes without, and who comes later does not wait, until something was written.
    pub fn suspend_backpressure(&self) {
        let mut queue = self.queue.lock();
        queue.is_backpressure_off = queue.bytes > 0;
        self.room.notify_all();
    }

    /// True while somebody waits for room.
    pub fn has_blocked_senders(&self) -> bool {
        self.queue.lock().blocked_senders > 0
    }

    /// Whether notes should be written rather than kept for their place: somebody waits, or soon will.
    pub fn is_nearly_full(&self) -> bool {
        let queue = self.queue.lock();
        queue.blocked_senders > 0 || queue.bytes > NOTES_BYTES / 2
    }

    /// Bytes of all notes that were sent and are not written yet.
    pub fn bytes(&self) -> usize {
        self.queue.lock().bytes
    }

    /// Sleeps until there is a note, at most so long.
    pub fn wait_for_annotation(&self, most: Duration) {
        let mut queue = self.queue.lock();
        if queue.notes.is_empty() && queue.blocked_senders == 0 {
            // What woke it is found by looking.
            self.news.wait_for(&mut queue, most);
        }
    }

    /// There is nobody any more who writes: whoever waits goes on, and what comes is forgotten.
    pub fn close(&self) {
        let mut queue = self.queue.lock();
        queue.closed = true;
        queue.notes = VecDeque::new();
        queue.bytes = 0;
        self.room.notify_all();
    }
}

/// Notes that wait for the record they come before, on the recorder's thread.
#[derive(Debug, Default)]
pub(crate) struct PendingAnnotations {
    notes: VecDeque<Annotation>,
    /// Bytes of those that were taken since [`AnnotationQueue::release_written`] was told.
    written: usize,
}

impl PendingAnnotations {
    pub fn first(&self) -> Option<&Annotation> {
        self.notes.front()
    }

    pub fn pop(&mut self) -> Option<Annotation> {
        let note = self.notes.pop_front()?;
        self.written += note.bytes();
        // After a flood the queue is not kept at its size.
        if self.notes.is_empty() && self.notes.capacity() > 1024 {
            self.notes = VecDeque::new();
        }
        Some(note)
    }

    pub fn is_empty(&self) -> bool {
        self.notes.is_empty()
    }

    pub fn clear(&mut self) {
        while self.pop().is_some() {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn log(bytes: usize) -> Annotation {
        Annotation::Log {
            time: 0.0,
            level: LogLevel::Info,
            source: "test".into(),
            message: "x".repeat(bytes).into(),
            chinese: None,
        }
    }

    #[test]
    fn what_does_not_fit_is_refused_whatever_the_size_of_the_notes() {
        for size in [0, 100, 64 << 10, 8 << 20] {
            let notes = AnnotationQueue::default();
            let mut sent = 0;
            while notes.send(log(size), false).is_ok() {
                sent += 1;
            }
            assert!(notes.bytes() <= NOTES_BYTES, "{size}");
            assert!(notes.bytes() + log(size).bytes() > NOTES_BYTES, "{size}");
            // Taken is not written.
            let mut waiting = PendingAnnotations::default();
            notes.drain_into(&mut waiting);
            assert_eq!(notes.send(log(size), false), Err(AnnotationDropped));
            let mut popped = 0;
            while waiting.pop().is_some() {
                popped += 1;
            }
            notes.release_written(&mut waiting);
            assert_eq!((popped, notes.bytes()), (sent, 0));
            assert_eq!(notes.send(log(size), false), Ok(()));
        }
    }

    #[test]
    fn a_note_larger_than_everything_passes_alone() {
        let notes = AnnotationQueue::default();
        assert_eq!(notes.send(log(NOTES_BYTES), false), Ok(()));
        assert_eq!(notes.send(log(0), false), Err(AnnotationDropped));
    }

    #[test]
    fn whoever_waits_goes_on_when_there_is_room_and_when_there_is_nobody_any_more() {
        let notes = Arc::new(AnnotationQueue::default());
        let passed = Arc::new(AtomicUsize::new(0));
        assert_eq!(notes.send(log(NOTES_BYTES), false), Ok(()));
        let senders: Vec<_> = (0..4)
            .map(|_| {
                let (notes, passed) = (notes.clone(), passed.clone());
                std::thread::spawn(move || {
                    for _ in 0..100 {
                        assert_eq!(notes.send(log(NOTES_BYTES / 3), true), Ok(()));
                        passed.fetch_add(1, Ordering::SeqCst);
                    }
                })
            })
            .collect();
        while !notes.is_nearly_full() {
            std::thread::yield_now();
        }
        assert_eq!(passed.load(Ordering::SeqCst), 0);
        let mut waiting = PendingAnnotations::default();
        while passed.load(Ordering::SeqCst) < 50 {
            notes.drain_into(&mut waiting);
            waiting.clear();
            notes.release_written(&mut waiting);
        }
        notes.close();
        senders
            .into_iter()
            .for_each(|sender| sender.join().unwrap());
        assert_eq!((passed.load(Ordering::SeqCst), notes.bytes()), (400, 0));
    }
}
