//! The ports: one folder each, with a pure codec, a session over any duplex stream, and a listener handed in bound.

pub mod callers;
pub mod dashboard;
pub mod derived;
pub mod description;
pub mod foxglove;
pub mod http;
pub mod interpreter;
pub mod lines;
pub mod listen;
pub mod modbus;
pub mod opening;
pub mod peer;
pub mod primary;
pub mod query;
pub mod rtsi;
pub mod sample;
pub mod shown;
pub mod state;
pub mod text;
pub mod tool_serial;
pub mod websocket;

pub use listen::ClientId;
