//! Half-typed lines: they spoil nothing else.

use crate::client::Client;

/// A line that is being typed in the middle of a program whose other names must still be known.
fn around(line: &str) -> Client {
    let text = format!(
        "def before(alpha):\n    return alpha\n{line}\nclass After:\n    def method(self):\n        beta = before(1)\
         \n        \n        return beta\nlast = After()\n"
    );
    Client::of(&text)
}

#[test]
fn the_rest_of_the_program_stays_known() {
    let halves = [
        "x = ",
        "x.",
        "movej(",
        "movej([1, 2",
        "if x",
        "if x.:",
        "while",
        "for i in",
        "for",
        "def g(",
        "def g(a, b",
        "def",
        "class",
        "class C(",
        "@",
        "return",
        "x = \"abc",
        "else:",
        "import",
        "from math import",
        "try:",
        "with open(",
        "lambda",
        "f\"{x",
        "$ ",
        "x = {1: ",
        "print x y",
        "\\",
        "raise from",
        "global",
        "((((",
        "))))",
        "del",
        "elif x:",
        "x += ",
        "a = b = ",
        "not",
        "[i for i in",
        "end",
        "sec",
        "sec f(",
    ];
    for half in halves {
        let mut client = around(half);
        let symbols = client.whole("textDocument/documentSymbol").to_string();
        for name in ["before", "After", "method", "last"] {
            assert!(
                symbols.contains(&format!("\"{name}\"")),
                "{half:?}: {name} is gone"
            );
        }
        let inside = client.completions(6, 8);
        assert!(inside.contains(&"beta".to_owned()), "{half:?}: {inside:?}");
        let attributes = client.at("textDocument/definition", 8, 8);
        assert_eq!(attributes[0]["range"]["start"]["line"], 3, "{half:?}");
    }
}

#[test]
fn blocks_below_a_broken_header_are_read() {
    let mut client = Client::of(
        "def f(a, b\n    gamma = a\n    \nclass D(:\n    def m(self):\n        self.delta = 1\n",
    );
    let inside = client.completions(2, 4);
    assert!(
        inside.contains(&"gamma".to_owned()) && inside.contains(&"b".to_owned()),
        "{inside:?}"
    );
    assert_eq!(
        client.at("textDocument/definition", 5, 14)[0]["range"]["start"]["line"],
        5
    );
}
