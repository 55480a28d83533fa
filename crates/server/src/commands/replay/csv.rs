//! `replay --csv TOPIC`: a topic as comma-separated values (RFC 4180), one header line, one line a message.

use std::io::{self, Write};

use controller::cell_world::topic;
use recorder::{Recording, TopicTable};

use super::ReplayError;

pub(super) fn print(
    recording: &Recording,
    name: &str,
    out: &mut impl Write,
) -> Result<(), ReplayError> {
    if name.trim_start_matches('/') == topic::TOPIC.trim_start_matches('/') {
        return print_world(recording, out);
    }
    let table = TopicTable::new(recording, name)?;
    line(table.columns().iter().map(String::as_str), out)?;
    for row in table.rows()? {
        let row = row?;
        line(row.iter().map(|cell| cell.as_deref().unwrap_or("")), out)?;
    }
    Ok(())
}

/// `/world`: a row for every part in the first cycle, and for each that moved or changed its holder since.
fn print_world(recording: &Recording, out: &mut impl Write) -> Result<(), ReplayError> {
    // A recording without the topic is told so, with the topics that it has.
    TopicTable::new(recording, topic::TOPIC)?;
    let period = recording.setup().map_or(0.0, |setup| setup.step_time);
    out.write_all(b"cycle,time,name,x,y,z,Rx,Ry,Rz,held_by\n")?;
    for message in topic::messages(recording)? {
        let message = message?;
        let (cycle, time) = (message.cycle.to_string(), message.cycle as f64 * period);
        for part in &message.parts {
            let mut cells = vec![cycle.clone(), time.to_string(), part.name.clone()];
            cells.extend(part.pose.iter().map(|number| rounded(*number).to_string()));
            cells.push(part.held_by.clone().unwrap_or_default());
            line(cells.iter().map(String::as_str), out)?;
        }
    }
    Ok(())
}

/// To a picometre: what rounding leaves of a rotation's zeros says nothing.
fn rounded(number: f64) -> f64 {
    (number * 1e12).round() / 1e12 + 0.0
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

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn what_rounding_leaves_of_zero_is_zero() {
        for (number, text) in [
            (4.336e-17, "0"),
            (-4.336e-17, "0"),
            (-0.0, "0"),
            (0.1, "0.1"),
            (-0.123_456_789_012_345, "-0.123456789012"),
            (-10.000_000_000_001, "-10.000000000001"),
        ] {
            assert_eq!(rounded(number).to_string(), text);
        }
    }
}
