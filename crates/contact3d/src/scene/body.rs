//! The body, a brick or a Gmsh file: the planes that cut a brick in cells, equal, graded or given ones, and the meshes that refining starts
//! from where a scene leaves them open.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    AdaptSettings, Contact, FirstMesh, InvalidValue, Material, Measure, ProblemPart, Scene,
    entry_key, is_default, validate::require,
};

/// A body Ω and the finite element of its displacement. Either `brick` or `gmsh` is given.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["brick"]}, {"required": ["gmsh"]}], "examples" = ["body.gmsh = { file = \"foot.msh\" }"]))]
pub struct Body {
    /// What its faces begin with where there are several bodies: `pad.z_min` is the face z_min of the body `pad`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The finite element of the displacement.
    #[serde(default, skip_serializing_if = "is_default")]
    pub element: ElementOrder,
    /// The box (0, Lx) × (0, Ly) × (0, Lz) cut in cells of five tetrahedra each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brick: Option<Brick>,
    /// A tetrahedral mesh from a Gmsh file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gmsh: Option<GmshFile>,
    /// The place in m of the origin of the brick or of the file's coordinates, among several bodies.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(extend("measures" = Measure::Length))]
    pub origin: [f64; 3],
    /// Its elastic law; that of the table `material` when not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("part" = ProblemPart::Operator))]
    pub material: Option<Material>,
}

impl From<Brick> for Body {
    fn from(brick: Brick) -> Self {
        Self {
            brick: Some(brick),
            ..Self::default()
        }
    }
}

impl From<GmshFile> for Body {
    fn from(file: GmshFile) -> Self {
        Self {
            gmsh: Some(file),
            ..Self::default()
        }
    }
}

/// The finite element of the displacement.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
pub enum ElementOrder {
    /// Linear tetrahedra, the paper's; panes of a brick are 2 × 2 cells.
    #[default]
    P1,
    /// Quadratic tetrahedra; panes of a brick are single cells. They take the fewest unknowns for an error, and hardly lock where ν is
    /// near 0.5.
    P2,
}

impl ElementOrder {
    /// Cells of a brick along the edge of a pane.
    ///
    /// Every pane needs a node of its own in its inside, or S is nearly singular: with P1 the centre
    /// of 2 × 2 cells, with P2 the middle of a cell's diagonal.
    #[must_use]
    pub fn cells_per_pane(self) -> usize {
        match self {
            Self::P1 => 2,
            Self::P2 => 1,
        }
    }
}

/// A mesh file of Gmsh: format 4.1, or 2.2 in text. Physical surfaces name the faces, physical volumes the regions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GmshFile {
    /// Path of the .msh file, relative to the scene file.
    pub file: PathBuf,
    /// The physical volume that is the body; all tetrahedra of the file when not given. Bodies of a file whose meshes share nodes may slide
    /// and open there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<String>,
    /// Length > 0 of the file's unit in m: 0.001 for a mesh in millimetres and a scene in metres.
    #[serde(default = "one")]
    #[schemars(extend("measures" = Measure::Length, "exclusiveMinimum" = 0))]
    pub unit: f64,
    /// BLAKE3 digest of the file. Filled in when the mesh is made; a scene that gives it is sure
    /// to use that very file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub digest: Option<String>,
}

fn one() -> f64 {
    1.0
}

impl Scene {
    /// The brick of the only body; `None` for other bodies and where there are several. What needs a regular mesh or faces known by name
    /// (nested meshes, mirror images) asks for it.
    #[must_use]
    pub fn as_brick(&self) -> Option<&Brick> {
        match self.bodies.as_slice() {
            [only] => only.brick.as_ref(),
            _ => None,
        }
    }

    /// As [`Self::as_brick`], to change.
    #[must_use]
    pub fn as_brick_mut(&mut self) -> Option<&mut Brick> {
        match self.bodies.as_mut_slice() {
            [only] => only.brick.as_mut(),
            _ => None,
        }
    }

    /// The finite element of all bodies.
    #[must_use]
    pub fn element(&self) -> ElementOrder {
        self.bodies[0].element
    }

