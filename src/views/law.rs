//! A law of friction alone: its bounds and its picture, without a run file.

use std::path::{Path, PathBuf};

use contact3d::{
    contact::{FrictionField, Interface, LawBounds},
    mesh::{Mesh, Quality, Refinement},
    scene::{FrictionModel, Invalid, ModelFeatures, Scene, SceneFile, Warning},
};
use plots::{LawPicture, OverSlip, law_page};

use super::{
    PictureFolder,
    law_curves::{self, Drawn},
    law_face::LawFace,
    picture,
};
use crate::pipeline::{StageError, mesh_of, pin_mesh_file};

/// Name of the picture.
pub(super) const PICTURE: &str = "law";

/// A law of friction by itself: its bounds and its picture, from the mesh alone and without a run
/// file.
#[derive(Debug)]
pub struct LawStudy {
    /// The scene.
    pub scene: Scene,
    /// Bounds of Coulomb's law; `None` for other laws.
    pub bounds: Option<LawBounds>,
    mesh: Mesh,
    interface: Option<Interface>,
}

/// The lengths of a discretisation that the uniqueness conditions of HKL §3 are stated in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshSizes {
    /// H: the root of the area of the largest pane, in m.
    pub pane: f64,
    /// h: the longest edge, in m.
    pub edge: f64,
}

impl LawStudy {
    /// Makes the mesh in memory and bounds the law.
    ///
    /// # Errors
    /// A mesh that cannot be made, a law that is no law.
    pub fn new(mut input: SceneFile) -> Result<Self, StageError> {
        pin_mesh_file(&mut input)?;
        if input.scene.contacts.len() > 1 {
            return Err(input
                .refuse(several_faces(input.scene.contacts.len()))
                .into());
        }
        let mesh = mesh_of(&input, &Refinement::default())?;
        let interface =
            Interface::new(&input.scene, &mesh).map_err(|invalid| input.refuse(invalid))?;
        let law = interface.as_ref().and_then(Interface::coulomb);
        Ok(Self {
            bounds: law.map(|law| LawBounds::new(law.only(), mesh.extent())),
            scene: input.scene,
            mesh,
            interface,
        })
    }

    /// The law of tangential stresses; `None` without contact.
    #[must_use]
    pub fn model(&self) -> Option<FrictionModel> {
        ModelFeatures::of(&self.scene).friction().next().cloned()
    }

    /// What is allowed in the scene and probably not meant.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = self.scene.warnings();
        if let Some(interface) = &self.interface {
            let length = self.scene.units.length();
            warnings.extend(interface.warnings(self.mesh.extent(), length));
        }
        warnings
    }

    /// H and h; `None` without contact.
    #[must_use]
    pub fn sizes(&self) -> Option<MeshSizes> {
        let panes = self.mesh.contact.as_ref()?.pane_area.iter();
        Some(MeshSizes {
            pane: panes.copied().fold(0.0, f64::max).sqrt(),
            edge: Quality::of(&self.mesh).longest_edge,
        })
    }

    /// Draws Coulomb's law as `law.svg` and `law.png`; returns the files, none for other laws.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn draw(&self, folder: &PictureFolder) -> Result<Vec<PathBuf>, StageError> {
        let (Some(surface), Some(interface)) = (&self.mesh.contact, &self.interface) else {
            return Ok(Vec::new());
        };
        let Some(law) = interface.coulomb() else {
            return Ok(Vec::new());
        };
        let only = law.only();
        let place = central_node(only.positions());
        let drawn = law_curves::over_slip(only.law(), place, self.mesh.extent());
        let varies = only.law().depends_on_place();
        let note = if varies && law.depends_on_slip() {
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
        let field = FrictionField::new(law, surface, &[]);
        let face = LawFace::new(&self.mesh, surface, &field);
        let title = self.scene.shown_title();
        let drawing = LawPicture {
            title: &title,
            units: self.scene.units,
            note: &note,
            over_slip: match &drawn {
                Drawn::Isotropic(curve) => OverSlip::Isotropic(curve),
                Drawn::Own(curves) => OverSlip::Own(curves),
                Drawn::Both(maps) => OverSlip::Both(maps),
            },
            at_rest: varies.then(|| face.picture(&title, self.scene.units, &interface.frame)),
        };
        let page = law_page(&drawing).map_err(|source| StageError::Figure {
            file: folder.path().join(format!("{PICTURE}.svg")),
            source,
        })?;
        folder.save([(PICTURE, page, picture::PAGE_WIDTH)])
    }
}

fn several_faces(found: usize) -> Invalid {
    Invalid {
        key: "contact".into(),
        expected: "one contact face, whose law is looked at by itself".into(),
        found: format!("{found} faces"),
        help: "leave the others out; the laws of all faces are in the pictures of a run".into(),
    }
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

/// The folder in the current directory in which the picture of a scene's law goes by default.
#[must_use]
pub fn law_folder(scene: &Path) -> PathBuf {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    PathBuf::from(format!("{stem}-law"))
}
