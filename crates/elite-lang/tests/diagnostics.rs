//! Golden texts of what people read: findings in program text, and reports of uncaught exceptions.

use messages::Language;

use crate::support;

use elite_syntax::{KnownNames, check, compile, render_human};
use support::{Task, run};

/// All findings of a text, rendered.
fn findings(text: &str) -> String {
    let file = Task::file(text);
    let known = KnownNames::new(["movej", "movel", "get_actual_joint_positions", "textmsg"]);
    let found = check(file.clone(), &known);
    let shown: Vec<String> = found
        .iter()
        .map(|finding| render_human(finding, &file, Language::English, false))
        .collect();
    shown.join("\n")
}

fn show(cases: &[&str]) -> String {
    let shown: Vec<String> = cases
        .iter()
        .map(|case| format!("--- {case:?}\n{}", findings(case)))
        .collect();
    shown.join("\n")
}

#[test]
fn several_errors_are_reported_in_one_go() {
    insta::assert_snapshot!(findings(
        "x = (1, 2\ny = 3 +\nif x = 3:\n    z = = 4\n    print('ok')\nfor i in range(3)\n    pass\n\
         w = 'open\nreturn 5\n"
    ));
}

#[test]
fn a_header_that_does_not_parse_takes_its_clauses_and_its_end_along() {
    insta::assert_snapshot!(findings(
        "def pick(height, speed=0.2)\n    x = 1\nend\nif x == 1\n    y = 1\nelif x == 2:\n    y = = 2\n\
         else:\n    y = 3\nend\ntry\n    z = 1\nexcept ValueError:\n    z = 2\nfinally:\n    z = 3\nlast = )\nend\n"
    ));
}

#[test]
fn places_are_whole_characters_in_every_script() {
    let deep = format!("位{}", "(位".repeat(150));
    let wide = format!("x = 位{}", " + 位".repeat(2000));
    for text in [
        "def h():\n    z = 1\n 一  exec(z)\n",
        "x = 4j一一\n",
        &deep,
        &wide,
    ] {
        let file = Task::file(text);
        let found = check(file.clone(), &KnownNames::new(["位"]));
        assert!(!found.is_empty(), "{text}");
        for finding in found {
            let (start, end) = (finding.span.start as usize, finding.span.end as usize);
            assert!(text.get(start..end).is_some(), "{finding:?}");
            assert!(
                render_human(&finding, &file, Language::English, false)
                    .contains(finding.message.english())
            );
        }
    }
}

#[test]
fn errors_in_expressions() {
    insta::assert_snapshot!(show(&[
        "x = ",
        "x = 1 +",
        "x = (1 + 2",
        "x = [1, 2",
        "x = {'a': 1, 'b'}",
        "x = 1 2",
        "x = f(a b)",
        "x = f(1, a=2, 3)",
        "x = f(a=1, a=2)",
        "x = f(**a, *b, c)",
        "x = a if b",
        "x = lambda: ",
        "x = [i for i in]",
        "x = [*a for a in b]",
        "x = f(i for i in a, 2)",
        "x = 012",
        "x = 1abc",
        "x = 'a' b'c'",
        "x = \"\\x1\"",
        "x = '\\ud800'",
        "x = f'{a'",
        "x = f'{}'",
        "x = f'{a!z}'",
        "x = f'}'",
        "x = a.1",
        "x = a..b",
        "x = not",
        "x = )",
        "x = (1]",
        "x = yield 1",
        "x ? 1 : 2",
        "x = a && b",
        "x = （1）",
        "print（'a'）",
        "x = *a",
    ]));
}

