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
mod inf_sup;
mod interpolation;
mod level;
mod quartic;
mod scaled;
mod successive;
mod trace;

pub use bound::{
    ContractionBound, DisplacementNorm, FaceConstants, FrictionFunctional, NormConstants, Radii,
};
pub use contraction::LocalContraction;
pub use inf_sup::{InfSup, TrialSpace};
pub use level::TheoryLevel;
pub use scaled::{ScaledPoint, Thresholds};
pub use successive::Observed;
pub use trace::{PartNorms, TraceConstants};

use std::{fmt, path::Path};

use serde::Serialize;

use crate::{
    accuracy::{AccuracySettings, brick_n_div, effort, nested_bricks, with_brick},
    progress::{Pieces, StudyStep},
};
use contact3d::{
    Problem, ProblemError,
    contact::{Interface, LawBounds},
    mesh::Mesh,
    scene::{Brick, BrickFace, GmshFile, InvalidValue, Scene},
};
use face::require_covered;
use inf_sup::{BrickFaceGram, inf_sup};
use level::TheoryProblem;
use scaled::ScaledLaws;

/// Which meshes are measured.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct TheorySettings {
    /// Smallest n_div of the meshes.
    pub coarsest: usize,
    /// n_div of the finest mesh, a multiple of the scene's own; that of the scene when not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finest: Option<usize>,
    /// Gmsh files of the same body, in place of the scene's own mesh; empty for a brick.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<GmshFile>,
}

/// The theory of a scene on its meshes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Theory {
    /// Constants of the law, the same on all meshes.
    pub law: LawConstants,
    /// Coarse to fine.
    pub levels: Vec<TheoryLevel>,
}

/// Constants of the law of friction, HKL (2.4), (3.10) and Lemma 3.5.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
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
        observe: &mut dyn FnMut(StudyStep),
    ) -> Result<Self, ProblemError> {
        require_covered(scene)?;
        let law = LawConstants::of(scene, folder)?;
        let pieces = &mut Pieces::new(observe);
        pieces.figure(format!(
            "coefficients of friction from {:.4} to {:.4}, Lipschitz modulus {:.4e} per {}",
            law.smallest,
            law.largest,
            law.lipschitz,
            scene.units.length()
        ));
        let levels = match scene.body.as_brick() {
            None => levels_of_files(scene, folder, &settings.meshes, pieces)?,
            Some(_) if !settings.meshes.is_empty() => return Err(no_file().into()),
            Some(brick) => nested_levels(scene, brick, settings, pieces)?,
        };
        Ok(Self { law, levels })
    }

    /// What the figures mean.
    #[must_use]
    pub fn findings(&self) -> Findings {
        Findings::new(self)
    }
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

/// The meshes of several files, or of the scene's own. They are not nested, so panes of one are not panes of another, and no space of
/// multipliers is measured against a finer mesh.
fn levels_of_files(
    scene: &Scene,
    folder: &Path,
    files: &[GmshFile],
    pieces: &mut Pieces<'_>,
) -> Result<Vec<TheoryLevel>, ProblemError> {
    let own = scene.body.mesh_file().cloned();
    let files = match files {
        [] => own.into_iter().collect(),
        files => files.to_vec(),
    };
    let mut levels = Vec::new();
    let work = LevelPieces::announce(files.iter().map(|_| 1.0), pieces);
    for file in files {
        let name = file.file.display().to_string();
        let mut changed = scene.clone();
        if let Some(own) = changed.body.mesh_file_mut() {
            *own = file;
        }
        let mut work = LevelWork {
            kinds: work,
            mesh: name,
            effort: 1.0,
            pieces,
        };
        work.constants();
        levels.push(TheoryProblem::new(changed, folder)?.measure(0, &mut work)?);
    }
    levels.sort_by_key(|level| level.n_free);
    Ok(levels)
}

/// What the work on all meshes is announced as.
#[derive(Debug, Clone, Copy)]
struct LevelPieces {
    constants: usize,
    scaled: usize,
}

impl LevelPieces {
    /// Announces meshes by their efforts.
    fn announce(efforts: impl Iterator<Item = f64>, pieces: &mut Pieces<'_>) -> Self {
        let [constants, scaled] = [pieces.kind(None), pieces.kind(None)];
        for effort in efforts {
            pieces.announce(constants, effort);
            for share in ScaledLaws::efforts() {
                pieces.announce(scaled, share * effort);
            }
        }
        Self { constants, scaled }
    }
}

