//! docs/IO.md and docs/modbus-map.md are made from the declarations in the code; here they are checked, and with
//! `UPDATE_DOCS=1` written.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fmt::Write as _;
use std::path::Path;

use elite_runtime::builtins::all;
use elite_runtime::builtins::declare::Category;
use io_bus::modbus_server::state_map::{BIT_BLOCKS, BLOCKS};

/// Chapter, its category, the peer it is tested against, and what a reader should know.
const CHAPTERS: [(&str, Category, &str, &str); 7] = [
    (
        "Inputs and outputs",
        Category::Io,
        "wires of a cell file; pymodbus as client of the controller's own server",
        "Applied once a cycle. While an input with the action \"freedrive\" is high and no motion runs, the arm can be led by hand.",
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
        "Signals outlive programs. One connection a device; neighbouring signals that are due together share a request until the device refuses that. While there are signals, virtual time keeps wall pace.",
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
        "None, bool, int, float, str, bytes, list and dict go both ways; dates arrive as texts. A call ends after 10 s.",
    ),
    (
        "Serial lines",
        Category::Serial,
        "pty; Python's socket behind `tcp:`",
        "A line needs a `[[serial]]` table in the cell file. Without one, and in the wrong mode, reads are empty, writes fail by value and the log says why.",
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

An input has the value that was last put on it, whoever did: a `[[wire]]` or `[[input]]` of the cell file, RTSI (registers),
a Modbus client (docs/modbus-map.md), or the http port:

```console server numbers=differ
$ curl -s http://127.0.0.1:8080/api/io
$ curl -s -H 'Content-Type: application/json' -d '{\"standard_digital_in[3]\": true, \"standard_analog_in[0]\": 2.5}' \\
       http://127.0.0.1:8080/api/inputs
{\"after_cycle\":1234}
```

Names are those of the cell file. A request sets all of its inputs in the next cycle (registers at once), or none and says
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
        "# Inputs, outputs, field buses\n\nMade from the declarations in the code (`UPDATE_DOCS=1 cargo test -p server --test all io_docs::`).\n\
         Every function here is implemented and acts on a real image, socket or line. An argument outside its range raises\n\
         an exception that names it, what was given and what is allowed. The tests against peers are in `tests/peers`.\n",
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
                builtin.returns.replace('|', "\\|")
            );
        }
    }
    check("IO.md", &page);
}

#[test]
fn modbus_map_is_current() {
    let mut page = String::from(
        "# The controller's own Modbus TCP server\n\nMade from `io-bus/src/modbus_server/state_map.rs`. Port 5020 unless `--modbus-port` says otherwise; every unit number is\n\
         this controller; at most 64 clients. Coils 0-127 and holding registers 0-255 are what `read_port_bit`,\n\
         `write_port_bit`, `read_port_register` and `write_port_register` see. The tables below are our own map; the vendor's is\n\
         not public. Addresses that are in no table: exception 2; unknown functions: 1; bad counts: 3; an output that\n\
         cannot be passed on at the moment: 6.\n\n## Holding registers (functions 3, 6, 16, 22) and, the same, input registers (4)\n\n\
         | addresses | write | meaning |\n|---|---|---|\n| 0-255 | yes | free, shared with scripts (holding registers only; also function 23) |\n",
    );
    let span = |first: u16, count: u16| match count {
        1 => first.to_string(),
        _ => format!("{first}-{}", first + count - 1),
    };
    for block in BLOCKS {
        let write = if block.is_writable { "yes" } else { "" };
        let _ = writeln!(
            page,
            "| {} | {write} | {} |",
            span(block.first, block.count),
            block.meaning
        );
    }
    for (title, is_coil) in [
        ("Coils (functions 1, 5, 15)", true),
        ("Discrete inputs (function 2)", false),
    ] {
        let _ = write!(page, "\n## {title}\n\n| addresses | meaning |\n|---|---|\n");
        if is_coil {
            page.push_str("| 0-127 | free, shared with scripts |\n");
        }
        for block in BIT_BLOCKS.iter().filter(|block| block.is_coil == is_coil) {
            let _ = writeln!(
                page,
                "| {} | {} |",
                span(block.first, block.count),
                block.meaning
            );
        }
    }
    check("modbus-map.md", &page);
}
