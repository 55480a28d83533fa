//! Compiling takes time in proportion to the text, whatever the text is made of, right or wrong.
//!
//! Every shape repeats one production of the grammar; texts of one size and of four times that size are compiled,
//! checked and their findings shown, and the times compared. Times are those of the processor, so that other work on
//! the machine does not disturb them.

use elite_syntax::{
    DIAGNOSTICS_MAX, KnownNames, SourceFile, check, compile, compile_statement, render_human,
};
use messages::Language;

/// Bytes of the smaller text.
const SMALL: usize = 24 << 10;
/// How much longer the longer text may take: 4 in proportion, 16 with the square.
const RATIO_MAX: f64 = 8.0;
/// Seconds in which no square of the longer text fits: nothing is compared then.
const FAST: f64 = 0.2;
/// Bytes in which a finding is shown.
const SHOWN_MAX: usize = 20_000;

/// A text that repeats something: what stands before, what is repeated (`#` is the number of the repetition), what
/// stands behind.
type Shape = (&'static str, &'static str, &'static str);

/// Lines, blanks, comments.
const LINES: &[Shape] = &[
    ("", "\n", ""),
    ("", "\r", ""),
    ("", "\r\n", ""),
    ("", " ", "x = 1\n"),
    ("if 1:\n", "\t", "x = 1\n"),
    ("if 1:\n", " \t", "x = 1\n"),
    ("", "# a comment\n", ""),
    ("#", " one long comment", "\n"),
    ("", "\u{c}\n", ""),
    ("x = 1 ", "\\\n", "\n"),
    ("x = 1 ", "\\\n+ 1", "\n"),
    ("x = 1 ", "\\ ", "\n"),
    ("x = (", "\n", ")\n"),
    ("x = (", "# inside\n", "1)\n"),
    ("", ";", "\n"),
    ("", "pass;", "\n"),
    ("", "pass;;", "\n"),
    ("", "x = #\n", ""),
    ("", "v# = #\n", ""),
    ("", "\u{4f4d}\u{7f6e}# = #\n", ""),
    ("", "\u{4f4d}", " = 1\n"),
    ("v", "a", " = 1\n"),
    ("", "$ LINE: (1, 'a')\n", "x = 1\n"),
    ("", "$ LINE: (#, 'a')\nx = #\n", ""),
    (
        "if 1:\n    x = 1\n",
        "    $ LINE: (1, 'a#', \"after\")\n",
        "else:\n    x = 2\n",
    ),
    ("x = (", "$ LINE: (1, 'a')\n", "1)\n"),
    ("$ LINE: (1, '", "a", "')\nx = 1\n"),
    ("$ LINE: (1, ", "(", "\nx = 1\n"),
    ("", "$\n", ""),
];

/// Statements.
const STATEMENTS: &[Shape] = &[
    ("", "f()\n", ""),
    ("", "x += #\n", ""),
    ("", "x: int = #\n", ""),
    ("", "x.y[#] = z\n", ""),
    ("", "a = ", "1\n"),
    ("", "a, ", "= b\n"),
    ("", "a, ", "\n"),
    ("del ", "a#, ", "b\n"),
    ("", "del a#\n", ""),
    ("", "assert a, b\n", ""),
    ("", "import m#\n", ""),
    ("import ", "m#, ", "m\n"),
    ("import ", "m#.", "m\n"),
    ("import ", "m#.m as a#, ", "m\n"),
    ("from m import ", "m#, ", "m\n"),
    ("from m import (", "m# as n#, ", ")\n"),
    ("from ", "m#.", "m import x\n"),
    ("def f():\n", "    global g#\n", ""),
    ("def f():\n    global ", "g#, ", "g\n"),
    ("def f():\n", "    v# = #\n", ""),
    ("def f():\n", "    v# = v#\n", ""),
    ("def f():\n", "    print(v#)\n", ""),
    ("def f():\n", "    return\n", ""),
    ("def f():\n", "    yield #\n", ""),
    ("def f():\n", "    def g#(): return v#\n", "    v = 1\n"),
    (
        "def f():\n    v = 1\n",
        "    def g#():\n        nonlocal v\n        v = #\n",
        "",
    ),
    ("def f():\n    def g():\n        nonlocal ", "v#, ", "v\n"),
    ("def f():\n    def g():\n", "        nonlocal v#\n", ""),
    ("def f():\n", "    v# = #\n    def g#(): return v#\n", ""),
    ("def f():\n", "    x# = lambda y: x#\n", ""),
    ("", "raise E from e\n", ""),
    ("", "print #\n", ""),
    ("print ", "#, ", "\n"),
    ("", "break\n", ""),
    ("", "return\n", ""),
    ("", "with a as b: pass\n", ""),
    ("", "with (a as b, c): pass\n", ""),
    ("", "with (a): pass\n", ""),
    ("with ", "a as b, ", "c: pass\n"),
    ("with (", "a, ", "c)): pass\n"),
    ("", "if a: pass\n", ""),
    ("if a: pass\n", "elif b#: pass\n", "else: pass\n"),
    ("if a:\n", "    b = #\n", "end\n"),
    ("", "if a:\n    b\nend\n", ""),
    ("", "while a: pass\nelse: pass\n", ""),
    ("", "while True:\n    x = 1\n", ""),
    ("while True:\n", "    ask()\n", ""),
    ("while True:\n", "    while True: ask()\n", ""),
    ("", "for a in b: pass\n", ""),
    ("for ", "a#, ", "in b: pass\n"),
    ("try: pass\n", "except E#: pass\n", "finally: pass\n"),
    ("try: pass\n", "except E# as e#: pass\n", ""),
    ("try: pass\n", "except: pass\n", ""),
    ("try: pass\n", "except* E#: pass\n", ""),
    ("try: pass\n", "except* E#:\n    return\n", ""),
    ("try: pass\nexcept* E:\n", "    return\n", ""),
    ("", "try: pass\nexcept A: pass\n", ""),
    ("", "def f#(): pass\n", ""),
    ("", "def f#():\n    a = #\n    return a\nend\n", ""),
    ("", "sec f#(): pass\n", ""),
    ("", "def f(a, b=1, *c, d, **e): pass\n", ""),
    ("def f(", "a#, ", "): pass\n"),
    ("def f(", "a#=#, ", "): pass\n"),
    ("def f(", "a#: int = #, ", "): pass\n"),
    ("def f(*, ", "a#, ", "): pass\n"),
    ("def f(", "a, ", "): pass\n"),
    ("def f(a=1, ", "b#, ", "): pass\n"),
    ("def f(", "*a, ", "): pass\n"),
    ("def f(", "/, ", "): pass\n"),
    ("lambda ", "a#, ", "b: 1\n"),
    ("", "@d#\n", "def f(): pass\n"),
    ("", "@d#\n", ""),
    ("", "class C#: pass\n", ""),
    ("class C(", "B#, ", "): pass\n"),
    ("class C(", "k#=#, ", "): pass\n"),
    ("class C:\n", "    a# = #\n", ""),
    ("class C:\n", "    a#: int\n", ""),
    ("class C:\n", "    def m#(self): return super().m#()\n", ""),
    ("class C:\n", "    __p# = #\n", ""),
    ("class C:\n", "    @property\n    def m#(self): pass\n", ""),
];

/// Expressions.
const EXPRESSIONS: &[Shape] = &[
    ("x = ", "# + ", "1\n"),
    ("x = ", "(# + 1) * ", "1\n"),
    ("x = ", "# ** ", "1\n"),
    ("x = ", "a# and ", "b\n"),
    ("x = ", "a# or ", "b\n"),
    ("x = ", "a and b or ", "c\n"),
    ("x = ", "not ", "b\n"),
    ("x = ", "-", "b\n"),
    ("x = ", "a# < ", "b\n"),
    ("x = ", "a# not in ", "b\n"),
    ("x = ", "a if b else ", "c\n"),
    ("x = [", "a if b else c, ", "]\n"),
    ("x", ".a#", "\n"),
    ("x", "[#]", "\n"),
    ("x", "(#)", "\n"),
    ("x[", "#, ", "]\n"),
    ("x[", "#:#:#, ", "]\n"),
    ("f(", "#,", ")\n"),
    ("f(", "0,", ")\n"),
    ("f(", "*a, ", ")\n"),
    ("f(", "**a, ", ")\n"),
    ("f(", "k#=#, ", ")\n"),
    ("f(", "k=#, ", ")\n"),
    ("f(**a, ", "b, ", ")\n"),
    ("f(k=1, ", "b, ", ")\n"),
    ("f(", "x for x in y, ", ")\n"),
    ("f(", "g(#), ", ")\n"),
    ("", "f(a, b=c, *d, **e)\n", ""),
    ("x = [", "#, ", "]\n"),
    ("x = (", "#, ", ")\n"),
    ("x = {", "#, ", "}\n"),
    ("x = {", "#: #, ", "}\n"),
    ("x = {", "**a, ", "}\n"),
    ("x = [", "*a, ", "]\n"),
    ("x = [", "(y := #), ", "]\n"),
    ("x = [", "lambda: #, ", "]\n"),
    ("x = [", "lambda a=#: a, ", "]\n"),
    ("x = [", "[y for y in z], ", "]\n"),
    ("def f():\n    x = [", "[y# for y# in z], ", "]\n"),
    ("def f():\n    x = [", "[lambda: y for y in z], ", "]\n"),
    ("def f():\n    x = [", "(y for y in z), ", "]\n"),
    ("def f():\n", "    [y for y in z]\n", ""),
    ("x = [y ", "for y# in z ", "]\n"),
    ("x = [y for y in z ", "if a# ", "]\n"),
    ("x = [(y := 1) ", "for y# in z ", "]\n"),
    ("x = ", "()", "\n"),
    ("x = [", "...,", "]\n"),
    ("x = [", "1j, .5, 1e5, 0x1f, 0b1, 0o7, ", "]\n"),
    ("x = 0x", "f", "\n"),
    ("x = ", "1", "\n"),
    ("x = ", "1_", "\n"),
    ("x = 1.", "1", "\n"),
    ("x = 1", "a", "\n"),
];

/// Texts and f-strings.
const TEXTS: &[Shape] = &[
    ("x = '", "text ", "'\n"),
    ("x = '", "\u{4f4d}", "'\n"),
    ("x = '''", "text\n", "'''\n"),
    ("x = '''", "text\r\n", "'''\n"),
    ("x = '", "\\n", "'\n"),
    ("x = '", "\\x41\\u4f4d\\101\\N{DIGIT ONE}", "'\n"),
    ("x = '", "\\x4", "'\n"),
    ("x = '", "\\N{nothing}", "'\n"),
    ("x = '", "\\N", "'\n"),
    ("x = '", "\\N{", "'\n"),
    ("x = '", "\\U99999999", "'\n"),
    ("x = b'", "\\x4", "'\n"),
    ("x = '", "\\\n", "'\n"),
    ("x = r'", "\\n", "'\n"),
    ("x = b'", "text", "'\n"),
    ("x = b'", "\u{4f4d}", "'\n"),
    ("", "b'\u{4f4d}'\n", ""),
    ("x = ", "'a' ", "\n"),
    ("x = ", "b'a' ", "\n"),
    ("x = ", "'a' f'{b}' ", "\n"),
    ("x = ", "f'a' ", "\n"),
    ("x = ", "'a' b'a' ", "\n"),
    ("x = f'", "{{", "'\n"),
    ("x = f'", "}}", "'\n"),
    ("x = f'", "{a}", "'\n"),
    ("x = f'", "{a#!r:>{b}}", "'\n"),
    ("x = f'", "{a#=}", "'\n"),
    ("x = f'", "{", "'\n"),
    ("x = f'", "}", "'\n"),
    ("x = f'", "{}", "'\n"),
    ("x = f'", "{a:", "'\n"),
    ("x = f'{a:", "{b}", "}'\n"),
    ("x = f'{a:", "b", "}'\n"),
    ("x = f'{", "a + ", "a}'\n"),
    ("x = f'{", " ", "a}'\n"),
    ("x = f'{[", "a, ", "]}'\n"),
    ("x = f'{[", "\"b\", ", "]}'\n"),
    ("x = f'{", "a b ", "}'\n"),
    ("x = f'", "\\N{DIGIT ONE}", "'\n"),
    ("x = f'", "\\{a}", "'\n"),
    ("", "f'{a}'\n", ""),
    ("", "'''\n'''\n", ""),
    ("", "'", "\n"),
    ("", "'\n", ""),
    ("", "'''", "\n"),
    ("x = '''", "a", "\n"),
    ("x = '", "a", "\n"),
];

/// The form with one line.
const ONE_LINE: &[Shape] = &[
    ("def g():;", " f();", "end\n"),
    ("def g():;", " f();", "\n"),
    ("def g():;", "f();", "end;\n"),
    ("def g():;", "if a:;f();end;", "end\n"),
    ("def g():;", "if a:;f();else:;g();end;", "end\n"),
    ("def g():;", "if a:;", "end\n"),
    ("def g():;", " x = ';';", "end\n"),
    ("def g():;", " x = (;", "end\n"),
    ("def g():;", "end;", "\n"),
    ("", "def g():; f();end\n", ""),
    ("def g():; ", "; ; ", "end\n"),
];

/// What does not parse, and what is warned about.
const ERRORS: &[Shape] = &[
    ("", "1a\n", ""),
    ("", "1a ", "\n"),
    ("", "a b\n", ""),
    ("", "a b c ", "\n"),
    ("", "?\n", ""),
    ("", "? ", "\n"),
    ("", "\u{ff08} ", "\n"),
    ("", ")\n", ""),
    ("", ") ", "\n"),
    ("", "(\n", ""),
    ("", "(", "\n"),
    ("", "(]\n", ""),
    ("", "[", ")\n"),
    ("", "x = (\npass\n", ""),
    ("", "f(\ndef g(): pass\n", ""),
    ("", "def\n", ""),
    ("", "def f(\n", ""),
    ("", "def f(:\n", ""),
    ("", "class\n", ""),
    ("", "if\n", ""),
    ("", "if a\n    b\n", ""),
    ("", "if a:\nb\n", ""),
    ("", "elif a: b\n", ""),
    ("", "else: b\n", ""),
    ("", "except: b\n", ""),
    ("", "try: a\n", ""),
    ("", "end\n", ""),
    ("", "end ; ", "\n"),
    ("", "  a\n b\n", ""),
    ("def f():\n", " )\n", ""),
    ("def f():\n", "    end\n", ""),
    ("def f():\n", "    1a\n", ""),
    ("", "async def f(): pass\n", ""),
    ("", "await x\n", ""),
    ("", "match x:\n    case 1:\n        pass\n", ""),
    ("", "from . import x\n", ""),
    ("", "1 = 2\n", ""),
    ("", "f() += 2\n", ""),
    ("", "a = *b\n", ""),
    ("", "*a, *b = c\n", ""),
    ("", "del f()\n", ""),
    ("", "x = [\n    1,\n    2\nwhile a: pass\n", ""),
    ("", "def f(a): global a\n", ""),
    ("def f():\n    x = 1\n", "    global x\n", ""),
    ("", "nonlocal a\n", ""),
    ("", "yield\n", ""),
    ("", "(yield)\n", ""),
    ("", "[(x := 1) for x in y]\n", ""),
    ("", "undefined#\n", ""),
    ("", "undefined\n", ""),
    ("", "def f#():\n    unused = 1\n", ""),
    ("", "def f#():\n    return\n    a()\n", ""),
    ("x = [", "undefined#, ", "]\n"),
    ("", "$", "\n"),
    ("", "\u{0}", "\n"),
    ("", "=", "\n"),
    ("", "= = ", "\n"),
    ("", "!", "\n"),
    ("", ". ", "\n"),
    ("", "@", "\n"),
    ("", ":", "\n"),
    ("", "->", "\n"),
    ("", "lambda", "\n"),
    ("", "lambda ", "\n"),
    ("", "not ", "\n"),
    ("", "if ", "\n"),
    ("", "def ", "\n"),
    ("", "f(a=", "\n"),
    ("", "f'{", "\n"),
];

/// What is put inside itself: before, after.
const NESTED: &[(&str, &str)] = &[
    ("(", ")"),
    ("(1, ", ")"),
    ("[", "]"),
    ("[1, ", ", 2]"),
    ("{", "}"),
    ("{1: ", "}"),
    ("f(", ")"),
    ("f(a=", ")"),
    ("f(*", ")"),
    ("x[", "]"),
    ("x[1:", "]"),
    ("lambda: ", ""),
    ("lambda a: a + ", ""),
    ("lambda a=", ": a"),
    ("not ", ""),
    ("-", ""),
    ("2 ** ", ""),
    ("1 if a else ", ""),
    ("[a for a in ", "]"),
    ("[", " for a in b]"),
    ("(", " for a in b)"),
    ("{", " for a in b}"),
    ("[lambda: ", " for a in b]"),
    ("(a := ", ")"),
    ("await ", ""),
    ("*", ""),
    ("[*", "]"),
    ("{**", "}"),
    ("[a for a in b if ", "]"),
    ("f(*[*", "])"),
    ("yield ", ""),
    ("(yield ", ")"),
];

/// Heads of blocks that are put inside one another.
const BLOCKS: &[&str] = &[
    "if a:",
    "while a:",
    "while True:",
    "for a in b:",
    "with a:",
    "try:",
    "def f():",
    "def f(a):",
    "class C:",
    "else:",
    "except* E:",
];

/// Seconds of processor time this thread has used, as Linux tells it.
fn processor_time() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split(' ').next().and_then(|field| field.parse().ok());
    nanoseconds.unwrap_or(0.0) / 1e9
}