#[test]
fn errors_in_statements() {
    insta::assert_snapshot!(show(&[
        "1 = x",
        "f() = 1",
        "a + b = 1",
        "x += y = 1",
        "(a, b) += 1",
        "*a = 1",
        "*a, *b = c",
        "del f()",
        "del 1",
        "for 1 in a: pass",
        "break",
        "continue",
        "return 1",
        "if x",
        "if x: if y: pass",
        "if x:\npass",
        "else: pass",
        "try:\n    pass\n",
        "try:\n    pass\nexcept:\n    pass\nexcept A:\n    pass\n",
        "try:\n    pass\nexcept A, B:\n    pass\n",
        "def f(a, a): pass",
        "def f(a=1, b): pass",
        "def f(*): pass",
        "def f(**k, a): pass",
        "def f(/, a): pass",
        "def if(): pass",
        "class 5: pass",
        "class A\n    pass",
        "import",
        "from a import",
        "from . import a",
        "global",
        "x y",
        "elseif x: pass",
        "function f(): pass",
        "whlie x > 0: pass",
        "retrun x",
        "prnit x",
        "pose p",
        "let x = 1",
        "raise",
        "assert",
        "with a as 1: pass",
        "@5\nx = 1",
        "  x = 1",
        "if a:\n    b\n  c\n",
        "x = 1\n    y = 2\n",
        "try: pass\nexcept*: pass",
        "try: pass\nexcept* A: pass\nexcept B: pass",
        "def f():\n    try: pass\n    except* A: return 1",
    ]));
}

#[test]
fn what_is_not_supported_says_so() {
    insta::assert_snapshot!(show(&[
        "async def f(): pass",
        "await x",
        "x = await y",
        "match x:\n    case 1: pass\n",
        "type X = int",
        "x = [i async for i in a]",
    ]));
}

#[test]
fn errors_about_end_and_sec() {
    insta::assert_snapshot!(show(&[
        "end",
        "x = 1\nend",
        "if a:\n    b()\nend\nelse:\n    c()\nend",
        "while a:\n    b()\n    end\n    c()\n",
        "def f():\n    pass\nend\nend",
        "sec f(a):\n    pass\nend",
        "x = 1\nsec f():\n    pass\nend",
        "def f():;a();b();end;end;",
    ]));
}

#[test]
fn errors_about_scopes() {
    insta::assert_snapshot!(show(&[
        "def f():\n    x = 1\n    global x\n",
        "def f(x):\n    global x\n",
        "def f():\n    print(x)\n    nonlocal x\n",
        "nonlocal x",
        "def f():\n    nonlocal nowhere\n    nowhere = 1\n",
        "def f():\n    global x\n    nonlocal x\n",
        "[x := 1 for x in a]",
        "class A:\n    [y := 1 for x in a]\n",
        "def f(): return [(yield x) for x in a]",
    ]));
}

#[test]
fn undefined_names_are_findings_with_a_suggestion() {
    insta::assert_snapshot!(findings(
        "speed = 0.5\ndef main():\n    mvoej([0, 0, 0, 0, 0, 0], v=speeed)\n    q = get_actual_joint_position()\n    \
         textmsg(q, nothing_like_it)\n    prnt(q)\n    retrun = 1\n    return retrn\n"
    ));
    assert_eq!(findings("from math import *\nx = sin(1)\n"), "");
    assert_eq!(
        findings("def f():\n    global made\n    made = 1\ndef g(): return made\nx = __name__\n"),
        ""
    );
    assert_eq!(
        findings("class A:\n    x = 1\n    y = x\n    def f(self): return __class__\n"),
        ""
    );
}

#[test]
fn indentation_that_mixes_blanks_and_tabs_warns() {
    insta::assert_snapshot!(findings("if True:\n    \tx = 1\n  \ty = 2\n"));
}

#[test]
fn places_count_characters_and_the_end_is_exclusive() {
    let file = Task::file("位置 = 1\n名 = 位置 + 未知\n");
    let found = check(file.clone(), &KnownNames::default());
    let fields = found[0].fields(&file);
    let place = (
        fields.line,
        fields.column,
        fields.end_line,
        fields.end_column,
    );
    assert_eq!((fields.code, place), ("undefined-name", (2, 10, 2, 12)));
    assert_eq!(fields.file, "test.script");
}

#[test]
fn warnings_do_not_keep_a_program_from_running() {
    let program = compile(Task::file("if False: unknown()\n"), &KnownNames::default()).unwrap();
    assert_eq!(program.warnings().len(), 1);
}

