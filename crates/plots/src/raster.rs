//! PNG from SVG, with an embedded font: no fonts of the system are needed.

use std::sync::Arc;

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use super::picture::FigureError;

/// Bytes of a PNG up to the end of its header.
const HEADER: usize = 33;
/// The chunk that names this program: length, type, keyword, text, check sum.
const SOFTWARE: &[u8] = b"\0\0\0\x17tEXtSoftware\0contact3d-pipe\x2a\xc3\xa9\x06";

/// Renders an SVG of this module as a PNG of the given width; the height follows from the shape of the page.
///
/// Text is set in DejaVu Sans from memory. The same input gives the same bytes. The file says that this program
/// made it.
///
/// # Errors
/// [`FigureError::Svg`] when `svg` is not a valid SVG, [`FigureError::Width`] when the picture would be empty or
/// too large, [`FigureError::Png`] when the encoder fails.
pub fn rasterise(svg: &str, pixels_wide: u32) -> Result<Vec<u8>, FigureError> {
    let tree = parse(svg)?;
    let scale = f64::from(pixels_wide) / f64::from(tree.size().width());
    let height = (scale * f64::from(tree.size().height())).round();
    if !(1.0..1e5).contains(&height) {
        return Err(FigureError::Width(pixels_wide));
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked above"
    )]
    let pixels_high = height as u32;
    let mut pixmap =
        Pixmap::new(pixels_wide, pixels_high).ok_or(FigureError::Width(pixels_wide))?;
    #[expect(
        clippy::cast_possible_truncation,
        reason = "single precision of tiny-skia"
    )]
    let scale = scale as f32;
    let transform = Transform::from_scale(scale, scale);
    resvg::render(&tree, transform, &mut pixmap.as_mut());
    let png = pixmap.encode_png();
    let mut png = png.map_err(|error| FigureError::Png(error.to_string()))?;
    png.splice(HEADER..HEADER, SOFTWARE.iter().copied());
    Ok(png)
}

/// The SVG with its text laid out.
pub(super) fn parse(svg: &str) -> Result<Tree, FigureError> {
    let mut fonts = fontdb::Database::new();
    for font in [
        dejavu::sans::regular(),
        dejavu::sans::oblique(),
        dejavu::sans::bold(),
        dejavu::sans::bold_oblique(),
    ] {
        fonts.load_font_source(fontdb::Source::Binary(Arc::new(font)));
    }
    fonts.set_sans_serif_family("DejaVu Sans");
    let options = Options {
        fontdb: Arc::new(fonts),
        ..Options::default()
    };
    Ok(Tree::from_str(svg, &options)?)
}
