//! What a dashboard user types: every line has one reply that fits the SDK's read.

use server::ports::dashboard::codec::{
    DashboardCommand, REPLY_BYTES_MAX, encode, help, mistake, parse,
};
use server::ports::lines::{Line, LineFramer};

fn lines<'a>(pieces: impl Iterator<Item = &'a [u8]>) -> Vec<Line> {
    let mut framer = LineFramer::new(200);
    let mut lines = Vec::new();
    for piece in pieces {
        framer.push(piece, &mut lines);
    }
    lines
}

pub(super) fn judge(data: &[u8]) {
    let whole = lines([data].into_iter());
    for line in &whole {
        let Line::Text(text) = line else { continue };
        let reply = match parse(text) {
            Ok(DashboardCommand::Help(names)) => help(&names),
            Ok(_) => continue,
            Err(found) => mistake(text, &found),
        };
        let bytes = encode(&reply);
        assert!(bytes.len() <= REPLY_BYTES_MAX && bytes.ends_with(b"\r\n"));
        let text = String::from_utf8_lossy(&bytes);
        assert!(
            text.split("\r\n")
                .all(|line| !line.contains(char::is_control))
        );
    }
    assert_eq!(whole, lines(data.chunks(1)));
}
