//! Why a scene cannot be used, with the line that is at fault, and what it may say but probably does not intend.

use std::{fmt, ops::Range, string::FromUtf8Error};

use miette::{Diagnostic, NamedSource, SourceSpan};
use thiserror::Error;

use super::{Component, Contact, ElementOrder, Follow, Isotropic, Material, Scene, Written};

/// Why a scene file cannot be used; draws the offending line.
#[derive(Debug, Error, Diagnostic)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("cannot read the scene {path}")]
    #[diagnostic(help("give the path of a scene file, such as pipelines/hkl2011_table1.toml"))]
    Read {
        /// The path as given.
        path: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// Not text, or more of it than a scene has.
    #[error("{path}: {problem}")]
    #[diagnostic(help("{help}"))]
    NoScene {
        /// The path as given.
        path: String,
        /// What was expected and what was found.
        problem: String,
        /// What to do about it.
        help: &'static str,
    },
    /// Not TOML, or not the keys and types of a scene.
    #[error("{}: {}", text.name(), problem.message)]
    #[diagnostic(help("{}", problem.help))]
    Syntax {
        /// What is wrong, and what to do about it.
        problem: Box<SyntaxProblem>,
        /// The scene text.
        #[source_code]
        text: NamedSource<String>,
        /// Where it is.
        #[label("here")]
        span: Option<SourceSpan>,
    },
    /// A value that no problem of this kind can have.
    #[error("{}: {}: expected {}, found {}", text.name(), invalid.key, invalid.expected, invalid.found)]
    #[diagnostic(help("{}", invalid.help))]
    Invalid {
        /// The key, what was expected and what was found.
        invalid: Box<InvalidValue>,
        /// The scene text.
        #[source_code]
        text: NamedSource<String>,
        /// Where the key is.
        #[label("this value")]
        span: Option<SourceSpan>,
    },
}

/// What is wrong with a text that is no scene, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SyntaxProblem {
    /// The key, where the text is TOML, and what is wrong there.
    pub message: String,
    /// What to do about it.
    pub help: String,
    /// Where it is, in bytes.
    pub(super) span: Range<usize>,
}

/// An unusable value: the key, what it should be, what it is, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{key}: expected {expected}, found {found}; {help}")]
pub struct InvalidValue {
    /// Path of the key, such as `material.isotropic.poisson_ratio` or `traction.0.value`.
    pub key: String,
    /// What the model allows.
    pub expected: String,
    /// What the scene says.
    pub found: String,
    /// What to do about it.
    pub help: String,
}

impl InvalidValue {
    /// The same of the scene at the end of a step.
    #[must_use]
    pub fn in_step(self, step: usize) -> Self {
        Self {
            key: format!("step.{step}"),
            expected: format!("{}: {}", self.key, self.expected),
            ..self
        }
    }
}

/// What to do about a formula that is not finite somewhere.
pub(crate) const UNDEFINED: &str = "mind square roots, logarithms and divisions: sqrt(max(FORMULA, 0)) and if(x > 0, FORMULA, VALUE) are defined everywhere";

/// A place in words.
#[must_use]
pub(crate) fn place_words(at: [f64; 3]) -> String {
    format!("x, y, z = {}", numbers(&at))
}

/// Numbers in a row.
#[must_use]
pub fn numbers(values: &[f64]) -> String {
    let words: Vec<String> = values.iter().map(|v| Written(v).to_string()).collect();
    words.join(", ")
}

impl SceneError {
    pub(super) fn no_text(path: String, error: &FromUtf8Error) -> Self {
        let bytes = error.as_bytes();
        let byte = error.utf8_error().valid_up_to();
        let line = 1 + bytes[..byte].iter().filter(|b| **b == b'\n').count();
        let found = bytes[byte];
        Self::NoScene {
            path,
            problem: format!(
                "line {line}: expected UTF-8 text, found byte 0x{found:02x} (byte {byte} of the file)"
            ),
            help: "a scene is a TOML file, such as pipelines/hkl2011_table1.toml; save it as UTF-8",
        }
    }
}