/// As many of `repeated` as make `bytes`, numbered.
fn repeat(repeated: &str, bytes: usize) -> String {
    let mut text = String::new();
    let mut number = 0;
    while text.len() < bytes {
        let mut parts = repeated.split('#');
        text.push_str(parts.next().unwrap_or(""));
        for part in parts {
            text += &format!("{number}{part}");
        }
        number += 1;
    }
    text
}

fn flat((before, repeated, after): Shape, bytes: usize) -> String {
    format!("{before}{}{after}", repeat(repeated, bytes))
}

/// All that the controller makes of a text before it runs: how many findings, and in how many bytes one is shown.
fn work_on(text: &str) -> (usize, usize) {
    let known = KnownNames::new(["ask", "movej"]);
    let file = SourceFile::new("t", text);
    let found = check(file.clone(), &known);
    let shown = found.iter().map(|finding| {
        finding.fields(&file);
        render_human(finding, &file, Language::English, true).len()
    });
    (found.len(), shown.max().unwrap_or(0))
}

fn seconds(text: &str) -> f64 {
    let before = processor_time();
    work_on(text);
    processor_time() - before
}

/// What is wrong with the findings of a text or the time for it, if anything.
fn trouble(name: &str, text: impl Fn(usize) -> String) -> Option<String> {
    let large = text(4 * SMALL);
    let before = processor_time();
    let (findings, shown) = work_on(&large);
    if findings > DIAGNOSTICS_MAX {
        return Some(format!("{name}: {findings} findings"));
    }
    if shown > SHOWN_MAX {
        return Some(format!("{name}: a finding is shown in {shown} bytes"));
    }
    if processor_time() - before < FAST {
        return None;
    }
    let small = text(SMALL);
    let mut best = f64::INFINITY;
    for _ in 0..4 {
        best = best.min(seconds(&large) / seconds(&small));
        if best <= RATIO_MAX {
            return None;
        }
    }
    Some(format!(
        "{name}: four times the text takes {best:.1} times as long"
    ))
}

