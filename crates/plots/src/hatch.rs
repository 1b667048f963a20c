//! The two patterns of diagonal lines, for both kinds of file.

use super::canvas::{Colour, Point};

/// A square tile with lines from lower left to upper right, continued by its neighbours.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hatch {
    /// Identifier within an SVG document.
    pub(super) name: &'static str,
    /// Side of the tile in pixels.
    pub(super) period: f64,
    pub(super) background: Colour,
    pub(super) lines: Colour,
    /// Width of the lines in pixels.
    pub(super) width: f64,
}

impl Hatch {
    /// A value that is not a number.
    pub(super) const NO_VALUE: Self = Self {
        name: "no-value",
        period: 6.0,
        background: Colour(0xd8, 0xd8, 0xd8),
        lines: Colour(0x8a, 0x8a, 0x8a),
        width: 1.0,
    };

    /// A pane that is out of contact.
    pub(super) const OPEN: Self = Self {
        name: "open",
        period: 5.0,
        background: Colour::WHITE,
        lines: Colour(0xc4, 0xc4, 0xc4),
        width: 0.7,
    };

    /// The diagonal of the tile, and the corners of those of its neighbours.
    pub(super) fn segments(&self) -> [[Point; 2]; 3] {
        let side = self.period;
        [
            [[-1.0, 1.0], [1.0, -1.0]],
            [[0.0, side], [side, 0.0]],
            [[side - 1.0, side + 1.0], [side + 1.0, side - 1.0]],
        ]
    }
}
