//! A finished picture.

use super::canvas::Canvas;
use super::picture::FigureError;
use super::{raster, svg};

/// A drawing with its title, as SVG or PNG.
///
/// The same figure gives the same bytes.
#[derive(Clone, Debug)]
pub struct Picture {
    canvas: Canvas,
    title: String,
}

impl Picture {
    pub(super) fn new(canvas: Canvas, title: &str) -> Self {
        Self {
            canvas,
            title: title.to_owned(),
        }
    }

    /// The figure as an SVG document, with the title as its accessible name.
    #[must_use]
    pub fn svg(&self) -> String {
        svg::document(&self.canvas, &self.title)
    }

    /// The figure as a PNG of the given width; the height follows from its shape.
    ///
    /// Text is set in DejaVu Sans, character by character from left to right. The file says that this program made it.
    ///
    /// # Errors
    /// [`FigureError::Width`] when the picture would be empty or too large, [`FigureError::Png`] when the encoder fails.
    pub fn png(&self, pixels_wide: u32) -> Result<Vec<u8>, FigureError> {
        raster::png(&self.canvas, pixels_wide)
    }
}
