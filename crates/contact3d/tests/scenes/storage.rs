//! What a storage is asked and given by the driver.

use contact3d::{
    Checkpoint, InMemory, Problem, ProblemError, RunStep, RunStorage,
    dual::{AssemblyError, InsufficientResource, Requirement, Resource},
    history::StepRecord,
    scene::{Body, Clamp, Contact, Friction, Material, Method, Pressure, Scene, Step, Traction},
    solver::{OuterState, Start},
};

/// A block that is pressed down and pulled, by successive approximations.
fn pulled() -> Scene {
    let mut scene = Scene::new(
        Body::brick([3.0, 1.0, 1.0], [6, 2, 2]),
        Material::isotropic(2.1e11, 0.3),
    )
    .with_clamp(Clamp::face("x_min"))
    .with_pressure(Pressure::on("z_max", 2e7))
    .with_traction(Traction::on("x_max", [1e7, 0.0, 0.0]).named("pull"))
    .with_contact(Contact::on("z_min"))
    .with_friction(Friction::coulomb(0.3));
    scene.solve.method = Method::FixedPoint;
    scene
}

/// Keeps all that it is given, and admits what takes no more memory than this.
#[derive(Default)]
struct Everything {
    memory: u64,
    assembled: Vec<&'static str>,
    states: Vec<OuterState>,
    records: Vec<Vec<StepRecord>>,
}

impl RunStorage for Everything {
    fn admit(&self, need: Requirement) -> Result<(), InsufficientResource> {
        if need.memory <= self.memory {
            return Ok(());
        }
        Err(InsufficientResource {
            step: need.step,
            resource: Resource::Memory,
            needed: need.memory,
            available: self.memory,
        })
    }

    fn observe(&mut self, step: RunStep<'_>) {
        if let RunStep::Assembling(name) = step {
            self.assembled.push(name);
        }
    }

    fn checkpoint(&mut self, unfinished: Checkpoint<'_>) {
        match unfinished {
            Checkpoint::Solve(state) => self.states.push(state.clone()),
            Checkpoint::History(records) => self.records.push(records.to_vec()),
        }
    }
}

#[test]
fn what_a_keeper_refuses_is_not_assembled() {
    let mut storage = Everything::default();
    let problem = Problem::new(pulled()).expect("a brick");
    let refused = problem.clone().assemble_with(&mut storage);
    assert!(matches!(
        refused,
        Err(ProblemError::Assembly(AssemblyError::InsufficientResource(
            _
        )))
    ));
    assert_eq!(storage.assembled.len(), 1);
    storage.memory = u64::MAX;
    problem.assemble_with(&mut storage).expect("a problem");
    assert_eq!(storage.assembled.len(), 3, "{:?}", storage.assembled);
}

#[test]
fn a_static_solve_goes_on_from_what_was_kept_with_the_same_bits() {
    let problem = Problem::new(pulled()).expect("a brick");
    let problem = problem.assemble().expect("a problem");
    let settings = &problem.scene().solve;
    let mut storage = Everything::default();
    let whole = problem.run(settings, Start::default(), Vec::new(), &mut storage);
    let whole = whole.expect("an answer");
    assert!(whole.records.is_empty() && storage.records.is_empty());
    let state = &storage.states[storage.states.len() / 2];
    let start = Start {
        checkpoint: Some(state),
        ..Start::default()
    };
    let rest = problem.run(settings, start, Vec::new(), &mut InMemory);
    let rest = rest.expect("an answer");
    assert_eq!(rest.solution.multiplier, whole.solution.multiplier);
    assert_eq!(rest.solution.displacement, whole.solution.displacement);
}

#[test]
fn a_history_keeps_its_increments_but_the_last_and_no_state_between() {
    let scene = pulled().with_step(Step::new("pull").with_factor("pull", 1.0).in_increments(3));
    let problem = Problem::new(scene).expect("a brick");
    let problem = problem.assemble().expect("a problem");
    let settings = &problem.scene().solve;
    let mut storage = Everything::default();
    let answer = problem.run(settings, Start::default(), Vec::new(), &mut storage);
    let answer = answer.expect("an answer");
    assert!(storage.states.is_empty());
    let expected: Vec<_> = (1..3).map(|n| answer.records[..n].to_vec()).collect();
    assert_eq!(storage.records, expected);
}
