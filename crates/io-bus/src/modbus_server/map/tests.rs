//! The map byte for byte, through the same requests that clients send.

use parking_lot::Mutex;

use motion_api::{IoImage, SafetyMode, SettingCommand};
use proptest::prelude::*;

use super::*;
use crate::modbus_server::codec::{ADU_BYTES_MAX, build_reply};
use crate::port_image::{ControlMode, ProgramState};

#[derive(Default)]
struct Fake {
    io: Mutex<IoImage>,
    speed: Mutex<Option<f64>>,
    registers: Registers,
    image: PortImage,
    is_full: bool,
}

impl ControllerAccess for &Fake {
    fn state(&self) -> RobotState {
        let io = self.io.lock();
        let mut state = RobotState::at_start(Default::default(), 0.004);
        state.digital_out = io.digital_out.into();
        state.digital_in = 0x0A_03_80_01;
        state.io_config = io.config;
        state.target_speed_fraction = self.speed.lock().unwrap_or(1.0);
        state.actual_q.0 = [0.1, -1.5712, 1.5, -7.0, 40.0, -1.571];
        state.actual_qd.0[5] = -3.2;
        state.actual_tcp_speed = [0.25, 0.0, 0.0, 0.0, 0.0, -0.5];
        state.joint_temperatures[2] = -4.6;
        state.safety_mode = SafetyMode::Reduced;
        state.analog_in[1] = 2.5;
        state
    }

    fn registers(&self) -> &Registers {
        &self.registers
    }

    fn image(&self) -> &PortImage {
        &self.image
    }

    fn joint_current(&self, _: &RobotState, joint: usize) -> f64 {
        -0.5 * joint as f64
    }

    fn give(&self, commands: &[CommandKind]) -> bool {
        if self.is_full {
            return false;
        }
        for command in commands {
            match command {
                CommandKind::Setting(SettingCommand::SetIo(change)) => self.io.lock().apply(change),
                CommandKind::Setting(SettingCommand::SetSpeedFraction(f)) => {
                    *self.speed.lock() = Some(*f)
                }
                other => panic!("{other:?}"),
            }
        }
        true
    }
}

/// The reply proper to a request proper, both in hex.
fn ask(fake: &Fake, request: &str) -> String {
    let bytes = request.split_whitespace();
    let request: Vec<u8> = bytes
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect();
    let message = [&[0, 1, 0, 0, 0, request.len() as u8 + 1, 255], &*request].concat();
    let reply = build_reply(&message, &Map(fake));
    let reply: Vec<String> = reply[7..].iter().map(|b| format!("{b:02x}")).collect();
    reply.join(" ")
}

fn words(fake: &Fake, address: u16, count: u16) -> Vec<i16> {
    let words = Map(fake).read_words(Space::Inputs, address, count).unwrap();
    words.into_iter().map(u16::cast_signed).collect()
}

#[test]
fn blocks_are_in_order_and_do_not_overlap() {
    let blocks: Vec<&RegisterRange> = blocks().collect();
    for pair in blocks.windows(2) {
        assert!(
            pair[0].first + pair[0].count <= pair[1].first,
            "{}",
            pair[1].first
        );
    }
    for space in [Space::Outputs, Space::Inputs] {
        let mut last = 0;
        for block in bit_blocks().filter(|b| b.space.is_none_or(|of| of == space)) {
            assert!(block.first >= last, "{}", block.first);
            last = block.first + block.count;
        }
    }
}

