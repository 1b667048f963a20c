//! Laws of friction alone: their bounds and their pictures, without a run file.

use std::path::PathBuf;

use super::{
    Drawing, PictureFolder,
    contact_cells::ContactCells,
    law_curves,
    picture::{self, NO_MULTIPLIER, endings_of},
};
use crate::pipeline::{StageError, mesh_of, pin_mesh_file};
use contact3d::{
    contact::{ContactFrame, CoulombLaw, FaceLaw, FrictionField, Interface, LawBounds},
    mesh::{ContactSurface, Mesh, Quality, Refinement},
    scene::{FrictionModel, Scene, SceneFile, Warning, escape_control},
};
use plots::{ContactPicture, DrawnFriction, FrictionKind, LawPicture, Picture, law_page};

/// What the names of pictures begin with.
const PICTURE: &str = "friction_law";

/// The laws of friction by themselves: their bounds and their pictures, from the mesh alone and without a run
/// file.
#[derive(Debug)]
pub struct LawStudy {
    /// The scene.
    pub scene: Scene,
    /// The law of each contact face, those with friction first.
    pub faces: Vec<FaceStudy>,
    mesh: Mesh,
    interface: Option<Interface>,
}

/// The law of one contact face.
#[derive(Debug)]
pub struct FaceStudy {
    /// The number of the face in the scene.
    pub entry: usize,
    /// Its name.
    pub name: String,
    /// The law of tangential stresses; `None` without friction.
    pub model: Option<FrictionModel>,
    /// Bounds of Coulomb's law; `None` for other laws.
    pub bounds: Option<LawBounds>,
    /// H and h.
    pub sizes: MeshSizes,
}

/// The lengths of a discretisation that the uniqueness conditions of HKL §3 are stated in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshSizes {
    /// H: the root of the area of the largest pane of the face, in m.
    pub pane: f64,
    /// h: the longest edge, in m.
    pub edge: f64,
}

impl LawStudy {
    /// Makes the mesh in memory and bounds the laws.
    pub fn new(mut input: SceneFile) -> Result<Self, StageError> {
        pin_mesh_file(&mut input)?;
        let mesh = mesh_of(&input, &Refinement::default())?;
        let interface =
            Interface::new(&input.scene, &mesh).map_err(|invalid| input.refuse(invalid))?;
        Ok(Self {
            faces: faces_of(&input.scene, &mesh, interface.as_ref()),
            scene: input.scene,
            mesh,
            interface,
        })
    }

