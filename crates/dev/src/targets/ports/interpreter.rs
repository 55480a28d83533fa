//! What a client of interpreter mode sends: the same statements in any pieces, and replies of one line.

use server::ports::interpreter::codec::{StatementFrame, StatementFramer, ack, executed};

fn frames<'a>(pieces: impl Iterator<Item = &'a [u8]>) -> Vec<StatementFrame> {
    let mut framer = StatementFramer::default();
    let mut frames = Vec::new();
    for piece in pieces {
        framer.push(piece, &mut frames);
    }
    framer.finish(&mut frames);
    frames
}

pub(super) fn judge(data: &[u8]) {
    let whole = frames([data].into_iter());
    for frame in &whole {
        let reply = match frame {
            StatementFrame::Statement(text) => {
                let run = executed(text);
                assert!(run.starts_with(text.as_str()) && run.len() <= 2 * text.len() + 3);
                ack(1, text)
            }
            StatementFrame::Command(command) => command.reply(1),
            StatementFrame::Rejected(rejection) => rejection.reply(),
        };
        assert!(
            reply.ends_with('\n') && !reply.trim_end_matches('\n').contains(['\n', '\r']),
            "{reply:?}"
        );
    }
    assert_eq!(whole, frames(data.chunks(1)));
    assert_eq!(whole, frames(data.chunks(5)));
}
