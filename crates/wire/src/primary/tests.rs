//! Both directions are the same layout, and no bytes of a peer panic.

use proptest::prelude::*;

use super::exception::encode_exception;
use super::*;
use crate::primary::state::{
    AdditionalInfo, Cartesian, Configuration, Joint, Joints, Masterboard, ModeData,
    STATE_MESSAGE_BYTES, Safety, Tool, ToolCommunication,
};

fn whole() -> State {
    State {
        mode: Some(ModeData {
            timestamp: 12_000_000,
            is_powered: true,
            robot_mode: 255,
            speed_scaling: 0.5,
            ..ModeData::default()
        }),
        joints: Some(Joints(core::array::from_fn(|i| Joint {
            actual_q: i as f64,
            torque: 1.5,
            mode: 253,
            ..Joint::default()
        }))),
        cartesian: Some(Cartesian {
            tcp_pose: [0.1, -0.2, 0.3, 3.0, 0.0, -1.0],
            ..Cartesian::default()
        }),
        configuration: Some(Configuration {
            dh_d: [0.160861, 0.0, 0.0, 0.147568, 0.0964976, 0.112116],
            robot_type: 6206,
            ..Configuration::default()
        }),
        masterboard: Some(Masterboard {
            digital_in: 0x0fff_ffff,
            safety_mode: 1,
            ..Masterboard::default()
        }),
        additional: Some(AdditionalInfo::default()),
        tool: Some(Tool {
            output_voltage: 24,
            ..Tool::default()
        }),
        safety: Some(Safety {
            elbow_position: [0.0, 0.1, 0.9],
            ..Safety::default()
        }),
        tool_communication: Some(ToolCommunication {
            baud_rate: 115_200,
            ..ToolCommunication::default()
        }),
        unknown: Vec::new(),
    }
}

fn decoded(bytes: &[u8]) -> Result<Message, DecodeError> {
    let frame = split_frame(bytes)?.expect("a whole message");
    decode_message(&frame)
}

#[test]
fn a_whole_state_has_the_size_of_the_protocol_and_is_read_back() {
    let bytes = whole().encode();
    assert_eq!(bytes.len(), STATE_MESSAGE_BYTES);
    assert_eq!(decoded(&bytes), Ok(Message::State(Box::new(whole()))));
}

#[test]
fn parts_that_are_missing_unknown_or_longer_than_known_are_taken_as_they_come() {
    let state = State {
        cartesian: whole().cartesian,
        ..State::default()
    };
    let mut bytes = state.clone().encode();
    // An unknown part of two bytes, and eight more bytes at the end of the known one.
    bytes.extend([0, 0, 0, 7, 14, 1, 2]);
    let part = 5 + 4 + 1 + 96;
    for _ in 0..8 {
        bytes.insert(part, 0);
    }
    bytes[5..9].copy_from_slice(&109_u32.to_be_bytes());
    let length = u32::try_from(bytes.len()).expect("short");
    bytes[..4].copy_from_slice(&length.to_be_bytes());
    let wanted = State {
        unknown: vec![14],
        ..state
    };
    assert_eq!(decoded(&bytes), Ok(Message::State(Box::new(wanted))));
}

/// A message of hand-made parts, by the protocol page.
fn page(parts: &[(u8, Vec<u8>)]) -> Vec<u8> {
    let mut body = vec![16];
    for (kind, part) in parts {
        let length = u32::try_from(part.len() + 5).expect("short");
        body.extend(length.to_be_bytes());
        body.push(*kind);
        body.extend(part);
    }
    let length = u32::try_from(body.len() + 4).expect("short");
    [&length.to_be_bytes()[..], &body].concat()
}

#[test]
fn streams_of_other_controllers_are_read_as_far_as_they_are_known() {
    // 53 bytes of part 0 as on the page: timestamp 12 s, power on, a task runs, RUNNING, half speed.
    let mut mode = vec![0; 48];
    mode[..8].copy_from_slice(&12_000_000_u64.to_be_bytes());
    (mode[10], mode[13], mode[15]) = (1, 1, 7);
    mode[17..25].copy_from_slice(&0.5_f64.to_be_bytes());
    let mut place = vec![0; 96];
    place[..8].copy_from_slice(&0.25_f64.to_be_bytes());
    let parts = [
        // Older controllers: production mode between the others, and at the end.
        (9, vec![1, 2, 3]),
        // Another order, an empty part, one that is shorter than any known.
        (4, place),
        (8, Vec::new()),
        (10, vec![0; 20]),
        (0, mode),
        // Of a neighbour's protocol: force, kinematics.
        (7, vec![0xff; 60]),
        (5, vec![0xff; 220]),
        (14, vec![7; 9]),
    ];
    let Ok(Message::State(state)) = decoded(&page(&parts)) else {
        panic!("a state");
    };
    assert_eq!(state.unknown, [9, 8, 10, 7, 5, 14]);
    let mode = state.mode.expect("known");
    assert!(mode.is_powered && mode.is_task_running && !mode.is_task_paused);
    assert_eq!((mode.robot_mode, mode.target_speed_fraction), (7, 0.5));
    assert_eq!(mode.timestamp, 12_000_000);
    assert_eq!(state.cartesian.expect("known").tcp_pose[0], 0.25);
    assert_eq!((state.joints, state.safety), (None, None));
    // Messages of a kind that nobody knows are left out.
    let mut other = page(&[]);
    other.push(0);
    other[3] += 1;
    other[4] = 21;
    assert_eq!(decoded(&other), Ok(Message::Unknown(21)));
}

