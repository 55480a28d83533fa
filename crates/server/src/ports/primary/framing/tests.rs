//! What clients send, cut anywhere; and anything else.

use super::*;
use proptest::prelude::*;

/// The frames of `chunks`, in order, with the end of the stream after them.
fn frames_of(chunks: &[&[u8]], limit: usize) -> Vec<ScriptFrame> {
    let mut framer = ScriptFramer::with_limit(limit);
    let mut frames = Vec::new();
    for chunk in chunks {
        framer.push(chunk, &mut frames);
    }
    framer.finish(ProgramEnd::PeerClosed, &mut frames);
    frames
}

fn frames(text: &str) -> Vec<ScriptFrame> {
    frames_of(&[text.as_bytes()], 1000)
}

fn program(kind: ProgramKind, text: &str) -> ScriptFrame {
    ScriptFrame::Program(ReceivedProgram {
        text: text.to_owned(),
        kind,
        ended_by: ProgramEnd::ItsText,
    })
}

fn closed(kind: ProgramKind, text: &str) -> ScriptFrame {
    ScriptFrame::Program(ReceivedProgram {
        text: text.to_owned(),
        kind,
        ended_by: ProgramEnd::PeerClosed,
    })
}

use ProgramKind::{Line, Main, Secondary};

#[test]
fn a_def_block_ends_at_its_end_and_the_next_line_is_a_program_of_its_own() {
    assert_eq!(
        frames("def t():\n  a()\nend\nt()\n"),
        [
            program(Main, "def t():\n  a()\nend\n"),
            program(Line, "t()\n")
        ]
    );
}

#[test]
fn what_the_sdk_and_the_ros_driver_send_is_one_program_each() {
    let headless =
        "def externalControl():\n\tglobal x\n\t\n\tclass Q(queue.Queue):\n\t\tpass\n\tend\nend\n";
    assert_eq!(frames(headless), [program(Main, headless)]);
    let serial = "sec tool_rs485_config():\n    tool_serial_config(True,115200,0,1)\nend\n\n";
    assert_eq!(
        frames(serial),
        [program(Secondary, serial.trim_end_matches("\n\n")).with_newline()]
    );
    assert_eq!(
        frames("popup(\"hello\")\n"),
        [program(Line, "popup(\"hello\")\n")]
    );
}

impl ScriptFrame {
    fn with_newline(mut self) -> Self {
        if let Self::Program(program) = &mut self {
            program.text.push('\n');
        }
        self
    }
}

#[test]
fn carriage_returns_before_newlines_are_dropped() {
    assert_eq!(
        frames("\r\ndef t():\r\n  a('x\\\r\nend')\r\nend\r\nstop task\r\n"),
        [
            program(Main, "def t():\n  a('x\\\nend')\nend\n"),
            ScriptFrame::Control(ControlPhrase::StopTask)
        ]
    );
}

#[test]
fn an_indented_end_closes_only_an_inner_block() {
    let text = "def t():\n  if x:\n    a()\n  end\n  end = 5\nendless = 1\nend # t\n";
    assert_eq!(frames(text), [program(Main, text)]);
}

#[test]
fn an_end_inside_a_triple_quoted_string_closes_nothing() {
    let text = "def t():\n  s = \"\"\"\nend\n'''\nend\"\"\"\n  c = '''\nend'''\nend\n";
    assert_eq!(frames(text), [program(Main, text)]);
    let header = "def t(s='''\nend\n'''):\n  a()\nend\n";
    assert_eq!(frames(header), [program(Main, header)]);
    // A quote in a comment opens nothing.
    let comment = "def t():\n  a() # it's \"\"\"\nend\n";
    assert_eq!(frames(comment), [program(Main, comment)]);
}

#[test]
fn every_line_outside_a_block_is_a_program() {
    assert_eq!(
        frames("if x:\n  a()\n# comment\n\n   \nend\n"),
        [
            program(Line, "if x:\n"),
            program(Line, "a()\n"),
            program(Line, "end\n")
        ]
    );
}

#[test]
fn blanks_before_a_line_are_no_part_of_it() {
    assert_eq!(
        frames("  \t a()\r\n \tb('  c')"),
        [program(Line, "a()\n"), closed(Line, "b('  c')\n")]
    );
    let halt = [ScriptFrame::Control(ControlPhrase::StopTask)];
    assert_eq!(frames(" halt() \n"), halt);
    assert_eq!(frames("def f():\n  halt()\nend\n").len(), 1);
}

