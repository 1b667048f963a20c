//! How far an answer can be trusted: conditioning, agreement of independent algorithms, and
//! invariance under all that must not matter.

mod conditioning;
mod cross_checks;
mod explicit_problem;
mod invariance;

pub use conditioning::{Conditioning, RoundingBound, Spectrum};
pub use cross_checks::{CrossCheck, CrossCheckResult};
pub use invariance::{Invariance, InvarianceResult};

use std::{fmt, path::Path, time::Instant};

use crate::StudyStep;
use explicit_problem::ExplicitProblem;

use contact3d::{
    ProblemError,
    linalg::Precision,
    post::Zone,
    scene::Scene,
    solver::{Linearisation, SolvedBy, Start, Status},
};

/// How much is checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// Conditioning, algorithms, certificate.
    Solve,
    /// These, and the problem in every other description.
    Invariances,
}

/// How many solutions are expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solutions {
    /// One, on which all algorithms must agree.
    One,
    /// Several: an algorithm may find another one, if it is one.
    Several,
}

/// All that is known of one problem.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// How many solutions were expected.
    pub solutions: Solutions,
    /// Free degrees of freedom.
    pub n_free: usize,
    /// Multipliers.
    pub n_multipliers: usize,
    /// Precision of the factor that the scene's own settings took.
    pub precision: Precision,
    /// How the solve with the scene's own settings ended.
    pub status: Status,
    /// Which algorithm gave the answer.
    pub solved_by: SolvedBy,
    /// Steps of Newton's method, and of successive approximations.
    pub steps: [usize; 2],
    /// The accuracy ε at which the solver stops.
    pub asked: f64,
    /// The error that a user accepts: ε where the scene sets it, else [`TRUSTED`].
    pub wanted: f64,
    /// The accuracy that the solver says it reached.
    pub accuracy: f64,
    /// Open, sticking and slipping panes.
    pub zones: [usize; 3],
    /// The largest figure of the certificate.
    pub certificate: f64,
    /// Condition of A and S.
    pub conditioning: Conditioning,
    /// R' at the answer.
    pub linearisation: Linearisation,
    /// What rounding allows.
    pub rounding_bound: RoundingBound,
    /// What other algorithms found.
    pub cross_checks: Vec<CrossCheckResult>,
    /// What other descriptions of the problem gave; empty unless asked for.
    pub invariances: Vec<InvarianceResult>,
    /// Wall-clock seconds of assembly and solve, without the comparisons.
    pub seconds: f64,
}

impl Check {
    /// Checks a scene with contact; mesh files are looked for in `folder`. An answer from a factor in single precision is held
    /// against those from one in double precision.
    ///
    /// # Errors
    /// [`ProblemError`] for a scene that has no discrete problem.
    pub fn new(
        scene: &Scene,
        folder: &Path,
        effort: Effort,
        solutions: Solutions,
        observe: &mut dyn FnMut(StudyStep),
    ) -> Result<Self, ProblemError> {
        observe(StudyStep::Begin("answer".to_owned()));
        let started = Instant::now();
        let own = ExplicitProblem::new(scene.clone(), folder)?;
        scene.solve.validate()?;
        let mut answer = own
            .assembled
            .solve_from(&scene.solve, Start::default(), &mut |_| {})?;
        let seconds = started.elapsed().as_secs_f64();
        let double = own.in_double_precision(scene, folder)?;
        let problem = double.as_ref().unwrap_or(&own);
        let report = problem.assembled.report(&answer)?;
        report.classify(&mut answer);
        observe(StudyStep::Figure(format!(
            "{} in {seconds:.2} s, certificate {:.1e}",
            answer.status.word().replace('_', " "),
            report.certificate.worst()
        )));
        observe(StudyStep::Begin("conditioning".to_owned()));
        let laws = problem.contact().laws();
        let unknowns = problem.unknowns(&answer.multiplier, &answer);
        let linearisation = Linearisation::new(problem.dual(), &laws, &unknowns);
        let conditioning = Conditioning::of(problem);
        Ok(Self {
            solutions,
            n_free: answer.displacement.len(),
            n_multipliers: answer.multiplier.len(),
            precision: own.precision(),
            status: answer.status,
            solved_by: answer.trace.solved_by,
            steps: [answer.trace.newton.len(), answer.trace.history.len()],
            asked: scene.solve.epsilon(),
            wanted: scene.solve.epsilon.unwrap_or(TRUSTED),
            accuracy: answer.accuracy,
            zones: [Zone::Open, Zone::Stick, Zone::Slip].map(|zone| report.count(zone)),
            certificate: report.certificate.worst(),
            rounding_bound: RoundingBound::of(
                problem,
                &answer,
                &report,
                &conditioning,
                &linearisation,
            ),
            conditioning,
            linearisation,
            cross_checks: cross_checks::compare(problem, &answer, observe)?,
            invariances: match effort {
                Effort::Solve => Vec::new(),
                Effort::Invariances => invariance::compare(&own, folder, &answer, observe)?,
            },
            seconds,
        })
    }

