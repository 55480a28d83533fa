//! Where log lines go: stderr, filtered by RUST_LOG, as text or JSON.

use std::io::{IsTerminal, stderr};

use thiserror::Error;
use tracing::Subscriber;
use tracing_subscriber::EnvFilter;
use tracing_subscriber::fmt::writer::BoxMakeWriter;
use tracing_subscriber::layer::SubscriberExt as _;

use crate::log_limit::LogLimit;
use crate::options::LogFormat;

/// What is shown when RUST_LOG is not set.
const DEFAULT_FILTER: &str = "info,foxglove=warn";

/// Why there is no log. Each is one sentence.
#[derive(Debug, Error)]
pub enum LoggingError {
    /// RUST_LOG is not a filter.
    #[error("RUST_LOG is `{given}`: {reason}; an example is `warn,server::ports=debug`")]
    Filter {
        /// As set.
        given: String,
        /// What the parser says.
        reason: String,
    },
    /// Set up twice: a fault of ours.
    #[error("the log is set up already")]
    Twice,
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
    let ansi = format == LogFormat::Text && stderr().is_terminal();
    let log = subscriber(format, filter, ansi, BoxMakeWriter::new(stderr));
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
