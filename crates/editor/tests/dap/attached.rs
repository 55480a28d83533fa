//! Sessions of clients that attach, whatever they send: each request is answered once, and whoever leaves has driven
//! last.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use editor::dap::stream::MessageSink;
use editor::dap::{AttachedSession, DebugHub, SessionSender};
use proptest::prelude::*;
use serde_json::{Value as Json, json};

struct Kept(Sender<Json>);

impl MessageSink for Kept {
    fn message(&mut self, message: &Json) -> io::Result<()> {
        let sent = self.0.send(message.clone());
        sent.map_err(|_| io::ErrorKind::BrokenPipe.into())
    }
}

fn session(
    hub: &Arc<DebugHub>,
    is_trusted: bool,
) -> (SessionSender, Receiver<Json>, JoinHandle<()>) {
    let (session, inlet) = AttachedSession::new(hub.clone(), is_trusted);
    let (sender, said) = channel();
    let served = std::thread::spawn(move || session.serve(&mut Kept(sender)));
    (inlet, said, served)
}

fn request(seq: i64, command: &str, arguments: &Json) -> String {
    json!({"seq": seq, "type": "request", "command": command, "arguments": arguments}).to_string()
}

/// The answer to a request.
fn answer(said: &Receiver<Json>, seq: i64) -> Result<Json, String> {
    loop {
        let message = said.recv().unwrap();
        if message["type"] == "response" && message["request_seq"] == seq {
            return match message["success"] == true {
                true => Ok(message["body"].clone()),
                false => Err(message["message"].as_str().unwrap().to_owned()),
            };
        }
    }
}

#[test]
fn one_drives_with_the_token_and_leaves_its_place_to_the_next() {
    let hub = Arc::new(DebugHub::default());
    let (stranger, to_stranger, _served) = session(&hub, false);
    let greeted = |inlet: &SessionSender| inlet.message(&request(0, "initialize", &json!({})));
    assert!(greeted(&stranger));
    assert!(stranger.message(&request(1, "attach", &json!({}))));
    let refused = answer(&to_stranger, 1).unwrap_err();
    assert!(refused.contains("token"), "{refused}");
    assert!(stranger.message(&request(2, "attach", &json!({"drive": false}))));
    answer(&to_stranger, 2).unwrap();
    assert!(stranger.message(&request(3, "setBreakpoints", &json!({"source": {}}))));
    assert!(
        answer(&to_stranger, 3)
            .unwrap_err()
            .contains("only looks on")
    );

    let (first, to_first, served) = session(&hub, true);
    let (second, to_second, _serving) = session(&hub, true);
    assert!(greeted(&first) && greeted(&second));
    assert!(first.message(&request(1, "attach", &json!({}))));
    answer(&to_first, 1).unwrap();
    assert!(second.message(&request(1, "attach", &json!({}))));
    assert!(
        answer(&to_second, 1)
            .unwrap_err()
            .contains("drives already")
    );
    assert_eq!(
        (&hub.shown()["driver"], &hub.shown()["watchers"]),
        (&json!(true), &json!(1))
    );
    first.gone();
    served.join().unwrap();
    assert_eq!(hub.shown()["driver"], false);
    assert!(second.message(&request(2, "attach", &json!({}))));
    answer(&to_second, 2).unwrap();
    for inlet in [stranger, second] {
        inlet.gone();
    }
}

fn anything() -> impl Strategy<Value = Json> {
    let leaf = prop_oneof![
        Just(Json::Null),
        any::<bool>().prop_map(Json::from),
        any::<i64>().prop_map(Json::from),
        ".{0,8}".prop_map(Json::from),
    ];
    let key = prop_oneof![
        Just("breakpoints".to_owned()),
        Just("source".to_owned()),
        Just("path".to_owned()),
        Just("line".to_owned()),
        Just("threadId".to_owned()),
        Just("frameId".to_owned()),
        Just("expression".to_owned()),
        Just("filters".to_owned()),
        Just("drive".to_owned()),
        "[a-z]{1,6}",
    ];
    leaf.prop_recursive(3, 24, 4, move |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(Json::from),
            prop::collection::btree_map(key.clone(), inner, 0..4)
                .prop_map(|fields| Json::Object(fields.into_iter().collect())),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_request_is_answered_once_whatever_it_is(
        requests in prop::collection::vec(
            (
                prop::sample::select(vec![
                    "initialize", "attach", "launch", "configurationDone", "setBreakpoints", "setFunctionBreakpoints",
                    "setExceptionBreakpoints", "setDataBreakpoints", "dataBreakpointInfo", "breakpointLocations",
                    "source", "loadedSources", "threads", "stackTrace", "scopes", "variables", "evaluate",
                    "setVariable", "continue", "next", "stepBack", "reverseContinue", "gotoCycle", "restart",
                    "terminate", "pause", "nonsense",
                ]),
                anything(),
            ),
            0..30,
        ),
        is_trusted in any::<bool>(),
    ) {
        let hub = Arc::new(DebugHub::default());
        let (inlet, said, served) = session(&hub, is_trusted);
        let is_taken = inlet.message("{]") && inlet.message(&request(0, "initialize", &json!({})));
        prop_assert!(is_taken);
        for (number, (command, arguments)) in requests.iter().enumerate() {
            prop_assert!(inlet.message(&request(number as i64 + 1, command, arguments)));
        }
        inlet.gone();
        served.join().unwrap();
        let said: Vec<Json> = said.iter().collect();
        for number in 1..=requests.len() {
            let answers = said.iter().filter(|m| m["type"] == "response" && m["request_seq"] == number);
            prop_assert_eq!(answers.count(), 1, "{:?}", requests[number - 1]);
        }
        prop_assert_eq!(&hub.shown()["driver"], &json!(false));
    }
}