    /// What an algorithm found; `None` where it was not asked.
    #[must_use]
    pub fn cross_check(&self, cross_check: CrossCheck) -> Option<&CrossCheckResult> {
        let mut results = self.cross_checks.iter();
        results.find(|result| result.cross_check == cross_check)
    }

    /// The differences to other algorithms that found a solution.
    fn disagreements(&self) -> impl Iterator<Item = f64> {
        let rivals = self.cross_checks.iter();
        let solutions = rivals.filter(|rival| rival.is_solution());
        solutions.map(|rival| rival.disagreement)
    }

    /// The differences between descriptions of the problem.
    fn variations(&self) -> impl Iterator<Item = f64> {
        self.invariances.iter().map(|result| result.difference)
    }

    /// The largest difference to another algorithm that found a solution; 0 for none.
    #[must_use]
    pub fn disagreement(&self) -> f64 {
        self.disagreements().fold(0.0, f64::max)
    }

    /// The largest difference between descriptions of the problem; `None` where not asked for.
    #[must_use]
    pub fn variation(&self) -> Option<f64> {
        self.variations().reduce(f64::max)
    }

    /// The decimal digits in which the answer, other algorithms and other descriptions agree and the conditions hold; 0 of what is not
    /// solved.
    #[must_use]
    pub fn trusted_digits(&self) -> usize {
        if !self.status.is_solved() {
            return 0;
        }
        let others = self.disagreements().chain(self.variations());
        let own = [self.accuracy, self.certificate, f64::EPSILON];
        let figures = others.filter(|it| *it <= USELESS).chain(own);
        (-figures.fold(0.0, f64::max).log10()).max(0.0) as usize
    }

    /// Whether the case holds what it should, and what is to be said about it.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        Verdict::of(self)
    }
}

/// What every case should reach.
pub const GOAL: f64 = 1e-10;

/// The error that is accepted where a scene asks for no other: far below that of any mesh.
pub const TRUSTED: f64 = 1e-8;

/// Answers that differ by more than this do not agree, however badly conditioned the problem is.
const USELESS: f64 = 1e-6;

/// The outcome of a case, and what is remarkable about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// The worst of the findings.
    pub level: VerdictLevel,
    /// What kept the case from reaching the goal.
    pub findings: Vec<String>,
}

units::worded! {
    /// From good to bad.
    #[derive(PartialOrd, Ord)]
    pub enum VerdictLevel {
        /// All that was asked for, to 1e-10 or to the bit.
        Pass = "pass",
        /// Above 1e-10, but within what double precision allows at this conditioning, or within what was asked for.
        Limited = "limited",
        /// Something was not reached and is not explained.
        Fail = "fail",
        /// There is no discrete problem.
        Refused = "refused",
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.findings.as_slice() {
            [] => f.write_str(self.level.word()),
            findings => write!(f, "{}: {}", self.level.word(), findings.join("; ")),
        }
    }
}

impl Verdict {
    fn of(check: &Check) -> Self {
        let mut verdict = Self {
            level: VerdictLevel::Pass,
            findings: Vec::new(),
        };
        if !check.status.is_solved() {
            verdict.add(VerdictLevel::Fail, check.status.word().replace('_', " "));
        }
        verdict.add_figure(
            level(check, check.certificate, check.rounding_bound.certificate),
            &"certificate",
            [check.certificate, check.rounding_bound.certificate],
        );
        let local = &check.linearisation;
        if local.determinant_sign < 1 {
            let sign = ["det R' < 0", "det R' = 0"][(local.determinant_sign + 1) as usize];
            verdict.add(VerdictLevel::Pass, sign.to_owned());
        }
        if local.contraction > 1.0 {
            let text = format!(
                "successive approximations leave this solution: they move away by a factor of {:.3e} a step",
                local.contraction
            );
            verdict.add(VerdictLevel::Pass, text);
        }
        if local.is_near_fold() {
            let text = format!(
                "a fold is near: an eigenvalue of Ψ' is within {:.1e} of 1",
                local.fold_distance
            );
            verdict.add(VerdictLevel::Pass, text);
        }
        verdict.add_cross_checks(check);
        for result in &check.invariances {
            let allowed = allowed(check, result);
            let name = result.invariance.word().replace('_', " ");
            let other = !result.invariance.is_exact() && result.residual <= GOAL;
            if other && result.difference > USELESS.max(allowed) {
                verdict.add_solution(check, &name, result.difference);
                continue;
            }
            let reached = match allowed {
                0.0 if result.difference == 0.0 => VerdictLevel::Pass,
                0.0 => VerdictLevel::Fail,
                rounding_bound => level(check, result.difference, rounding_bound),
            };
            let figures = [result.difference, allowed];
            verdict.add_figure(reached, &name, figures);
        }
        verdict
    }

