//! Requests and their answers, byte for byte, and any bytes.

use super::super::tables::Store;
use super::*;
use proptest::prelude::*;
use std::sync::Arc;

/// The reply proper to a request proper, both in hex.
fn reply(store: &Store, request: &str) -> String {
    let request: Vec<u8> = request
        .split_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect();
    let reply = reply_to(&request, store);
    let reply: Vec<String> = reply.iter().map(|byte| format!("{byte:02x}")).collect();
    reply.join(" ")
}

#[test]
fn the_golden_message_is_answered_with_its_transaction_and_unit() {
    let store = Store::default();
    store.values().registers[2] = 0x1234;
    let request = [0xAB, 0xCD, 0, 0, 0, 6, 0x11, 3, 0, 2, 0, 1];
    assert_eq!(message_bytes(&request[..6]), Ok(None));
    assert_eq!(message_bytes(&request), Ok(Some(12)));
    assert_eq!(
        build_reply(&request, &store),
        [0xAB, 0xCD, 0, 0, 0, 5, 0x11, 3, 2, 0x12, 0x34]
    );
}

#[test]
fn a_slave_answers_to_its_number_and_the_only_one_to_0_and_255() {
    let request = |unit: u8| [0, 1, 0, 0, 0, 6, unit, 3, 0, 2, 0, 1];
    let one = Slaves::from([(9, Arc::new(Store::default()) as _)]);
    for unit in [9, 0, 255] {
        let answer = [0, 1, 0, 0, 0, 5, unit, 3, 2, 0, 0];
        assert_eq!(build_slave_reply(&request(unit), &one), answer);
    }
    let absent = |unit| [0, 1, 0, 0, 0, 3, unit, 0x83, 11];
    assert_eq!(build_slave_reply(&request(8), &one), absent(8));
    let two = Slaves::from([9, 3].map(|unit| (unit, Arc::new(Store::default()) as _)));
    assert_eq!(build_slave_reply(&request(255), &two), absent(255));
}

/// A device that has the function 3 only.
struct Reader(Store);

impl Tables for Reader {
    fn has_function(&self, function: u8) -> bool {
        function == 3
    }

    fn read_bits(&self, space: Space, from: u16, count: u16) -> Result<Vec<bool>, ModbusException> {
        self.0.read_bits(space, from, count)
    }

    fn write_bits(&self, address: u16, levels: &[bool]) -> Result<(), ModbusException> {
        self.0.write_bits(address, levels)
    }

    fn read_words(&self, space: Space, from: u16, count: u16) -> Result<Vec<u16>, ModbusException> {
        self.0.read_words(space, from, count)
    }

    fn write_words(&self, address: u16, values: &[u16]) -> Result<(), ModbusException> {
        self.0.write_words(address, values)
    }
}

#[test]
fn a_function_that_a_device_has_not_is_exception_1_and_changes_nothing() {
    let device = Reader(Store::default());
    let both = [0x17, 0, 0, 0, 2, 0, 1, 0, 1, 2, 0, 9];
    assert_eq!(reply_to(&both, &device), [0x97, 1]);
    assert_eq!(reply_to(&[6, 0, 1, 0, 9], &device), [0x86, 1]);
    assert_eq!(reply_to(&[3, 0, 1, 0, 1], &device), [3, 2, 0, 0]);
}

#[test]
fn every_function_reads_and_writes_the_image() {
    let store = Store::default();
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
        assert_eq!(reply(&store, request), expected, "{request}");
    }
    let values = store.values();
    assert_eq!([3, 8, 17].map(|n| values.coils[n]), [false, true, true]);
    assert_eq!(values.registers[255], 0x8001);
}

#[test]
fn unknown_functions_are_exception_1() {
    let store = Store::default();
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
            reply(&store, request),
            format!("{function:02x} 01"),
            "{request}"
        );
    }
    assert_eq!(reply(&store, "83 00"), "83 01");
    assert_eq!(reply(&store, ""), "80 01");
}

#[test]
fn addresses_outside_are_exception_2_and_change_nothing() {
    let store = Store::default();
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
            reply(&store, request).ends_with(" 02"),
            "{request}: {}",
            reply(&store, request)
        );
    }
    let values = store.values();
    assert!(values.registers.iter().all(|word| *word == 0) && !values.coils.contains(&true));
}

#[test]
fn bad_counts_are_exception_3_even_at_addresses_outside() {
    let store = Store::default();
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
            reply(&store, request).ends_with(" 03"),
            "{request}: {}",
            reply(&store, request)
        );
    }
}

#[test]
fn a_header_that_is_none_is_refused() {
    assert_eq!(
        message_bytes(&[0, 0, 0, 1, 0, 6, 1]),
        Err(ModbusFrameError::Protocol(1))
    );
    assert_eq!(
        message_bytes(&[0, 0, 0, 0, 0, 1, 1]),
        Err(ModbusFrameError::Length(1))
    );
    assert_eq!(
        message_bytes(&[0, 0, 0, 0, 0, 255, 1]),
        Err(ModbusFrameError::Length(255))
    );
    assert_eq!(
        message_bytes(&[0, 0, 0, 0, 0, 254, 1]),
        Ok(Some(ADU_BYTES_MAX))
    );
    let error = message_bytes(b"GET / HTTP/1.1").unwrap_err();
    assert_eq!(
        error,
        ModbusFrameError::Protocol(u16::from_be_bytes(*b"T "))
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]
    #[test]
    fn any_request_gets_an_answer_that_fits(
        function in prop_oneof![Just(1u8), Just(3), Just(5), Just(6), Just(15), Just(16), Just(22), Just(23),
            any::<u8>()],
        fields in proptest::collection::vec(prop_oneof![3 => 0u8..4, 1 => any::<u8>()], 0..20),
    ) {
        let store = Store::default();
        let pdu = [&[function][..], &fields].concat();
        let length = (1 + pdu.len()) as u16;
        let message = [&[0, 7, 0, 0][..], &length.to_be_bytes(), &[255], &pdu].concat();
        prop_assert_eq!(message_bytes(&message), Ok(Some(message.len())));
        let answer = build_reply(&message, &store);
        prop_assert_eq!(message_bytes(&answer), Ok(Some(answer.len())));
        prop_assert!(answer[7] == function || answer[7] == function | 0x80);
    }
}
