//! What the figures are drawn from, and which there are.

use thiserror::Error;
use units::Units;

use super::{canvas::Canvas, panes::FrictionKind, raster, svg};

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

/// One solved contact problem as the figures need it: borrowed arrays, no dependence on how it was computed.
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
    /// Number of the named face of every boundary triangle, or none at all: lines are drawn where they differ.
    pub boundary_face: &'a [usize],
    /// Nodes of the triangles of the contact part Γ_c; none for a body without contact.
    pub contact_triangles: &'a [[usize; 3]],
    /// Pane of every contact triangle.
    pub contact_triangle_pane: &'a [usize],
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
    /// Normal contact stress σ_ν of every pane \[Pa\].
    pub normal_stress: &'a [f64],
    /// The law and the friction of every pane, as many as `normal_stress`; `None` without friction.
    pub friction: Option<(FrictionKind, &'a [DrawnFriction])>,
}

/// Why a figure cannot be drawn.
#[derive(Debug, Error)]
pub enum FigureError {
    /// Two arrays that belong together differ in length.
    #[error("{what}: {found} entries where {expected} are needed")]
    Length {
        /// The array.
        what: &'static str,
        /// Entries needed.
        expected: usize,
        /// Entries found.
        found: usize,
    },
    /// A triangle names a node or a pane that does not exist.
    #[error("{what}: index {index} where there are only {count}")]
    Index {
        /// The array.
        what: &'static str,
        /// The offending index.
        index: usize,
        /// Number of nodes or panes.
        count: usize,
    },
    /// A node position or a drawing axis is not finite.
    #[error("{0} are not finite")]
    NotFinite(&'static str),
    /// The picture of that width is empty or too large for memory.
    #[error("a picture {0} pixels wide cannot be made")]
    Width(u32),
    /// The PNG could not be written.
    #[error("PNG encoding failed: {0}")]
    Png(String),
}

impl ContactPicture<'_> {
    /// Checks lengths, indices and positions.
    ///
    /// # Errors
    /// [`FigureError`] names the first array that does not fit.
    pub fn validate(&self) -> Result<(), FigureError> {
        let nodes = self.coordinates.len();
        let panes = self.normal_stress.len();
        same_length("displacement", nodes, self.displacement.len())?;
        let triangles = self.contact_triangles.len();
        same_length(
            "contact_triangle_pane",
            triangles,
            self.contact_triangle_pane.len(),
        )?;
        if !self.boundary_face.is_empty() {
            let (expected, found) = (self.boundary_triangles.len(), self.boundary_face.len());
            same_length("boundary_face", expected, found)?;
        }
        if let Some((_, friction)) = self.friction {
            same_length("friction", panes, friction.len())?;
        }
        let boundary = self.boundary_triangles.as_flattened();
        indices_below("boundary_triangles", nodes, boundary)?;
        let contact = self.contact_triangles.as_flattened();
        indices_below("contact_triangles", nodes, contact)?;
        indices_below("contact_triangle_pane", panes, self.contact_triangle_pane)?;
        if let Some(obstacle) = self.obstacle {
            let points = obstacle.points.len();
            same_length("obstacle gaps", points, obstacle.gaps.len())?;
            let corners = obstacle.triangles.as_flattened();
            indices_below("obstacle triangles", points, corners)?;
            finite("obstacle points", &obstacle.points)?;
            finite("obstacle gaps", &obstacle.gaps)?;
        }
        for mark in self.marks {
            indices_below("nodes of a mark", nodes, &mark.nodes)?;
            for list in [&mark.vectors, &mark.normals] {
                same_length("vectors of a mark", mark.nodes.len(), list.len())?;
                finite("vectors of a mark", list)?;
            }
        }
        let frame = [self.normal, self.axis_1, self.axis_2];
        finite("drawing axes", &frame)?;
        finite("coordinates", self.coordinates)
    }
}

pub(super) fn same_length(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), FigureError> {
    if expected == found {
        Ok(())
    } else {
        Err(FigureError::Length {
            what,
            expected,
            found,
        })
    }
}

pub(super) fn indices_below(
    what: &'static str,
    count: usize,
    indices: &[usize],
) -> Result<(), FigureError> {
    match indices.iter().find(|&&index| index >= count) {
        Some(&index) => Err(FigureError::Index { what, index, count }),
        None => Ok(()),
    }
}

pub(super) fn finite(what: &'static str, vectors: &[[f64; 3]]) -> Result<(), FigureError> {
    if vectors.as_flattened().iter().all(|value| value.is_finite()) {
        Ok(())
    } else {
        Err(FigureError::NotFinite(what))
    }
}

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
