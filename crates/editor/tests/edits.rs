//! Random edits: after any of them the session answers as one that has opened the text just now.

use proptest::prelude::*;
use serde_json::{Value, json};

use crate::client::{Client, URI};

/// A change: where, as lines and UTF-16 columns which need not exist, and what is written there.
type Change = ((u32, u32), (u32, u32), String);

fn seeds() -> Vec<&'static str> {
    vec![
        "def f(a, b=1):\n    x = [i for i in range(a)]\n    return x\nf(1)\n",
        "class A:\n    位置 = 1\n    def m(self):\n        self.q = \"𝄞\"\na = A()\na.m()\n",
        "sec s():\n    while True:\n        sync()\n    end\nend\n",
        "def f():; if x:; y();end;end;\r\n# c\r\n",
        "try:\n    movej([0, 0, 0, 0, 0, 0])\nexcept Exception as e:\n    print(f\"{e!r}\")\n",
        "",
    ]
}

fn changes() -> impl Strategy<Value = Vec<Change>> {
    let place = (0..9u32, prop_oneof![0..20u32, Just(9999)]);
    let written = prop_oneof![
        Just(String::new()),
        "[a-z(){}\\[\\]:;.,=\"'#$ \n\t\\\\]{0,6}",
        Just("    ".to_owned()),
        Just("\r\n".to_owned()),
        Just("𝄞位".to_owned()),
        Just("def g(".to_owned()),
        Just("\"\"\"".to_owned()),
        Just("movej(".to_owned()),
    ];
    prop::collection::vec((place.clone(), place, written), 1..8)
}

/// The text after a change, worked out on its own: line by line, in units of UTF-16.
fn changed(text: &str, change: &Change) -> String {
    let units: Vec<u16> = text.encode_utf16().collect();
    let offset = |(line, column): (u32, u32)| {
        let (mut at, mut left) = (0, line);
        while left > 0 && at < units.len() {
            let end = units[at] == 10 || units[at] == 13 && units.get(at + 1) != Some(&10);
            left -= u32::from(end);
            at += 1;
        }
        let mut column = if left > 0 { 0 } else { column };
        while column > 0 && at < units.len() && !matches!(units[at], 10 | 13) {
            let pair = (0xd800..0xdc00).contains(&units[at]);
            let width = if pair { 2 } else { 1 };
            if width > column {
                break;
            }
            at += width as usize;
            column -= width;
        }
        at
    };
    let (a, b) = (offset(change.0), offset(change.1));
    let mut result = units[..a.min(b)].to_vec();
    result.extend(change.2.encode_utf16());
    result.extend(&units[a.max(b)..]);
    String::from_utf16(&result).unwrap()
}

/// Everything that can be asked about a text.
fn asked(client: &mut Client, line: u32, character: u32) -> Vec<Value> {
    let mut told = vec![json!(client.findings())];
    for method in [
        "hover",
        "completion",
        "signatureHelp",
        "definition",
        "documentHighlight",
        "prepareRename",
    ] {
        told.push(client.at(&format!("textDocument/{method}"), line, character));
    }
    for method in [
        "documentSymbol",
        "foldingRange",
        "semanticTokens/full",
        "inlayHint",
        "codeAction",
        "formatting",
    ] {
        told.push(client.whole(&format!("textDocument/{method}")));
    }
    told
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn edits_lead_where_a_fresh_look_leads(seed in 0..6usize, edits in changes(), line in 0..9u32,
        character in 0..30u32) {
        let mut text = seeds()[seed].to_owned();
        let mut client = Client::of(&text);
        for (version, change) in edits.iter().enumerate() {
            let place = |(line, character): (u32, u32)| json!({ "line": line, "character": character });
            let event = json!({ "range": { "start": place(change.0), "end": place(change.1) }, "text": change.2 });
            client.note("textDocument/didChange", json!({
                "textDocument": { "uri": URI, "version": version + 2 },
                "contentChanges": [event],
            }));
            text = changed(&text, change);
            client.at("textDocument/completion", line, character);
        }
        let mut fresh = Client::of(&text);
        prop_assert_eq!(asked(&mut client, line, character), asked(&mut fresh, line, character), "{:?}", text);
    }
}
