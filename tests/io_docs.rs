//! docs/IO.md and docs/modbus-map.md are made from the declarations in the code; here they are checked, and with
//! `UPDATE_DOCS=1` written.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fmt::Write as _;
use std::path::Path;

use elite_runtime::builtins::all;
use elite_runtime::builtins::declare::Category;
use io_bus::modbus_server::map::{bit_blocks, blocks};
use io_bus::modbus_server::tables::Space;

/// Chapter, its category, the peer it is tested against, and what a reader should know.
const CHAPTERS: [(&str, Category, &str, &str); 7] = [
    (
        "Inputs and outputs",
        Category::Io,
        "wires of a cell file; pymodbus as client of the controller's own server",
        "Applied once a cycle. While an input with the action \"freedrive\" is high and no motion runs, the arm can be \
         led by hand.",
    ),
    (
        "Registers",
        Category::Register,
        "wires of a cell file; pymodbus as client of the controller's own server",
        "A write is seen by the next read, whoever reads.",
    ),
    (
        "Modbus TCP",
        Category::Modbus,
        "pymodbus as device and as client; silent and talkative sockets",
        "Signals outlive programs. One connection a device; neighbouring signals that are due together share a request \
         until the device refuses that. While there are signals, virtual time keeps wall pace.",
    ),
    (
        "Sockets",
        Category::Socket,
        "Python's socket",
        "Client sockets by name, at most 32 a program.",
    ),
    (
        "Remote calls",
        Category::Rpc,
        "Python's xmlrpc.server",
        "None, bool, int, float, str, bytes, list and dict go both ways; dates arrive as texts. A call ends \
         after 10 s.",
    ),
    (
        "Serial lines",
        Category::Serial,
        "pty; Python's socket behind `tcp:`",
        "A line needs a `[[serial]]` table in the cell file. Without one, and in the wrong mode, reads are empty, \
         writes fail by value and the log says why.",
    ),
    (
        "Modbus RTU",
        Category::ModbusRtu,
        "pymodbus as RTU device behind a pty; damaged answers",
        "Reads that fail give an empty list, writes 0 or False; the log says why.",
    ),
];

/// The ways in that are no function.
const FROM_OUTSIDE: &str = "
## Inputs from outside

An input has the value that was last put on it, whoever did: a `[[wire]]` or `[[input]]` of the cell file, \
RTSI (registers),
a Modbus client (docs/modbus-map.md), or the http port:

```console server numbers=differ
$ curl -s http://127.0.0.1:8080/api/io
$ curl -s -H 'Content-Type: application/json' -d '{\"standard_digital_in[3]\": true, \"standard_analog_in[0]\": 2.5}' \\
       http://127.0.0.1:8080/api/inputs
{\"after_cycle\":1234}
```

Names are those of the cell file. A request sets all of its inputs in the next cycle (registers at once), \
or none and says
why: 422 names the point, what was given and what is allowed. Pages of another origin, forms, and pages that call this
server by a name are turned away (403, 415).
";

fn check(name: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../docs")
        .join(name);
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, text).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == text,
        "docs/{name} is not what the code says; run `UPDATE_DOCS=1 cargo test -p server --test all io_docs::`"
    );
}

#[test]
fn io_page_is_current() {
    let mut page = String::from(
        "# Inputs, outputs, field buses\n\n\
         Made from the declarations in the code (`UPDATE_DOCS=1 cargo test -p server --test all io_docs::`).\n\
         Every function here is implemented and acts on a real image, socket or line. An argument outside its range \
         raises\n\
         an exception that names it, what was given and what is allowed. The tests against peers are in \
         `tests/peers`.\n",
    );
    page.push_str(FROM_OUTSIDE);
    for (title, category, peer, note) in CHAPTERS {
        let _ = write!(
            page,
            "\n## {title}\n\n{note}\n\nTested against: {peer}.\n\n"
        );
        page.push_str("| section | function | returns | may wait |\n|---|---|---|---|\n");
        for builtin in all().filter(|builtin| builtin.category == category) {
            let waits = if builtin.waits { "yes" } else { "" };
            let _ = writeln!(
                page,
                "| {} | `{}` | {} | {waits} |",
                builtin.section,
                builtin.signature(),
                builtin.returns.english().replace('|', "\\|")
            );
        }
    }
    check("IO.md", &page);
}

