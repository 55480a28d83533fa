//! What a Modbus TCP client sends, cut into messages as the session does it: every one gets an answer that is a
//! message.

use io_bus::PortImage;
use io_bus::modbus_server::codec::{HEADER_BYTES, build_reply, message_bytes};
use io_bus::modbus_server::map::{ControllerAccess, Map};
use motion_api::{CommandKind, Registers, RobotState};

#[derive(Default)]
struct StandingRobot(Registers, PortImage);

impl ControllerAccess for StandingRobot {
    fn state(&self) -> RobotState {
        RobotState::at_start(Default::default(), 0.004)
    }
    fn registers(&self) -> &Registers {
        &self.0
    }
    fn image(&self) -> &PortImage {
        &self.1
    }
    fn joint_current(&self, _: &RobotState, _: usize) -> f64 {
        -40.0
    }
    fn give(&self, commands: &[CommandKind]) -> bool {
        commands.len() < 2
    }
}

pub(super) fn judge(data: &[u8]) {
    let map = Map(StandingRobot::default());
    let mut rest = data;
    while let Ok(Some(length)) = message_bytes(rest) {
        let Some((message, after)) = rest.split_at_checked(length) else {
            return;
        };
        let reply = build_reply(message, &map);
        assert_eq!(message_bytes(&reply), Ok(Some(reply.len())));
        assert_eq!(reply[..4], message[..4], "transaction and protocol");
        let (asked, answered) = (message[HEADER_BYTES], reply[HEADER_BYTES]);
        assert!(answered == asked || answered == asked | 0x80);
        rest = after;
    }
}
