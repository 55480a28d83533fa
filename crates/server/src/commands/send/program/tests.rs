use super::*;

fn outgoing(text: &str, settings: &[&str]) -> Result<OutgoingProgram, WrapError> {
    let file = SourceFile::new("task.script", text);
    let program = compile(file, &elite_runtime::builtins::known_names()).expect("it compiles");
    let settings: Result<Vec<Preset>, PresetError> =
        settings.iter().map(|given| Preset::parse(given)).collect();
    OutgoingProgram::new(&program, &settings?)
}

#[test]
fn blocks_go_out_as_they_are() {
    for text in [
        "def task():\n  movej([0, 0, 0, 0, 0, 0])\nend\n",
        "# of the pendant\n\ndef task():\n\tif True:\n\t\tprint(1)\n\tend\nend",
        "def task():\n  x = '''\nnot indented\n'''\nend # of it\n",
    ] {
        let sent = outgoing(text, &[]).expect("sent");
        assert_eq!(sent.text.trim_end(), text.trim_end());
        assert_eq!(sent.place(2, 5), Some((2, 5)));
    }
    let helper = outgoing("sec helper():\n  textmsg('a')\nend\n", &[]).expect("sent");
    assert!(helper.is_secondary);
}

#[test]
fn plain_statements_go_into_a_function_and_keep_their_places_and_globals() {
    let text = "count = 0\ndef more():\n    global count\n    count += 1\nmore()\ntext = '''a\n  b\n'''\n\
        print(count, text)\n";
    let sent = outgoing(text, &[]).expect("sent");
    let wanted = "def task_program():\n\tglobal count, more, text\n\tpass\n\tcount = 0\n\tdef more():\n\
        \t    global count\n\t    count += 1\n\tmore()\n\ttext = '''a\n  b\n'''\n\tprint(count, text)\nend\n";
    assert_eq!(sent.text, wanted);
    assert_eq!(sent.place(4, 2), Some((1, 1)));
    assert_eq!(sent.place(7, 6), Some((4, 5)));
    // In the middle of a text nothing was moved.
    assert_eq!(sent.place(10, 3), Some((7, 3)));
    assert_eq!(sent.place(12, 8), Some((9, 7)));
    for line in [1, 2, 3, 13, 14, 0, -1, i32::MIN] {
        assert_eq!(sent.place(line, 1), None, "{line}");
    }
}

#[test]
fn a_function_without_end_is_called_by_nobody_else() {
    let sent = outgoing("def f():\n    print(1)\nf()\n", &[]).expect("sent");
    assert!(sent.text.ends_with("\tf()\nend\n"), "{}", sent.text);
}

#[test]
fn settings_stand_before_the_program() {
    let sent = outgoing("print(speed)\n", &["speed=0.25", "name = \"a=b;c\""]).expect("sent");
    assert!(
        sent.text.contains(
            "\tglobal name, speed\n\tspeed = 0.25\n\tname = \"a=b;c\"\n\tpass\n\tprint(speed)\n"
        ),
        "{}",
        sent.text
    );
    // A block is called inside the function that sets them.
    let block = "def task():\n  global speed\n  print(speed)\nend\n";
    let sent = outgoing(block, &["speed=1"]).expect("sent");
    assert!(
        sent.text.ends_with("\tend\n\ttask()\nend\n"),
        "{}",
        sent.text
    );
    for wrong in [
        "speed",
        "=1",
        "1x=1",
        "a.b=1",
        "if=1",
        "x=",
        "x=1;halt()",
        "x=1) ; (2",
        "x=1\nhalt()",
        "x=text",
        "x=1 #",
        "x=(",
    ] {
        let error = outgoing("pass\n", &[wrong]).expect_err(wrong);
        assert!(error.to_string().starts_with("--set "), "{error}");
    }
    let helper = outgoing("sec helper():\n  pass\nend\n", &["a=1"]);
    assert!(matches!(helper, Err(WrapError::SecondarySet)));
}

