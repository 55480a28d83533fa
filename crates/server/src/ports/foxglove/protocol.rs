//! What is said on the Foxglove port: the WebSocket protocol of the Foxglove app, the part of it that shows. Pure.
//!
//! Texts are JSON objects with an `op`, binary messages begin with an opcode and are little-endian
//! (github.com/foxglove, ws-protocol, docs/spec.md). Nothing can be published, set or called here, and the server says
//! so.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use recorder::Topic;
use serde::Deserialize;
use serde_json::json;

use crate::ports::escape::EscapedLine;

/// The protocol's names in the handshake, the one that we prefer first. The app and the SDK say the first; the second
/// is what the same messages were called before 2025, and what older versions and viewers that came of them still
/// offer.
pub const SUBPROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

/// Longest message of a client, bytes.
pub const MESSAGE_BYTES_MAX: usize = 64 * 1024;

/// Most subscriptions of one client.
pub const SUBSCRIPTIONS_MAX: usize = 64;

const MESSAGE_DATA: u8 = 1;
const TIME: u8 = 2;

/// The number by which clients know a topic, from 1.
pub fn channel_of(place: usize) -> u32 {
    // There are a handful of topics.
    u32::try_from(place + 1).unwrap_or(u32::MAX)
}

/// The first message: who is there, and that viewers follow its time.
pub fn server_info(session: u64) -> String {
    let info = json!({
        "op": "serverInfo",
        "name": "eliteserver",
        "capabilities": ["time"],
        "supportedEncodings": [],
        "metadata": {},
        "sessionId": session.to_string(),
    });
    info.to_string()
}

/// The second message: which topics there are, with their schemas.
pub fn advertise(topics: &[Topic]) -> String {
    let channels = topics.iter().enumerate().map(|(place, topic)| {
        let schema = topic.schema();
        json!({
            "id": channel_of(place),
            "topic": topic.name(),
            "encoding": topic.message_encoding(),
            "schemaName": schema.name,
            "schemaEncoding": schema.encoding,
            "schema": BASE64.encode(&schema.data),
        })
    });
    let channels: Vec<serde_json::Value> = channels.collect();
    json!({"op": "advertise", "channels": channels}).to_string()
}

/// Tells a client that what it said was not done.
pub fn warning(text: &str) -> String {
    json!({"op": "status", "level": 1, "message": text}).to_string()
}

/// A message of a topic for one subscription. `at` is its time, ns.
pub fn message_data(subscription: u32, at: u64, payload: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(13 + payload.len());
    bytes.push(MESSAGE_DATA);
    bytes.extend(subscription.to_le_bytes());
    bytes.extend(at.to_le_bytes());
    bytes.extend(payload);
    bytes
}

/// The time, ns.
pub fn time(at: u64) -> Vec<u8> {
    let mut bytes = vec![TIME];
    bytes.extend(at.to_le_bytes());
    bytes
}

/// What one client follows: its number for each subscription, and the place of the topic. In the order of the numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Subscriptions(Vec<(u32, usize)>);

#[derive(Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
enum ClientMessage {
    Subscribe {
        subscriptions: Vec<SubscribeRequest>,
    },
    Unsubscribe {
        #[serde(rename = "subscriptionIds")]
        ids: Vec<u32>,
    },
    #[serde(other)]
    Other,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct SubscribeRequest {
    id: u32,
    channel_id: u32,
}

impl Subscriptions {
    /// The subscriptions to the topic at this place.
    pub fn to(&self, place: usize) -> impl Iterator<Item = u32> {
        let all = self.0.iter();
        all.filter(move |(_, topic)| *topic == place)
            .map(|(id, _)| *id)
    }

    /// True when nothing is followed.
    pub const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Does what a client says; `topics` is how many there are.
    ///
    /// # Errors
    /// A sentence for the client; what came before the mistake is done.
    pub fn take(&mut self, text: &str, topics: usize) -> Result<(), String> {
        let said = serde_json::from_str(text);
        match said.map_err(|error| format!("not understood: {error}"))? {
            ClientMessage::Subscribe { subscriptions } => {
                for SubscribeRequest { id, channel_id } in subscriptions {
                    self.subscribe(id, channel_id, topics)?;
                }
                Ok(())
            }
            ClientMessage::Unsubscribe { ids } => {
                self.0.retain(|(id, _)| !ids.contains(id));
                Ok(())
            }
            ClientMessage::Other => {
                Err("nothing but subscribe and unsubscribe is possible".to_owned())
            }
        }
    }