#[test]
fn a_block_that_is_open_at_the_end_was_cut_off_if_it_has_blocks_that_are_closed() {
    let cut = |lines| [ScriptFrame::Rejected(ScriptRejection::CutOff { lines })];
    assert_eq!(frames("def f():\n  if a:\n    b()\n  end\n  c("), cut(5));
    assert_eq!(frames("sec f():\n  while a:\n  end # x\n"), cut(3));
    assert_eq!(
        frames("def f():\n  b()\n"),
        [closed(Main, "def f():\n  b()\n")]
    );
    let mut framer = ScriptFramer::default();
    let mut by_silence = Vec::new();
    framer.push(b"def f():\n  if a:\n  end\n", &mut by_silence);
    framer.finish(ProgramEnd::Silence, &mut by_silence);
    assert!(
        matches!(by_silence[..], [ScriptFrame::Program(_)]),
        "{by_silence:?}"
    );
}

#[test]
fn a_directive_of_the_pendant_is_no_program_and_no_end() {
    let text = "def t():\n  $ LINE: (2, \"it's\")\n$ LINE: (3, 'end')\n  a()\nend\n";
    assert_eq!(
        frames(&format!("$ LINE: (1, \"a\")\n{text} $LINE: (4, 'b')\n")),
        [program(Main, text)]
    );
    // What is none is told by the compiler.
    assert_eq!(frames("$ DIR\n"), [program(Line, "$ DIR\n")]);
}

#[test]
fn a_block_on_one_line_is_complete_and_a_header_with_a_body_is_not() {
    let line = "def f():; textmsg(\"a;\"); popup(\"b\");end;\n";
    assert_eq!(frames(line), [program(Main, line)]);
    let short = "def f():;a();b();end # done\n";
    assert_eq!(frames(short), [program(Main, short)]);
    assert_eq!(
        frames("def f(): a()\nend\nb()\n"),
        [program(Main, "def f(): a()\nend\n"), program(Line, "b()\n")]
    );
    assert_eq!(frames("def f(): end\n"), [closed(Main, "def f(): end\n")]);
}

#[test]
fn sec_is_a_header_only_before_a_function() {
    assert_eq!(frames("sec = 5\n"), [program(Line, "sec = 5\n")]);
    assert_eq!(frames("sec (5)\n"), [program(Line, "sec (5)\n")]);
    assert_eq!(frames("section()\n"), [program(Line, "section()\n")]);
    assert_eq!(frames("define(1)\n"), [program(Line, "define(1)\n")]);
    let tab = "sec\tf ():\n\ta()\nend\n";
    assert_eq!(frames(tab), [program(Secondary, tab)]);
    // A misspelt name is still a block, so that its body is not run line by line.
    let wrong = "def 1f():\n  a()\nend\n";
    assert_eq!(frames(wrong), [program(Main, wrong)]);
}

#[test]
fn control_phrases_are_orders_in_any_spacing_but_not_inside_a_block() {
    use ControlPhrase::*;
    for (line, phrase) in [
        ("stop task\n", StopTask),
        ("  pause   task \n", PauseTask),
        ("resume task\n", ResumeTask),
        ("power on\n", PowerOn),
        ("power off\n", PowerOff),
        ("set robotmode run\n", ReleaseBrakes),
        ("set unlock protective stop\n", UnlockProtectiveStop),
        ("restart safetyboard\n", RestartSafetyBoard),
        ("set speed 0.50\n", SetSpeed(0.5)),
        ("set speed 1", SetSpeed(1.0)),
    ] {
        assert_eq!(frames(line), [ScriptFrame::Control(phrase)], "{line}");
    }
    assert_eq!(
        frames("stop task now\n"),
        [program(Line, "stop task now\n")]
    );
    let block = "def f():\nstop task\nend\n";
    assert_eq!(frames(block), [program(Main, block)]);
    for given in ["1.01", "-0.1", "nan", "fast"] {
        let rejected = &frames(&format!("set speed {given}\n"))[0];
        let ScriptFrame::Rejected(rejection) = rejected else {
            panic!("{rejected:?}")
        };
        assert_eq!(
            rejection.to_string(),
            format!("`set speed` takes a number from 0 to 1, not `{given}`")
        );
    }
}

#[test]
fn the_end_of_the_stream_completes_a_block_and_a_line() {
    assert_eq!(
        frames("def t():\n  a()\n"),
        [closed(Main, "def t():\n  a()\n")]
    );
    assert_eq!(frames("def t(): a()"), [closed(Main, "def t(): a()\n")]);
    assert_eq!(frames("a()"), [closed(Line, "a()\n")]);
    assert_eq!(
        frames("def t():\n  a()\nend"),
        [closed(Main, "def t():\n  a()\nend\n")]
    );
    assert_eq!(frames("  \n# x"), []);
}

