//! Lines and letters as smooth pixels.
//!
//! Owns the picture and the font, which is compiled in: no font of the system is needed. Places are in pixels from the
//! top left corner.

use std::io::Read as _;
use std::sync::LazyLock;

use flate2::read::ZlibDecoder;
use messages::text;
use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash,
    Transform,
};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

use super::PlotError;

/// Regular and bold, as build.rs packs them; unpacked for the first picture.
static FONTS: LazyLock<[Vec<u8>; 2]> = LazyLock::new(|| {
    [
        unpacked(include_bytes!(concat!(env!("OUT_DIR"), "/regular.font"))),
        unpacked(include_bytes!(concat!(env!("OUT_DIR"), "/bold.font"))),
    ]
});

/// What could be unpacked; a font that is cut off is found when it is read.
fn unpacked(packed: &[u8]) -> Vec<u8> {
    let mut font = Vec::new();
    let _ = ZlibDecoder::new(packed).read_to_end(&mut font);
    font
}

/// How a line is drawn.
#[derive(Clone, Copy)]
pub(super) struct StrokeStyle {
    pub color: Color,
    pub width: f32,
    /// Lengths of dash and gap; `None` is solid.
    pub dash: Option<[f32; 2]>,
}

/// How text is set.
#[derive(Clone, Copy)]
pub(super) struct TextStyle {
    pub size: f32,
    pub color: Color,
    pub bold: bool,
    pub align: Align,
}

/// The end of a text that its position is for. Vertically, the position is the middle of the capitals.
#[derive(Clone, Copy)]
pub(super) enum Align {
    Left,
    Center,
    Right,
}

pub(super) struct Canvas {
    pixmap: Pixmap,
    regular: Face<'static>,
    bold: Face<'static>,
}

impl Canvas {
    /// An empty picture.
    pub(super) fn new(width: u32, height: u32, paper: Color) -> Result<Self, PlotError> {
        let mut pixmap =
            Pixmap::new(width, height).ok_or(PlotError::Draw(text!("it is too large", "过大")))?;
        pixmap.fill(paper);
        let face = |data: &'static [u8]| {
            Face::parse(data, 0).map_err(|_| {
                PlotError::Draw(text!("the compiled-in font is broken", "内置字体损坏"))
            })
        };
        let [regular, bold] = &*FONTS;
        Ok(Self {
            pixmap,
            regular: face(regular)?,
            bold: face(bold)?,
        })
    }

    /// The picture as the bytes of a PNG file.
    pub(super) fn into_png(self) -> Result<Vec<u8>, PlotError> {
        let png = self.pixmap.encode_png();
        png.map_err(|error| PlotError::Encode(error.to_string()))
    }

    /// A line through all points.
    pub(super) fn line(&mut self, points: impl IntoIterator<Item = (f32, f32)>, line: StrokeStyle) {
        let mut builder = PathBuilder::new();
        for (x, y) in points {
            if builder.is_empty() {
                builder.move_to(x, y);
            } else {
                builder.line_to(x, y);
            }
        }
        let stroke = Stroke {
            width: line.width,
            line_join: LineJoin::Round,
            line_cap: if line.dash.is_some() {
                LineCap::Butt
            } else {
                LineCap::Round
            },
            dash: line
                .dash
                .and_then(|lengths| StrokeDash::new(lengths.to_vec(), 0.0)),
            ..Stroke::default()
        };
        // Fewer than two points make no path, and there is nothing to draw.
        if let Some(path) = builder.finish() {
            let paint = paint(line.color);
            let pixmap = &mut self.pixmap;
            pixmap.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
        }
    }

    /// A filled disc.
    pub(super) fn dot(&mut self, (x, y): (f32, f32), radius: f32, color: Color) {
        // No radius, no disc.
        if let Some(path) = PathBuilder::from_circle(x, y, radius) {
            let pixmap = &mut self.pixmap;
            let place = Transform::identity();
            pixmap.fill_path(&path, &paint(color), FillRule::Winding, place, None);
        }
    }

    /// One line of text.
    pub(super) fn text(&mut self, text: &str, (x, y): (f32, f32), style: TextStyle) {
        let face = if style.bold {
            &self.bold
        } else {
            &self.regular
        };
        let scale = style.size / f32::from(face.units_per_em());
        let (outline, width) = outline(face, text);
        let left = match style.align {
            Align::Left => x,
            Align::Center => x - width * scale / 2.0,
            Align::Right => x - width * scale,
        };
        let capitals = capital_height(face) * scale;
        // Letters stand upwards, pixels count downwards.
        let place = Transform::from_row(scale, 0.0, 0.0, -scale, left, y + capitals / 2.0);
        if let Some(outline) = outline {
            let paint = paint(style.color);
            let pixmap = &mut self.pixmap;
            pixmap.fill_path(&outline, &paint, FillRule::Winding, place, None);
        }
    }

    /// Width of a text, pixels.
    pub(super) fn width(&self, text: &str, style: TextStyle) -> f32 {
        let face = if style.bold {
            &self.bold
        } else {
            &self.regular
        };
        outline(face, text).1 * style.size / f32::from(face.units_per_em())
    }
}