    fn subscribe(&mut self, id: u32, channel: u32, topics: usize) -> Result<(), String> {
        let place = (0..topics).find(|place| channel_of(*place) == channel);
        let Some(place) = place else {
            return Err(format!("there is no channel {channel}"));
        };
        if self.0.iter().any(|(known, _)| *known == id) {
            return Err(format!("there is a subscription {id} already"));
        }
        if self.0.len() == SUBSCRIPTIONS_MAX {
            return Err(format!("{SUBSCRIPTIONS_MAX} subscriptions are the most"));
        }
        self.0.push((id, place));
        Ok(())
    }
}

/// The warning that answers a mistake.
pub fn answer_to(mistake: &str) -> String {
    warning(&EscapedLine(mistake).to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn clients_subscribe_and_unsubscribe() {
        let mut following = Subscriptions::default();
        let text = concat!(
            r#"{"op":"subscribe","subscriptions":[{"id":7,"channelId":1},"#,
            r#"{"id":8,"channelId":2},{"id":9,"channelId":1}]}"#
        );
        assert_eq!(following.take(text, 2), Ok(()));
        assert_eq!(following.to(0).collect::<Vec<_>>(), [7, 9]);
        assert_eq!(following.to(1).collect::<Vec<_>>(), [8]);
        let text = r#"{"op":"unsubscribe","subscriptionIds":[7,8,100]}"#;
        assert_eq!(following.take(text, 2), Ok(()));
        assert_eq!(following, Subscriptions(vec![(9, 0)]));
    }

    #[test]
    fn mistakes_are_answered_and_change_nothing() {
        let mut following = Subscriptions::default();
        for (text, words) in [
            (
                r#"{"op":"subscribe","subscriptions":[{"id":1,"channelId":3}]}"#,
                "no channel 3",
            ),
            (
                r#"{"op":"subscribe","subscriptions":[{"id":1,"channelId":0}]}"#,
                "no channel 0",
            ),
            (
                r#"{"op":"advertise","channels":[]}"#,
                "nothing but subscribe",
            ),
            (r#"{"op":"setParameters"}"#, "nothing but subscribe"),
            ("{}", "not understood"),
            ("\u{1b}[2J", "not understood"),
        ] {
            let mistake = following.take(text, 2).unwrap_err();
            assert!(mistake.contains(words), "{mistake}");
            assert!(following.is_empty());
        }
        for id in 0..1000 {
            let _ = following.subscribe(id, 1, 2);
        }
        assert_eq!(following.to(0).count(), SUBSCRIPTIONS_MAX);
        assert!(
            following
                .subscribe(3, 1, 2)
                .unwrap_err()
                .contains("already")
        );
    }

    #[test]
    fn binary_messages_are_as_the_protocol_says() {
        assert_eq!(
            message_data(0x0102, 0x0304, b"ab"),
            [1, 2, 1, 0, 0, 4, 3, 0, 0, 0, 0, 0, 0, b'a', b'b']
        );
        assert_eq!(time(5), [2, 5, 0, 0, 0, 0, 0, 0, 0]);
        let told: serde_json::Value = serde_json::from_str(&advertise(&[Topic::Cycle])).unwrap();
        let channel = &told["channels"][0];
        assert_eq!(channel["topic"], "/cycle");
        let schema = BASE64.decode(channel["schema"].as_str().unwrap()).unwrap();
        assert_eq!(schema, &*Topic::Cycle.schema().data);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn any_text_is_done_or_answered(text in r#"[{}\[\]":,a-zA-Z0-9 .-]{0,80}"#) {
            let mut following = Subscriptions::default();
            if let Err(mistake) = following.take(&text, 2) {
                prop_assert!(answer_to(&mistake).len() < 4096);
            }
        }
    }
}
