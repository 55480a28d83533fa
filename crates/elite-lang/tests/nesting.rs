//! Whatever can nest in the grammar nests 200 levels deep at most, and every long chain ends in a tree of bounded
//! depth: each production repeated many times over is refused with a reason or is a program, and its tree is dropped
//! unharmed.

use crate::support;

use elite_lang::{Resume, ResumeOutcome};
use elite_syntax::{Severity, check, compile};
use support::Task;

/// So many that any recursion without a bound runs out of the stack for compiling.
const MANY: usize = 20_000;
/// Links of a chain; what is made of them is a list, or refused beyond 1000.
const LINKS: usize = 3_000;

/// What nests: before, what is repeated, the innermost, what closes each level, after.
pub const NESTED: &[(&str, &str, &str, &str, &str)] = &[
    ("x = ", "(", "1", ")", ""),
    ("x = ", "[", "1", "]", ""),
    ("x = ", "{", "1", "}", ""),
    ("x = ", "{1: ", "1", "}", ""),
    ("x = ", "{", "1", ": 1}", ""),
    ("x = ", "[*", "a", "]", ""),
    ("x = ", "(*", "a", ",)", ""),
    ("x = ", "{*", "a", "}", ""),
    ("x = ", "{**", "a", "}", ""),
    ("x = ", "[0, *", "a", "]", ""),
    ("x = ", "f(", "", ")", ""),
    ("x = ", "f(*", "a", ")", ""),
    ("x = ", "f(**", "a", ")", ""),
    ("x = ", "f(k=", "a", ")", ""),
    ("x = ", "f(k for k in ", "a", ")", ""),
    ("x = ", "a[", "0", "]", ""),
    ("x = ", "a[*", "0", "]", ""),
    ("x = ", "a[:", "0", "]", ""),
    ("x = ", "a[::", "0", "]", ""),
    ("x = ", "a[1, ", "0", "]", ""),
    ("x = ", "[i for i in ", "a", "]", ""),
    ("x = ", "{i for i in ", "a", "}", ""),
    ("x = ", "{i: i for i in ", "a", "}", ""),
    ("x = ", "(i for i in ", "a", ")", ""),
    ("x = ", "[i for ", "i", " in a]", ""),
    ("x = ", "[i for [i for ", "i", " in a] in a]", ""),
    ("x = ", "[i for i in a if ", "a", "]", ""),
    ("x = ", "[", "a", " for i in a]", ""),
    ("x = ", "[i for i in a for j in ", "a", "]", ""),
    ("x = ", "(a := ", "1", ")", ""),
    ("x = ", "- ", "1", "", ""),
    ("x = ", "+", "1", "", ""),
    ("x = ", "~", "1", "", ""),
    ("x = ", "not ", "1", "", ""),
    ("x = ", "2 ** ", "1", "", ""),
    ("x = ", "2 ** -", "1", "", ""),
    ("x = ", "1 if 1 else ", "1", "", ""),
    ("x = ", "1 if (", "1", ") else 1", ""),
    ("x = ", "lambda: ", "1", "", ""),
    ("x = ", "lambda a=", "1", ": 1", ""),
    ("x = ", "1 + (", "1", ")", ""),
    ("x = ", "1 < (", "1", ")", ""),
    ("x = ", "1 and (", "1", ")", ""),
    ("x = f'{", "(", "1", ")", "}'"),
    ("x = f'{", "- ", "1", "", "}'"),
    ("x = f'{", "[i for i in ", "a", "]", "}'"),
    ("", "(", "a", ")", " = 1"),
    ("", "(", "a", ",)", " = 1"),
    ("", "[", "a", "]", " = 1"),
    ("", "[*", "a", "]", " = 1"),
    ("for ", "(", "a", ",)", " in b: pass"),
    ("for ", "[", "a", "]", " in b: pass"),
    ("for ", "*[", "a", "]", " in b: pass"),
    ("for a in ", "[", "a", "]", ": pass"),
    ("for a in ", "*[", "a", "]", ": pass"),
    ("del ", "(", "a", ")", ""),
    ("del ", "[", "a", "]", ""),
    ("with ", "(", "a", ")", ": pass"),
    ("with a as ", "(", "a", ",)", ": pass"),
    ("with a as ", "[", "a", "]", ": pass"),
    ("if ", "(", "a", ")", ": pass"),
    ("while ", "not ", "a", "", ": pass"),
    ("return_ = ", "(", "a", ")", ""),
    ("assert ", "(", "a", ")", ""),
    ("raise ", "(", "a", ")", ""),
    ("raise a from ", "(", "a", ")", ""),
    ("print ", "(", "a", ")", ""),
    ("@", "(", "a", ")", "\ndef f(): pass"),
    ("def f(a=", "(", "1", ")", "): pass"),
    ("def f(a: ", "(", "1", ")", "): pass"),
    ("def f() -> ", "(", "1", ")", ": pass"),
    ("class A(", "(", "object", ")", "): pass"),
    ("x: ", "a[", "0", "]", " = 1"),
    ("x[", "a[", "0", "]", "] = 1"),
    ("try: pass\nexcept ", "(", "a", ")", ": pass"),
    ("def f():\n    x = ", "(yield ", "1", ")", ""),
    ("def f():\n    x = ", "(yield *", "a", ",)", ""),
    ("def f():\n    x = ", "(yield from ", "a", ")", ""),
    ("def f():\n    return ", "*(", "a", ",)", ""),
    ("x = ", "(not ", "1", ")", ""),
    ("x = ", "[lambda: ", "1", "]", ""),
    ("x = ", "[a[f(", "1", ")]]", ""),
];

