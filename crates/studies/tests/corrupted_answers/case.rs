//! Scenes with their answers, and what the certificate and the verdict say of other answers to
//! them.

use std::path::{Path, PathBuf};

use contact3d::{
    AssembledProblem, Problem,
    dual::ContactSystem,
    mesh::ContactSurface,
    post::{ContactReport, Zone},
    scene::{DualOperatorKind, Scene, SolveSettings},
    solver::Solution,
};
use studies::stability::{Check, Effort, Solutions, VerdictLevel};

/// Scenes of `pipelines` with the number of corruptions that they have panes for.
pub(crate) const NAMES: [(&str, usize); 6] = [
    ("hkl2011_table1.toml", 13),
    ("tresca.toml", 11),
    ("frictionless.toml", 7),
    ("nodal.toml", 13),
    ("gap.toml", 11),
    ("hard/soft_block.toml", 10),
];

/// A scene, its answer, and what is known of both.
pub(crate) struct Case {
    pub(crate) problem: AssembledProblem,
    pub(crate) solution: Solution,
    pub(crate) report: ContactReport,
    check: Check,
}

impl Case {
    /// A scene of `pipelines`, bricks with 12 × 4 × 4 cells, solved to rounding.
    pub(crate) fn named(name: &str) -> Self {
        let text = std::fs::read_to_string(pipelines().join(name)).expect("a pipeline");
        let mut scene = Scene::parse(name, &text).expect("a valid pipeline");
        if let (Some(brick), false) = (scene.as_brick_mut(), name.starts_with("hard/")) {
            brick.cells = [12, 4, 4];
        }
        Self::of(scene)
    }

    pub(crate) fn of(mut scene: Scene) -> Self {
        scene.assemble.dual_operator = DualOperatorKind::Explicit;
        scene.solve = SolveSettings::default();
        let check = Check::new(
            &scene,
            Path::new(""),
            Effort::Solve,
            Solutions::One,
            &mut |_| {},
        );
        let problem = Problem::new(scene).expect("a brick");
        let problem = problem.assemble().expect("a discrete problem");
        let solution = problem.solve(&problem.scene().solve).expect("S is dense");
        Self {
            report: problem.report(&solution).expect("finite loads"),
            check: check.expect("a discrete problem"),
            problem,
            solution,
        }
    }

    /// The largest figure of the certificate of an answer to the scene.
    pub(crate) fn figure(&self, solution: &Solution) -> f64 {
        let report = self.problem.report(solution).expect("finite loads");
        report.certificate.worst()
    }

    /// The answer with what the gate leaves of its claim.
    pub(crate) fn judged(&self, mut solution: Solution) -> Solution {
        let report = self.problem.report(&solution).expect("finite loads");
        report.classify(&mut solution);
        solution
    }

    /// What the suite says of an answer with this certificate, were all else in order.
    pub(crate) fn verdict_of_certificate(&self, certificate: f64) -> VerdictLevel {
        let check = Check {
            certificate,
            ..self.check.clone()
        };
        check.verdict().level
    }

    /// What the suite says of a multiplier in Pa, were its certificate in order: all other
    /// algorithms find the uncorrupted one.
    pub(crate) fn verdict_of_multiplier(&self, multiplier: &[f64]) -> VerdictLevel {
        let mut check = self.check.clone();
        for cross_check in &mut check.cross_checks {
            cross_check.disagreement += distance(multiplier, &self.solution.multiplier);
        }
        check.verdict().level
    }

    /// What the suite says of the case with one thing changed.
    pub(crate) fn verdict(&self, change: impl Fn(&mut Check)) -> VerdictLevel {
        let mut check = self.check.clone();
        change(&mut check);
        check.verdict().level
    }

    pub(crate) fn contact(&self) -> &ContactSystem {
        let contact = self.problem.system.contact.as_ref();
        contact.expect("a contact face")
    }

    pub(crate) fn surface(&self) -> &ContactSurface {
        self.problem
            .mesh()
            .contact
            .as_ref()
            .expect("a contact face")
    }

    pub(crate) fn n_panes(&self) -> usize {
        self.report.panes.len()
    }

    /// The largest pressure in Pa.
    pub(crate) fn pressure(&self) -> f64 {
        let normal = &self.solution.multiplier[..self.n_panes()];
        normal.iter().copied().fold(0.0, f64::max)
    }

    pub(crate) fn most_pressed(&self) -> usize {
        let pressure = self.pressure();
        let normal = &self.solution.multiplier;
        let pane = normal.iter().position(|value| *value == pressure);
        pane.expect("a pane that is pressed")
    }

    /// The largest tangential stress that the law allows anywhere or that acts, in Pa.
    pub(crate) fn shear(&self) -> f64 {
        let panes = self.report.panes.iter();
        let friction = panes.filter_map(|pane| pane.friction);
        let sizes = friction.flat_map(|f| {
            [
                f.semi_axes[0],
                f.semi_axes[1],
                f.stress[0].hypot(f.stress[1]),
            ]
        });
        sizes.fold(0.0, f64::max)
    }

    /// The pane of a zone that bears most, or any pane where none is pressed.
    pub(crate) fn pane(&self, zone: Zone) -> Option<usize> {
        let panes = (0..self.n_panes()).filter(|i| self.report.panes[*i].zone == zone);
        let multiplier = &self.solution.multiplier;
        panes.max_by(|a, b| multiplier[*a].total_cmp(&multiplier[*b]))
    }
}

/// ‖x − y‖ / ‖y‖.
pub(crate) fn distance(x: &[f64], y: &[f64]) -> f64 {
    let difference: Vec<f64> = x.iter().zip(y).map(|(x, y)| x - y).collect();
    norm(&difference) / norm(y)
}

/// ‖v‖.
pub(crate) fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn pipelines() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines")
}
