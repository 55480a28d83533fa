//! Packs the font of the pictures: what draws letters of it, compressed. As it is it would be a twentieth of the
//! program.

use std::io::Write as _;
use std::ops::Range;
use std::path::PathBuf;
use std::{env, fs};

use flate2::Compression;
use flate2::write::ZlibEncoder;

/// The tables that `plot::canvas` reads. Names, and what other scripts and coarse screens need, become zeros.
const READ: [&[u8]; 9] = [
    b"OS/2", b"cmap", b"glyf", b"head", b"hhea", b"hmtx", b"kern", b"loca", b"maxp",
];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    for (name, font) in [
        ("regular.font", dejavu::sans::regular()),
        ("bold.font", dejavu::sans::bold()),
    ] {
        let mut font = font.to_vec();
        strip(&mut font).unwrap_or_else(|| panic!("{name}: no TrueType font as expected"));
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
        encoder
            .write_all(&font)
            .and_then(|()| encoder.finish())
            .and_then(|packed| fs::write(out.join(name), packed))
            .unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

/// Sets to zero what draws no letter: whole tables, and the instructions of letters for coarse screens.
fn strip(font: &mut [u8]) -> Option<()> {
    let (mut letters, mut places, mut long) = (0..0, 0..0, false);
    for entry in 0..number(font, 4, 2)? {
        let entry = 12 + 16 * entry;
        let name = font.get(entry..entry + 4)?.to_vec();
        let start = number(font, entry + 8, 4)?;
        let table = start..start + number(font, entry + 12, 4)?;
        match name.as_slice() {
            b"glyf" => letters = table,
            b"loca" => places = table,
            b"head" => long = number(font, start + 50, 2)? == 1,
            name if READ.contains(&name) => {}
            _ => font.get_mut(table)?.fill(0),
        }
    }
    if !long || letters.is_empty() {
        return None;
    }
    for place in places.step_by(4).collect::<Vec<_>>().windows(2) {
        let [from, to] = [number(font, place[0], 4)?, number(font, place[1], 4)?];
        let letter = letters.start + from;
        // A letter made of others, whose count of lines is negative, has next to no instructions.
        if from < to && number(font, letter, 2)? < 0x8000 {
            let length = letter + 10 + 2 * number(font, letter, 2)?;
            let instructions: Range<usize> = length + 2..length + 2 + number(font, length, 2)?;
            font.get_mut(instructions)?.fill(0);
        }
    }
    Some(())
}

fn number(font: &[u8], at: usize, bytes: usize) -> Option<usize> {
    let digits = font.get(at..at + bytes)?.iter();
    Some(digits.fold(0, |number, &byte| number << 8 | usize::from(byte)))
}
