//! The law of friction scaled by t: solutions, contraction and thresholds.

use super::{LevelWork, level::TheoryProblem};
use contact3d::{
    ProblemError,
    scene::SolveSettings,
    solver::{ContactState, Start, solve},
};

/// Scales in each decade, from the smallest to the largest.
const PER_DECADE: i32 = 4;
const SMALLEST: i32 = -2;
const LARGEST: i32 = 6;

/// Decades below that are gone down where a contraction is not yet below 1.
const LEAST: i32 = -12;

/// Halvings of a step in log t: 10^(1/4) to the power 2^-12 is 1.00014.
const HALVINGS: usize = 12;

/// Effort of all thresholds, as so many scales: up to four are bisected.
const THRESHOLDS: f64 = 4.0 * HALVINGS as f64;

/// The solution for the law t F that was found, and Ψ′ there.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ScaledPoint {
    /// t.
    pub scale: f64,
    /// Whether a solution was found; if not, the figures are NaN and 0.
    pub solved: bool,
    /// The spectral radius of Ψ′.
    pub spectral_radius: f64,
    /// The weighted norm of Ψ′ ([`super::PartNorms::weighted`]), for each norm of displacements.
    pub norm: [f64; 2],
    /// Sign of det R′ of the natural map.
    pub determinant: i8,
}

/// The smallest scales t at which the law t F reaches a limit; `None` where none is reached up to 1e6.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Thresholds {
    /// q = 1 for HKL's bound in the units of the scene, for each norm of displacements.
    pub paper: [f64; 2],
    /// q = 1 with the best weight.
    pub weighted: [f64; 2],
    /// q = 1 with composed constants.
    pub sharp: [f64; 2],
    /// The weighted norm of Ψ′ is 1.
    pub norm: [Option<f64>; 2],
    /// The spectral radius of Ψ′ is 1.
    pub spectral_radius: Option<f64>,
    /// det R′ changes its sign.
    pub singular: Option<f64>,
}

/// Solutions for scaled laws, each from the one before.
pub(super) struct ScaledLaws<'a> {
    problem: &'a TheoryProblem,
    /// Found so far, by increasing scale.
    pub(super) points: Vec<ScaledPoint>,
}

impl<'a> ScaledLaws<'a> {
    /// Efforts of the scales, and of the thresholds between them.
    pub(super) fn efforts() -> impl Iterator<Item = f64> {
        let scales = SMALLEST * PER_DECADE..=LARGEST * PER_DECADE;
        scales.map(|_| 1.0).chain([THRESHOLDS])
    }

    /// Goes from the smallest scale to the largest.
    pub(super) fn scan(
        problem: &'a TheoryProblem,
        work: &mut LevelWork<'_, '_>,
    ) -> Result<Self, ProblemError> {
        let mut scan = Self {
            problem,
            points: Vec::new(),
        };
        let mut start = None;
        for k in SMALLEST * PER_DECADE..=LARGEST * PER_DECADE {
            work.scaled(1.0, &format!("law scaled by {:.3e}", scale(k)));
            let (point, multiplier) = scan.at(scale(k), start.as_deref())?;
            scan.points.push(point);
            if point.solved {
                start = Some(multiplier);
            }
        }
        work.scaled(THRESHOLDS, "thresholds");
        let mut k = SMALLEST * PER_DECADE;
        let is_large = |p: &ScaledPoint| p.norm.iter().any(|norm| *norm > 1.0);
        while scan.points.first().is_some_and(is_large) && k > LEAST * PER_DECADE {
            k -= PER_DECADE;
            let (point, _) = scan.at(scale(k), None)?;
            scan.points.insert(0, point);
        }
        Ok(scan)
    }

    /// What was found for the law at a scale, and λ.
    fn at(
        &self,
        scale: f64,
        start: Option<&[f64]>,
    ) -> Result<(ScaledPoint, Vec<f64>), ProblemError> {
        let (problem, contact) = (self.problem, self.problem.contact());
        let interface = contact.interface.scaled(scale);
        let interface = &interface.expect("Coulomb's law, as the study asked for");
        let contact = ContactState {
            interface,
            ..contact
        };
        let start = Start {
            multiplier: start,
            checkpoint: None,
        };
        let settings = SolveSettings::default();
        let (system, contact) = (problem.system(), Some(&contact));
        let solution = solve(system, contact, &settings, start, &mut |_| {})?;
        let mut point = ScaledPoint {
            scale,
            solved: false,
            spectral_radius: f64::NAN,
            norm: [f64::NAN; 2],
            determinant: 0,
        };
        if solution.status.is_solved()
            && let Some(found) = problem.contraction(interface, &solution, false)
        {
            point.solved = true;
            point.spectral_radius = found.spectral_radius;
            point.norm = [0, 1].map(|k| found.parts[k].weighted());
            point.determinant = problem.determinant(interface, &solution.multiplier);
        }
        Ok((point, solution.multiplier))
    }

    /// The smallest scale at which a measure, small for small scales, turns true, to four digits.
    pub(super) fn first(
        &self,
        is_beyond: impl Fn(&ScaledPoint) -> bool,
    ) -> Result<Option<f64>, ProblemError> {
        let solved: Vec<&ScaledPoint> = self.points.iter().filter(|p| p.solved).collect();
        let Some(place) = solved.iter().position(|p| is_beyond(p)) else {
            return Ok(None);
        };
        let Some(below) = place.checked_sub(1) else {
            return Ok(Some(solved[place].scale));
        };
        let (mut low, mut high) = (solved[below].scale, solved[place].scale);
        let (_, mut start) = self.at(low, None)?;
        for _ in 0..HALVINGS {
            let middle = (low * high).sqrt();
            let (point, multiplier) = self.at(middle, Some(&start))?;
            if point.solved && is_beyond(&point) {
                high = middle;
            } else {
                low = middle;
                start = multiplier;
            }
        }
        Ok(Some((low * high).sqrt()))
    }
}

fn scale(k: i32) -> f64 {
    10f64.powf(f64::from(k) / f64::from(PER_DECADE))
}
