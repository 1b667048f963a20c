//! The theory of HKL §3, measured: constants, radii and contraction bound of a scene's meshes, and what Ψ really does.
//!
//! Ψ takes slips φ = (φ₁, φ₂) and a pressure g on the contact face to those of the frozen problem; its fixed points are the
//! solutions. HKL bound its Lipschitz modulus by q (3.13): q < 1 proves that there is one solution, and that successive
//! approximations find it. Every constant in q is an extreme eigenvalue or a small convex problem, and is computed as such
//! on the discrete spaces. Beside q stand the spectral radius and the norm of Ψ′ at the solution, the observed rate, and the
//! scales t of the law at which each of them reaches 1.
//!
//! The norm ‖·‖_{*,h} is taken over V₀^h, displacements without tangential part on Γ_c: that is what the proofs use. In
//! H¹(Ω)³ it is HKL's norm; in the energy norm, which couples components, it is smaller than that over V^h, by which the
//! proofs would fail.
//!
//! Source: J. Haslinger, R. Kučera, T. Ligurský, *J. Comput. Appl. Math.* 235 (2011) 3464, sections 2 and 3.

mod bound;
mod contraction;
mod dense;
mod face;
mod face_gram;
mod findings;
mod functional;
mod inf_sup;
mod interpolation;
mod level;
mod part_norms;
mod pencil;
mod problem;
mod quartic;
mod scaled;
mod scatter;
mod sobolev;
mod successive;
#[cfg(test)]
mod tests;
mod trace;

pub use bound::{ContractionBound, DisplacementNorm, FaceConstants, NormConstants, Radii};
pub use contraction::LocalContraction;
pub use findings::Findings;
pub use functional::FrictionFunctional;
pub use inf_sup::{InfSup, TrialSpace};
pub use level::TheoryLevel;
pub use part_norms::PartNorms;
pub use scaled::{ScaledPoint, Thresholds};
pub use successive::Observed;
pub use trace::TraceConstants;

use std::path::Path;

use serde::Serialize;

use crate::{
    contact::{Interface, LawBounds},
    convergence::{AccuracySettings, brick_n_div, nested_bricks, with_brick},
    mesh::Mesh,
    problem::{Problem, ProblemError},
    scene::{
        Brick, BrickFace, ElementOrder, FrictionModel, Invalid, ModelFeatures, Quantity, Scene,
        Written,
    },
};
use inf_sup::{BrickFaceGram, inf_sup};
use problem::TheoryProblem;

/// How far the ladder of meshes goes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TheorySettings {
    /// Smallest n_div of the meshes.
    pub coarsest: usize,
    /// n_div of the finest mesh, a multiple of the scene's own; that of the scene when not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finest: Option<usize>,
}

/// The theory of a scene on nested meshes.
#[derive(Debug, Clone, PartialEq)]
pub struct Theory {
    /// Constants of the law, the same on all meshes.
    pub law: LawConstants,
    /// Coarse to fine; one for a mesh file.
    pub levels: Vec<TheoryLevel>,
}

/// Constants of the law of friction, HKL (2.4), (3.10) and Lemma 3.5.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawConstants {
    /// F_min.
    pub smallest: f64,
    /// F_max.
    pub largest: f64,
    /// L in 1/m.
    pub lipschitz: f64,
    /// κ(F).
    pub anisotropy: f64,
    /// Whether they are estimates.
    pub estimated: bool,
}

/// What an observer sees before each mesh: its n_div, 0 for a mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TheoryProgress(pub usize);

impl Theory {
    /// Measures everything on every mesh; mesh files are looked for in `folder`.
    ///
    /// # Errors
    /// [`ProblemError::Invalid`] for a scene that the theory does not cover (without Coulomb friction, with a gap, with quadratic
    /// elements) and for a finest mesh in which the scene's own is not nested.
    pub fn measure(
        scene: &Scene,
        folder: &Path,
        settings: &TheorySettings,
        observe: &mut dyn FnMut(TheoryProgress),
    ) -> Result<Self, ProblemError> {
        require_covered(scene)?;
        let law = LawConstants::of(scene, folder)?;
        let levels = match scene.body.as_brick() {
            None => {
                observe(TheoryProgress(0));
                vec![TheoryProblem::new(scene.clone(), folder)?.measure(0)?]
            }
            Some(brick) => nested_levels(scene, brick, settings, observe)?,
        };
        Ok(Self { law, levels })
    }

    /// What the figures mean.
    #[must_use]
    pub fn findings(&self) -> Findings {
        Findings::new(self)
    }
}

