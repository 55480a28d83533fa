//! Text files that people name: cells, calibrations, URDF, configuration, programs beside them.
//!
//! Owns how much of one is read. Knows nothing of what is in it.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

use messages::text;

/// The longest text file that is read: 16 MiB, several times what any of the readers takes. A name may lead to
/// anything, as `/dev/zero`, which never ends.
pub const TEXT_FILE_BYTES_MAX: u64 = 16 << 20;

/// The text of a file.
///
/// # Errors
/// What the system says, that it is larger than [`TEXT_FILE_BYTES_MAX`], or that it is no UTF-8.
pub fn read_text_file(path: &Path) -> Result<String> {
    let bytes = read_small_file(path)?;
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let why = text!(
            "it is no text: its byte {at} is not UTF-8",
            "不是文本：第 {at} 个字节不是 UTF-8"
        );
        Error::new(ErrorKind::InvalidData, why)
    })
}

/// The bytes of a file that is as bounded as a text.
///
/// # Errors
/// What the system says, or that it is larger than [`TEXT_FILE_BYTES_MAX`].
pub fn read_small_file(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut start = File::open(path)?.take(TEXT_FILE_BYTES_MAX + 1);
    start.read_to_end(&mut bytes)?;
    if bytes.len() as u64 > TEXT_FILE_BYTES_MAX {
        let max = TEXT_FILE_BYTES_MAX >> 20;
        let why = text!("it is larger than {max} MiB", "超过 {max} MiB");
        return Err(Error::new(ErrorKind::FileTooLarge, why));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_never_ends_and_what_is_no_text_is_refused_by_name_of_the_trouble() {
        let endless = read_text_file(Path::new("/dev/zero")).unwrap_err();
        assert_eq!(endless.to_string(), "it is larger than 16 MiB");
        let this_program = std::env::current_exe().unwrap();
        let binary = read_text_file(&this_program).unwrap_err().to_string();
        assert!(
            binary.starts_with("it is larger") || binary.starts_with("it is no text: its byte "),
            "{binary}"
        );
        let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        assert!(read_text_file(&here).unwrap().contains("kinematics"));
    }
}
