//! Texts for people, in English and Chinese.
//!
//! Both languages of a text stand side by side where the text is declared, so neither can be forgotten and no text has
//! to be recognised later. An error names its texts on its variants; the derive macro refuses a variant whose two texts
//! use different arguments:
//!
//! ```
//! use messages::{Language, Localized};
//!
//! #[derive(Debug, thiserror::Error, Localized)]
//! enum ReadError {
//!     #[error("joint {joint} is at {position:.3} rad")]
//!     #[zh("关节 {joint} 位于 {position:.3} rad")]
//!     Position { joint: u8, position: f64 },
//!     // Without words of its own a text needs no second form: its parts are told in the language of the reader.
//!     #[error("{0}: {1}")]
//!     File(String, Box<ReadError>),
//! }
//!
//! let error = ReadError::Position { joint: 2, position: 0.5 };
//! let error = ReadError::File("a.mcap".to_owned(), Box::new(error));
//! assert_eq!(error.to_string(), "a.mcap: joint 2 is at 0.500 rad");
//! assert_eq!(error.in_language(Language::Chinese).to_string(), "a.mcap：关节 2 位于 0.500 rad");
//! ```
//!
//! A text that is no error of its own is a [`Text`], made by [`text!`]. An argument that is localized itself appears in
//! the language of the text around it:
//!
//! ```
//! use messages::{Language, Text, text};
//!
//! let allowed: Text = text!("a number", "数");
//! let refusal = text!("{} must be {allowed}", "{} 必须是{allowed}", "q");
//! assert_eq!(refusal.english(), "q must be a number");
//! assert_eq!(refusal.in_language(Language::Chinese), "q 必须是数");
//! ```
//!
//! Two forms with different arguments do not compile:
//!
//! ```compile_fail
//! let (x, y) = (1, 2);
//! messages::text!("{x} and {y}", "{x}");
//! ```
//!
//! Neither does an error with a text in one language only:
//!
//! ```compile_fail
//! #[derive(Debug, thiserror::Error, messages::Localized)]
//! #[error("the file ends")]
//! struct EndError;
//! ```
//!
//! `Display` is English everywhere: what machines read (logs, recordings, answers of ports) stays English. Whoever
//! shows a text to a person asks for the language of that person.

mod help;
mod language;
mod library;
mod localized;
mod system;
mod text;
#[doc(hidden)]
pub mod value;

pub use help::LocalizedHelp;
pub use language::Language;
pub use library::LibrarySentences;
pub use localized::{Localized, LocalizedDisplay};
pub use messages_macros::{Localized, LocalizedHelp, text};
pub use text::Text;
