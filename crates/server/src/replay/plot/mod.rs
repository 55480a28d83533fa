//! `replay --plot OUT.png`: the run as a picture.
//!
//! Owns reading the curves out of the recording and writing the file; [`draw`] puts them on paper.

mod curves;
mod draw;

use std::fs::File;
use std::io::{self, BufWriter};
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
    /// The drawing library refused.
    #[error("the picture cannot be drawn: {0}")]
    Draw(String),
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
    let pixels = draw::draw(&curves, SIZE)?;
    write_png(path, &pixels).map_err(|source| PlotError::Write {
        path: path.to_owned(),
        source,
    })
}

fn write_png(path: &Path, rgb: &[u8]) -> io::Result<()> {
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = png::Encoder::new(file, SIZE.0, SIZE.1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    writer.finish()?;
    Ok(())
}