    /// The key of a body in messages: `body`, or `body.1` for the second of several.
    #[must_use]
    pub fn body_key(&self, body: usize) -> String {
        entry_key("body", self.bodies.len(), body)
    }

    /// What the names of a body's faces begin with: nothing for the only one.
    #[must_use]
    pub fn face_prefix(&self, body: usize) -> String {
        match self.bodies.len() {
            1 => String::new(),
            _ => format!("{}.", self.body_name(body)),
        }
    }

    /// What results call a body.
    #[must_use]
    pub fn body_name(&self, body: usize) -> String {
        let name = self.bodies[body].name.clone();
        name.unwrap_or_else(|| self.body_key(body))
    }

    /// Refuses scenes of several bodies for a task that knows one.
    ///
    /// # Errors
    /// The key of the bodies.
    pub fn require_one_body(&self, task: &str) -> Result<(), InvalidValue> {
        require(
            self.bodies.len() == 1,
            "body",
            &format!("one body, for {task} knows no other"),
            format!("{} bodies", self.bodies.len()),
            "put a rigid obstacle in the place of the stiffer body",
        )
    }

    /// The scene of some of several bodies alone, with what holds and touches them.
    #[must_use]
    pub fn of_bodies(&self, bodies: &[usize]) -> Self {
        let prefixes: Vec<String> = bodies.iter().map(|b| self.face_prefix(*b)).collect();
        let is_own = |face: &str| prefixes.iter().any(|prefix| face.starts_with(prefix));
        let mut own = self.clone();
        own.springs.retain(|spring| is_own(&spring.face));
        own.tools
            .retain(|tool| tool.face.as_deref().is_some_and(is_own));
        own.contacts
            .retain(|contact| contact.faces().into_iter().any(is_own));
        own
    }

    /// The brick that a face belongs to, with the face; `None` for other faces.
    #[must_use]
    pub fn brick_face(&self, face: &str) -> Option<(&Brick, BrickFace)> {
        let bodies = self.bodies.iter().enumerate();
        let mut found = bodies.filter_map(|(i, body)| {
            let own = face.strip_prefix(&self.face_prefix(i))?;
            Some((body.brick.as_ref()?, BrickFace::named(own)?))
        });
        found.next()
    }

    /// The materials with their keys: that of the table `material` (of the first body where there is none), those of the regions, then those
    /// of the bodies that have their own.
    pub fn materials(&self) -> impl Iterator<Item = (String, &Material)> {
        let regions = self.regions.iter().enumerate();
        let regions = regions.map(|(i, region)| (format!("region.{i}.material"), &region.material));
        let bodies = (0..self.bodies.len()).filter_map(move |body| {
            let key = format!("{}.material", self.body_key(body));
            Some((key, self.bodies[body].material.as_ref()?))
        });
        let common = self.material.iter();
        let common = common.map(|material| ("material".to_owned(), material));
        // Regions count from 1.
        let any = bodies.clone().filter(|_| self.material.is_none()).take(1);
        common.chain(any).chain(regions).chain(bodies)
    }

    /// The number of a body's own material among [`Self::materials`]; 0 where it has none.
    #[must_use]
    pub fn own_material(&self, body: usize) -> usize {
        let before = self.bodies[..body].iter();
        let before = before.filter(|body| body.material.is_some()).count();
        match self.bodies[body].material {
            Some(_) => 1 + self.regions.len() + before,
            None => 0,
        }
    }

    /// The scene with the mesh that refining starts from: where it [leaves its mesh open](Self::leaves_mesh_open), a brick gets as
    /// few cells as keep their shape: two along its shortest edge, four with panes of 2 × 2 cells.
    ///
    /// What is chosen stands in the scene, so choosing again changes nothing.
    #[must_use]
    pub fn with_first_mesh(mut self) -> Self {
        let element = self.element();
        if self.leaves_mesh_open()
            && let Some(brick) = self.as_brick_mut()
        {
            brick.cells = fewest_cells(brick, element);
        }
        self
    }

