//! What a Modbus TCP client sends, cut into messages as the session does it: every one gets an answer that is a message.

use io_bus::modbus_server::codec::{HEADER_BYTES, answer_with, message_bytes};
use io_bus::modbus_server::state_map::Controller;
use io_bus::port_image::PortImage;
use motion_api::{IoChange, Registers, RobotState};

struct Standing(Registers);

impl Controller for Standing {
    fn state(&self) -> RobotState {
        RobotState::at_start(Default::default(), 0.004)
    }
    fn registers(&self) -> &Registers {
        &self.0
    }
    fn change(&self, _: IoChange) -> bool {
        true
    }
}

pub(super) fn judge(data: &[u8]) {
    let (image, controller) = (PortImage::default(), Standing(Registers::default()));
    let mut rest = data;
    while let Ok(Some(length)) = message_bytes(rest) {
        let Some((message, after)) = rest.split_at_checked(length) else {
            return;
        };
        let answer = answer_with(message, &image, Some(&controller));
        assert_eq!(message_bytes(&answer), Ok(Some(answer.len())));
        assert_eq!(answer[..4], message[..4], "transaction and protocol");
        let (asked, answered) = (message[HEADER_BYTES], answer[HEADER_BYTES]);
        assert!(answered == asked || answered == asked | 0x80);
        rest = after;
    }
}