#[test]
fn nesting_has_a_limit() {
    let deep = |n: usize| format!("x = {}1{}", "(".repeat(n), ")".repeat(n));
    assert_eq!(findings(&deep(150)), "");
    assert!(findings(&deep(5000)).contains("this nests deeper than 200 levels"));
    let blocks: String = (0..300)
        .map(|n| format!("{}if x:\n", " ".repeat(n)))
        .collect();
    assert!(findings(&blocks).contains("this nests deeper than 200 levels"));
    let chain = |n: usize| format!("x = 1{}", "+1".repeat(n));
    assert_eq!(findings(&chain(900)), "");
    assert!(findings(&chain(5000)).contains("this expression is deeper than 1000 levels"));
    assert!(
        findings(&format!("x = a{}", ".b".repeat(5000)))
            .contains("this expression is deeper than 1000 levels")
    );
    assert!(
        findings(&format!("x = {}1", "-".repeat(5000)))
            .contains("this nests deeper than 200 levels")
    );
    assert!(
        findings(&format!("x = {}1", "not ".repeat(5000)))
            .contains("this nests deeper than 200 levels")
    );
    assert!(
        findings(&format!("x = {}1", "2**".repeat(5000)))
            .contains("this nests deeper than 200 levels")
    );
    assert!(
        findings(&format!("x = {}1", "lambda: ".repeat(5000)))
            .contains("this nests deeper than 200 levels")
    );
}

#[test]
fn an_uncaught_exception_is_reported_with_carets_and_the_call_stack() {
    insta::assert_snapshot!(run(
        "def ratio(a, b):\n\treturn 1 + a / b\n\nclass Arm:\n    def move(self, pose):\n        for v in pose:\
         \n            \
         self.last = ratio(v, pose[0] - 0.5)\n\ndef main():\n    arm = Arm()\n    arm.move([0.5, 1, 2])\n\nmain()\n"
    ));
}

#[test]
fn chained_exceptions_are_reported_in_order() {
    insta::assert_snapshot!(run(
        "def a():\n    try:\n        {}['位置']\n    except KeyError as e:\n        raise ValueError('no pose') from e\n\
         try:\n    a()\nexcept ValueError:\n    undefined + 1\n"
    ));
}

#[test]
fn errors_point_at_the_exact_expression() {
    let cases = [
        "x = [1, 2]\ny = x[0] + x[5] * 2",
        "print(1, undefined, 2)",
        "x = {'a': {'b': 1}}\nprint(x['a']['c'])",
        "class A: pass\nA().b.c",
        "def f(a): return a\nprint(f(1), f())",
        "[i / 0 for i in range(3)]",
        "print(f'{1 + 1} {undefined!r:>10}')",
        "x = 'a'\nx += 1",
        "for i in 5: pass",
        "a, b = 1, 2, 3",
        "del nothing",
        "assert 1 == 2, 'numbers'",
        "import nowhere",
        "with 5 as x: pass",
        "x = 5\nx.y = 1",
        "def g():\n    yield 1\n    yield 1 / 0\nlist(g())",
        "sorted([1, 'a'])",
        "(lambda: 1 / 0)()",
        "class A:\n    x = undefined\n",
        "if 1 < 'a': pass",
        "def f(x=undefined): pass",
        "raise KeyError('k')",
        "x = [3, 1]\nx.sort(key=lambda v: v.foo)",
        "f'{3:q}'",
        "x = 1\nx()",
        "not_a_function = None\nnot_a_function(1,\n  2)",
    ];
    let shown: Vec<String> = cases.iter().map(|case| run(case)).collect();
    insta::assert_snapshot!(shown.join("\n"));
}

#[test]
fn functions_of_modules_are_named_with_their_module() {
    let calls = [
        "math.sqrt(1, 2)",
        "math.sqrt(x=1)",
        "math.atan2(1)",
        "math.ldexp(1, 2.5)",
        "time.sleep()",
        "time.monotonic(1)",
        "math.sin(*[1], **{1: 2})",
        "[].append()",
        "len(1, 2)",
    ];
    let shown = calls.map(|call| support::last_line(&format!("import math, time\n{call}\n")));
    insta::assert_snapshot!(shown.join("\n"));
}

#[test]
fn the_last_line_is_always_type_and_message() {
    for (text, last) in [
        (
            "speed = 1\nspeeed",
            "NameError: name 'speeed' is not defined",
        ),
        (
            "def f(a): pass\nf()",
            "TypeError: f() missing 1 required positional argument: 'a'",
        ),
        (
            "try: lenn([])\nexcept NameError: [].appendd(1)",
            "AttributeError: 'list' object has no attribute 'appendd'",
        ),
        ("assert False", "AssertionError"),
    ] {
        let report = run(text);
        assert_eq!(report.lines().last(), Some(last), "{report}");
    }
    assert!(run("speed = 1\nspeeed").contains("help: did you mean 'speed'"));
}