    /// The scene with other cells of its brick, which shrink towards the faces of clamps, loads and contact: at their edges
    /// stresses are singular or jump.
    #[must_use]
    pub fn with_graded_cells(mut self, cells: [usize; 3]) -> Self {
        let faces = self.named_faces().into_iter();
        let faces = faces.filter_map(|(_, name)| BrickFace::named(&name));
        if let Some(brick) = self.as_brick_mut() {
            let equal = Brick::new(brick.size, cells);
            // On the published problem at 24 × 8 × 8 cells the exponent 1.5 leaves 2.8 % of estimated error where equal cells
            // leave 4.1 %, and 2 as much as they.
            let towards = |brick: Brick, face| brick.with_grading(face, 1.5);
            *brick = faces.fold(equal, towards);
        }
        self
    }

    /// Whether the scene asks for an error, starts coarse, and equal cells of any size show all that it says.
    #[must_use]
    pub fn leaves_mesh_open(&self) -> bool {
        let starts_coarse = |adapt: AdaptSettings| adapt.start == FirstMesh::Coarse;
        self.adapt.is_some_and(starts_coarse) && self.is_shown_by_any_cells()
    }

    /// Whether equal cells of any size show all that the scene says.
    fn is_shown_by_any_cells(&self) -> bool {
        let is_whole_and_flat = |face: &Contact| face.obstacle.is_none() && face.corners.is_none();
        let has_equal_cells = |brick: &Brick| (0..3).all(|axis| brick.is_even(axis));
        self.as_brick().is_some_and(has_equal_cells)
            && self.contacts.iter().all(is_whole_and_flat)
            && self.regions.is_empty()
            && !self.clamps.iter().any(|clamp| clamp.corners.is_some())
            && !self.depends_on_place()
    }
}

/// The fewest cells of the shape that those of a brick have, `[nx, ny, nz]`: whole panes along every edge.
fn fewest_cells(brick: &Brick, element: ElementOrder) -> [usize; 3] {
    let pane = element.cells_per_pane();
    let shortest = brick.cells.into_iter().min().unwrap_or(1);
    let factor = shortest as f64 / (2 * pane) as f64;
    if factor <= 1.0 {
        return brick.cells;
    }
    // A count divided by what makes the smallest one 2 panes.
    let panes = |cells: usize| (cells as f64 / (factor * pane as f64)).round() as usize;
    brick.cells.map(|cells| pane * panes(cells))
}

/// Most cells of a brick along an edge.
pub const MOST_CELLS: usize = 4096;

/// The largest exponent of graded cells: with it, two cells alone differ a billionfold.
const MOST_GRADING: usize = 30;

/// A box and its mesh, whose cells lie between planes perpendicular to the axes (HKL §4).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Brick {
    /// Edge lengths [Lx, Ly, Lz] > 0 in m.
    #[schemars(extend("measures" = Measure::Length, "exclusiveMinimum" = 0))]
    pub size: [f64; 3],
    /// Numbers of cells [nx, ny, nz]; with panes of P1, even along the two axes of the contact face.
    #[schemars(extend("minimum" = 1, "maximum" = MOST_CELLS))]
    pub cells: [usize; 3],
    /// Faces towards which cells shrink; equal cells where none is named.
    #[serde(default, skip_serializing_if = "is_default")]
    pub grading: Grading,
    /// The planes between the cells along axes that have neither equal nor graded cells.
    #[serde(default, skip_serializing_if = "is_default")]
    pub coordinates: GivenPlanes,
}