    /// Reports a figure that is not as small as it should be, with what rounding allows.
    fn add_figure(
        &mut self,
        level: VerdictLevel,
        what: &dyn fmt::Display,
        [value, rounding_bound]: [f64; 2],
    ) {
        if level != VerdictLevel::Pass {
            let text = format!("{what} {value:.0e}, rounding allows {rounding_bound:.0e}");
            self.add(level, text);
        }
    }

    /// Two algorithms must agree; what the others say is a remark.
    fn add_cross_checks(&mut self, check: &Check) {
        let several = check.solutions == Solutions::Several;
        let mut agreeing = 0;
        let mut remarks = Vec::new();
        for cross_check in &check.cross_checks {
            // Reported accuracies hold up to this factor: they are measured in another norm.
            let allowed = check.rounding_bound.multiplier
                + check.linearisation.sensitivity
                    * (cross_check.residual + check.linearisation.residual)
                + 10.0 * cross_check.accuracy;
            let reached = if cross_check.disagreement > USELESS {
                VerdictLevel::Fail
            } else {
                level(check, cross_check.disagreement, allowed)
            };
            match (cross_check.is_solution(), reached) {
                (false, _) => remarks.push((VerdictLevel::Pass, described(cross_check))),
                (true, VerdictLevel::Pass) => agreeing += 1,
                (true, VerdictLevel::Limited) => {
                    agreeing += 1;
                    let text = format!(
                        "{} {:.0e}, its residual allows {allowed:.0e}",
                        cross_check.cross_check.word(),
                        cross_check.disagreement
                    );
                    remarks.push((VerdictLevel::Limited, text));
                }
                (true, VerdictLevel::Fail)
                    if cross_check.residual <= GOAL && cross_check.disagreement > allowed =>
                {
                    self.add_solution(
                        check,
                        &cross_check.cross_check.word(),
                        cross_check.disagreement,
                    );
                }
                (true, _) => remarks.push((VerdictLevel::Fail, described(cross_check))),
            }
        }
        // Algorithms that have to agree.
        if agreeing < 2 && !several {
            let agree = match agreeing {
                0 => "no algorithm agrees",
                _ => "only one algorithm agrees",
            };
            self.add(VerdictLevel::Fail, agree.to_owned());
        }
        for (level, text) in remarks {
            self.add(level, text);
        }
    }

    /// Reports another solution, which satisfies the problem as well as the answer does.
    fn add_solution(&mut self, check: &Check, by: &dyn fmt::Display, difference: f64) {
        let level = match check.solutions {
            Solutions::One => VerdictLevel::Fail,
            Solutions::Several => VerdictLevel::Pass,
        };
        self.add(level, format!("{by}: another solution ({difference:.0e})"));
    }

    fn add(&mut self, level: VerdictLevel, finding: String) {
        self.level = self.level.max(level);
        self.findings.push(finding);
    }
}

fn described(cross_check: &CrossCheckResult) -> String {
    if cross_check.is_solution() {
        format!(
            "{} finds another answer ({:.0e})",
            cross_check.cross_check.word(),
            cross_check.disagreement
        )
    } else {
        format!(
            "{}: {}",
            cross_check.cross_check.word(),
            cross_check.status.word().replace('_', " ")
        )
    }
}

/// Where a figure lies between the goal and what rounding allows, or was asked for; NaN fails.
fn level(check: &Check, value: f64, rounding_bound: f64) -> VerdictLevel {
    if value <= GOAL {
        VerdictLevel::Pass
    } else if value <= rounding_bound.max(check.wanted) {
        VerdictLevel::Limited
    } else {
        VerdictLevel::Fail
    }
}

/// What a change of the description may do: nothing, or the rounding of both answers and twice
/// the residual at which the solver stops.
fn allowed(check: &Check, result: &InvarianceResult) -> f64 {
    if result.invariance.is_exact() {
        return 0.0;
    }
    let stopped = check.linearisation.residual.max(check.asked);
    2.0 * (check.rounding_bound.multiplier + check.linearisation.sensitivity * stopped)
}
