//! Beginnings of browsers in every method, spelling and division, and beginnings of clients that must be let in.

use proptest::prelude::*;

use super::*;

/// The verdict on `bytes` that come in pieces of `piece`, and what went on.
fn verdict(bytes: &[u8], piece: usize) -> (SniffResult, Vec<u8>) {
    let (mut opening, mut ours) = (ProtocolSniffer::default(), Vec::new());
    for part in bytes.chunks(piece) {
        match opening.take(part, &mut ours) {
            SniffResult::Undecided => {}
            verdict => return (verdict, ours),
        }
    }
    (SniffResult::Undecided, ours)
}

/// Every request line that somebody may send to a port.
pub(crate) fn requests() -> Vec<String> {
    let mut requests = Vec::new();
    for method in METHODS {
        for target in ["/", "*", "/a b", "http://127.0.0.1/", "127.0.0.1:443"] {
            requests.push(format!("{method} {target} HTTP/1.1\r\nHost: x\r\n\r\n"));
        }
    }
    for method in METHODS.iter().chain(&RARE_METHODS) {
        let capital = &method[..1];
        let small = method.to_lowercase();
        for method in [*method, &small, &format!("{capital}{}", &small[1..])] {
            requests.push(format!("{method} / HTTP/1.1\r\n\r\n"));
            requests.push(format!("\r\n\n {method}\t/x HTTP/1.0\r\n\r\n"));
            requests.push(format!("{method} host:443 http/1.1\r\n\r\n"));
        }
    }
    requests.push("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n".to_owned());
    requests
}

/// Greetings of TLS 1.0 to 1.3, and what a browser's begins with.
pub(crate) const HELLOS: [&[u8]; 2] = [
    &[0x16, 3, 1, 2, 0, 1, 0, 1, 0xfc, 3, 3],
    &[0x16, 3, 3, 0, 200, 1, 0, 0, 196, 3, 3],
];

#[test]
fn no_request_gets_in_whole_or_in_pieces() {
    for request in requests() {
        for piece in [1, 2, 3, 7, 1000] {
            let (verdict, ours) = verdict(request.as_bytes(), piece);
            assert_eq!(
                verdict,
                SniffResult::Intruder(ForeignProtocol::Http),
                "{request:?}"
            );
            assert!(ours.trim_ascii().is_empty(), "{request:?} let {ours:?} in");
        }
    }
    for hello in HELLOS {
        for piece in [1, 2, 100] {
            let (verdict, ours) = verdict(hello, piece);
            assert_eq!(verdict, SniffResult::Intruder(ForeignProtocol::Tls));
            assert!(ours.is_empty());
        }
    }
}

#[test]
fn clients_of_every_port_are_let_in_with_every_byte() {
    let modbus_with_any_transaction = |a: u8, b: u8| vec![a, b, 0, 0, 0, 6, 1, 3, 0, 0, 0, 1];
    let mut clients: Vec<Vec<u8>> = [
        "def f():\n  x = 1\nend\n",
        "get = 5\n",
        "head = [1, 2]\n",
        "trace *= 2\n",
        "head /= 2\n",
        "copy = HTTP\n",
        "LOCK = 1\n",
        "post (1)\n",
        "getx / 2\n",
        "GETTER = 1\n",
        "put\n",
        "move in [1]\n",
        "options is None HTTP/\n",
        "stop task\n",
        "play\n",
        "popup -s GET / HTTP/1.1\n",
        "pause task\n",
        "# GET / HTTP/1.1\n",
    ]
    .iter()
    .map(|text| text.as_bytes().to_vec())
    .collect();
    clients.push(vec![0, 5, b'V', 0, 1]);
    for (a, b) in [(b'G', b'E'), (b'P', b'O'), (0x16, 3), (b'P', b'R'), (0, 0)] {
        clients.push(modbus_with_any_transaction(a, b));
    }
    for client in clients {
        for piece in [1, 2, 5, 1000] {
            let (mut opening, mut ours) = (ProtocolSniffer::default(), Vec::new());
            let mut decided = false;
            for part in client.chunks(piece) {
                if decided {
                    ours.extend(part);
                } else {
                    decided = match opening.take(part, &mut ours) {
                        SniffResult::Undecided => false,
                        SniffResult::Ours => true,
                        intruder => panic!("{client:?}: {intruder:?}"),
                    };
                }
            }
            opening.give_back(&mut ours);
            assert_eq!(ours, client);
        }
    }
}

#[test]
fn what_stays_unclear_is_let_go_after_a_while() {
    let long = format!("get {}", "x".repeat(1000));
    let (verdict, ours) = verdict(long.as_bytes(), 1);
    assert_eq!(verdict, SniffResult::Ours);
    assert_eq!(ours.len(), HELD_BYTES_MAX);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn how_bytes_are_divided_changes_nothing(bytes in "[GETPOSpost /*H\r\n\
        ]{0,20}|[\\x00-\\x20]{0,8}", piece in 1_usize..8) {
        let whole = verdict(bytes.as_bytes(), bytes.len().max(1));
        let pieces = verdict(bytes.as_bytes(), piece);
        prop_assert_eq!(whole.0, pieces.0);
        if whole.0 == SniffResult::Undecided {
            prop_assert_eq!(whole.1, pieces.1);
        }
    }
}