/// What goes on without nesting: the first one, what follows again and again.
pub const CHAINS: &[(&str, &str)] = &[
    ("x = 1", " + 1"),
    ("x = a", " + a"),
    ("x = a", " - a * a"),
    ("x = a", " | a"),
    ("x = a", " @ a"),
    ("x = a", " % a"),
    ("x = a", " // a"),
    ("x = a", " << a"),
    ("x = a", " and a"),
    ("x = a", " or a"),
    ("x = a", " or a and not a"),
    ("x = a", " < a"),
    ("x = a", " in a"),
    ("x = a", " is not a"),
    ("x = a", ".a"),
    ("x = a", "()"),
    ("x = a", "[0]"),
    ("x = a", "[0:1]"),
    ("x = a", ".a()"),
    ("x = a", "(a)(b=1)[0].c"),
    ("x = 'a'", " 'a'"),
    ("x = f'{1}'", " f'{1}'"),
    ("x = f'", "{1}"),
    ("x = b'a'", " b'a'"),
    ("x = a", " = a"),
    ("x = [a", ", a"),
    ("x = {1", ", 1"),
    ("x = {1: 1", ", 1: 1"),
    ("x = [a for b in c", " for b in c"),
    ("x = [a for b in c", " if a"),
    ("x = lambda a", ", a"),
    ("if a: pass", "\nelif a: pass"),
    ("try: pass\nexcept a: pass", "\nexcept a: pass"),
    ("@a", "\n@a"),
    ("x = 1", "; x = 1"),
    ("x = 1", "\nx = 1"),
    ("def f(): pass", "\ndef f(): pass"),
    ("import a", ".a"),
    ("import a", ", a"),
    ("from a import b", ", b"),
    ("del a", ", a"),
    ("del a", ".a"),
    ("with a", ", a"),
    ("global a", ", a"),
    ("print a", ", a"),
    ("raise a", ".a"),
    ("assert a", ", a"),
    ("x", ": a"),
    ("x", "[a]"),
    ("x = not", " not"),
    ("x = (", "("),
    ("x = [", "["),
    ("x = {", "{"),
    ("x = f(", "f("),
    ("x = '", "\\"),
    ("x = f'{", "{"),
    ("x = f'{a:", "{a:"),
    ("if a:", " if a:"),
    ("else", "\nelse"),
    ("x = a", "\\\n"),
    ("#", "#"),
    ("x = 1", "1"),
    ("x = 1", "_1"),
    ("x = a", "a"),
];

/// Blocks in blocks, by their head.
const BLOCKS: &[&str] = &[
    "if a:",
    "while a:",
    "for a in b:",
    "with a:",
    "def f():",
    "class A:",
    "def f(a=lambda: 1):",
];

/// Checks and, if it is a program, compiles and drops it; the messages of its errors.
fn errors(text: &str) -> Vec<String> {
    let file = Task::file(text);
    let found = check(file.clone(), &Default::default());
    if let Ok(program) = compile(file, &Default::default()) {
        let task = Task::new();
        let mut thread = task.interpreter.spawn_program(&program);
        let step = thread.resume(Resume::Stop, 0);
        assert!(matches!(step, ResumeOutcome::Stopped), "{step:?}");
    }
    let errors = found.into_iter().filter(|f| f.severity == Severity::Error);
    errors.map(|f| f.message.to_string()).collect()
}

fn nested(form: &(&str, &str, &str, &str, &str), count: usize) -> String {
    let (before, open, inside, close, after) = form;
    let (open, close) = (open.repeat(count), close.repeat(count));
    format!("{before}{open}{inside}{close}{after}\n")
}

#[test]
fn whatever_nests_is_refused_beyond_a_depth() {
    refused(&NESTED[..NESTED.len() / 2]);
}

#[test]
fn whatever_else_nests_is_refused_beyond_a_depth() {
    refused(&NESTED[NESTED.len() / 2..]);
}

fn refused(forms: &[(&str, &str, &str, &str, &str)]) {
    for form in forms {
        let text = nested(form, MANY);
        let errors = errors(&text);
        let is_refused = errors
            .iter()
            .any(|error| error.contains("levels") || error.contains("nest"));
        // Some cannot be nested at all; then the first level is refused already.
        let at_once = !self::errors(&nested(form, 3)).is_empty();
        assert!(is_refused || at_once, "{form:?}: {:?}", errors.first());
    }
}

#[test]
fn long_chains_are_refused_or_have_shallow_trees() {
    for (first, more) in CHAINS {
        errors(&format!("{first}{}\n", more.repeat(LINKS)));
    }
}

#[test]
fn blocks_in_blocks_are_refused_beyond_a_depth() {
    for head in BLOCKS {
        let mut text = String::new();
        for level in 0..2_000 {
            text += &format!("{}{head}\n", " ".repeat(level));
        }
        text += &format!("{}pass\n", " ".repeat(2_000));
        let errors = errors(&text);
        assert!(
            errors.iter().any(|error| error.contains("levels")),
            "{head}: {:?}",
            errors.first()
        );
    }
}

#[test]
fn texts_compiled_by_programs_nest_no_deeper() {
    let text = r#"
forms = ['(' * 30000, '[i for i in ' * 30000 + 'a' + ']' * 30000, '-' * 30000 + '1', 'a' + '.a' * 30000,
         '+'.join(['1'] * 30000), '[*' * 30000 + 'a' + ']' * 30000,
         '{**' * 30000 + 'a' + '}' * 30000, 'f(' * 30000 + ')' * 30000,
         'lambda: ' * 30000 + '1']
for form in forms:
    for run in eval, exec, lambda text: compile(text, 'text', 'eval'):
        try:
            run(form)
            print('ran')
        except (SyntaxError, RecursionError, MemoryError) as e:
            print('refused')
"#;
    assert_eq!(support::run(text), "refused\n".repeat(27));
}
