//! The debugger as a client meets it: requests in, responses and events out, over a socket within the process.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::disallowed_methods,
    reason = "test helpers fail by panicking, and start threads as they like"
)]

#[path = "dap/attached.rs"]
mod attached;
#[path = "dap/back.rs"]
mod back;
#[path = "dap/client.rs"]
mod client;
#[path = "dap/hostile.rs"]
mod hostile;
#[path = "dap/look.rs"]
mod look;
#[path = "dap/requests.rs"]
mod requests;
#[path = "dap/stops.rs"]
mod stops;