#[test]
fn the_state_is_where_the_vendor_has_it() {
    let fake = Fake::default();
    fake.image.set_program(ProgramState::Paused);
    fake.image.set_control(ControlMode::Local);
    assert_eq!(words(&fake, 0, 4), [0x8001_u16 as i16, 0x0A03, 0, 0]);
    assert_eq!(words(&fake, 17, 1), [100]);
    assert_eq!(
        words(&fake, 63, 16),
        [
            2, 15, 0, 7, 1, 0, 0, 1, 1, -1, 100, -1571, 1500, -7000, 32767, -1571
        ]
    );
    assert_eq!(words(&fake, 84, 6), [0, 0, 0, 0, 0, -3200]);
    assert_eq!(
        words(&fake, 95, 10),
        [0, -500, -1000, -1500, -2000, -2500, 0, 0, 0, 0]
    );
    assert_eq!(words(&fake, 105, 6), [32, 32, -5, 32, 32, 32]);
    assert_eq!(words(&fake, 400, 6), [250, 0, 0, 0, 0, -500]);
    assert_eq!(words(&fake, 500, 1), [2]);
    // One request as a client of the field sends it, gaps included, by function 3 and 4 alike.
    let (by_4, by_3) = (ask(&fake, "04 00 3f 00 30"), ask(&fake, "03 00 3f 00 30"));
    assert!(
        by_4.starts_with("04 60 00 02 00 0f 00 00 00 07 00 01"),
        "{by_4}"
    );
    assert_eq!(by_4[2..], by_3[2..]);
    assert_eq!(ask(&fake, "02 00 00 00 20"), "02 04 01 80 03 0a");
    assert_eq!(ask(&fake, "01 00 00 00 20"), "01 04 01 80 03 0a");
}

#[test]
fn outputs_and_speed_that_are_written_act() {
    let fake = Fake::default();
    assert_eq!(ask(&fake, "05 00 23 ff 00"), "05 00 23 ff 00");
    assert_eq!(ask(&fake, "02 00 23 00 01"), "02 01 01");
    assert_eq!(ask(&fake, "06 00 02 00 03"), "06 00 02 00 03"); // and output 3 off
    assert_eq!(ask(&fake, "01 00 20 00 10"), "01 02 03 00");
    assert_eq!(ask(&fake, "06 00 03 03 64"), "06 00 03 03 64"); // tool pins 0 and 1 are outputs
    assert_eq!(ask(&fake, "01 00 30 00 10"), "01 02 64 03");
    assert_eq!(ask(&fake, "0f 00 30 00 0a 02 00 02"), "0f 00 30 00 0a");
    assert_eq!(ask(&fake, "04 00 02 00 02"), "04 04 00 03 02 00");
    assert_eq!(
        ask(&fake, "10 00 02 00 02 04 00 80 00 01"),
        "10 00 02 00 02"
    );
    assert_eq!(ask(&fake, "04 00 02 00 02"), "04 04 00 80 00 01");
    assert_eq!(ask(&fake, "06 00 11 00 32"), "06 00 11 00 32");
    assert_eq!(ask(&fake, "03 00 11 00 01"), "03 02 00 32");
    for wrong in ["06 00 11 00 01", "06 00 11 00 65", "06 00 11 ff ff"] {
        assert_eq!(ask(&fake, wrong), "86 03", "{wrong}");
    }
    let full = Fake {
        is_full: true,
        ..Fake::default()
    };
    assert_eq!(ask(&full, "05 00 20 ff 00"), "85 06");
    assert_eq!(ask(&full, "06 00 02 00 01"), "86 06");
}

#[test]
fn general_purpose_words_and_user_ranges_hold_what_is_written() {
    let fake = Fake::default();
    assert_eq!(ask(&fake, "06 01 00 ff fe"), "06 01 00 ff fe");
    assert_eq!(
        ask(&fake, "10 01 7e 00 02 04 00 01 80 00"),
        "10 01 7e 00 02"
    );
    assert_eq!(ask(&fake, "04 01 00 00 01"), "04 02 ff fe");
    assert_eq!(ask(&fake, "16 01 00 00 f2 00 25"), "16 01 00 00 f2 00 25");
    assert_eq!(ask(&fake, "03 01 00 00 01"), "03 02 00 f7");
    assert_eq!(
        ask(&fake, "17 01 7e 00 02 01 7f 00 01 02 00 09"),
        "17 04 00 01 00 09"
    );
    assert_eq!(ask(&fake, "06 02 58 80 00"), "06 02 58 80 00");
    assert_eq!(fake.registers.input.integer(0), -32768);
    fake.registers.output.set_integer(47, -70000);
    fake.registers.output.set_integer(46, 65535);
    assert_eq!(words(&fake, 746, 2), [-1, -32768]);
    assert_eq!(ask(&fake, "05 01 2c ff 00"), "05 01 2c ff 00");
    assert!(fake.registers.input.boolean(0));
    fake.registers.output.set_boolean(127, true);
    assert_eq!(ask(&fake, "02 02 72 00 02"), "02 01 02");
}

