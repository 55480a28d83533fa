//! What a script client sends: the same programs whether it comes in one piece or byte by byte, and bounded memory.

use server::ports::primary::framing::{ProgramEnd, ScriptFrame, ScriptFramer};

const LIMIT: usize = 300;

fn frames<'a>(pieces: impl Iterator<Item = &'a [u8]>) -> Vec<ScriptFrame> {
    let mut framer = ScriptFramer::with_limit(LIMIT);
    let mut frames = Vec::new();
    for piece in pieces {
        framer.push(piece, &mut frames);
    }
    framer.finish(ProgramEnd::PeerClosed, &mut frames);
    frames
}

pub(super) fn judge(data: &[u8]) {
    let whole = frames([data].into_iter());
    for frame in &whole {
        if let ScriptFrame::Program(program) = frame {
            assert!(program.text.len() <= LIMIT, "{} bytes", program.text.len());
        }
    }
    assert_eq!(whole, frames(data.chunks(1)));
    assert_eq!(whole, frames(data.chunks(7)));
}
