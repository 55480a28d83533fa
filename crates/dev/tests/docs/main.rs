//! The documentation against the product: every program and command of a page is run, every link leads somewhere, and
//! the book has every page.
//!
//! `markdown.rs` reads pages. How a block of a page is treated is said by its first line (CONTRIBUTING.md,
//! "Documentation").

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests fail by panicking"
)]

mod book;
mod debugger;
mod links;
mod markdown;
mod programs;
mod walk;
