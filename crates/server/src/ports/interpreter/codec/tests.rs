//! Lines, blocks and replies as the manual prints them, and any bytes.

use super::*;
use proptest::prelude::*;

fn frames_of(chunks: &[&[u8]]) -> Vec<StatementFrame> {
    let mut framer = StatementFramer::default();
    let mut frames = Vec::new();
    for chunk in chunks {
        framer.push(chunk, &mut frames);
    }
    framer.finish(&mut frames);
    frames
}

fn frames(text: &str) -> Vec<StatementFrame> {
    frames_of(&[text.as_bytes()])
}

fn statement(text: &str) -> StatementFrame {
    StatementFrame::Statement(text.to_owned())
}

#[test]
fn replies_are_those_of_the_manual() {
    assert_eq!(ack(3, "popup(\"a\")"), "ack: 3: popup(\"a\")\n");
    assert_eq!(
        discard(&Discard::InvalidState, "a()"),
        "discard: Task is in an invalid state: a()\n"
    );
    assert_eq!(
        discard(&Discard::TooMany, "a()"),
        "discard: Too many interpreted messages: a()\n"
    );
    assert_eq!(
        discard(&Discard::CleanedUp, "a()"),
        "discard: Cleaned up before interpretation: a()\n"
    );
    assert_eq!(
        discard(&Discard::Compile("line 1:\n  a(\n".to_owned()), "a("),
        "discard: Compile error:line 1:   a( : a(\n"
    );
    assert_eq!(ack(1, "def a():\n b()\nend"), "ack: 1: def a():  b() end\n");
}

#[test]
fn every_command_is_answered_with_its_own_word() {
    for command in InterpreterCommand::ALL {
        let line = format!(" {}\r\n", command.word());
        assert_eq!(frames(&line), [StatementFrame::Command(command)]);
        assert_eq!(command.reply(7), format!("state: 7: {}\n", command.word()));
    }
    assert_eq!(frames("abort()\n"), [statement("abort()")]);
}

#[test]
fn a_line_is_a_statement_and_blank_lines_are_none() {
    assert_eq!(
        frames("\r\n \na()\r\n# said\n  b = 1; c()\nd()"),
        [
            statement("a()"),
            statement("# said"),
            statement("  b = 1; c()"),
            statement("d()")
        ]
    );
}

#[test]
fn the_one_line_form_with_semicolons_is_one_statement() {
    let line = "def test_func():; textmsg(\"a\"); popup(\"b\");end;";
    assert_eq!(frames(&format!("{line}\n")), [statement(line)]);
    assert_eq!(
        frames("def f(): return 1\n"),
        [statement("def f(): return 1")]
    );
    assert_eq!(
        frames("d = {1: 2}\nx[1:]\n"),
        [statement("d = {1: 2}"), statement("x[1:]")]
    );
}

#[test]
fn a_block_goes_to_its_end() {
    let sample = "def a():\n servoj([0], t=0.008)\nend";
    assert_eq!(
        frames(&format!("{sample}\na()\n")),
        [statement(sample), statement("a()")]
    );
    let nested = "def a(): # it's\n  if x:\n    b()\n  end\nend # a";
    assert_eq!(frames(&format!("{nested}\n")), [statement(nested)]);
    let strings = "while x:\n  s = '''\nend\n'''\nend";
    assert_eq!(frames(&format!("{strings}\n")), [statement(strings)]);
    let inside = "  if x:\n    a()\n  end";
    assert_eq!(
        frames(&format!("{inside}\nb()\n")),
        [statement(inside), statement("b()")]
    );
    assert_eq!(
        frames("if x:\r\n a()\r\nelse:\r\n b()\r\nend\r\n"),
        [statement("if x:\n a()\nelse:\n b()\nend")]
    );
    assert_eq!(frames("def a():\n b()"), [statement("def a():\n b()")]);
}

#[test]
fn a_long_line_is_reported_once_and_skipped_to_its_end() {
    let long = "x".repeat(3 * LINE_BYTES_MAX);
    let found = frames(&format!("{long}\na()\n"));
    assert_eq!(found[1..], [statement("a()")]);
    let StatementFrame::Rejected(rejection) = &found[0] else {
        panic!("{found:?}")
    };
    assert_eq!(
        rejection.reply(),
        format!(
            "discard: Compile error:the line is longer than 64 KiB : {}…\n",
            "x".repeat(80)
        )
    );
    let most = "x".repeat(LINE_BYTES_MAX - 1);
    assert_eq!(frames(&format!("{most}\n")), [statement(&most)]);
}

#[test]
fn a_long_block_is_reported_once_and_skipped_to_its_end() {
    let body = " b('''\nend\n''')\n".repeat(BLOCK_BYTES_MAX / 8);
    let long_line = format!("# {}\n", "x".repeat(2 * LINE_BYTES_MAX));
    for block in [
        format!("def a():\n{body}end\n"),
        format!("def a():\n{long_line} c()\n end\n{long_line}end\n"),
    ] {
        let found = frames(&format!("{block}c()\n"));
        assert_eq!(found[1..], [statement("c()")]);
        let StatementFrame::Rejected(rejection) = &found[0] else {
            panic!("{:?}", found[0])
        };
        assert!(
            rejection.reply().starts_with(
                "discard: Compile error:the block is longer than 1024 KiB : def a(): "
            )
        );
    }
}

#[test]
fn what_is_no_text_is_reported() {
    let found = frames_of(&[b"a('\xff')\nb()\n"]);
    let start = "a('\u{FFFD}')".to_owned();
    assert_eq!(
        found,
        [
            StatementFrame::Rejected(StatementRejection::NotUtf8 { start }),
            statement("b()")
        ]
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]
    #[test]
    fn where_tcp_cuts_the_stream_does_not_matter(
        pieces in proptest::collection::vec(prop_oneof![
            Just("def a():\n"), Just("end\n"), Just(" end\r\n"), Just("'''"), Just("abort\n"), Just("x;"),
            Just("\n"), Just("\\"), Just("é"), Just(":\n"),
        ], 0..30),
        cut in 1usize..9,
    ) {
        let text = pieces.concat();
        let chunks: Vec<&[u8]> = text.as_bytes().chunks(cut).collect();
        prop_assert_eq!(frames_of(&chunks), frames(&text));
    }
}

#[test]
fn a_block_without_parameters_is_called_and_nothing_else_is() {
    for (statement, call) in [
        ("def a():\n movej(q)\nend", "\na()"),
        ("def  a ( ) :  # one\n movej(q)\nend", "\na()"),
        ("def a():; movej(q);end;", ""),
        ("def a():", ""),
        ("def a(q):\n movej(q)\nend", ""),
        ("def a(q=1):\n movej(q)\nend", ""),
        ("if x:\n a()\nend", ""),
        ("def a(): movej(q)\nend", ""),
        ("a()", ""),
    ] {
        assert_eq!(executed(statement), format!("{statement}{call}"));
    }
}
