//! `replay --plot OUT.png`: the run as a picture.
//!
//! Owns the file that is written. [`curves`] reads what there is to draw, [`draw`] lays it out, [`canvas`] makes pixels.

mod canvas;
mod curves;
mod draw;

use std::io;
use std::path::{Path, PathBuf};

use recorder::{ReadError, Recording};
use thiserror::Error;

/// Width and height of the picture, pixels.
const SIZE: (u32, u32) = (1600, 1500);

/// Why there is no picture.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PlotError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Nothing to draw.
    #[error("there is nothing to draw: the recording has no cycles")]
    Empty,
    /// The compiled-in font cannot be read, or there is no memory for the picture.
    #[error("the picture cannot be drawn: {0}")]
    Draw(&'static str),
    /// The file cannot be written.
    #[error("cannot write the picture {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// Draws the recording into a PNG file.
///
/// # Errors
/// [`PlotError`].
pub(super) fn plot(recording: &Recording, path: &Path) -> Result<(), PlotError> {
    let curves = curves::read(recording)?;
    let picture = draw::draw(&curves, SIZE)?;
    let written = picture.into_png().map_err(io::Error::other);
    written
        .and_then(|png| std::fs::write(path, png))
        .map_err(|source| PlotError::Write {
            path: path.to_owned(),
            source,
        })
}
