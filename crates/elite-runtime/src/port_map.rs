//! The robot behind its own Modbus map: for clients, and for the functions of scripts that read and write it.

use io_bus::PortImage;
use io_bus::modbus_server::map::ControllerAccess;
use motion_api::{CommandKind, IoImage, Origin, Registers, RobotMode, RobotState};

use crate::robot::Robot;
use crate::task::RobotView;

/// Motor current at a joint's nominal torque, A. No public figure exists: the simulator's own choice, so that currents
/// of all models and joints are alike.
pub const NOMINAL_AMPERES: f64 = 12.5;

/// The robot as clients see it.
pub struct ClientMap<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Words, and who has control.
    pub image: &'a PortImage,
}

impl ControllerAccess for ClientMap<'_> {
    fn state(&self) -> RobotState {
        with_io(self.robot.foreseen().state, self.robot.io())
    }

    fn registers(&self) -> &Registers {
        self.robot.registers()
    }

    fn image(&self) -> &PortImage {
        self.image
    }

    fn joint_current(&self, state: &RobotState, joint: usize) -> f64 {
        joint_current(self.robot, state, joint)
    }

    fn give(&self, commands: &[CommandKind]) -> bool {
        self.robot.send_all(Origin::default(), commands).is_ok()
    }
}

/// The robot as a program sees it.
pub(crate) struct ProgramMap<'a> {
    pub view: &'a RobotView,
    pub image: &'a PortImage,
    pub origin: Origin,
}

impl ControllerAccess for ProgramMap<'_> {
    fn state(&self) -> RobotState {
        with_io(self.view.foreseen().state, self.view.io())
    }

    fn registers(&self) -> &Registers {
        self.view.registers()
    }

    fn image(&self) -> &PortImage {
        self.image
    }

    fn joint_current(&self, state: &RobotState, joint: usize) -> f64 {
        joint_current(self.view, state, joint)
    }

    /// A program writes one value at a time, so there is one command at most.
    fn give(&self, commands: &[CommandKind]) -> bool {
        let mut given = commands
            .iter()
            .map(|kind| self.view.send(self.origin, *kind));
        given.all(|sent| sent.is_ok())
    }
}

/// What waits for its cycle is seen, too.
fn with_io(mut state: RobotState, io: IoImage) -> RobotState {
    state.digital_in = io.digital_in.into();
    state.digital_out = io.digital_out.into();
    state.analog_in = io.analog_in;
    state.analog_out = io.analog_out();
    state.io_config = io.config;
    state
}

fn joint_current(robot: &Robot, state: &RobotState, joint: usize) -> f64 {
    let is_powered = matches!(
        state.robot_mode,
        RobotMode::Idle | RobotMode::Backdrive | RobotMode::Running
    );
    if !is_powered {
        return 0.0;
    }
    state.actual_torque[joint] / robot.model().limits().effort[joint] * NOMINAL_AMPERES
}
