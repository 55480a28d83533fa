//! What scripts may reach beyond the robot (`--allow`).

/// What is granted. Nothing by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Permissions {
    /// Sockets, Modbus devices, remote calls.
    pub net: bool,
    /// Files beyond the task directory.
    pub fs: bool,
    /// Processes and signals.
    pub process: bool,
    /// Environment variables.
    pub env: bool,
}