#[test]
fn silence_can_complete_what_is_open() {
    let mut framer = ScriptFramer::default();
    let mut frames = Vec::new();
    framer.push(b"def t():\n  a()\n  b(", &mut frames);
    assert!(framer.is_open());
    assert_eq!(framer.open_text(), Some("def t():\n  a()\n  b("));
    framer.push(b")\r", &mut frames);
    framer.finish(ProgramEnd::Silence, &mut frames);
    let ScriptFrame::Program(program) = &frames[0] else {
        panic!("{frames:?}")
    };
    assert_eq!(program.text, "def t():\n  a()\n  b()\n");
    assert_eq!(program.ended_by, ProgramEnd::Silence);
    assert!(!framer.is_open());
    framer.push(b"a()\n", &mut frames);
    assert_eq!(frames.len(), 2);
}

#[test]
fn a_block_that_is_too_long_is_reported_once_and_skipped_to_its_end() {
    let body = "  aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa()\n".repeat(40);
    let text = format!("def t():\n{body}  s='''\nend\n'''\n  end\n{body}end\nb()\n");
    assert_eq!(
        frames(&text),
        [
            ScriptFrame::Rejected(ScriptRejection::TooLong),
            program(Line, "b()\n")
        ]
    );
    assert_eq!(
        ScriptRejection::TooLong.to_string(),
        "the program is longer than 8 MiB; it is skipped to its end"
    );
}

#[test]
fn a_line_that_is_too_long_is_skipped_and_so_is_the_block_it_opens() {
    let long = "a".repeat(1200);
    assert_eq!(
        frames(&format!("{long}\nb()\n")),
        [
            ScriptFrame::Rejected(ScriptRejection::TooLong),
            program(Line, "b()\n")
        ]
    );
    assert_eq!(
        frames(&format!("def {long}():\n  a()\nend\nb()\n")),
        [
            ScriptFrame::Rejected(ScriptRejection::TooLong),
            program(Line, "b()\n")
        ]
    );
    // The limit passed exactly at an `end`.
    let text = format!("def t():\n#{}\nend\nb()\n", "x".repeat(987));
    assert_eq!(
        frames(&text),
        [
            ScriptFrame::Rejected(ScriptRejection::TooLong),
            program(Line, "b()\n")
        ]
    );
}

#[test]
fn bytes_that_are_no_text_are_reported_with_their_place() {
    let bad = frames_of(&[b"def t():\n  a('\xff')\nend\nb()\n"], 1000);
    let place = ScriptRejection::NotUtf8 { line: 2, column: 6 };
    assert_eq!(bad, [ScriptFrame::Rejected(place), program(Line, "b()\n")]);
}

#[test]
fn a_byte_order_mark_is_no_part_of_the_text() {
    assert_eq!(
        frames("\u{FEFF}def t():\n  a()\nend\n"),
        [program(Main, "def t():\n  a()\nend\n")]
    );
}

/// Pieces that meet the framer's decisions more often than random bytes would.
fn stream() -> impl Strategy<Value = Vec<u8>> {
    let piece = prop_oneof![
        Just(b"def t():\n".to_vec()),
        Just(b"sec s():\r\n".to_vec()),
        Just(b"end\n".to_vec()),
        Just(b"  end\n".to_vec()),
        Just(b"\"\"\"".to_vec()),
        Just(b"'".to_vec()),
        Just(b"\\".to_vec()),
        Just(b"\n".to_vec()),
        Just(b"a();".to_vec()),
        Just(b"POST ".to_vec()),
        Just(b"set speed 2\n".to_vec()),
        Just("é\u{FEFF}".as_bytes().to_vec()),
        proptest::collection::vec(any::<u8>(), 0..20),
    ];
    proptest::collection::vec(piece, 0..30).prop_map(|pieces| pieces.concat())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn where_tcp_cuts_the_stream_does_not_matter(bytes in stream(),
        cuts in proptest::collection::vec(1usize..40, 1..20)) {
        let whole = frames_of(&[&bytes], 10_000);
        let mut chunks = Vec::new();
        let mut rest = bytes.as_slice();
        for cut in cuts.iter().cycle() {
            if rest.is_empty() { break; }
            let (chunk, after) = rest.split_at(rest.len().min(*cut));
            chunks.push(chunk);
            rest = after;
        }
        prop_assert_eq!(frames_of(&chunks, 10_000), whole);
    }

    #[test]
    fn any_bytes_leave_the_framer_bounded(chunks in proptest::collection::vec(stream(), 0..12)) {
        let limit = 64;
        let mut framer = ScriptFramer::with_limit(limit);
        let mut frames = Vec::new();
        for chunk in &chunks {
            framer.push(chunk, &mut frames);
            prop_assert!(framer.text.len() <= limit.max(SKIPPED_LINE_BYTES));
            for frame in frames.drain(..) {
                if let ScriptFrame::Program(program) = frame {
                    prop_assert!(program.text.len() <= limit);
                }
            }
        }
        framer.finish(ProgramEnd::PeerClosed, &mut frames);
        prop_assert!(!framer.is_open());
    }
}