/// How cells shrink towards each face: an exponent from 1, equal cells, to 30.
///
/// Along an axis with exponent p towards its lower and q towards its upper face, node i of n lies at the
/// share B(i/n; p, q) / B(1; p, q) of the length, B(s; p, q) = ∫₀ˢ tᵖ⁻¹ (1 − t)^(q−1) dt. That is (i/n)ᵖ where q = 1,
/// and as smooth between two graded faces as at one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Grading {
    /// Exponent towards x = 0.
    #[serde(skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 1, "maximum" = MOST_GRADING))]
    pub x_min: f64,
    /// Exponent towards x = Lx.
    #[serde(skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 1, "maximum" = MOST_GRADING))]
    pub x_max: f64,
    /// Exponent towards y = 0.
    #[serde(skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 1, "maximum" = MOST_GRADING))]
    pub y_min: f64,
    /// Exponent towards y = Ly.
    #[serde(skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 1, "maximum" = MOST_GRADING))]
    pub y_max: f64,
    /// Exponent towards z = 0.
    #[serde(skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 1, "maximum" = MOST_GRADING))]
    pub z_min: f64,
    /// Exponent towards z = Lz.
    #[serde(skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 1, "maximum" = MOST_GRADING))]
    pub z_max: f64,
}

/// Coordinates in m of the planes between cells, from 0 to the edge length; absent axes have equal or
/// graded cells.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GivenPlanes {
    /// From x = 0 to x = Lx, nx + 1 numbers in m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Length))]
    pub x: Option<Vec<f64>>,
    /// From y = 0 to y = Ly, ny + 1 numbers in m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Length))]
    pub y: Option<Vec<f64>>,
    /// From z = 0 to z = Lz, nz + 1 numbers in m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Length))]
    pub z: Option<Vec<f64>>,
}

impl Brick {
    /// A box with edges in m, cut in equal cells.
    #[must_use]
    pub fn new(size: [f64; 3], cells: [usize; 3]) -> Self {
        Self {
            size,
            cells,
            grading: Grading::default(),
            coordinates: GivenPlanes::default(),
        }
    }

    /// The same box with cells that shrink towards a face; see [`Grading`] for the exponent.
    ///
    /// ```
    /// use contact3d::scene::{Body, Brick, BrickFace};
    ///
    /// let brick = Brick::new([3.0, 1.0, 1.0], [4, 2, 2]).with_grading(BrickFace::XMin, 2.0);
    /// assert_eq!(brick.planes(0), [0.0, 0.1875, 0.75, 1.6875, 3.0]);
    /// let body: Body = brick.into();
    /// ```
    #[must_use]
    pub fn with_grading(mut self, face: BrickFace, exponent: f64) -> Self {
        *self.grading.towards_mut(face) = exponent;
        self
    }

    /// The same box with given planes between the cells along axis 0, 1 or 2, from 0 to the edge length in m,
    /// which they set together with the number of cells.
    #[must_use]
    pub fn with_planes(mut self, axis: usize, planes: Vec<f64>) -> Self {
        self.cells[axis] = planes.len().saturating_sub(1);
        self.size[axis] = planes.last().copied().unwrap_or(0.0);
        *self.coordinates.along_mut(axis) = Some(planes);
        self
    }

    /// Coordinates in m of the planes between cells along an axis, `[cells + 1]`, increasing from 0 to the edge
    /// length.
    #[must_use]
    pub fn planes(&self, axis: usize) -> Vec<f64> {
        if let Some(given) = self.coordinates.along(axis) {
            return given.clone();
        }
        let (length, n) = (self.size[axis], self.cells[axis]);
        let exponents = self.grading.along(axis);
        let plane = |i: usize| length * graded_share(i, n, exponents);
        (0..=n).map(plane).collect()
    }

    /// Whether the cells along an axis are equal by definition.
    #[must_use]
    pub fn is_even(&self, axis: usize) -> bool {
        self.coordinates.along(axis).is_none() && self.grading.along(axis) == [1.0; 2]
    }
}

impl Default for Grading {
    fn default() -> Self {
        Self {
            x_min: 1.0,
            x_max: 1.0,
            y_min: 1.0,
            y_max: 1.0,
            z_min: 1.0,
            z_max: 1.0,
        }
    }
}

impl Grading {
    /// The exponent towards a face.
    #[must_use]
    pub fn towards(&self, face: BrickFace) -> f64 {
        self.along(face.axis())[usize::from(face.is_max())]
    }

