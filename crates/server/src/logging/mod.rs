//! Where log lines go: stderr, filtered by RUST_LOG, as text or JSON. Everything for stderr goes through one queue,
//! which never makes anybody wait.

pub mod queue;

use std::io::{self, IsTerminal, Write, stderr};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use messages::Localized;
use thiserror::Error;
use tracing::Subscriber;
use tracing_subscriber::EnvFilter;
use tracing_subscriber::fmt::writer::BoxMakeWriter;
use tracing_subscriber::layer::SubscriberExt as _;

use crate::log_rate_limit::LogLimit;
use crate::options::LogFormat;
use queue::{EventWriter, LogQueue, harmless_object, sanitize};

/// The way to stderr of this process.
static STDERR: OnceLock<LogQueue> = OnceLock::new();

/// What is shown when RUST_LOG is not set.
const DEFAULT_FILTER: &str = "info,foxglove=warn,rmcp=warn";

/// A reason why there is no log, told in one sentence.
#[derive(Debug, Error, Localized)]
pub enum LoggingError {
    /// RUST_LOG is not a filter.
    #[error("RUST_LOG is `{given}`: {reason}; an example is `warn,server::ports=debug`")]
    #[zh("RUST_LOG 为 `{given}`：{reason}；例如 `warn,server::ports=debug`")]
    Filter {
        /// The filter as it was set.
        given: String,
        /// What the parser says.
        reason: String,
    },
    /// No thread to write it.
    #[error("the log cannot be written: {0}")]
    #[zh("无法写日志：{0}")]
    Thread(io::Error),
    /// Set up twice: a fault of ours.
    #[error("the log is set up already")]
    #[zh("日志已设置")]
    Twice,
}

/// The queue, started by whoever needs it first.
fn queue() -> io::Result<LogQueue> {
    if let Some(queue) = STDERR.get() {
        return Ok(queue.clone());
    }
    let started = LogQueue::start(stderr())?;
    Ok(STDERR.get_or_init(|| started).clone())
}

/// Whether each line on stderr is a JSON object.
static IS_JSON: AtomicBool = AtomicBool::new(false);

/// Whether each line on stderr is for a program.
pub fn is_json() -> bool {
    IS_JSON.load(Ordering::Relaxed)
}

/// Says something to the person at the terminal, without time and level. Like the log it waits for nobody. Where the
/// log is JSON, it is the `message` of an object.
pub fn say(text: &str) {
    let text = text.trim_end_matches('\n');
    let shown = match IS_JSON.load(Ordering::Relaxed) {
        true => harmless_object(&serde_json::json!({ "message": text }).to_string()),
        false => sanitize(text, false, ""),
    };
    match queue() {
        Ok(queue) => queue.push(shown.into_bytes()),
        // Without threads nothing runs that could be held up; that stderr is gone changes nothing either.
        Err(_) => drop(stderr().write_all(shown.as_bytes())),
    }
}

/// Lines that nobody will read: there was no room for them, or standard error is closed.
pub fn lost() -> u64 {
    STDERR.get().map_or(0, LogQueue::lost)
}

/// Waits until everything said so far is written, at most so long.
pub fn flush_within(patience: Duration) {
    if let Some(queue) = STDERR.get() {
        queue.flush_within(patience);
    }
}

/// Sets up the log of the process. Call it once.
pub fn init(format: LogFormat) -> Result<(), LoggingError> {
    let filter = match std::env::var(EnvFilter::DEFAULT_ENV) {
        Ok(given) if !given.trim().is_empty() => {
            EnvFilter::try_new(&given).map_err(|error| LoggingError::Filter {
                given,
                reason: error.to_string(),
            })?
        }
        _ => EnvFilter::new(DEFAULT_FILTER),
    };
    IS_JSON.store(format == LogFormat::Json, Ordering::Relaxed);
    let ansi = format == LogFormat::Text && stderr().is_terminal();
    let queue = queue().map_err(LoggingError::Thread)?;
    let events = move || EventWriter {
        queue: queue.clone(),
        coloured: ansi,
        format,
    };
    let log = subscriber(format, filter, ansi, BoxMakeWriter::new(events));
    tracing::subscriber::set_global_default(log).map_err(|_| LoggingError::Twice)
}

/// How lines look: as text the spans stand before the message, as JSON in `spans`, the outermost first.
fn subscriber(
    format: LogFormat,
    filter: EnvFilter,
    ansi: bool,
    writer: BoxMakeWriter,
) -> Box<dyn Subscriber + Send + Sync> {
    let log = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(writer)
        .with_ansi(ansi);
    match format {
        LogFormat::Text => Box::new(log.finish().with(LogLimit::default())),
        LogFormat::Json => Box::new(
            log.json()
                .flatten_event(true)
                .with_current_span(false)
                .finish()
                .with(LogLimit::default()),
        ),
    }
}

#[cfg(test)]
mod tests;
