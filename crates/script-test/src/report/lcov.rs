//! Executed lines as a trace file of lcov (geninfo(1), "FILES"): `SF` a file, `DA` a line and its count, `LF` and `LH`
//! how many there are and how many were executed. Programs that were given as text have no file and are left out.

use std::fmt::Write as _;
use std::path::Path;

use elite_runtime::LineCountsByText;

/// The trace file. Paths are as whole as they can be, so that it can be read from anywhere.
pub fn trace_file(counts: &LineCountsByText) -> String {
    let mut out = String::new();
    for (name, lines) in counts {
        let path = Path::new(name);
        if !path.is_file() {
            continue;
        }
        let whole = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let _ = writeln!(out, "TN:\nSF:{}", whole.display());
        for (line, executed) in lines {
            let _ = writeln!(out, "DA:{line},{executed}");
        }
        let hit = lines.values().filter(|executed| **executed > 0).count();
        let _ = writeln!(out, "LF:{}\nLH:{hit}\nend_of_record", lines.len());
    }
    out
}
