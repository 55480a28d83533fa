//! Golden texts of what `check` warns about, and programs it must be silent about.

use messages::{Language, Text};

use crate::support;

use elite_syntax::{ArgumentLiteral, CallHint, CallSite, KnownNames, check, render_human};
use support::Task;

/// A robot that moves by numbers up to ten.
fn hook(site: &CallSite<'_>) -> Vec<CallHint> {
    let mut hints = Vec::new();
    for (argument, arg) in site.args.iter().enumerate() {
        let hint = |message: String| CallHint {
            argument: Some(argument),
            code: "too-far",
            message: Text::verbatim(message),
            help: Some(Text::verbatim("move less")),
        };
        match &arg.value {
            ArgumentLiteral::Integer(number) if number.abs() > 10 => {
                let name = arg.name.unwrap_or("distance");
                hints.push(hint(format!("{name} of {number} in {}()", site.function)));
            }
            ArgumentLiteral::Number(number) if number.abs() > 10.0 => {
                let name = arg.name.unwrap_or("distance");
                hints.push(hint(format!("{name} of {number} in {}()", site.function)));
            }
            ArgumentLiteral::List(items) if items.len() > 2 => {
                hints.push(hint(format!("{} numbers", items.len())));
            }
            ArgumentLiteral::CallOf(name) => hints.push(hint(format!("the result of {name}()"))),
            _ => {}
        }
    }
    hints
}

fn findings(text: &str) -> String {
    let file = Task::file(text);
    let known = KnownNames::new(["go", "wait", "sensor"])
        .with_waiting(["go", "wait"])
        .with_call_hook(hook);
    let shown: Vec<String> = check(file.clone(), &known)
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
fn what_is_never_used() {
    insta::assert_snapshot!(show(&[
        "def f():\n    speed = 5\n    total = 1\n    total += 2\n",
        "import math, time as clock\nfrom random import choice\nprint(clock)\n",
        "def f():\n    import json\n    x: int = 3\n",
        "def f():\n    a = b = 1\n    return a\n",
    ]));
}

#[test]
fn modules_that_are_not_there() {
    insta::assert_snapshot!(show(&[
        "import numpy\nprint(numpy)\n",
        "import maht as m, os.nothing\nprint(m, os)\n",
        "import jsn\nprint(jsn)\n",
        "from maths import sin\nprint(sin)\n",
        "from . import near\nprint(near)\n",
        "from ..far import *\n",
        "try:\n    pass\nexcept ValueError:\n    import numpy\n    print(numpy)\n",
    ]));
}

#[test]
fn what_is_never_reached() {
    insta::assert_snapshot!(show(&[
        "def f():\n    return 1\n    print('no')\n",
        "for i in range(3):\n    continue\n    if i:\n        print(i)\n",
        "while True:\n    wait(1)\nprint('never')\n",
        "def f(x):\n    if x:\n        return 1\n    else:\n        raise ValueError\n    x = 2\n    return x\n",
        "def f():\n    try:\n        return 1\n    finally:\n        print(1)\n    print(2)\n",
    ]));
}

#[test]
fn loops_that_never_wait() {
    insta::assert_snapshot!(show(&[
        "while True: pass",
        "while not sensor(): pass",
        "while True:\n    if sensor() > 3:\n        break\n",
        "def f():\n    n = 0\n    while 1:\n        n += 1\n        print(n)\n",
        // A wait, but not on every way.
        "while True:\n    if sensor() > 3:\n        go(1)\n",
        "while True:\n    if sensor() > 3: go(1)\n    elif sensor() > 2: wait(1)\n    else: print('low')\n",
        "while True:\n    if sensor() > 3: continue\n    go(1)\n",
        "while True:\n    if sensor() > 3:\n        if sensor() > 4: continue\n        wait(1)\n    else: wait(2)\n",
    ]));
}

#[test]
fn loops_that_wait_on_every_way() {
    for text in [
        "while True:\n    if sensor() > 3: go(1)\n    else: wait(1)\n",
        "while True:\n    if sensor() > 3: go(1)\n    wait(1)\n",
        "while True:\n    if sensor() > 3:\n        wait(1)\n        continue\n    go(1)\n",
        // It can be left.
        "while True:\n    if sensor() > 3: go(1)\n    elif sensor() > 2: break\n",
        // Functions and methods of the program, and loops within, may wait.
        "def rest(): wait(1)\nwhile True:\n    rest()\n    if sensor() > 3: go(1)\n",
        "import time\nwhile True:\n    if sensor() > 3: go(1)\n    time.sleep(0.1)\n",
        "while True:\n    while sensor() < 3: wait(0.1)\n    print('high')\n",
        "while True:\n    for i in range(3): go(i)\n",
        "while True:\n    try:\n        go(1)\n    except ValueError: pass\n",
        "while True:\n    if go(1): print(1)\n",
        "def f():\n    while True:\n        if sensor() > 3: go(1)\n        else: return\n",
        "def f():\n    while True:\n        if sensor() > 3: yield 1\n        else: wait(1)\n",
    ] {
        assert_eq!(findings(text), "", "{text}");
    }
}

#[test]
fn what_the_embedder_says_about_calls() {
    insta::assert_snapshot!(show(&[
        "go(11)",
        "go(1, far=-20.5)",
        "x = [go([1, 2, 3]) for _ in range(2)]",
        "def f(d=go(sensor())):\n    return f'{go(99)}'\n",
    ]));
}

#[test]
fn programs_in_order_get_no_warnings() {
    for text in [
        "def f():\n    a, b = 1, 2\n    for i in range(3): pass\n    _c = 5\n    with a as d: pass\n    return b\n",
        "def f():\n    x = 1\n    def g(): return x\n    return g\n",
        "def f():\n    x = 1\n    def g():\n        nonlocal x\n        x = 2\n    g()\n    return x\n",
        "def f():\n    global shared\n    shared = 1\n",
        "def f():\n    x = 1\n    return eval('x')\n",
        "def f():\n    x = 1\n    return [x for _ in range(2)], {x: 1 for _ in range(1)}\n",
        "def f():\n    import math\n    return math.pi\n",
        "import math\ndef f(): return math.pi\n",
        "import os.path, collections.abc, _thread, __main__, builtins\n\
         print(os, collections, _thread, __main__, builtins)\n",
        "try:\n    import numpy\nexcept ImportError:\n    numpy = None\nprint(numpy)\n",
        "try:\n    if sensor():\n        from . import a\nexcept (ValueError, Exception):\n    a = None\nprint(a)\n",
        "try:\n    import numpy\nexcept:\n    numpy = None\nprint(numpy)\n",
        "class A:\n    x = 1\n    def f(self):\n        return 1\n",
        "def g():\n    return\n    yield\n",
        "while True:\n    wait(1)\n",
        "while True:\n    if sensor(): break\n    wait(1)\nprint('reached')\n",
        "n = 5\nwhile n:\n    n -= 1\n",
        "n = 5\nwhile True:\n    n -= 1\n    if n == 0: break\n",
        "def f(q):\n    while True:\n        q.get()\n",
        "def tick(): wait(1)\nwhile True:\n    tick()\n",
        "def f():\n    while True:\n        yield 1\n",
        "def f():\n    while True:\n        try:\n            return 1\n        except ValueError:\
         \n            wait(1)\n",
        "go(5, near=1)\nother = go\nother(99)\n",
        "if sensor():\n    raise ValueError\nelse:\n    print(1)\nprint(2)\n",
    ] {
        assert_eq!(findings(text), "", "{text}");
    }
}