/// The work on a mesh.
struct LevelWork<'a, 'b> {
    kinds: LevelPieces,
    mesh: String,
    effort: f64,
    pieces: &'a mut Pieces<'b>,
}

impl LevelWork<'_, '_> {
    fn constants(&mut self) {
        let words = format!("{}: constants", self.mesh);
        self.pieces.begin(self.kinds.constants, self.effort, words);
    }

    /// A piece of the scaled laws, a share of their effort.
    fn scaled(&mut self, share: f64, words: &str) {
        let words = format!("{}: {words}", self.mesh);
        let effort = share * self.effort;
        self.pieces.begin(self.kinds.scaled, effort, words);
    }

    fn figure(&mut self, words: &str) {
        self.pieces.figure(format!("{}: {words}", self.mesh));
    }
}

fn no_file() -> InvalidValue {
    InvalidValue {
        key: "body.gmsh".into(),
        expected: "a body from a Gmsh file, of which other files are finer or coarser meshes"
            .into(),
        found: "a brick".into(),
        help: "leave the mesh files out: the coarser meshes of a brick are made of its own cells"
            .into(),
    }
}

/// The finest mesh first, since the stability of all others is measured against it.
fn nested_levels(
    scene: &Scene,
    brick: &Brick,
    settings: &TheorySettings,
    pieces: &mut Pieces<'_>,
) -> Result<Vec<TheoryLevel>, ProblemError> {
    let bricks = theory_bricks(scene, brick, settings)?;
    let contact = scene.contacts.first();
    let on = contact.and_then(|c| BrickFace::named(&c.face));
    let mut finest = None;
    let mut levels = Vec::new();
    let work = LevelPieces::announce(bricks.iter().map(effort), pieces);
    for brick in bricks.into_iter().rev() {
        let name = format!("n_div = {}", brick_n_div(&brick));
        let mut work = LevelWork {
            kinds: work,
            mesh: name,
            effort: effort(&brick),
            pieces,
        };
        work.constants();
        let problem = TheoryProblem::new(with_brick(scene, &brick), Path::new(""))?;
        let mut level = problem.measure(brick_n_div(&brick), &mut work)?;
        let here = BrickFaceGram {
            brick: &brick,
            face: &problem.face,
            gram: &problem.grams[0],
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
    let settings = AccuracySettings {
        coarsest: settings.coarsest.min(brick_n_div(brick)),
        finest: settings.finest.or(Some(brick_n_div(brick))),
        ..AccuracySettings::default()
    };
    nested_bricks(scene, brick, &settings)
}

/// A rate and an eigenvalue that differ by less than this agree.
const AGREE: f64 = 0.02;

/// Rates outside of this range are too fast or too slow to observe.
const OBSERVABLE: [f64; 2] = [0.02, 0.98];

/// What the measured theory means for its finest mesh, and how far bound and truth are apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Findings {
    /// n_div of the mesh; 0 for a mesh file.
    pub n_div: usize,
    /// Scale of the law up to which HKL's bound is below 1, in the energy norm with the best weight.
    pub proved: f64,
    /// The same with composed constants, which is a proof of uniqueness.
    pub proved_sharply: f64,
    /// Whether HKL's bound uses c_tr⁽⁴⁾, which is known from below only: then it is no proof.
    pub is_lower: bool,
    /// Whether constants of the law are estimates: then nothing is a proof.
    pub is_estimated: bool,
    /// Scale up to which successive approximations contract near the solutions followed from the smallest scale; `None` where they do near
    /// every one found up to 1e6.
    pub contracts: Option<f64>,
    /// The spectral radius near the solution that was followed to the law itself.
    pub followed: Option<f64>,
    /// Exponents p of H^p of the scale proved and of the one observed between the two finest meshes.
    pub exponents: [Option<f64>; 2],
    /// The spectral radius and the rate observed.
    pub rates: Option<[f64; 2]>,
    /// Whether a value of Ψ left the set of HKL Lemma 3.3, which would be an error of this program.
    pub lemma_fails: bool,
}

impl Findings {
    fn new(theory: &Theory) -> Self {
        let finest = theory.levels.last();
        let before = theory.levels.iter().rev().nth(1);
        let exponent = |of: &dyn Fn(&TheoryLevel) -> Option<f64>| {
            let (fine, coarse) = (finest?, before?);
            let sizes = (fine.face.pane_size / coarse.face.pane_size).ln();
            let power = (of(fine)? / of(coarse)?).ln() / sizes;
            Some(power).filter(|power| power.is_finite())
        };
        let proved = |level: &TheoryLevel| level.thresholds.weighted[1];
        let contracts = |level: &TheoryLevel| level.thresholds.spectral_radius;
        let levels = theory.levels.iter();
        let lemma = levels.flat_map(|l| l.observed.lemma.iter().flatten());
        Self {
            n_div: finest.map_or(0, |level| level.n_div),
            proved: finest.map_or(f64::NAN, proved),
            proved_sharply: finest.map_or(f64::NAN, |level| level.thresholds.sharp[1]),
            is_lower: theory.law.lipschitz > 0.0,
            is_estimated: theory.law.estimated,
            contracts: finest.and_then(contracts),
            followed: finest.and_then(|level| {
                let mut points = level.scaled.iter();
                let itself = points.find(|point| point.solved && point.scale == 1.0);
                itself.map(|point| point.spectral_radius)
            }),
            exponents: [exponent(&|level| Some(proved(level))), exponent(&contracts)],
            rates: finest.and_then(|level| {
                Some([level.local.as_ref()?.spectral_radius, level.observed.rate])
            }),
            lemma_fails: lemma.copied().any(|share| share.is_nan() || share > 1.0),
        }
    }

    /// The spectral radius at the solution followed to the law itself, where it tells that from the solution found without following.
    #[must_use]
    pub fn other_followed(&self) -> Option<f64> {
        let ([radius, _], followed) = (self.rates?, self.followed?);
        let apart = (radius - followed).abs() > AGREE * radius.max(followed).max(AGREE);
        apart.then_some(followed)
    }

    /// Whether the rate that was observed is the spectral radius to 2 %; `None` where it is too fast or too slow to be
    /// observed.
    #[must_use]
    pub fn rates_agree(&self) -> Option<bool> {
        let [radius, rate] = self.rates?;
        let observable = OBSERVABLE[0] < radius && radius < OBSERVABLE[1];
        observable.then(|| (rate / radius - 1.0).abs() <= AGREE)
    }
}

impl fmt::Display for Findings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mesh = match self.n_div {
            0 => "On the finest mesh".to_owned(),
            n => format!("At n_div = {n}"),
        };
        write!(
            f,
            "{mesh} uniqueness {} for this law scaled by less than {:.2e}, by the bound with composed constants; that of HKL (3.13) gives {:.2e}{}; near the solutions followed from the smallest scale successive approximations contract ",
            if self.is_estimated {
                "would follow, were the estimated constants of the law bounds,"
            } else {
                "is proven"
            },
            self.proved_sharply,
            self.proved,
            if self.is_lower {
                ", with c_tr(4) from an ascent, so no proof"
            } else {
                ""
            }
        )?;
        match self.contracts {
            Some(scale) => write!(
                f,
                "up to {scale:.3}, {:.1e} times as far",
                scale / self.proved_sharply
            )?,
            None => f.write_str("at every scale solved, up to 1e6")?,
        }
        if let [Some(proved), observed] = self.exponents {
            write!(
                f,
                ". Between the two finest meshes the scale of (3.13) goes like H^{proved:.2}"
            )?;
            if let Some(observed) = observed {
                write!(f, ", the true one like H^{observed:.2}")?;
            }
        }
        if let Some([radius, rate]) = self.rates {
            write!(
                f,
                ". At the solution of the law itself the spectral radius is {radius:.4}, "
            )?;
            if rate.is_nan() {
                f.write_str("and no rate is observed")?
            } else {
                write!(f, "the observed rate {rate:.4}")?
            }
            if let Some(followed) = self.other_followed() {
                write!(
                    f,
                    "; another solution, the one followed to it, has {followed:.4}"
                )?;
            }
        }
        f.write_str(".")
    }
}