#[test]
fn errors_have_their_place_also_when_lines_are_told_only() {
    let sent = outgoing("a = 1\nb = 2\n", &[]).expect("sent");
    let first = 1 + sent
        .text
        .lines()
        .position(|line| line == "\ta = 1")
        .expect("there") as i32;
    let at = format!("at line {first}");
    let place = |line: i32, column: i32, text: &str| sent.place_of_error(line, column, text);
    for column in [i32::MIN, -1, 0, 1, 2] {
        assert_eq!(place(first, column, "NameError"), Some((1, 1)));
    }
    assert_eq!(place(first + 1, 6, ""), Some((2, 5)));
    let text = format!(
        "File \"task\", line {first}\n  File \"task\", line {}, in f\nNameError",
        first + 1
    );
    assert_eq!(place(0, 0, &text), Some((2, 1)));
    assert_eq!(place(-1, 0, &at), Some((1, 1)));
    for text in [
        "",
        "line ",
        "line x",
        "line 99999999999",
        "offline 7 was here",
    ] {
        assert_eq!(place(0, 0, text), None, "{text}");
    }
}

#[test]
fn reports_name_the_file_and_its_lines() {
    let sent = outgoing(
        "# first\ndef helper(n):\n    return n / 0\nhelper(1)\n",
        &[],
    )
    .expect("sent");
    let report = "Traceback (most recent call last):\n  task_program, line 7, column 2, in task_program\
        \n    helper(1)\n  task_program, line 6, column 13, in task_program.<locals>.helper\n\
        ZeroDivisionError: at , line 7";
    assert_eq!(
        sent.in_file(report, "pick.script"),
        "Traceback (most recent call last):\n  pick.script, line 4, column 1, in <module>\n    helper(1)\n  \
         pick.script, line 3, column 12, in helper\nZeroDivisionError: at , line 7"
    );
}

#[test]
fn a_controller_that_knows_the_file_gets_its_lines_back() {
    for (text, settings, name) in [
        (
            "# first\ncount = 0\ntext = '''a\n\tb\n'''\nprint(count, text)\n",
            &["speed=0.25"][..],
            "pick.script",
        ),
        ("count = 0", &[], "0 in Ruhe.script"),
        (
            "# of the pendant\n\ndef task():\n\tprint(1)\nend\n",
            &[],
            "task.script",
        ),
        (
            "def task():\n\tprint(speed)\nend\n",
            &["speed=1"],
            "task.script",
        ),
    ] {
        let mut sent = outgoing(text, settings).expect("sent");
        let settings: Vec<Preset> = settings.iter().map(|s| Preset::parse(s).unwrap()).collect();
        sent.name_the_file(name, &settings);
        assert_eq!(sent.place(4, 2), Some((4, 2)), "{}", sent.text);
        let block = &sent.text[sent.text.find("def ").unwrap()..];
        let (program, presets) = SentFile::behind(block).expect("it is told");
        assert_eq!(program.name, name);
        assert_eq!(presets, settings);
        let mut lines = program.text.lines().zip(text.lines());
        // What stands before the block is not sent.
        assert!(
            lines.all(|(found, line)| found == line
                || found.is_empty()
                || found.starts_with("def task():  # ")),
            "{}",
            program.text
        );
    }
}

#[test]
fn the_function_around_a_file_has_a_name_that_is_recognised() {
    for (file, function) in [
        ("pick.script", "pick_program"),
        ("a/b c.v2.script", "b_c_program"),
        ("7.script", "_7_program"),
        ("-", "eliteserver_program"),
        ("\u{5939}\u{53d6}.script", "eliteserver_program"),
    ] {
        assert_eq!(function_of(file), function);
    }
    let sent = outgoing("task_program = 1\nprint(task_program)\n", &[]).expect("sent");
    assert!(
        sent.text.starts_with("def eliteserver_program():"),
        "{}",
        sent.text
    );
}