#[test]
fn what_does_not_fit_together_is_told() {
    let cut = |bytes: &[u8], at: usize| {
        let mut bytes = bytes[..at].to_vec();
        let length = u32::try_from(at).expect("short");
        bytes[..4].copy_from_slice(&length.to_be_bytes());
        bytes
    };
    let whole = whole().encode();
    let said = |bytes: &[u8]| decoded(bytes).expect_err("refused").to_string();
    assert_eq!(
        said(&cut(&whole, 40)),
        "part 0 of a state says it has 53 bytes, 35 are there"
    );
    assert_eq!(
        said(&cut(&whole, 61)),
        "3 bytes behind the last part of a state are no part"
    );
    let mut zero = cut(&whole, 58);
    zero[8] = 0;
    assert_eq!(
        said(&zero),
        "part 0 of a state says it has 0 bytes, 53 are there"
    );
    for length in [0, 5, 2_000_000_u32] {
        let mut bytes = whole.clone();
        bytes[..4].copy_from_slice(&length.to_be_bytes());
        assert!(split_frame(&bytes).is_err(), "{length}");
    }
    assert_eq!(split_frame(&whole[..100]), Ok(None));
}

#[test]
fn exceptions_are_read_back() {
    let text = || ErrorData::Text("tool lost".to_owned());
    for data in [
        ErrorData::None,
        ErrorData::Unsigned(9),
        ErrorData::Signed(-1),
        ErrorData::Float(1.5),
        ErrorData::Hex(0xce110),
        ErrorData::Joint(5),
        text(),
    ] {
        let exception = Exception::Robot {
            code: 7,
            sub_code: -2,
            level: ExceptionLevel::Error,
            data,
        };
        let bytes = encode_exception(99, ExceptionSource::Safety, &exception);
        let wanted = RobotException {
            timestamp: 99,
            source: 99,
            exception,
        };
        assert_eq!(decoded(&bytes), Ok(Message::Exception(wanted)));
    }
    // Other controllers end texts with nothing, or with a line end.
    let page = [
        0, 0, 0, 0x25, 20, 0, 0, 1, 0x8b, 0xcf, 0xe5, 0x68, 0, 104, 10, 0, 0, 0, 2, 0, 0, 0, 1,
        b'i', b'n', b'v', b'a', b'l', b'i', b'd', b' ', b's', b'y', b'n', b't', b'a', b'x',
    ];
    let Ok(Message::Exception(found)) = decoded(&page) else {
        panic!("the example of the protocol");
    };
    let wanted = Exception::Script {
        line: 2,
        column: 1,
        text: "invalid syntax".to_owned(),
    };
    assert_eq!(
        (found.timestamp, found.exception),
        (1_700_000_000_000, wanted)
    );
    // A kind that nobody knows.
    let mut other = page;
    other[14] = 3;
    assert_eq!(decoded(&other), Ok(Message::Unknown(20)));
}

proptest! {
    #[test]
    fn no_bytes_panic(mut bytes in proptest::collection::vec(any::<u8>(), 6..300),
        kind in prop_oneof![Just(16_u8), Just(20), any::<u8>()], small in any::<bool>()) {
        let length = u32::try_from(bytes.len()).expect("short");
        bytes[..4].copy_from_slice(&length.to_be_bytes());
        bytes[4] = kind;
        if small && bytes.len() > 10 {
            bytes[5..8].fill(0);
        }
        let frame = split_frame(&bytes).expect("its length fits").expect("whole");
        let _ = decode_message(&frame);
    }

    #[test]
    fn changed_states_do_not_panic(place in 0..STATE_MESSAGE_BYTES, byte in any::<u8>(),
        cut in 6..STATE_MESSAGE_BYTES) {
        let mut bytes = whole().encode();
        bytes[place] = byte;
        bytes.truncate(cut);
        if let Ok(Some(frame)) = split_frame(&bytes) {
            let _ = decode_message(&frame);
        }
    }
}