fn paint(color: Color) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color(color);
    paint.anti_alias = true;
    paint
}

/// Outline and width of a text in units of the font. A character that the font lacks is its empty box.
fn outline(face: &Face, text: &str) -> (Option<Path>, f32) {
    let mut letters = Letters {
        path: PathBuilder::new(),
        x: 0.0,
    };
    let mut before = None;
    for character in text.chars() {
        let glyph = face.glyph_index(character).unwrap_or(GlyphId(0));
        letters.x += before.map_or(0.0, |before| kerning(face, before, glyph));
        // Spaces have no outline.
        let _ = face.outline_glyph(glyph, &mut letters);
        letters.x += f32::from(face.glyph_hor_advance(glyph).unwrap_or_default());
        before = Some(glyph);
    }
    (letters.path.finish(), letters.x)
}

/// Height of capitals in units of the font; measured, since older fonts do not tell.
fn capital_height(face: &Face) -> f32 {
    let bounds = face
        .glyph_index('H')
        .and_then(|h| face.glyph_bounding_box(h));
    bounds.map_or(0.0, |bounds| f32::from(bounds.y_max))
}

fn kerning(face: &Face, left: GlyphId, right: GlyphId) -> f32 {
    let subtables = face.tables().kern.map(|kern| kern.subtables);
    let horizontal = subtables
        .into_iter()
        .flatten()
        .filter(|table| table.horizontal);
    horizontal
        .filter_map(|table| table.glyphs_kerning(left, right))
        .next()
        .map_or(0.0, f32::from)
}

/// Collects the outlines of letters one beside the other.
struct Letters {
    path: PathBuilder,
    x: f32,
}

impl OutlineBuilder for Letters {
    fn move_to(&mut self, x: f32, y: f32) {
        self.path.move_to(self.x + x, y);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        self.path.line_to(self.x + x, y);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.path.quad_to(self.x + x1, y1, self.x + x, y);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let from = self.x;
        self.path
            .cubic_to(from + x1, y1, from + x2, y2, from + x, y);
    }
    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every letter of the font has the outline and the room that it has in the font as published.
    #[test]
    fn packed_fonts_draw_the_letters_of_whole_ones() {
        let whole = [dejavu::sans::regular(), dejavu::sans::bold()];
        for (packed, whole) in FONTS.iter().zip(whole) {
            let (packed, whole) = (
                Face::parse(packed, 0).unwrap(),
                Face::parse(whole, 0).unwrap(),
            );
            assert_eq!(capital_height(&packed), capital_height(&whole));
            for letter in
                ('\u{20}'..'\u{10000}').filter(|&letter| whole.glyph_index(letter).is_some())
            {
                let text = format!("A{letter}V");
                assert_eq!(
                    outline(&packed, &text),
                    outline(&whole, &text),
                    "{letter:?}"
                );
            }
        }
    }
}
