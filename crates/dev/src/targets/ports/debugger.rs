//! The debugger: whatever a client sends, each answer is a message, and the session ends with the stream.

use std::io::Cursor;

use controller::ControllerConfig;
use controller::options::PlantChoice;
use editor::dap::{RunTarget, serve, stream};
use elite_runtime::ProgramText;
use serde_json::Value as Json;

/// Whatever is launched is this.
const PROGRAM: &str = "def f(n):\n    m = n\n    return m\nx = [1]\nsleep(0.02)\ny = f(2)\n1 / 0\n";

fn launch(_: &Json) -> Result<RunTarget, messages::Text> {
    Ok(RunTarget {
        program: ProgramText {
            name: "program.script".to_owned(),
            text: PROGRAM.to_owned(),
        },
        robot: ControllerConfig {
            plant: PlantChoice::Ideal,
            ..ControllerConfig::default()
        },
        presets: Vec::new(),
        recorded: None,
    })
}

pub(super) fn judge(bytes: &[u8]) {
    let mut out = Vec::new();
    if serve(Cursor::new(bytes.to_vec()), &mut out, &launch).is_err() {
        // The system gave no thread.
        return;
    }
    let mut input = &out[..];
    loop {
        match stream::read(&mut input) {
            Ok(Some(stream::DapInput::Message(message))) => {
                assert!(message["seq"].is_i64() && message["type"].is_string());
            }
            Ok(None) => return,
            other => panic!("an answer is no message: {other:?}"),
        }
    }
}

/// Right sessions.
pub(super) fn seeds() -> Vec<Vec<u8>> {
    let session = |requests: &[&str]| {
        let framed = |request: &&str| {
            let body = format!("{{\"seq\":1,\"type\":\"request\",{request}}}");
            format!("Content-Length: {}\r\n\r\n{body}", body.len())
        };
        let text: String = requests.iter().map(framed).collect();
        text.into_bytes()
    };
    let start = [
        "\"command\":\"initialize\",\"arguments\":{\"linesStartAt1\":false}",
        "\"command\":\"launch\",\"arguments\":{\"program\":\"program.script\",\"stopOnEntry\":true}",
        "\"command\":\"setBreakpoints\",\"arguments\":{\"source\":{\"path\":\"program.script\"},\
         \"breakpoints\":[{\"line\":2,\"condition\":\"n > 1\",\"hitCondition\":\"% 2\"}]}",
        "\"command\":\"configurationDone\"",
    ];
    let then = [
        "\"command\":\"stackTrace\",\"arguments\":{\"threadId\":1}",
        "\"command\":\"variables\",\"arguments\":{\"variablesReference\":1,\"start\":0}",
        "\"command\":\"evaluate\",\"arguments\":{\"expression\":\"x\",\"context\":\"repl\"}",
        "\"command\":\"stepBack\",\"arguments\":{\"threadId\":1}",
        "\"command\":\"gotoCycle\",\"arguments\":{\"cycle\":3}",
        "\"command\":\"setDataBreakpoints\",\"arguments\":{\"breakpoints\":[{\"dataId\":\"time > 1\"}]}",
        "\"command\":\"disconnect\"",
    ];
    let whole: Vec<&str> = start.iter().chain(&then).copied().collect();
    vec![session(&start), session(&then), session(&whole)]
}
