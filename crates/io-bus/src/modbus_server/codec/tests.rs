//! Requests and their answers, byte for byte, and any bytes.

use super::*;
use proptest::prelude::*;

/// The reply proper to a request proper, both in hex.
fn reply(image: &PortImage, request: &str) -> String {
    let request: Vec<u8> = request
        .split_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect();
    let reply = reply_to(&request, image);
    let reply: Vec<String> = reply.iter().map(|byte| format!("{byte:02x}")).collect();
    reply.join(" ")
}

struct Nothing(motion_api::Registers);

impl Controller for Nothing {
    fn state(&self) -> motion_api::RobotState {
        motion_api::RobotState::at_start(Default::default(), 0.004)
    }
    fn registers(&self) -> &motion_api::Registers {
        &self.0
    }
    fn change(&self, _: motion_api::IoChange) -> bool {
        false
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn any_request_to_the_map_is_answered(function in prop_oneof![Just(1_u8), Just(2), Just(3), Just(4), Just(5), Just(6), Just(15), Just(16), Just(22), Just(23), any::<u8>()], address in prop_oneof![1000..1600_u16, any::<u16>()], rest in proptest::collection::vec(prop_oneof![Just(0_u8), Just(1), Just(2), any::<u8>()], 0..12)) {
        let mut request = vec![function];
        request.extend(address.to_be_bytes());
        request.extend(&rest);
        let mut message = vec![0, 1, 0, 0, 0, (request.len() + 1) as u8, 255];
        message.extend(&request);
        let reply = answer_with(&message, &PortImage::default(), Some(&Nothing(Default::default())));
        prop_assert!(reply.len() >= 9 && reply.len() <= ADU_BYTES_MAX);
        prop_assert_eq!(reply[7] & 0x7F, function & 0x7F);
    }
}

#[test]
fn the_map_begins_at_1000_and_outputs_that_cannot_be_set_are_busy() {
    let nothing = Nothing(Default::default());
    let ask = |request: &[u8]| {
        let message = [&[0, 1, 0, 0, 0, request.len() as u8 + 1, 255], request].concat();
        answer_with(&message, &PortImage::default(), Some(&nothing))[7..].to_vec()
    };
    assert_eq!(ask(&[3, 0x03, 0xFC, 0, 1]), [3, 2, 0, 7]); // 1020: running
    assert_eq!(ask(&[4, 0x03, 0xFC, 0, 1]), [4, 2, 0, 7]);
    assert_eq!(ask(&[4, 0, 0, 0, 1]), [0x84, 2]);
    assert_eq!(ask(&[5, 0x03, 0xE8, 0xFF, 0]), [0x85, 6]);
    assert_eq!(
        ask(&[16, 0x04, 0xB0, 0, 2, 4, 0, 0, 0, 9]),
        [16, 0x04, 0xB0, 0, 2]
    );
    assert_eq!(nothing.0.input.integer(0), 9);
    assert_eq!(ask(&[3, 0, 0, 0, 1]), [3, 2, 0, 0]); // the flat registers as ever
}

#[test]
fn the_golden_message_is_answered_with_its_transaction_and_unit() {
    let image = PortImage::default();
    image.write_register(2, 0x1234).unwrap();
    let request = [0xAB, 0xCD, 0, 0, 0, 6, 0x11, 3, 0, 2, 0, 1];
    assert_eq!(message_bytes(&request[..6]), Ok(None));
    assert_eq!(message_bytes(&request), Ok(Some(12)));
    assert_eq!(
        answer(&request, &image),
        [0xAB, 0xCD, 0, 0, 0, 5, 0x11, 3, 2, 0x12, 0x34]
    );
}

#[test]
fn every_function_reads_and_writes_the_image() {
    let image = PortImage::default();
    for (request, expected) in [
        ("05 00 03 ff 00", "05 00 03 ff 00"),
        ("0f 00 08 00 0a 02 05 02", "0f 00 08 00 0a"),
        ("01 00 00 00 12", "01 03 08 05 02"),
        ("01 00 78 00 08", "01 01 00"),
        ("06 00 ff 80 01", "06 00 ff 80 01"),
        ("10 00 00 00 02 04 00 0a 01 02", "10 00 00 00 02"),
        ("03 00 00 00 02", "03 04 00 0a 01 02"),
        ("16 00 01 00 f2 00 25", "16 00 01 00 f2 00 25"),
        ("03 00 01 00 01", "03 02 00 07"),
        ("17 00 00 00 02 00 01 00 01 02 00 09", "17 04 00 0a 00 09"),
        ("05 00 03 00 00", "05 00 03 00 00"),
    ] {
        assert_eq!(reply(&image, request), expected, "{request}");
    }
    assert_eq!(image.read_bit(3), Ok(false));
    assert_eq!(image.read_bit(8), Ok(true));
    assert_eq!(image.read_bit(17), Ok(true));
    assert_eq!(image.read_register(255), Ok(0x8001));
}

#[test]
fn unknown_functions_are_exception_1() {
    let image = PortImage::default();
    for request in [
        "02 00 00 00 01",
        "04 00 00 00 01",
        "2b 0e 01 00",
        "41",
        "07",
        "11",
    ] {
        let function = u8::from_str_radix(&request[..2], 16).unwrap() | 0x80;
        assert_eq!(
            reply(&image, request),
            format!("{function:02x} 01"),
            "{request}"
        );
    }
    assert_eq!(reply(&image, "83 00"), "83 01");
    assert_eq!(reply(&image, ""), "80 01");
}

#[test]
fn addresses_outside_are_exception_2_and_change_nothing() {
    let image = PortImage::default();
    for request in [
        "01 00 80 00 01",
        "01 00 7f 00 02",
        "01 ff ff 07 d0",
        "03 01 00 00 01",
        "03 00 ff 00 02",
        "05 00 80 ff 00",
        "06 01 00 00 01",
        "0f 00 7f 00 02 01 03",
        "10 00 ff 00 02 04 00 01 00 02",
        "16 01 00 00 00 00 01",
        "17 00 00 00 01 00 ff 00 02 04 00 01 00 02",
        "17 00 ff 00 02 00 00 00 01 02 00 01",
    ] {
        assert!(
            reply(&image, request).ends_with(" 02"),
            "{request}: {}",
            reply(&image, request)
        );
    }
    let values = image.lock();
    assert!(values.registers.iter().all(|word| *word == 0) && !values.coils.contains(&true));
}

#[test]
fn bad_counts_are_exception_3_even_at_addresses_outside() {
    let image = PortImage::default();
    for request in [
        "01 00 00 00 00",
        "01 ff ff 07 d1",
        "03 00 00 00 00",
        "03 ff ff 00 7e",
        "05 00 00 00 01",
        "0f 00 00 00 00 00",
        "0f 00 00 00 09 01 ff",
        "0f 00 00 00 08 02 ff ff",
        "0f 00 00 00 08 01",
        "10 00 00 00 00 00",
        "10 00 00 00 02 02 00 01",
        "10 00 00 00 01 02 00",
        "10 00 00 80 01 02 00 00",
        "17 00 00 00 00 00 00 00 01 02 00 01",
        "17 00 00 00 01 00 00 00 00 00",
        "01 00 00 00",
        "03 00 00 00 01 00",
        "06",
    ] {
        assert!(
            reply(&image, request).ends_with(" 03"),
            "{request}: {}",
            reply(&image, request)
        );
    }
}

#[test]
fn a_header_that_is_none_is_refused() {
    assert_eq!(
        message_bytes(&[0, 0, 0, 1, 0, 6, 1]),
        Err(NotModbus::Protocol(1))
    );
    assert_eq!(
        message_bytes(&[0, 0, 0, 0, 0, 1, 1]),
        Err(NotModbus::Length(1))
    );
    assert_eq!(
        message_bytes(&[0, 0, 0, 0, 0, 255, 1]),
        Err(NotModbus::Length(255))
    );
    assert_eq!(
        message_bytes(&[0, 0, 0, 0, 0, 254, 1]),
        Ok(Some(ADU_BYTES_MAX))
    );
    let error = message_bytes(b"GET / HTTP/1.1").unwrap_err();
    assert_eq!(error, NotModbus::Protocol(u16::from_be_bytes(*b"T ")));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]
    #[test]
    fn any_request_gets_an_answer_that_fits(
        function in prop_oneof![Just(1u8), Just(3), Just(5), Just(6), Just(15), Just(16), Just(22), Just(23), any::<u8>()],
        fields in proptest::collection::vec(prop_oneof![3 => 0u8..4, 1 => any::<u8>()], 0..20),
    ) {
        let image = PortImage::default();
        let pdu = [&[function][..], &fields].concat();
        let length = (1 + pdu.len()) as u16;
        let message = [&[0, 7, 0, 0][..], &length.to_be_bytes(), &[255], &pdu].concat();
        prop_assert_eq!(message_bytes(&message), Ok(Some(message.len())));
        let answer = answer(&message, &image);
        prop_assert_eq!(message_bytes(&answer), Ok(Some(answer.len())));
        prop_assert!(answer[7] == function || answer[7] == function | 0x80);
    }
}
