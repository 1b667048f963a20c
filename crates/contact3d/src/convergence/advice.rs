//! What both errors of a scene mean for its tolerance and its mesh.

use std::fmt;

use super::{Accuracy, AlgebraicLadder, EPSILONS, Level};

/// An algebraic error of this share of the discretisation error is too small to matter: errors add
/// as squares, so it changes the whole by half a per cent.
const NEGLIGIBLE_SHARE: f64 = 0.1;

/// What the ladders mean for someone who has the scene's mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Advice {
    /// n_div of the scene's mesh; `None` for a mesh file.
    pub n_div: Option<usize>,
    /// The relative discretisation error in the energy norm, extrapolated; where no order is
    /// observed, the difference to the finest mesh, which it exceeds.
    pub discretisation_error: Option<f64>,
    /// Whether the error is extrapolated.
    pub extrapolated: bool,
    /// The loosest ε from which on every method's algebraic error stays below a tenth of the
    /// discretisation error.
    pub sufficient_epsilon: Option<f64>,
    /// What the next mesh brings.
    pub refinement: Option<Refinement>,
}

/// The next mesh compared with the scene's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refinement {
    /// Its n_div.
    pub n_div: usize,
    /// Its seconds over those of the scene's mesh.
    pub cost_ratio: f64,
    /// The scene's error over its error; `None` without extrapolation.
    pub error_ratio: Option<f64>,
}

impl Advice {
    /// Reads the advice off both ladders.
    #[must_use]
    pub fn new(accuracy: &Accuracy) -> Self {
        let mut advice = Self {
            n_div: None,
            discretisation_error: None,
            extrapolated: false,
            sufficient_epsilon: None,
            refinement: None,
        };
        let Some(ladder) = &accuracy.discretisation else {
            return advice;
        };
        advice.n_div = Some(ladder.scene_n_div);
        let Some(here) = ladder.scene_level() else {
            return advice;
        };
        let is_finest = ladder.levels.last() == Some(here);
        advice.extrapolated = here.energy_error.is_some();
        advice.discretisation_error = here
            .energy_error
            .or((!is_finest).then_some(here.energy_difference));
        let finer = ladder.levels.iter().find(|l| l.n_div > here.n_div);
        advice.refinement = finer.map(|finer| Refinement::new(here, finer));
        advice.sufficient_epsilon = accuracy
            .algebraic
            .as_ref()
            .zip(advice.discretisation_error)
            .and_then(|(ladder, error)| sufficient_epsilon(ladder, NEGLIGIBLE_SHARE * error));
        advice
    }
}

impl Refinement {
    fn new(here: &Level, finer: &Level) -> Self {
        Self {
            n_div: finer.n_div,
            cost_ratio: finer.cost.seconds / here.cost.seconds,
            error_ratio: here
                .energy_error
                .zip(finer.energy_error)
                .map(|(here, finer)| here / finer),
        }
    }
}

/// The loosest ε from which on every solve that ran has an energy error of at most `bound`.
fn sufficient_epsilon(ladder: &AlgebraicLadder, bound: f64) -> Option<f64> {
    let good = |epsilon: f64| {
        let results = ladder
            .entries
            .iter()
            .filter(|entry| entry.epsilon == epsilon);
        let mut solved = results
            .filter_map(|entry| entry.result)
            .filter(|result| result.status.is_solved())
            .peekable();
        solved.peek().is_some() && solved.all(|result| result.energy_error <= bound)
    };
    let strict_first = EPSILONS.into_iter().rev();
    strict_first.take_while(|&epsilon| good(epsilon)).last()
}

impl fmt::Display for Advice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(n_div) = self.n_div else {
            return f.write_str(
                "A mesh file has no finer meshes, so its discretisation error is not known.",
            );
        };
        match self.discretisation_error {
            None => write!(
                f,
                "At this mesh (n_div = {n_div}) the discretisation error is not known"
            )?,
            Some(error) => write!(
                f,
                "At this mesh (n_div = {n_div}) the discretisation error is {}{:.2} % in the energy norm",
                if self.extrapolated { "" } else { "at least " },
                100.0 * error
            )?,
        }
        if let Some(epsilon) = self.sufficient_epsilon {
            write!(f, "; epsilon below {epsilon:.0e} buys nothing")?;
        }
        if let Some(next) = self.refinement {
            write!(
                f,
                "; refining to n_div = {} costs {:.1} times the time",
                next.n_div, next.cost_ratio
            )?;
            if let Some(ratio) = next.error_ratio {
                write!(f, " and divides the error by {ratio:.2}")?;
            }
        }
        f.write_str(".")
    }
}
