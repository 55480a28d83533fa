//! What a client of port 40011 sends: the same questions in any pieces, answers of one line.

use server::ports::lines::{Line, LineFramer};
use server::ports::query::codec::{Failure, Request, answer, parse};

fn requests<'a>(pieces: impl Iterator<Item = &'a [u8]>) -> Vec<Option<Request>> {
    let mut framer = LineFramer::new(200);
    let mut lines = Vec::new();
    for piece in pieces {
        framer.push(piece, &mut lines);
    }
    let request = |line: Line| match line {
        Line::Text(text) => parse(&text),
        Line::TooLong => None,
    };
    lines.into_iter().map(request).collect()
}

pub(super) fn judge(data: &[u8]) {
    let whole = requests([data].into_iter());
    for request in &whole {
        if let Some(request) = request {
            assert!(request.id > 0 && !request.statement.is_empty());
            assert!(!request.statement.contains('\n'));
        }
        let id = request.as_ref().map(|request| request.id);
        let value = String::from_utf8_lossy(data).into_owned();
        for value in [Ok(value), Err(Failure::Execute)] {
            let answer = answer(id, &value);
            assert!(answer.starts_with('[') && answer.ends_with("]\n"));
            assert_eq!(answer.chars().filter(|c| c.is_control()).count(), 1);
        }
    }
    assert_eq!(whole, requests(data.chunks(1)));
}
