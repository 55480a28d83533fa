//! Field buses: the controller's own Modbus registers and the server that shows them.
//!
//! Knows no script value and no robot; the runtime reads and writes [`PortImage`] for `read_port_*` and `write_port_*`,
//! the server hands connections to [`modbus_server::serve`].

pub mod modbus_server;
pub mod port_image;

pub use port_image::{PortError, PortImage};
