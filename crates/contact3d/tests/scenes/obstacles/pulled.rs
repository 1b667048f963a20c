//! Load histories on round obstacles, and their stresses pane by pane.

use contact3d::{
    AssembledProblem, Problem,
    history::StepRecord,
    post::Zone,
    scene::{Scene, SolveSettings},
};

pub(crate) struct Pulled {
    problem: AssembledProblem,
    records: Vec<StepRecord>,
}

/// What a pane carries.
pub(crate) struct Loaded {
    pub(crate) area: f64,
    /// Means of x, x² and x² + y², x from the middle of the contact.
    pub(crate) x: f64,
    pub(crate) along: f64,
    pub(crate) around: f64,
    pub(crate) pressure: f64,
    /// σ_t1, along x.
    pub(crate) shear: f64,
    pub(crate) sticks: bool,
}

impl Pulled {
    /// Solves the steps of a scene whose contact is around (1, 0, 0).
    pub(crate) fn new(text: &str) -> Self {
        let scene = Scene::parse("test", text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let problem = Problem::new(scene).and_then(Problem::assemble);
        let problem = problem.unwrap_or_else(|e| panic!("{e}\n{text}"));
        let history = problem.solve_history(&SolveSettings::default());
        let records = history.expect("a history").records;
        for record in &records {
            assert!(record.status.is_solved(), "{:?}", record.status);
            assert!(record.certificate < 1e-9, "{}", record.certificate);
        }
        Self { problem, records }
    }

    /// The panes after a step of one increment each.
    pub(crate) fn panes(&self, step: usize) -> Vec<Loaded> {
        let (mesh, record) = (self.problem.mesh(), &self.records[step]);
        let surface = mesh.contact.as_ref().expect("contact");
        let contact = self.problem.system.contact.as_ref().expect("contact");
        let layout = contact.coupling.layout;
        let pane = |i: usize| {
            let mean = |of: &dyn Fn([f64; 3]) -> f64| -> f64 {
                let nodes = surface.pane_weights(i);
                nodes
                    .map(|(node, share)| {
                        let [x, y, z] = mesh.coordinates[surface.nodes[node]];
                        share * of([x - 1.0, y, z])
                    })
                    .sum()
            };
            Loaded {
                area: surface.pane_area[i],
                x: mean(&|[x, _, _]| x),
                along: mean(&|[x, _, _]| x * x),
                around: mean(&|[x, y, _]| x * x + y * y),
                pressure: record.multiplier[layout.normal(i)],
                shear: -layout.pair(&record.multiplier, i)[0],
                sticks: record.panes[i].zone == Zone::Stick,
            }
        };
        (0..surface.n_panes()).map(pane).collect()
    }

    /// Energy that friction took in a step.
    pub(crate) fn dissipation(&self, step: usize) -> f64 {
        self.records[step].energies.dissipation
    }
}