    /// What is allowed in the scene and probably not meant.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = self.scene.warnings();
        if let Some(interface) = &self.interface {
            let length = self.scene.units.length();
            warnings.extend(interface.warnings(self.mesh.extent(), length));
        }
        warnings
    }

    /// The pictures that may be drawn.
    pub fn drawing(&self) -> Drawing {
        Drawing::Law(endings_of(&self.scene))
    }

    /// Draws Coulomb's law as `friction_law.svg` and `.png`, of several faces each its own, with the name of the face at the end; returns the
    /// files, none for other laws.
    pub fn draw(&self, folder: &PictureFolder) -> Result<Vec<PathBuf>, StageError> {
        let (Some(surface), Some(interface)) = (&self.mesh.contact, &self.interface) else {
            return Ok(Vec::new());
        };
        let Some(law) = interface.coulomb() else {
            return Ok(Vec::new());
        };
        let field = FrictionField::new(law, &surface.pane_average, &[]);
        let faces = self.faces.iter().zip(law.faces()).enumerate();
        let bounded = faces.filter(|(_, (study, _))| study.bounds.is_some());
        let endings = endings_of(&self.scene);
        let pages = bounded.map(|(number, (study, law))| {
            let name = format!("{PICTURE}{}", endings[number]);
            let face = (surface, number);
            let page = self.page(study, law, face, &field, &interface.frame);
            (name, page, picture::PAGE_WIDTH)
        });
        folder.save(pages)
    }

    fn page(
        &self,
        study: &FaceStudy,
        law: &FaceLaw,
        (surface, number): (&ContactSurface, usize),
        field: &FrictionField,
        frame: &ContactFrame,
    ) -> Picture {
        let place = central_node(law.positions());
        let drawn = law_curves::over_slip(law.law(), place, self.mesh.extent());
        let varies = law.law().depends_on_place();
        let note = if varies && law.law().depends_on_slip() {
            // Four decimals of the exponential form.
            let short = |v: f64| format!("{v:.4e}").parse::<f64>().unwrap_or(v);
            let [x, y, z] = place.map(short);
            format!(
                "slips varied at x, y, z = {x}, {y}, {z} {}, the contact node nearest to the centre",
                self.scene.units.length()
            )
        } else {
            String::new()
        };
        let title = match self.faces.len() {
            1 => self.scene.shown_title(),
            _ => format!(
                "{}: {}",
                self.scene.shown_title(),
                escape_control(&study.name)
            ),
        };
        let face = &surface.faces[number];
        let cells = ContactCells::new(&self.mesh, Some((surface, face)));
        let panes: Vec<[f64; 2]> = face.panes.clone().map(|i| field.pane(i)).collect();
        let friction = cells.of_cells(&panes, &NO_MULTIPLIER, |&semi_axes| DrawnFriction {
            semi_axes,
            ..NO_MULTIPLIER
        });
        let reference = frame.references[number];
        let [axis_1, axis_2] = reference.axes;
        let at_rest = ContactPicture {
            title: &title,
            units: self.scene.units,
            coordinates: &cells.coordinates,
            displacement: &vec![[0.0; 3]; cells.coordinates.len()],
            boundary_triangles: &[],
            boundary_face: &[],
            contact_triangles: &cells.triangles,
            contact_triangle_pane: &cells.pane,
            normal: reference.normal,
            obstacle: None,
            marks: &[],
            axis_1,
            axis_2,
            normal_stress: &vec![0.0; friction.len()],
            friction: Some((FrictionKind::OverPressure, &friction)),
        };
        law_page(&LawPicture {
            title: &title,
            units: self.scene.units,
            note: &note,
            over_slip: &drawn,
            at_rest: varies.then_some(at_rest),
        })
    }
}

/// The law of each face, in the order of the multipliers; none without contact.
fn faces_of(scene: &Scene, mesh: &Mesh, interface: Option<&Interface>) -> Vec<FaceStudy> {
    let Some(surface) = &mesh.contact else {
        return Vec::new();
    };
    let laws = interface
        .and_then(Interface::coulomb)
        .map_or(&[][..], CoulombLaw::faces);
    let features = scene.contact_features().into_iter();
    let studied = features.zip(&surface.faces).enumerate();
    let edge = Quality::of(mesh).longest_edge;
    studied
        .map(|(number, (features, face))| {
            let panes = surface.pane_area[face.panes.clone()].iter();
            let model = features.friction;
            let follows_pressure = |model: &FrictionModel| model.bound.follows_pressure();
            let law = laws
                .get(number)
                .filter(|_| model.as_ref().is_some_and(follows_pressure));
            FaceStudy {
                entry: features.entry,
                name: features.name,
                bounds: law.map(|law| LawBounds::new(law, mesh.extent())),
                model,
                sizes: MeshSizes {
                    pane: panes.copied().fold(0.0, f64::max).sqrt(),
                    edge,
                },
            }
        })
        .collect()
}

/// The names of all pictures with these endings.
pub(super) fn names(endings: &[String]) -> Vec<String> {
    let names = endings.iter().map(|ending| format!("{PICTURE}{ending}"));
    names.collect()
}

/// The contact node nearest to the centre of the box around all of them.
fn central_node(positions: &[[f64; 3]]) -> [f64; 3] {
    let centre: [f64; 3] = std::array::from_fn(|c| {
        let along = positions.iter().map(|x| x[c]);
        let low = along.clone().fold(f64::INFINITY, f64::min);
        low.midpoint(along.fold(f64::NEG_INFINITY, f64::max))
    });
    let distance = |x: &[f64; 3]| (0..3).map(|c| (x[c] - centre[c]).powi(2)).sum::<f64>();
    let nearest = positions
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.copied().unwrap_or_default()
}
