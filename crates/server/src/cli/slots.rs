//! Options of `serve` by their keys, for whoever has texts for them: configuration files, `launch` of the debugger.

use controller::options::OptionSlot;

use super::{ControllerArgs, ServeArgs};

impl ControllerArgs {
    /// The option of this key; `None` for a key that no option has. The configuration file itself is none.
    pub(crate) fn slot(&mut self, key: &str) -> Option<&mut dyn OptionSlot> {
        Some(match key {
            "log-dir" => &mut self.log_dir,
            "log-format" => &mut self.log.log_format,
            "language" => &mut self.log.language,
            _ => return self.options.slot(key),
        })
    }
}

impl ServeArgs {
    /// The option of this key; `None` for a key that no option has. Those of the node have a table of their own.
    pub(crate) fn slot(&mut self, key: &str) -> Option<&mut dyn OptionSlot> {
        Some(match key {
            "attachable" => &mut self.attachable,
            "bind" => &mut self.bind,
            "control" => &mut self.control,
            "cycle-phase-us" => &mut self.cycle_phase_us,
            "dashboard-port" => &mut self.dashboard_port,
            "foxglove-port" => &mut self.foxglove_port,
            "http-port" => &mut self.http_port,
            "interpreter-port" => &mut self.interpreter_port,
            "local" => &mut self.local,
            "modbus-port" => &mut self.modbus_port,
            "powered-off" => &mut self.powered_off,
            "primary-port" => &mut self.primary_port,
            "query-port" => &mut self.query_port,
            "ready-file" => &mut self.ready_file,
            "ros2-profile" => &mut self.ros2_profile,
            "rtsi-port" => &mut self.rtsi_port,
            "state-port" => &mut self.state_port,
            "tool-serial-port" => &mut self.tool_serial_port,
            "trust-host" => &mut self.trust_host,
            _ => return self.shared.slot(key),
        })
    }
}