/// How well a meaning is known.
fn known(sources: Option<u8>) -> &'static str {
    match sources {
        None => "",
        Some(0) => "inferred",
        Some(1) => "one source",
        Some(_) => "yes",
    }
}

#[test]
fn modbus_map_is_current() {
    let mut page = String::from(
        "# The controller's own Modbus TCP server\n\n\
         Made from `io-bus/src/modbus_server/map/`. Port 502, the vendor's, where the user that runs the server may \
         open it, else 5020 with\n\
         a line in the log that says so; `--modbus-port` chooses. Every unit number is this controller; at most 64 \
         clients. Programs see the same\n\
         map with `read_port_bit`, `write_port_bit` (bits 0-127), `read_port_register` and `write_port_register`.\n\n\
         Addresses below 1000 are the vendor's. Its sheet is not public; the column *known* says how well an address \
         is known from the vendor's\n\
         pages, the manual and public programs for real arms: *one source* is good and not certain, *inferred* follows \
         from the rest only. Addresses\n\
         between known ones of which nothing is known read 0. From 1000 on it is our own map.\n\n\
         Values are those of the latest cycle, the same that RTSI sends; what is written to outputs and to the speed \
         slider acts at the beginning of the\n\
         next cycle and is read back at once. The general purpose words hold what programs and clients write, \
         and outlive programs and clients.\n\n\
         - Functions 1 and 2 show the same bits below 1000, functions 3 and 4 the same words everywhere. On the arm \
           the words that only show state\n\
           \x20 (63-110, 384-405, 500) are reported, by one source, to answer function 4 alone, and function 3 with \
           exception 1: a client for both asks by 4.\n\
         - Functions 1, 2, 3, 4, 5, 6, 15, 16, 22, 23; any other: exception 1.\n\
         - Addresses outside, and writes to what only shows something (an output pin of the tool that is an input \
           included): exception 2, nothing is\n  changed.\n\
         - Bad counts, coils that are neither 0000 nor FF00, a speed outside 2 to 100: exception 3. An output that \
         cannot be passed on at the moment: 6.\n\
         - In a program a word that is not there or cannot be written raises `ValueError`. A bit that cannot be \
           switched stays as it is, with a warning:\n\
           \x20 the manual's own example, `write_port_bit(3, True)`, is an input here.\n\n\
         ## Words\n\n| addresses | write | known | meaning |\n|---|---|---|---|\n",
    );
    let span = |first: u16, count: u16| match count {
        1 => first.to_string(),
        _ => format!("{first}-{}", first + count - 1),
    };
    for block in blocks().filter(|block| block.is_known()) {
        let _ = writeln!(
            page,
            "| {} | {} | {} | {} |",
            span(block.first, block.count),
            if block.is_writable() { "yes" } else { "" },
            known(block.sources),
            block.meaning
        );
    }
    let title =
        "\n## Bits\n\n| addresses | functions | write | known | meaning |\n|---|---|---|---|---|\n";
    page.push_str(title);
    for block in bit_blocks().filter(|block| !block.meaning.is_empty()) {
        let functions = match block.space {
            None => "1, 2",
            Some(Space::Outputs) => "1",
            Some(Space::Inputs) => "2",
        };
        let _ = writeln!(
            page,
            "| {} | {functions} | {} | {} | {} |",
            span(block.first, block.count),
            if block.is_writable() { "yes" } else { "" },
            known(block.sources),
            block.meaning
        );
    }
    check("modbus-map.md", &page);
}
