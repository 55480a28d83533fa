//! Everything outside that belongs to the controller and outlives programs: Modbus signals, serial ports, and the
//! controller's own Modbus values.

use std::sync::Arc;

use supervision::ThreadSupervisor;

use crate::link::SimulatedPeers;
use crate::modbus::ModbusClient;
use crate::port_image::{PortImage, ProgramState};
use crate::serial::SerialLine;

/// The field buses of one controller. The default has no serial devices.
#[derive(Default)]
pub struct Fieldbus {
    /// Signals of Modbus devices.
    pub modbus: ModbusClient,
    /// What the controller's own Modbus map shows beside the robot's state.
    pub port_image: Arc<PortImage>,
    /// RS-485 at the tool connector.
    pub tool_serial: SerialLine,
    /// RS-485 in the control box.
    pub masterboard_serial: SerialLine,
}

impl Fieldbus {
    /// A field bus with these lines; `faults` hears of those on its threads. Modbus devices may have stand-ins.
    pub fn new(
        tool_serial: SerialLine,
        masterboard_serial: SerialLine,
        faults: &ThreadSupervisor,
        stand_ins: Option<Arc<dyn SimulatedPeers>>,
    ) -> Self {
        Self {
            modbus: ModbusClient::new(faults.clone(), stand_ins),
            port_image: Arc::default(),
            tool_serial: tool_serial.with_supervisor(faults.clone()),
            masterboard_serial: masterboard_serial.with_supervisor(faults.clone()),
        }
    }

    /// The main program does something else from now on: outputs of Modbus devices may depend on it.
    pub fn set_program(&self, state: ProgramState) {
        self.port_image.set_program(state);
        self.modbus.program_running(state == ProgramState::Running);
    }
}
