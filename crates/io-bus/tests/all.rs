//! Tests of field buses over real sockets, in one binary: a file each.

mod modbus_client;
mod modbus_signals;