    /// As [`Self::towards`], to change.
    #[must_use]
    pub fn towards_mut(&mut self, face: BrickFace) -> &mut f64 {
        match face {
            BrickFace::XMin => &mut self.x_min,
            BrickFace::XMax => &mut self.x_max,
            BrickFace::YMin => &mut self.y_min,
            BrickFace::YMax => &mut self.y_max,
            BrickFace::ZMin => &mut self.z_min,
            BrickFace::ZMax => &mut self.z_max,
        }
    }

    /// The exponents towards the lower and the upper face of an axis.
    #[must_use]
    pub fn along(&self, axis: usize) -> [f64; 2] {
        [
            [self.x_min, self.x_max],
            [self.y_min, self.y_max],
            [self.z_min, self.z_max],
        ][axis]
    }
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde asks for a reference"
)]
fn is_one(exponent: &f64) -> bool {
    *exponent == 1.0
}

impl GivenPlanes {
    /// The planes along an axis; `None` for equal or graded cells.
    #[must_use]
    pub fn along(&self, axis: usize) -> Option<&Vec<f64>> {
        [&self.x, &self.y, &self.z][axis].as_ref()
    }

    /// As [`Self::along`], to change.
    #[must_use]
    pub fn along_mut(&mut self, axis: usize) -> &mut Option<Vec<f64>> {
        [&mut self.x, &mut self.y, &mut self.z][axis]
    }
}

units::worded! {
    /// A face of the brick.
    #[derive(Hash, PartialOrd, Ord)]
    pub enum BrickFace {
        /// x = 0.
        XMin = "x_min",
        /// x = Lx.
        XMax = "x_max",
        /// y = 0.
        YMin = "y_min",
        /// y = Ly.
        YMax = "y_max",
        /// z = 0.
        ZMin = "z_min",
        /// z = Lz.
        ZMax = "z_max",
    }
}

impl BrickFace {
    /// The coordinate axis the face is perpendicular to (0, 1, 2).
    #[must_use]
    pub fn axis(self) -> usize {
        self as usize / 2
    }

    /// Whether the face lies at the upper end of its axis.
    #[must_use]
    pub fn is_max(self) -> bool {
        self as usize % 2 == 1
    }
}

/// The share of an edge below plane i of n where cells shrink with exponents p and q towards its ends.
///
/// The regularised incomplete beta function I(i/n; p, q) (DLMF 8.17.2): the cells per length go with
/// s^(1−p) (1 − s)^(1−q), so their widths have no jump anywhere. Equal cells and one graded end, where it is a
/// power, are not left to a series, so they have the bits of that power.
#[must_use]
pub(super) fn graded_share(i: usize, n: usize, exponents: [f64; 2]) -> f64 {
    let below = i as f64 / n as f64;
    let above = (n - i) as f64 / n as f64;
    let [p, q] = exponents;
    match (p == 1.0, q == 1.0) {
        (true, true) => below,
        (false, true) => below.powf(p),
        (true, false) => 1.0 - above.powf(q),
        (false, false) if 2 * i <= n => integral(below, p, q) / whole(p, q),
        (false, false) => 1.0 - integral(above, q, p) / whole(p, q),
    }
}

/// B(1; p, q), both halves by the series where it converges fast.
fn whole(p: f64, q: f64) -> f64 {
    integral(0.5, p, q) + integral(0.5, q, p)
}

/// B(s; p, q) = ∫₀ˢ tᵖ⁻¹ (1 − t)^(q−1) dt for 0 ≤ s ≤ ½ and p, q ≥ 1, by the series of positive terms
/// sᵖ (1 − s)^q / p · (1 + Σₖ s^(k+1) Πⱼ₌₀ᵏ (p + q + j)/(p + 1 + j)) (DLMF 8.17.8).
fn integral(s: f64, p: f64, q: f64) -> f64 {
    let (mut sum, mut term, mut j) = (1.0, 1.0, 0.0);
    // Terms grow at most once and then fall, at last by the factor s.
    while term > 0.1 * f64::EPSILON * sum {
        term *= s * (p + q + j) / (p + 1.0 + j);
        sum += term;
        j += 1.0;
    }
    s.powf(p) * (1.0 - s).powf(q) / p * sum
}
