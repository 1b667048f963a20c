//! The law of friction scaled by t: solutions, contraction and thresholds.

use super::level::TheoryProblem;
use contact3d::{
    ProblemError,
    contact::Interface,
    scene::SolveSettings,
    solver::{ContactState, Linearisation, Solution, Start, solve},
};

/// Scales in each decade, from the smallest to the largest.
const PER_DECADE: i32 = 4;
const SMALLEST: i32 = -2;
const LARGEST: i32 = 6;

/// Decades below that are gone down where a contraction is not yet below 1.
const LEAST: i32 = -12;

/// Halvings of a step in log t: 10^(1/4) to the power 2^-12 is 1.00014.
const HALVINGS: usize = 12;

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
    /// Goes from the smallest scale to the largest.
    pub(super) fn scan(problem: &'a TheoryProblem) -> Result<Self, ProblemError> {
        let mut scan = Self {
            problem,
            points: Vec::new(),
        };
        let mut start = None;
        for k in SMALLEST * PER_DECADE..=LARGEST * PER_DECADE {
            let (point, solution) = scan.at(scale(k), start.as_deref())?;
            scan.points.push(point);
            if point.solved {
                start = Some(solution.multiplier);
            }
        }
        let mut k = SMALLEST * PER_DECADE;
        let is_large = |p: &ScaledPoint| p.norm.iter().any(|norm| *norm > 1.0);
        while scan.points.first().is_some_and(is_large) && k > LEAST * PER_DECADE {
            k -= PER_DECADE;
            let (point, _) = scan.at(scale(k), None)?;
            scan.points.insert(0, point);
        }
        Ok(scan)
    }

    fn at(
        &self,
        scale: f64,
        start: Option<&[f64]>,
    ) -> Result<(ScaledPoint, Solution), ProblemError> {
        let contact = self.problem.contact();
        let interface = contact.interface.scaled(scale);
        let interface = interface.expect("Coulomb's law, as the study asked for");
        let contact = ContactState {
            interface: &interface,
            ..contact
        };
        let start = Start {
            multiplier: start,
            checkpoint: None,
        };
        let settings = SolveSettings::default();
        let solution = solve(
            self.problem.system(),
            Some(&contact),
            &settings,
            start,
            &mut |_| {},
        )?;
        Ok((self.point(scale, &interface, &solution), solution))
    }

    fn point(&self, scale: f64, interface: &Interface, solution: &Solution) -> ScaledPoint {
        let contraction = solution
            .status
            .is_solved()
            .then(|| self.problem.contraction(interface, solution, false))
            .flatten();
        let contact = ContactState {
            interface,
            ..self.problem.contact()
        };
        match contraction {
            None => ScaledPoint {
                scale,
                solved: false,
                spectral_radius: f64::NAN,
                norm: [f64::NAN; 2],
                determinant: 0,
            },
            Some(found) => ScaledPoint {
                scale,
                solved: true,
                spectral_radius: found.spectral_radius,
                norm: [found.parts[0].weighted(), found.parts[1].weighted()],
                determinant: Linearisation::new(
                    self.problem.dual(),
                    &contact.laws(),
                    &solution.multiplier,
                )
                .determinant,
            },
        }
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
        let mut start = self.at(low, None)?.1.multiplier;
        for _ in 0..HALVINGS {
            let middle = (low * high).sqrt();
            let (point, solution) = self.at(middle, Some(&start))?;
            if point.solved && is_beyond(&point) {
                high = middle;
            } else {
                low = middle;
                start = solution.multiplier;
            }
        }
        Ok(Some((low * high).sqrt()))
    }
}

fn scale(k: i32) -> f64 {
    10f64.powf(f64::from(k) / f64::from(PER_DECADE))
}
