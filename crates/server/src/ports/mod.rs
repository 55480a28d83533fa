//! The ports: one folder each, with a pure codec, a session over any duplex stream, and a listener handed in bound.

pub mod allowed_hosts;
pub mod dashboard;
pub mod derived;
pub mod description;
pub mod escape;
pub mod foxglove;
pub mod gripper;
pub mod http;
pub mod interpreter;
pub mod lines;
pub mod listen;
pub mod modbus;
pub mod peer;
pub mod primary;
pub mod protocol_sniffer;
pub mod query;
pub mod ros2;
pub mod rtsi;
pub mod sample;
pub mod script_text;
pub mod state;
pub mod tool_serial;
pub mod websocket;

pub use listen::ClientId;