#[test]
fn a_deep_call_stack_is_shortened() {
    let report = run("def f(n):\n    return f(n + 1)\nf(0)\n");
    assert!(report.contains("more levels"), "{report}");
    assert!(report.lines().count() < 100);
    assert!(report.ends_with("RecursionError: maximum recursion depth exceeded\n"));
}

#[test]
fn reports_advise_on_names_and_calls() {
    use elite_lang::{NativeFunction, Param, Value};
    let movej = NativeFunction {
        name: "movej",
        params: vec![
            Param::required("q"),
            Param::optional("a"),
            Param::optional("v"),
        ],
        call: elite_lang::NativeBody::new(|_| Ok(Value::None)),
    };
    let cases = [
        "speed = 1\nprint(sped)",
        "def f(count): return cuont\nf(1)",
        "x = [1]\nx.apend(2)",
        "class Arm:\n    def __init__(self): self.position = 1\n    def move(self): pass\nArm().postion",
        "class Arm:\n    def move(self): pass\nArm().moev()",
        "prnt('a')",
        "movj([0])",
        "def f(a, b=2, *, c, d=[1, 2, 3], **k): pass\nf()",
        "def f(a, b=2): pass\nf(1, 2, 3)",
        "def f(a, /, b, *rest): pass\nf(1, c=2)",
        "def f(text='a rather long default value'): pass\nf(1, 2)",
        "movej()",
        "movej([0], 1, 2, 3)",
        "movej([0], speed=1)",
        "class A:\n    def __init__(self, x): pass\nA()",
        "nothing_like_anything",
        "'abc'.uper()",
        "{}.itmes()",
        "None.foo",
        "len()",
    ];
    let shown: Vec<String> = cases
        .iter()
        .map(|case| Task::with(vec![movej.clone()], Default::default()).run(case))
        .collect();
    insta::assert_snapshot!(shown.join("\n"));
}

#[test]
fn directives_that_cannot_be_read_say_so_once_on_their_line() {
    for (directive, message) in [
        (
            "$ LINE: (7, \"a\"",
            "expected ')', found the end of the line",
        ),
        ("$ LINE: (7, \"a)", "this string is never closed"),
        (
            "$ LINE: (7, [",
            "expected an expression, found the end of the line",
        ),
        (
            "$ LINE: (7, \"a\") x",
            "expected the end of the expression, found 'x'",
        ),
    ] {
        let text = format!("def main():\n    x = 1\n    {directive}\n    print(x)\nend\n");
        let file = elite_syntax::SourceFile::new("a.script", text.as_str());
        let found = elite_syntax::check(file.clone(), &elite_syntax::KnownNames::default());
        let shown: Vec<String> = found
            .iter()
            .map(|finding| elite_syntax::render_human(finding, &file, Language::English, false))
            .collect();
        assert_eq!(found.len(), 1, "{shown:?}");
        assert_eq!(found[0].message, message);
        assert_eq!(found[0].code, "directive");
        assert!(
            shown[0].contains("a.script:3:") && shown[0].contains("help: write '$ LINE"),
            "{shown:?}"
        );
    }
}

#[test]
fn async_and_await_are_names_where_nothing_says_otherwise() {
    let program = "\
async = 1
await = [2]
class Task:
    def await(self, async=3): return async
def async_(await): return await
print(async, await[0], Task().await(), Task().await(async=4), async_(5), -await[0])
for async in await: print(async)
await.append(async)
print(await, async in await)
";
    assert_eq!(
        crate::support::run(program),
        "1 2 3 4 5 -2\n2\n[2, 2] True\n"
    );
    for (text, what) in [
        ("async def f(): pass", "'async'"),
        ("x = [i async for i in y]", "'async'"),
        ("x = await f()", "'await'"),
        ("await 1", "'await'"),
    ] {
        let file = elite_syntax::SourceFile::new("a.script", text);
        let found = elite_syntax::check(file, &elite_syntax::KnownNames::default());
        assert!(
            found
                .iter()
                .any(|finding| finding.message.english().contains(what)),
            "{text}: {found:?}"
        );
    }
}