/// Something in a scene that is allowed and probably not meant.
#[derive(Debug, Clone, PartialEq)]
pub enum Warning {
    /// A parameter that no formula uses.
    UnusedParameter {
        /// The parameter.
        name: String,
    },
    /// A nearly incompressible material on linear tetrahedra, which lock.
    Locking {
        /// The key of Poisson's ratio.
        key: String,
        /// Poisson's ratio.
        ratio: f64,
    },
    /// Components of a load that act on held displacements only.
    IdleLoad {
        /// The key of the load.
        key: String,
        /// Its components without effect.
        components: Vec<Component>,
    },
    /// A pressure that acts on held displacements only.
    IdlePressure {
        /// The key of the pressure.
        key: String,
    },
    /// A load whose formula changes so fast that integrals over triangles miss a part of it.
    UnresolvedLoad {
        /// The key of the load.
        key: String,
        /// The part, over the whole.
        share: f64,
    },
    /// A total force at a point far from the middle of what it loads.
    ReversedForce {
        /// The key of the point.
        key: String,
        /// The point in m.
        point: [f64; 3],
    },
    /// A tool to be followed from increment to increment where there are none.
    NothingToFollow {
        /// The key of what follows it.
        key: String,
    },
    /// A stiffer material than there is, as of lengths in mm with stresses in Pa.
    TooStiff {
        /// The key of Young's modulus.
        key: String,
    },
    /// A body of metres that is softer than rubber, as of lengths in mm with stresses in MPa where no unit is named.
    UnnamedUnits {
        /// The key of Young's modulus.
        key: String,
    },
    /// Glued faces that lie apart or overlap.
    ClosedGap {
        /// The key of the faces.
        key: String,
        /// Which of both, with the largest distance between them and its unit.
        gap: String,
    },
    /// A joint of glued faces that is narrower than triangles of one of them.
    NarrowJoint {
        /// The key of the faces.
        key: String,
        /// The face with the wide triangles.
        face: String,
        /// The largest share of one of them that the joint covers.
        cover: f64,
    },
    /// One of several bodies that no contact names.
    UntouchedBody {
        /// Its name.
        name: String,
    },
    /// A law of friction that is not positive and finite at slips that may never occur.
    LawLeavesRange {
        /// The key of the law.
        key: String,
        /// Its worst value.
        value: f64,
        /// Slips and place of that value in words.
        place: String,
    },
}

impl Scene {
    /// What the scene alone shows; loads and laws are looked at with the mesh.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let unused = self.unused_parameters().into_iter();
        unused
            .map(|name| Warning::UnusedParameter { name })
            .chain(self.locking())
            .chain(self.too_stiff())
            .chain(self.nothing_to_follow())
            .chain(self.untouched())
            .collect()
    }

    /// Of several bodies those that no contact is of, while others have one.
    fn untouched(&self) -> impl Iterator<Item = Warning> {
        let bodies = 0..self.bodies.len();
        let faces = || self.contacts.iter().flat_map(Contact::faces);
        let names = bodies.filter(move |body| {
            let prefix = self.face_prefix(*body);
            faces().next().is_some() && !faces().any(|face| face.starts_with(&prefix))
        });
        names.map(|body| Warning::UntouchedBody {
            name: self.body_name(body),
        })
    }

    /// The materials in which linear tetrahedra lock: they make a flat pad on 8 × 8 × 4 cells too stiff by 6 % at a Poisson's ratio of
    /// 0.45, by 16 % at 0.49 and by 69 % at 0.499 (docs/how_to/rubber.md).
    fn locking(&self) -> impl Iterator<Item = Warning> {
        let laws = self.isotropic();
        let ratios = laws.map(|(key, law)| (format!("{key}.poisson_ratio"), law.poisson_ratio));
        ratios
            .filter(|(_, ratio)| self.element() == ElementOrder::P1 && *ratio > 0.45)
            .map(|(key, ratio)| Warning::Locking { key, ratio })
    }

    /// The isotropic materials with their keys.
    fn isotropic(&self) -> impl Iterator<Item = (String, &Isotropic)> {
        self.materials()
            .filter_map(|(key, material)| match material {
                Material::Isotropic(law) => Some((format!("{key}.isotropic"), law)),
                Material::Orthotropic(_) | Material::Voigt(_) => None,
            })
    }
}

impl Scene {
    /// The contacts that are to follow tools where no steps make increments.
    fn nothing_to_follow(&self) -> impl Iterator<Item = Warning> {
        let without_steps = self
            .contacts
            .iter()
            .enumerate()
            .filter(|_| self.steps.is_empty());
        let followed = without_steps.filter(|(_, it)| it.follow == Some(Follow::Increment));
        followed.map(|(entry, _)| Warning::NothingToFollow {
            key: format!("{}.follow", self.contact_key(entry)),
        })
    }

