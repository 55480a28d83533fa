//! What comes in on the Foxglove port: handshakes, frames and messages, and what is left of a client that is gone.

use server::ports::foxglove::FoxgloveBroadcast;
use server::ports::foxglove::protocol::{
    SUBPROTOCOLS, SUBSCRIPTIONS_MAX, Subscriptions, answer_to,
};
use tokio_util::sync::CancellationToken;

use super::conversation::{answered, callers, may_be_for_us};

/// Topics of a port in which nothing is shown.
const TOPICS: usize = 6;

thread_local! {
    static STAGE: FoxgloveBroadcast = FoxgloveBroadcast::new(1);
}

/// A handshake that is right.
pub(super) fn handshake() -> Vec<u8> {
    let protocol = SUBPROTOCOLS[0];
    format!(
        "GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\
         Sec-WebSocket-Protocol: {protocol}\r\n\r\n"
    )
    .into_bytes()
}

/// A message of a client in a frame of its own (RFC 6455, 5.2), with a mask that changes nothing.
fn framed(message: &[u8]) -> Vec<u8> {
    let is_text = std::str::from_utf8(message).is_ok();
    let mut frame = vec![if is_text { 0x81 } else { 0x82 }];
    match u16::try_from(message.len()) {
        Ok(length @ 0..126) => frame.push(0x80 | length as u8),
        Ok(length) => {
            frame.push(0xfe);
            frame.extend(length.to_be_bytes());
        }
        Err(_) => {
            frame.push(0xff);
            frame.extend((message.len() as u64).to_be_bytes());
        }
    }
    frame.extend([0; 4]);
    frame.extend_from_slice(message);
    frame
}

/// Texts of the frames that a server sent; none is longer than what a greeting takes.
fn texts(mut frames: &[u8]) -> Vec<&[u8]> {
    let mut texts = Vec::new();
    while let [kind, length, rest @ ..] = frames {
        let (length, rest) = match (length, rest) {
            (126, [a, b, rest @ ..]) => (usize::from(u16::from_be_bytes([*a, *b])), rest),
            (127, [0, 0, 0, 0, a, b, c, d, rest @ ..]) => {
                (u32::from_be_bytes([*a, *b, *c, *d]) as usize, rest)
            }
            (short, rest) => (usize::from(*short), rest),
        };
        let (payload, after) = rest.split_at(length.min(rest.len()));
        if kind & 0x0f == 1 && payload.len() == length {
            texts.push(payload);
        }
        frames = after;
    }
    texts
}

/// Any bytes at the port; and, one a line, messages of a client that has shaken hands.
pub(super) fn judge(data: &[u8]) {
    let messages: Vec<&[u8]> = data.split(|byte| *byte == b'\n').collect();
    let mut following = Subscriptions::default();
    for text in messages.iter().flat_map(|text| std::str::from_utf8(text)) {
        if let Err(mistake) = following.take(text, TOPICS) {
            let answer = answer_to(&mistake);
            assert!(answer.len() < 4096 && !answer.contains(char::is_control));
        }
    }
    let count: usize = (0..TOPICS).map(|place| following.to(place).count()).sum();
    assert!(count <= SUBSCRIPTIONS_MAX, "{count} subscriptions");

    let answer = said(data);
    assert!(answer.is_empty() || answer.starts_with(b"HTTP/1."));
    assert!(!answer.starts_with(b"HTTP/1.1 101") || may_be_for_us(data));
    if data.starts_with(b"GET ") {
        return;
    }
    let frames = messages.iter().flat_map(|message| framed(message));
    let answer = said(&handshake().into_iter().chain(frames).collect::<Vec<u8>>());
    assert!(answer.starts_with(b"HTTP/1.1 101"));
    let head = answer.windows(4).position(|four| four == b"\r\n\r\n");
    let texts = texts(&answer[head.map_or(answer.len(), |at| at + 4)..]);
    assert!(texts.len() >= 2, "the greeting is missing");
    for text in &texts[2..] {
        let said: serde_json::Value = serde_json::from_slice(text).unwrap_or_default();
        assert_eq!(said["op"], "status", "{}", String::from_utf8_lossy(text));
    }
}

/// Everything that a client is sent that sends this; then nobody follows anything.
fn said(sent: &[u8]) -> Vec<u8> {
    STAGE.with(|stage| {
        let (callers, shutdown) = (callers(), CancellationToken::new());
        let answer = answered(sent, |peer| stage.attend(peer, &callers, &shutdown));
        assert_eq!(stage.followers(), 0, "somebody who is gone follows");
        answer
    })
}