#[test]
fn our_own_addresses_begin_at_1000() {
    let fake = Fake::default();
    assert_eq!(words(&fake, 1035, 1), [-1571]);
    assert_eq!(words(&fake, 1010, 3), [0, 2500, 0]);
    Map(&fake).write_words(1294, &[0xFFFF, 0xFFFE]).unwrap();
    assert_eq!(fake.registers.input.integer(47), -2);
    Map(&fake).write_words(1400, &[0x3FC0, 0]).unwrap();
    assert_eq!(fake.registers.input.float(0), 1.5);
    assert_eq!(words(&fake, 1400, 2), [0x3FC0, 0]);
    Map(&fake).write_words(1107, &[0x8001]).unwrap();
    assert!(fake.registers.input.boolean(127) && fake.registers.input.boolean(112));
    assert_eq!(ask(&fake, "01 04 ca 00 02"), "01 01 02");
    Map(&fake).write_bits(1002, &[true, false, true]).unwrap();
    assert_eq!(ask(&fake, "01 03 ea 00 03"), "01 01 05");
    assert_eq!(ask(&fake, "02 03 e8 00 02"), "02 01 01");
    assert_eq!(words(&fake, 1002, 1), [0b10100]);
}

#[test]
fn what_is_not_there_or_only_shows_something_is_refused_whole() {
    let fake = Fake::default();
    for request in [
        "04 00 6f 00 01", // 111
        "04 00 6e 00 02", // 110 and 111
        "03 01 f5 00 01", // 501
        "03 ff ff 00 7d",
        "06 00 49 00 05",                // a joint position
        "06 01 f4 00 01",                // the program
        "06 00 04 00 01",                // a gap
        "06 00 00 00 01",                // inputs
        "06 02 bc 00 01",                // user outputs
        "10 01 7f 00 02 04 00 01 00 02", // 383 and the pose
        "10 00 01 00 02 04 00 01 00 02", // inputs and outputs
        "05 00 03 ff 00",                // an input
        "05 00 40 ff 00",                // a gap
        "05 00 3a ff 00",                // tool pin 2 is an input
        "06 00 03 04 00",                // the same as a word
        "06 00 03 10 00",                // a thirteenth output
        "05 01 f4 ff 00",                // user output
        "01 00 7f 00 02",
        "02 01 ac 00 01",
        "16 00 49 00 00 00 01",
        "17 01 00 00 01 00 49 00 01 02 00 01",
        "17 ff ff 00 02 01 00 00 01 02 00 01",
        "06 05 14 00 01", // an integer output register
        "04 03 ec 00 01", // 1004
    ] {
        let reply = ask(&fake, request);
        assert!(reply.ends_with(" 02"), "{request}: {reply}");
    }
    assert_eq!(fake.image.words(), [0; 128]);
    assert_eq!(fake.registers.input.booleans(), [0, 0]);
    assert_eq!(fake.io.lock().digital_out, 0);
    for request in ["2b 0e 01 00", "07", "08 00 00 00 00", "11"] {
        assert!(ask(&fake, request).ends_with(" 01"), "{request}");
    }
    for request in ["04 01 00 00 00", "04 01 00 00 7e", "05 00 20 00 01"] {
        assert!(ask(&fake, request).ends_with(" 03"), "{request}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn any_request_to_the_map_is_answered(
        function in prop_oneof![Just(1_u8), Just(2), Just(3), Just(4), Just(5), Just(6), Just(15), Just(16), Just(22),
            Just(23), any::<u8>()],
        address in prop_oneof![0..800_u16, 1000..1600_u16, any::<u16>()],
        rest in proptest::collection::vec(prop_oneof![Just(0_u8), Just(1), Just(2), any::<u8>()], 0..12),
    ) {
        let request = [&[function][..], &address.to_be_bytes(), &rest].concat();
        let message = [&[0, 1, 0, 0, 0, (request.len() + 1) as u8, 255][..], &request].concat();
        let reply = build_reply(&message, &Map(&Fake::default()));
        prop_assert!(reply.len() >= 9 && reply.len() <= ADU_BYTES_MAX);
        prop_assert_eq!(reply[7] & 0x7F, function & 0x7F);
    }
}