    /// Young's moduli above twice that of diamond, 1.05e12 Pa.
    fn too_stiff(&self) -> impl Iterator<Item = Warning> {
        let most = self.units.from_pascals(2.1e12);
        self.isotropic()
            .filter(move |(_, law)| law.young_modulus > most)
            .map(|(key, _)| Warning::TooStiff {
                key: format!("{key}.young_modulus"),
            })
    }

    /// The first Young's modulus of solids in MPa, 1e3 to 1e6, where no unit is named and the body is longer than 5: in Pa that is a gel.
    #[must_use]
    pub fn unnamed_units(&self, mesh_extent: f64) -> Option<Warning> {
        let is_metric = self.units.is_default() && mesh_extent > 5.0;
        let mut laws = self.isotropic().filter(|_| is_metric);
        let (key, _) = laws.find(|(_, law)| (1e3..1e6).contains(&law.young_modulus))?;
        Some(Warning::UnnamedUnits {
            key: format!("{key}.young_modulus"),
        })
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnusedParameter { name } => write!(
                f,
                "parameters.{name}: no formula uses it; correct the name, or remove it"
            ),
            Self::Locking { key, ratio } => write!(
                f,
                "{key}: linear tetrahedra are far too stiff at {ratio}, so near to 0.5; write body.element = \"P2\""
            ),
            Self::IdleLoad { key, components } => {
                let names: Vec<&str> = components.iter().map(|c| c.word()).collect();
                let names = names.join(", ");
                write!(
                    f,
                    "{key}: its part along {names} does nothing, since clamps hold that displacement wherever \
                     it acts; set it to 0, or take {names} out of `components` of the clamp"
                )
            }
            Self::IdlePressure { key } => write!(
                f,
                "{key}: it does nothing, since clamps hold the displacement along the normal of the face; \
                 remove it, or take that direction out of `components` of the clamp"
            ),
            Self::UnresolvedLoad { key, share } => write!(
                f,
                "{key}: it varies inside triangles so much that their integrals differ by {:.1} % from those over a quarter each; refine the mesh there",
                100.0 * share
            ),
            Self::ReversedForce { key, point } => write!(
                f,
                "{key}: so far from the middle of the loaded part that some of that is drawn the other way; disc = {{ centre = [{}], radius = ... }} loads what lies around the point alone",
                numbers(point)
            ),
            Self::NothingToFollow { key } => write!(
                f,
                "{key}: without a [[step]] there are no increments, and normals and distances are those where the tool begins; add steps, or leave the key out"
            ),
            Self::TooStiff { key } => write!(
                f,
                "{key}: stiffer than any material; stresses are in the unit of force over that of length squared, with units.length = \"mm\" in N/mm^2 = MPa"
            ),
            Self::UnnamedUnits { key } => write!(
                f,
                "{key}: in Pa softer than rubber, of a body as long as a house; if lengths are in mm and stresses in MPa, write units.length = \"mm\", so that words and files say so"
            ),
            Self::ClosedGap { key, gap } => write!(
                f,
                "{key}: the glued faces {gap}, more than triangles leave of curved ones, and their nodes are moved to close that; if they should meet, move one body with body.origin"
            ),
            Self::NarrowJoint { key, face, cover } => write!(
                f,
                "{key}: the joint covers {:.0} % of a triangle of {face} at most, which makes it far too stiff; refine {face} there",
                100.0 * cover
            ),
            Self::UntouchedBody { name } => write!(
                f,
                "body {}: no contact names it, so that it passes through the others; write [[contact]] between = [...] of two faces where bodies may touch",
                Written(name)
            ),
            Self::LawLeavesRange { key, value, place } => {
                let remedy = if value.is_nan() {
                    "where the formula is not defined, choose a value with if(CONDITION, FORMULA, VALUE)"
                } else if *value > 0.0 {
                    "min(FORMULA, 1) stays below a bound"
                } else {
                    "max(FORMULA, 0.05) stays above a bound"
                };
                write!(
                    f,
                    "{key}: not 0 < F < infinity, at worst {} at {place}; if pressed panes \
                     slip so far, the solve counts as failed: {remedy}",
                    Written(value)
                )
            }
        }
    }
}