fn assert_no_trouble(found: impl IntoIterator<Item = String>) {
    let found: Vec<String> = found.into_iter().collect();
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

fn assert_in_proportion(shapes: &[Shape]) {
    assert_no_trouble(
        shapes
            .iter()
            .filter_map(|shape| trouble(&format!("{shape:?}"), |bytes| flat(*shape, bytes))),
    );
}

#[test]
fn lines_repeated_compile_in_proportion() {
    assert_in_proportion(LINES);
}

#[test]
fn statements_repeated_compile_in_proportion() {
    assert_in_proportion(STATEMENTS);
}

#[test]
fn expressions_repeated_compile_in_proportion() {
    assert_in_proportion(EXPRESSIONS);
}

#[test]
fn texts_repeated_compile_in_proportion() {
    assert_in_proportion(TEXTS);
}

#[test]
fn programs_in_one_line_compile_in_proportion() {
    assert_in_proportion(ONE_LINE);
}

#[test]
fn errors_repeated_compile_in_proportion() {
    assert_in_proportion(ERRORS);
}

#[test]
fn the_lines_of_a_function_compile_in_proportion() {
    // The lines of a text, one level deeper.
    let shapes = [STATEMENTS, ERRORS].concat();
    let lines = shapes
        .iter()
        .filter(|(before, repeated, _)| before.is_empty() && repeated.ends_with('\n'));
    assert_no_trouble(lines.filter_map(|(_, repeated, _)| {
        let inner = repeated.trim_end_matches('\n').replace('\n', "\n    ");
        let inner = format!("    {inner}\n");
        let text = |bytes| format!("def f():\n{}", repeat(&inner, bytes));
        trouble(&format!("in a function: {repeated:?}"), text)
    }));
}

#[test]
fn expressions_within_themselves_compile_in_proportion() {
    let mut found = Vec::new();
    for (before, after) in NESTED {
        // As deep as is allowed, many times; and far deeper than that.
        let one = format!("x = {}a{}\n", before.repeat(180), after.repeat(180));
        let name = format!("{before:?} 180 deep");
        found.extend(trouble(&name, |bytes| one.repeat(bytes / one.len() + 1)));
        let name = format!("{before:?} without end");
        found.extend(trouble(&name, |bytes| {
            let depth = bytes / (before.len() + after.len());
            format!("x = {}a{}\n", before.repeat(depth), after.repeat(depth))
        }));
        let name = format!("{before:?} never closed");
        found.extend(trouble(&name, |bytes| before.repeat(bytes / before.len())));
        let name = format!("{before:?} around much");
        found.extend(trouble(&name, |bytes| {
            let much = "a, ".repeat(bytes / 3);
            format!("x = {}({much}){}\n", before.repeat(90), after.repeat(90))
        }));
    }
    assert_no_trouble(found);
}

#[test]
fn blocks_within_themselves_compile_in_proportion() {
    let mut found = Vec::new();
    for head in BLOCKS {
        let depth = 180;
        let mut one = String::new();
        for level in 0..depth {
            one += &format!("{}{head}\n", " ".repeat(level));
        }
        let blanks = " ".repeat(depth);
        let name = format!("{head:?} {depth} deep");
        found.extend(trouble(&name, |bytes| {
            format!("{one}{blanks}a = 1\n").repeat(bytes / one.len() + 1)
        }));
        let name = format!("{head:?} {depth} deep around many names");
        found.extend(trouble(&name, |bytes| {
            format!("{one}{blanks}{}\n", repeat("a# = b#; ", bytes))
        }));
        let name = format!("{head:?} without end");
        found.extend(trouble(&name, |bytes| {
            let mut text = String::new();
            let mut level = 0;
            while text.len() < bytes {
                text += &format!("{}{head}\n", " ".repeat(level));
                level += 1;
            }
            text
        }));
        let name = format!("{head:?} without end in one line");
        found.extend(trouble(&name, |bytes| {
            format!("{head};").repeat(bytes / head.len())
        }));
    }
    assert_no_trouble(found);
}

#[test]
fn a_program_and_a_statement_full_of_errors_have_fifty() {
    for text in [
        "1a\n",
        "1a ",
        "a b\n",
        ") ",
        "'\n",
        "nonlocal a\n",
        "x = '\\N'\n",
    ] {
        let text = text.repeat(20_000);
        let file = SourceFile::new("t", &*text);
        let program = compile(file.clone(), &KnownNames::default()).expect_err(&text[..9]);
        let statement = compile_statement(file, &KnownNames::default()).expect_err(&text[..9]);
        assert!(program.len() <= DIAGNOSTICS_MAX && statement.len() <= DIAGNOSTICS_MAX);
    }
}
