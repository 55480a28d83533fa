//! docs/RTSI.md is made from the declarations in the code; here it is checked, and with `UPDATE_DOCS=1` written. The
//! client tests (tests/clients/test_rtsi.py) read it: a variable without a row in their table fails them.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fmt::Write as _;
use std::ops::Range;
use std::path::Path;

use server::ports::rtsi::inputs::InputVariable;
use server::ports::rtsi::outputs::OutputVariable;
use wire::rtsi::RtsiType;

const HEAD: &str = "# Variables of RTSI (port 30004)

Made from the code by `UPDATE_DOCS=1 cargo test -p server --test all rtsi_docs::`. Every variable has a row in the \
table of
`tests/clients/test_rtsi.py`, which sets it from the arm, a script or a client and reads it back through a socket.
";

fn table(
    out: &mut String,
    named: impl Iterator<Item = (&'static str, RtsiType)>,
    numbered: impl Iterator<Item = (&'static str, Range<u8>, RtsiType)>,
) {
    out.push_str("\n| variable | type |\n|---|---|\n");
    for (name, kind) in named {
        writeln!(out, "| `{name}` | {} |", kind.name()).unwrap();
    }
    for (group, numbers, kind) in numbered {
        let (first, last) = (numbers.start, numbers.end - 1);
        writeln!(
            out,
            "| `{group}{first}` to `{group}{last}` | {} |",
            kind.name()
        )
        .unwrap();
    }
}

fn page() -> String {
    let mut page = HEAD.to_owned();
    page.push_str("\n## Outputs: what clients read\n");
    table(
        &mut page,
        OutputVariable::named().map(|(name, output)| (name, output.kind())),
        OutputVariable::numbered().map(|(group, numbers, first)| (group, numbers, first.kind())),
    );
    page.push_str("\n## Inputs: what clients write\n");
    table(
        &mut page,
        InputVariable::named().map(|(name, input)| (name, input.kind())),
        InputVariable::numbered().map(|(group, numbers, first)| (group, numbers, first.kind())),
    );
    page
}

#[test]
fn the_page_of_variables_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/RTSI.md");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, page()).unwrap();
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == page(),
        "docs/RTSI.md is not what the code says: run this test with UPDATE_DOCS=1"
    );
}

#[test]
fn every_name_of_the_page_is_found_by_that_name() {
    for (name, output) in OutputVariable::named() {
        assert_eq!(OutputVariable::by_name(name).unwrap().kind(), output.kind());
    }
    for (group, numbers, first) in OutputVariable::numbered() {
        for number in numbers {
            let found = OutputVariable::by_name(&format!("{group}{number}")).unwrap();
            assert_eq!(found.kind(), first.kind());
        }
    }
    for (name, input) in InputVariable::named() {
        assert_eq!(
            (InputVariable::by_name(name), input.name()),
            (Some(input), name.to_owned())
        );
    }
    for (group, numbers, first) in InputVariable::numbered() {
        for number in numbers {
            let name = format!("{group}{number}");
            let found = InputVariable::by_name(&name).unwrap();
            assert_eq!((found.kind(), found.name()), (first.kind(), name));
        }
    }
}

#[test]
fn scripts_can_watch_every_input_and_nothing_else() {
    use elite_runtime::panel::is_rtsi_input;
    let numbered = |(group, numbers, _): (&'static str, Range<u8>, InputVariable)| {
        numbers.map(move |number| format!("{group}{number}"))
    };
    let named = InputVariable::named().map(|(name, _)| name.to_owned());
    for name in named.chain(InputVariable::numbered().flat_map(numbered)) {
        assert!(is_rtsi_input(&name), "{name}");
    }
    for (name, _) in OutputVariable::named() {
        assert_eq!(
            is_rtsi_input(name),
            InputVariable::by_name(name).is_some(),
            "{name}"
        );
    }
    for name in [
        "input_int_register48",
        "input_bit_register63",
        "output_int_register0",
        "rtsi",
    ] {
        assert!(!is_rtsi_input(name), "{name}");
    }
}
