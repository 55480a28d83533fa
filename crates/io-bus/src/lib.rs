//! Field buses and other lines to the outside: Modbus both ways, serial lines, script sockets, remote calls.
//!
//! Knows no script value. The runtime finds signals, serial ports and the words of [`PortImage`] in [`Fieldbus`] and
//! reads the controller's own Modbus map ([`modbus_server::map`]) for `read_port_*` and `write_port_*`; the server
//! hands connections to [`modbus_server::serve`].

// No thread starts but through `supervision`; nothing waits for, or panics at, whoever reads our output.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

mod driver;
mod fieldbus;
pub mod link;
pub mod modbus;
pub mod modbus_server;
pub mod names;
pub mod port_image;
pub mod script_socket;
pub mod serial;
pub mod xmlrpc;

pub use fieldbus::Fieldbus;
pub use link::{PeerStream, SimulatedPeers};
pub use port_image::{ControlMode, PortImage, ProgramState};
pub use script_socket::ScriptSocket;
