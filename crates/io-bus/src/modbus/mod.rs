//! Modbus as a master: requests and replies (`pdu`), serial framing (`rtu`), devices over TCP with their signals.
//!
//! `client` is what scripts call, `signal` and `state` what it keeps, `schedule` decides what is asked next, `device`
//! asks, `played` where a test plays the device.
//! The framing is our own: scripts send codes of their own over both kinds of line, garbage on a serial line has to be
//! searched for the reply, and neighbouring signals share one request, none of which tokio-modbus offers. It is the
//! independent peer in the tests instead.

pub mod client;
mod device;
pub mod pdu;
mod played;
pub mod rtu;
mod schedule;
mod signal;
mod state;

pub use client::{ModbusClient, ModbusError};
pub use signal::{DeviceAddress, SignalKind, SignalSpec};
