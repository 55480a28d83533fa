//! Field buses: the controller's Modbus server.
