//! What the figures are drawn from, and which there are.

use std::ops::Range;

use thiserror::Error;
use units::{Dimension, Units};

use super::{
    canvas::{Anchor, Canvas, Colour, Fill, png},
    panes::FrictionKind,
    text::{Label, fitted},
};

/// Contact state of a pane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawnZone {
    /// σ_ν = 0: the pane has left the support.
    Open,
    /// ‖F⁻¹σ_t‖ < −σ_ν: the pane sticks.
    Stick,
    /// ‖F⁻¹σ_t‖ = −σ_ν: the pane slips.
    Slip,
}

impl DrawnZone {
    /// Its word in pictures.
    pub(super) const fn word(self) -> &'static str {
        ["open", "stick", "slip"][self as usize]
    }
}

/// Friction on one pane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnFriction {
    /// ‖F⁻¹σ_t‖ \[Pa\] of Coulomb's law, ‖(g F)⁻¹σ_t‖ of Tresca's.
    pub scaled_tangential: f64,
    /// F₁, F₂ (HKL §2) of Coulomb's law, g F₁, g F₂ \[Pa\] of Tresca's.
    pub semi_axes: [f64; 2],
    /// Tangential contact stress along t₁ and t₂, divided by the slip bound with Coulomb's law (λ_ν = −σ_ν, or
    /// no more than its cap), \[Pa\] with Tresca's.
    pub stress: [f64; 2],
    /// Angle of the pane's own t₁ from `axis_1` of the picture towards its `axis_2`, in radians; 0
    /// where the frame does not turn.
    pub turn: f64,
    /// Contact state.
    pub zone: DrawnZone,
}

/// A field of the body.
#[derive(Clone, Copy, Debug)]
pub struct BodyField<'a> {
    /// What it is, in words.
    pub title: &'a str,
    /// What stands at the colour bar, before the unit.
    pub symbol: &'a str,
    /// What it is measured in.
    pub dimension: Dimension,
    /// A value for each of the picture's `coordinates`; those that no boundary triangle has may be anything.
    pub values: &'a [f64],
}

/// The part of a rigid obstacle that a contact face sees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawnObstacle {
    /// Points of the face and around it \[m\].
    pub points: Vec<[f64; 3]>,
    /// From each of these to the obstacle \[m\], as many as `points`.
    pub gaps: Vec<[f64; 3]>,
    /// Points of its triangles.
    pub triangles: Vec<[usize; 3]>,
}

/// What acts on a body somewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyMarkKind {
    /// A clamp; its vectors have a 1 for each axis along which it holds, and 0 for the others.
    Held,
    /// A clamp that moves; its vectors are displacements.
    Moved,
    /// Springs along the normal; their vectors are not read.
    Spring,
    /// A load on a face; its vectors are tractions.
    Load,
    /// A load in the volume; its vectors are forces per volume.
    Volume,
}

/// A clamp or a load, of which some symbols are drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyMark {
    /// What it is.
    pub kind: BodyMarkKind,
    /// Nodes where it acts.
    pub nodes: Vec<usize>,
    /// What it does at each of them.
    pub vectors: Vec<[f64; 3]>,
    /// Outward unit normal of its face at each of them; zero where it is on none.
    pub normals: Vec<[f64; 3]>,
}

/// One solved contact problem as the figures need it: borrowed arrays, no dependence on how it was computed. All that draws one panics
/// where arrays of it do not fit together.
///
/// A value that is not finite is drawn as a hatched pane or a grey facet.
#[derive(Clone, Copy, Debug)]
pub struct ContactPicture<'a> {
    /// Title of the page.
    pub title: &'a str,
    /// The units of all lengths and stresses.
    pub units: Units,
    /// Coordinates of the nodes \[m\].
    pub coordinates: &'a [[f64; 3]],
    /// Displacement of the nodes \[m\], as many as `coordinates`.
    pub displacement: &'a [[f64; 3]],
    /// Nodes of the triangles of the whole boundary ∂Ω.
    pub boundary_triangles: &'a [[usize; 3]],
    /// The nodes of each of several bodies; none for one.
    pub bodies: &'a [Range<usize>],
    /// Number of the named face of every boundary triangle, or none at all: lines are drawn where they differ.
    pub boundary_face: &'a [usize],
    /// Nodes of the triangles of the contact part Γ_c; none for a body without contact.
    pub contact_triangles: &'a [[usize; 3]],
    /// Pane of every contact triangle.
    pub contact_triangle_pane: &'a [usize],
    /// Whether displacements are drawn as large as they are: beside what is curved or not touched yet, larger ones would leave the body in it
    /// or far from it.
    pub is_to_scale: bool,
    /// Outward unit normal ν on Γ_c, or its mean direction where it varies: pictures of the face look along it.
    pub normal: [f64; 3],
    /// What the body may touch; `None` where it is not drawn.
    pub obstacle: Option<&'a DrawnObstacle>,
    /// Clamps and loads.
    pub marks: &'a [BodyMark],
    /// First unit tangent; drawn to the right.
    pub axis_1: [f64; 3],
    /// Second unit tangent; drawn upwards.
    pub axis_2: [f64; 3],
    /// Contact pressure −σ_ν of every pane \[Pa\].
    pub pressure: &'a [f64],
    /// The law and the friction of every pane, as many as `pressure`; `None` without friction.
    pub friction: Option<(FrictionKind, &'a [DrawnFriction])>,
}

impl ContactPicture<'_> {
    /// Whether the contact face looks up rather than down, along the global z axis.
    #[must_use]
    pub fn is_contact_above(&self) -> bool {
        self.normal[2] > 0.5
    }
}

/// Why a PNG cannot be made.
#[derive(Debug, Error)]
pub enum PngError {
    /// The picture of that width is empty or too large for memory.
    #[error("a picture {0} pixels wide cannot be made")]
    Width(u32),
    /// The renderer or the encoder failed.
    #[error("the PNG cannot be made: {0}")]
    Failed(String),
}

/// A drawing as SVG or PNG.
///
/// The same figure gives the same bytes.
#[derive(Clone, Debug)]
pub struct Picture {
    canvas: Canvas,
    title: String,
}

impl Picture {
    pub(super) fn new(canvas: Canvas, title: &str) -> Self {
        let title = title.to_owned();
        Self { canvas, title }
    }

    /// The figure below a red band with a warning, `None` for none.
    #[must_use]
    pub fn stamped(self, warning: Option<&str>) -> Self {
        let Some(warning) = warning else {
            return self;
        };
        let (height, size) = (34.0, 15.0);
        let mut canvas = Canvas::new(self.canvas.width, height + self.canvas.height);
        let red = Fill::Plain(Colour(0xff, 0xb8, 0xad));
        canvas.rectangle([0.0, 0.0], [canvas.width, height], red, None);
        let words = Label::plain(fitted(warning, size, canvas.width - 32.0));
        canvas.bold_text([16.0, 23.0], &words, size, Anchor::Start);
        canvas.place(&self.canvas, [0.0, height]);
        Self { canvas, ..self }
    }

    /// The figure as an SVG document, with the title as its accessible name.
    #[must_use]
    pub fn svg(&self) -> String {
        self.canvas.svg(&self.title)
    }

    /// The figure as a PNG of the given width, which resvg draws from the SVG in DejaVu Sans; the height follows from its
    /// shape. The file says that this program made it.
    ///
    /// # Errors
    /// [`PngError::Width`] when the picture would be empty or too large, [`PngError::Failed`] when drawing or encoding fails.
    pub fn png(&self, pixels_wide: u32) -> Result<Vec<u8>, PngError> {
        png(&self.svg(), pixels_wide)
    }
}