/// The finest mesh first, since the stability of all others is measured against it.
fn nested_levels(
    scene: &Scene,
    brick: &Brick,
    settings: &TheorySettings,
    observe: &mut dyn FnMut(TheoryProgress),
) -> Result<Vec<TheoryLevel>, ProblemError> {
    let bricks = theory_bricks(scene, brick, settings)?;
    let contact = scene.contacts.first();
    let on = contact.and_then(|c| BrickFace::named(&c.face));
    let mut finest = None;
    let mut levels = Vec::new();
    for brick in bricks.into_iter().rev() {
        observe(TheoryProgress(brick_n_div(&brick)));
        let problem = TheoryProblem::new(with_brick(scene, &brick), Path::new(""))?;
        let mut level = problem.measure(brick_n_div(&brick))?;
        let here = BrickFaceGram {
            brick: &brick,
            face: &problem.face,
            gram: problem.sobolev_gram(),
        };
        let reference =
            finest
                .as_ref()
                .map(|(brick, face, gram)| BrickFaceGram { brick, face, gram });
        level.inf_sup = on.map_or_else(Vec::new, |on| inf_sup(on, &here, reference.as_ref()));
        levels.push(level);
        if finest.is_none() {
            let (face, gram) = problem.into_sobolev_gram();
            finest = Some((brick, face, gram));
        }
    }
    levels.reverse();
    Ok(levels)
}

/// The nested meshes of a brick, coarse to fine.
///
/// # Errors
/// A finest mesh in which the scene's own is not nested.
pub fn theory_bricks(
    scene: &Scene,
    brick: &Brick,
    settings: &TheorySettings,
) -> Result<Vec<Brick>, ProblemError> {
    let ladder = AccuracySettings {
        budget: 0.0,
        coarsest: settings.coarsest.min(brick_n_div(brick)),
        finest: settings.finest.or(Some(brick_n_div(brick))),
        ways: None,
        memory: None,
    };
    nested_bricks(scene, brick, &ladder)
}

/// Refuses what HKL §2 and §3 do not cover.
fn require_covered(scene: &Scene) -> Result<(), Invalid> {
    scene.require_no_history("the theory")?;
    let faces = ModelFeatures::of(scene).contact;
    if faces.len() > 1 {
        return Err(Invalid {
            key: "contact".into(),
            expected: "one contact face, as in HKL section 2".into(),
            found: format!("{} faces", faces.len()),
            help: "the norms and constants of HKL section 3 belong to one flat face with one law; leave the others out"
                .into(),
        });
    }
    match faces.first().map(|face| &face.friction) {
        Some(FrictionModel::Coulomb { .. } | FrictionModel::CappedCoulomb { .. }) => {}
        other => {
            return Err(Invalid {
                key: "friction".into(),
                expected: "Coulomb friction on a contact face".into(),
                found: match other {
                    None => "no contact".into(),
                    Some(model) => model.word().into(),
                },
                help: "other scenes are one minimisation: their solution is unique, and there is no mapping to study".into(),
            });
        }
    }
    let obstacle = faces.first().and_then(|face| face.obstacle.as_ref());
    if let Some(obstacle) = obstacle {
        return Err(Invalid {
            key: "contact.obstacle".into(),
            expected: "no obstacle, as in HKL section 2".into(),
            found: obstacle.word().into(),
            help: "there the contact face is flat and touches its foundation everywhere at first; leave the obstacle out".into(),
        });
    }
    let gap = faces.first().and_then(|face| face.gap.clone());
    if let Some(gap) = gap {
        return Err(Invalid {
            key: "contact.gap".into(),
            expected: "no gap, as in HKL section 2".into(),
            found: match gap {
                Quantity::Constant(value) => Written(&value).to_string(),
                _ => "a gap that varies".into(),
            },
            help:
                "the radii of Lemma 3.3 compare u with 0 and 2u, which a gap excludes; set it to 0"
                    .into(),
        });
    }
    if scene.body.element == ElementOrder::P2 {
        return Err(Invalid {
            key: "body.element".into(),
            expected: "\"P1\"".into(),
            found: "\"P2\"".into(),
            help: "quadratic interpolation does not preserve signs, which HKL (3.2) asks for"
                .into(),
        });
    }
    Ok(())
}

impl LawConstants {
    /// Over slips up to the extent of the body.
    fn of(scene: &Scene, folder: &Path) -> Result<Self, ProblemError> {
        let mesh = Mesh::of_scene(scene, folder)?;
        let extent = mesh.extent();
        let problem = Problem::of_checked(scene.clone(), std::sync::Arc::new(mesh))?;
        let law = problem.interface().and_then(Interface::coulomb);
        let bounds = LawBounds::new(law.expect("checked before").only(), extent);
        Ok(Self {
            smallest: bounds.smallest.value,
            largest: bounds.largest.value,
            lipschitz: bounds.lipschitz.value,
            anisotropy: bounds.anisotropy.value,
            estimated: bounds.estimated,
        })
    }
}
