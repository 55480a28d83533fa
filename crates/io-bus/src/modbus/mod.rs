//! Modbus as a master: requests and replies (`pdu`), serial framing (`rtu`), devices over TCP with their signals (`client`).
//!
//! The framing is our own: scripts send codes of their own over both kinds of line, garbage on a serial line has to be
//! searched for the reply, and neighbouring signals share one request, none of which tokio-modbus offers. It is the
//! independent peer in the tests instead.

pub mod client;
mod device;
pub mod pdu;
pub mod rtu;

pub use client::{DeviceAddress, ModbusClient, ModbusError, SignalKind, SignalSpec};
