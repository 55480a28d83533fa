//! Translated programs as texts, and laws that hold for any text.

use elite_syntax::{KnownNames, SourceFile, parser};
use program_import::translate::functions::FUNCTIONS;
use program_import::translate::{MessageKind, translate};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// What stands after the first line, in programs without helpers.
fn body(program: &str) -> String {
    let text = translate(program, "a").unwrap().text;
    text.split_once("\n\n").unwrap().1.to_owned()
}

/// Whether a text is EliteScript.
fn is_script(text: &str) -> bool {
    let file = SourceFile::new("a.script", text);
    let found = parser::parse(&file).diagnostics;
    assert!(found.is_empty(), "{found:?} in\n{text}");
    true
}

#[test]
fn the_body_of_the_program_keeps_comments_breaks_and_labels() {
    let program = "\
# before
def main():
  # first
  x = 1 # one

  $ 3 \"Loop\"
  while (x < 3): # again
    x = x + 1
    # last of the loop
  end
  if x == 3: textmsg(\"3\") else: halt end
end
# after
";
    insta::assert_snapshot!(body(program), @r#"
    # before

    # first
    x = 1  # one

    # 3 "Loop"
    while x < 3:  # again
        x = x + 1
        # last of the loop
    end
    if x == 3:
        textmsg("3")
    else:
        halt()
    end

    # after
    "#);
}

#[test]
fn a_file_of_functions_stays_one() {
    let program = "def f(a):\n  return a\nend\ndef g():\n  f(1)\nend\ng()\n";
    assert_eq!(
        body(program),
        "def f(a):\n    return a\nend\ndef g():\n    f(1)\nend\ng()\n"
    );
    assert_eq!(
        body("sec tick():\n  set_flag(1, True)\nend\n"),
        "sec tick():\n    set_flag(1, True)\nend\n"
    );
}

#[test]
fn names_live_where_universal_robots_puts_them() {
    let program = "\
def main():
  def reader():
    return later
  end
  def counter():
    inner = 0
    def step():
      inner = inner + 1
      shared = inner
      global fresh = inner
    end
    step()
    return inner
  end
  shared = 1
  later = 2
end
";
    let text = body(program);
    // `shared` comes after the function and is written before it is read, so it is a local variable nobody reads.
    assert!(
        text.contains(
            "def step():\n        global fresh\n        nonlocal inner\n        inner = inner + 1\n\
                           \x20       _shared = inner\n        fresh = inner\n"
        ),
        "{text}"
    );
}

#[test]
fn motions_take_poses_and_joint_positions() {
    let program = "\
def main():
  q = [0, 0, 0, 0, 0, 0]
  movel(q, v=0.1)
  movej(p[1, 2, 3, 0, 0, 0.5], t=2)
  movec(p[1, 2, 3, 0, 0, 0], q)
  servoj(q, 0, 0, 0.008)
  movej(q, 1, 2)
end
";
    assert_eq!(
        body(program),
        "\
q = [0, 0, 0, 0, 0, 0]
movel(get_forward_kin(q), v=0.1)
movej(get_inverse_kin([1, 2, 3, 0, 0, 0.5]), t=2, a=1.4, v=1.05)
movec([1, 2, 3, 0, 0, 0], get_forward_kin(q), mode=1)
servoj(q, t=0.008)
movej(q, 1, 2)
"
    );
}

#[test]
fn rows_of_the_table_make_calls_that_are_read() {
    for row in FUNCTIONS.iter() {
        let params = row.parameters();
        let args: Vec<&str> = params
            .iter()
            .map(|param| {
                if param.kind == "p" {
                    "p[1,2,3,0,0,0]"
                } else {
                    "1"
                }
            })
            .collect();
        let call = format!("{}({})\n", row.name(), args.join(", "));
        let translation = translate(&call, "a").unwrap();
        is_script(&translation.text);
        let is_missing = row.call == "!";
        assert_eq!(translation.is_complete(), !is_missing, "{call}");
        assert_eq!(
            FUNCTIONS
                .iter()
                .filter(|other| other.name() == row.name())
                .count(),
            1,
            "{} stands twice",
            row.name()
        );
    }
}

#[test]
fn calls_beyond_the_table_are_named() {
    let translation = translate(
        "def a():\n  rq_close()\n  x = speed_of_belt\n  run b()\nend\n",
        "a",
    )
    .unwrap();
    let missing: Vec<(u32, &str)> = translation
        .messages
        .iter()
        .filter(|message| message.kind == MessageKind::Missing)
        .map(|message| (message.line, message.name.as_str()))
        .collect();
    assert_eq!(missing, [(2, "rq_close"), (3, "speed_of_belt"), (4, "b")]);
}

#[test]
fn depth_is_bounded() {
    for text in [
        "(".repeat(100_000),
        format!("x = {}1", "-".repeat(100_000)),
        format!("x = {}1", "not ".repeat(100_000)),
        format!("x = 1{}", " + 1".repeat(100_000)),
        format!("x = a{}", "[0]".repeat(100_000)),
        "if True: ".repeat(100_000),
        "def f(): ".repeat(100_000),
    ] {
        assert!(translate(&text, "a").is_err());
    }
    assert!(translate(&format!("x = {}1{}", "(".repeat(40), ")".repeat(40)), "a").is_ok());
}

/// Pieces that texts of URScript are made of.
fn piece() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec![
        "def ",
        "f",
        "()",
        ":",
        "\n",
        "end",
        "\n",
        "if ",
        "True",
        "else:",
        "while ",
        "x",
        " = ",
        "[",
        "]",
        "p[",
        ", ",
        "1",
        "0.5",
        "-",
        " + ",
        " and ",
        " xor ",
        "not ",
        "(",
        ")",
        "global ",
        "local ",
        "thread ",
        "run ",
        "kill ",
        "join ",
        "return ",
        "movel",
        "movej",
        "set_digital_out",
        "\"a\"",
        "#",
        "$ 1",
        ".",
        "halt",
        "struct",
        "elif ",
        "break",
        "p",
    ])
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(4), cases: 2000, ..ProptestConfig::default() })]

    #[test]
    fn any_text_is_translated_or_refused(pieces in prop::collection::vec(piece(), 0..60)) {
        let text = pieces.concat();
        if let Ok(translation) = translate(&text, "a") {
            let file = SourceFile::new("a.script", &*translation.text);
            let known = KnownNames::default();
            let _ = elite_syntax::check(file, &known);
        }
    }

    #[test]
    fn expressions_keep_their_shape(
        values in prop::collection::vec(1_u32..9, 6),
        signs in prop::collection::vec(prop::sample::select(vec!["+", "-", "*", "/"]), 5),
    ) {
        let mut text = values[0].to_string();
        for (sign, value) in signs.iter().zip(&values[1..]) {
            text = format!("{text} {sign} {value}");
        }
        let translated = translate(&format!("x = {text}\n"), "a").unwrap().text;
        prop_assert!(translated.ends_with(&format!("x = {text}\n")), "{}", translated);
    }
}
