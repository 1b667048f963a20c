//! Solved scenes and what is measured on them.

use std::path::Path;

use contact3d::{
    AssembledProblem, Problem, ProblemError,
    mesh::ContactSurface,
    post::ContactReport,
    scene::{Scene, SolveSettings},
};

pub(crate) struct Solved {
    pub(crate) problem: AssembledProblem,
    pub(crate) report: ContactReport,
    pub(crate) multiplier: Vec<f64>,
}

impl Solved {
    /// Solves the scene of a text; the certificate must be clean.
    pub(crate) fn new(text: &str) -> Self {
        Self::in_folder(text, Path::new("")).unwrap_or_else(|error| panic!("{error}\n{text}"))
    }

    /// As [`Self::new`] with mesh files in a folder; what a scene is refused for.
    pub(crate) fn in_folder(text: &str, folder: &Path) -> Result<Self, String> {
        let scene = Scene::parse("test", text).map_err(|error| error.to_string())?;
        let solved = || -> Result<Self, ProblemError> {
            let problem = Problem::in_folder(scene, folder)?.assemble()?;
            let solution = problem.solve(&SolveSettings::default())?;
            assert!(solution.status.is_solved());
            Ok(Self {
                report: problem.report(&solution)?,
                multiplier: solution.multiplier,
                problem,
            })
        };
        let solved = solved().map_err(|error| error.to_string())?;
        let certificate = &solved.report.certificate;
        assert!(certificate.worst() < 1e-9, "{certificate:?}");
        Ok(solved)
    }

    pub(crate) fn surface(&self) -> &ContactSurface {
        self.problem.mesh().contact.as_ref().expect("contact")
    }

    /// Force of the obstacle on the body.
    pub(crate) fn force(&self) -> [f64; 3] {
        let contact = self.report.resultants.contact;
        contact.expect("contact").contact_force
    }

    pub(crate) fn peak(&self) -> f64 {
        let contact = self.report.resultants.contact;
        contact.expect("contact").largest_pressure
    }

    /// ∫ p w dA over ∫ p dA for a function w of the place.
    pub(crate) fn pressure_mean(&self, weight: impl Fn([f64; 3]) -> f64) -> f64 {
        let (mesh, surface) = (self.problem.mesh(), self.surface());
        let mut sums = [0.0; 2];
        for (pane, state) in self.report.panes.iter().enumerate() {
            let mean: f64 = surface
                .pane_weights(pane)
                .map(|(node, share)| share * weight(mesh.coordinates[surface.nodes[node]]))
                .sum();
            let force = -state.normal_stress * surface.pane_area[pane];
            sums = [sums[0] + force * mean, sums[1] + force];
        }
        sums[0] / sums[1]
    }

    /// u_z at the node nearest to a place.
    pub(crate) fn lift(&self, at: [f64; 3]) -> f64 {
        let nodes = self.problem.mesh().coordinates.iter();
        let distance = |x: &[f64; 3]| -> f64 { (0..3).map(|c| (x[c] - at[c]).powi(2)).sum() };
        let nearest = nodes
            .enumerate()
            .min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        self.report.displacement[nearest.expect("nodes").0][2]
    }
}

/// A vector as a scene writes it.
pub(crate) fn list(v: [f64; 3]) -> String {
    format!("[{:?}, {:?}, {:?}]", v[0], v[1], v[2])
}

/// ‖a − b‖ / ‖b‖.
pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    norm(&mut a.iter().zip(b).map(|(x, y)| x - y)) / norm(&mut b.iter().copied())
}
