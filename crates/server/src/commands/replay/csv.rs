//! `replay --csv TOPIC`: a topic as comma-separated values (RFC 4180), one header line, one line a message.

use std::io::{self, Write};

use recorder::{Recording, TopicTable};

use super::ReplayError;

pub(super) fn print(
    recording: &Recording,
    topic: &str,
    out: &mut impl Write,
) -> Result<(), ReplayError> {
    let table = TopicTable::new(recording, topic)?;
    line(table.columns().iter().map(String::as_str), out)?;
    for row in table.rows()? {
        let row = row?;
        line(row.iter().map(|cell| cell.as_deref().unwrap_or("")), out)?;
    }
    Ok(())
}

fn line<'a>(cells: impl Iterator<Item = &'a str>, out: &mut impl Write) -> io::Result<()> {
    for (i, cell) in cells.enumerate() {
        if i > 0 {
            out.write_all(b",")?;
        }
        if cell.contains([',', '"', '\n', '\r']) {
            write!(out, "\"{}\"", cell.replace('"', "\"\""))?;
        } else {
            out.write_all(cell.as_bytes())?;
        }
    }
    out.write_all(b"\n")
}
