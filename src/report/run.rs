//! The figures of a solved run.

use contact3d::{
    adaptation::AdaptiveStatus,
    dual::Assembly,
    elasticity::BodyMotion,
    history::{HistoryErrors, StepRecord},
    mesh::Mesh,
    post::{
        ContactReport, ContactResultants, ErrorEstimate, FaceResultants, SourceForce,
        StressConcentration, ToolState, Zone,
    },
    scene::{
        ContactFeatures, ElementOrder, FrictionModel, Functional, MultiplierSpace, Scene,
        escape_control,
    },
    solver::{Solution, SolvedBy, StartStrategy},
};
use serde_json::{Map, Value, json};
use units::Dimension;

use super::{
    Digits::Scientific,
    FigureTable, Figures,
    answer::{
        fold_words, name_of_quantity, null_space_motions, quantities_json, radius_words,
        sign_words, with_bar,
    },
    levels::name,
    status::status,
};
use crate::{format::StageSizes, pipeline::Results};

/// A scene with its results.
pub struct SolvedRun<'a> {
    pub(crate) scene: &'a Scene,
    pub(super) results: &'a Results,
    pub(super) mesh: &'a Mesh,
    pub(super) solution: &'a Solution,
    pub(super) report: &'a ContactReport,
    /// Those of a history.
    pub(super) increments: &'a [StepRecord],
    /// The quantity that grew on all levels of its mesh.
    pub(super) unbounded: Option<Functional>,
    /// What is probably not meant in the scene.
    warnings: Vec<String>,
    /// What there is to look at in a solution: nothing touches, something is too large for the theory, or contact too narrow for its panes.
    pub cautions: Vec<String>,
}

impl<'a> SolvedRun<'a> {
    /// The results of a scene.
    pub fn new(scene: &'a Scene, results: &'a Results) -> Self {
        let mut run = Self {
            scene,
            results,
            mesh: results.mesh(),
            solution: &results.solution,
            report: &results.report,
            increments: &results.increments,
            unbounded: None,
            warnings: results.warnings(),
            cautions: Vec::new(),
        };
        run.cautions = run.all_cautions();
        run
    }

    /// The same on the last of the levels that ended so.
    #[must_use]
    pub fn after_levels(mut self, status: Option<AdaptiveStatus>) -> Self {
        let is_unbounded = status == Some(AdaptiveStatus::Unbounded);
        self.unbounded = self
            .scene
            .adapt
            .filter(|_| is_unbounded)
            .and_then(|it| it.of);
        self
    }

    /// The warnings of the scene and of its solution.
    pub(super) fn all_warnings(&self) -> Vec<&str> {
        let all = self.warnings.iter().chain(&self.cautions);
        all.map(String::as_str).collect()
    }

    /// The accuracy of the least accurate increment, or of the solution.
    fn accuracy(&self) -> f64 {
        let records = self.increments.iter().map(|record| record.accuracy);
        records.fold(self.solution.accuracy, f64::max)
    }

    /// The estimated error, of a history the largest over the largest size of an increment, with the parts of the increment that is loaded most, and
    /// which increment it is of.
    fn estimate(&self) -> (f64, &ErrorEstimate, usize) {
        let [energy, ..] = StepRecord::LOADS;
        let (_, report, place) = self.results.loaded_most(energy);
        let parts = &report.discretisation_error;
        let Some(errors) = HistoryErrors::new(self.increments, None) else {
            return (parts.relative(), parts, place);
        };
        let largest = errors.largest();
        let worst = errors.relative.iter().position(|error| *error == largest);
        (largest, parts, worst.unwrap_or(place))
    }

    /// Whether a contact face has panes.
    pub(super) fn has_panes(&self) -> bool {
        let mut faces = self.scene.contacts.iter();
        faces.any(|face| face.multipliers == MultiplierSpace::Panes)
    }

    /// The estimate, and why it may be no more than a guess.
    pub(super) fn estimate_words(&self) -> String {
        let (scene, (error, estimate, place)) = (self.scene, self.estimate());
        if estimate.displacement == 0.0 {
            return "none: nothing is deformed by more than rounding".to_owned();
        }
        // Estimates above this share of the energy norm were down to 0.66 of the error on meshes of some hundred unknowns; below
        // it they were between 0.7 and 1.5 times the error (docs/explanation/errors.md).
        let is_of_panes = self.has_panes() && estimate.relative_contact() > 0.9 * error;
        let caution = match (error > 0.25, scene.adapt) {
            (false, _) => "",
            (true, _) if is_of_panes => {
                ", a rough guess: panes are wider than what happens on them; contact.multipliers = \"nodal\" sees more"
            }
            (true, None) if scene.element() == ElementOrder::P1 => {
                ", a rough guess: linear elements are stiff in bending; body.element = \"P2\", or refine: run ... --error 10%"
            }
            (true, None) => ", a rough guess: the mesh is coarse; refine it: run ... --error 10%",
            (true, Some(_)) => ", a rough guess: the mesh is coarse",
        };
        let told = match error < 10.0 {
            true => format!("about {}", percent(error)),
            false => estimated_percent(error),
        };
        format!(
            "{told} in the energy norm{}{caution}",
            self.in_increment(place)
        )
    }

    /// Which increment something is of; empty for the last, and without a history.
    pub(super) fn in_increment(&self, place: usize) -> String {
        let (number, all) = (place + 1, self.increments.len());
        match self.increments.get(place) {
            Some(record) if number < all => {
                format!(
                    " in increment {number} of {all} ({})",
                    name(self.scene, record.increment)
                )
            }
            _ => String::new(),
        }
    }

    /// The numbers of unknowns.
    pub fn sizes(&self) -> StageSizes {
        let faces = self.mesh.contact.as_ref().map(|surface| &surface.faces);
        StageSizes {
            n_free: Some(self.solution.displacement.len()),
            panes: faces.map(|faces| faces.iter().map(|f| f.panes.len()).collect()),
            contact_nodes: faces.map(|faces| faces.iter().map(|f| f.nodes.len()).collect()),
            n_rigid_modes: self.solution.rigid.as_ref().map(|rigid| rigid.motion.len()),
        }
    }

    /// The first screen and the details.
    pub fn figures(&self) -> Figures {
        self.summary().with(self.details())
    }

    /// What the first screen leaves out of the solve, contact, body and their errors.
    pub fn details(&self) -> Figures {
        let solve = self.of_solve().with(self.of_contact());
        solve.with(self.of_body()).with(self.of_errors())
    }

    /// What pictures and pages say first of a solve that failed; `None` of one that did not.
    pub fn stamp(&self) -> Option<String> {
        let words = status(self.solution, self.scene, self.mesh);
        let (what, _) = words.split_once(';').unwrap_or((&words, ""));
        let what = what.trim_start_matches("NOT CONVERGED: ");
        let failed = !self.solution.status.is_success(&self.scene.solve);
        failed.then(|| format!("NOT CONVERGED: {what}"))
    }

    /// What the status means, and the accuracy of the least accurate increment where it is another one.
    pub(super) fn status_words(&self) -> String {
        let words = status(self.solution, self.scene, self.mesh);
        let accuracy = self.accuracy();
        if accuracy > self.solution.accuracy {
            format!("{words}; the least accurate increment to {accuracy:.1e}")
        } else {
            words
        }
    }

    #[rustfmt::skip]
    fn of_solve(&self) -> Figures {
        let (solution, mesh) = (self.solution, self.mesh);
        let mut figures = Figures::new(self.scene.units);
        figures.json_only("status", solution.status.word());
        figures.json_only("warnings", self.all_warnings());
        figures.json_only("accuracy", self.accuracy());
        figures.json_only("n_nodes", mesh.coordinates.len());
        figures.json_only("n_tetrahedra", mesh.tetrahedra.len());
        figures.json_only("n_panes", self.report.panes.len());
        let nodes = mesh.contact.as_ref().map(|surface| surface.nodes.len());
        figures.json_only("n_contact_nodes", nodes);
        let (primal, dual) = (solution.displacement.len(), solution.multiplier.len());
        figures.counts("unknowns (primal, dual)", [("n_free", primal), ("n_multipliers", dual)]);
        figures.human_only("steps", Some(steps(solution)));
        figures.json_only("strategy", solution.trace.strategy.map(StartStrategy::word));
        figures.json_only("outer_steps", solution.trace.history.len());
        figures.json_only("newton_steps", solution.trace.newton.len());
        let seconds = solution.trace.newton.iter().map(|step| step.seconds);
        figures.json_only("newton_seconds", seconds.sum::<f64>());
        figures.plain("applications", "applications of S", solution.trace.applications);
        figures.json_only("law_evaluations", solution.trace.law_evaluations);
        let friction = solution.friction.as_ref();
        let moved = "moved by the mapping Psi";
        figures.number("mapping_change", moved, Scientific(1), friction.and_then(|it| it.mapping_change));
        let local = friction.and_then(|it| it.local_mapping.as_ref());
        let (radius, sign) = (local.map(radius_words), local.and_then(sign_words));
        figures.described("spectral_radius", "spectral radius of Psi'", radius, local.map(|l| l.spectral_radius));
        figures.described("determinant_sign", "sign of det R'", sign, local.map(|l| l.determinant_sign));
        let fold = local.and_then(fold_words);
        figures.described("fold_distance", "distance from a fold", fold, local.map(|l| l.fold_distance));
        figures
    }

    fn of_contact(&self) -> Figures {
        let contact = self.report.resultants.contact.as_ref();
        let zones = [Zone::Open, Zone::Stick, Zone::Slip].map(|zone| self.report.count(zone));
        let mut figures = self.resultants(zones, contact).for_programs();
        for face in self.faces().rows {
            let mut pairs = face.pairs();
            let name = pairs.next().map(|(_, name)| format!("on {name}"));
            let told: Vec<String> = pairs
                .map(|(name, value)| format!("{name} {value}"))
                .collect();
            figures.human_only(&name.unwrap_or_default(), Some(told.join("; ")));
        }
        figures.human_only("friction on panes", friction_ranges(self.report));
        figures
    }

    /// How deep the foundation cuts into the body before it is pressed apart; `None` where it does not.
    pub(super) fn interference(&self) -> Option<String> {
        let depth = self.results.interference();
        let share = percent(depth / self.mesh.extent());
        let told = self.scene.units.of(Dimension::LENGTH).told(&[depth]);
        (depth > 0.0).then(|| format!("{told} deep, {share} of the body's size"))
    }

    /// What happens on one contact face, or on all of them.
    #[rustfmt::skip]
    fn resultants(&self, zones: [usize; 3], contact: Option<&ContactResultants>) -> Figures {
        let mut figures = Figures::new(self.scene.units);
        figures.zones(self.scene.has_friction(), zones, true);
        figures.told("normal force", Dimension::FORCE, contact.map(|c| [c.normal_force]));
        figures.json_only("normal_force", contact.map(|c| c.normal_force));
        let tangential = contact.and_then(|c| c.tangential_force);
        let on_body = tangential.map(|force| self.without_noise(force, |row| row.force).map(|part| -part));
        figures.told("friction t1, t2 on the body", Dimension::FORCE, on_body);
        figures.json_only("tangential_force", tangential);
        figures.told("largest pressure", Dimension::STRESS, contact.map(|c| [c.largest_pressure]));
        figures.json_only("largest_pressure", contact.map(|c| c.largest_pressure));
        figures
    }

    /// What happens on each of several contact faces.
    pub fn faces(&self) -> FigureTable {
        let features = self.scene.contact_features();
        let faces = self.report.faces.iter().zip(features);
        let row = |(face, has): (&FaceResultants, ContactFeatures)| {
            let mut figures = Figures::new(self.scene.units);
            figures.described(
                "name",
                "contact face",
                Some(escape_control(&has.name)),
                &has.name,
            );
            figures.json_only("law", FrictionModel::word(has.friction.as_ref()));
            figures.json_only("contact_force", face.contact.contact_force);
            figures.with(self.resultants(face.zone_counts, Some(&face.contact)))
        };
        FigureTable::new("Contact faces", faces.map(row))
    }

    /// The forces on the body by their sources, and their moments about the origin of coordinates.
    #[rustfmt::skip]
    pub fn forces(&self) -> FigureTable {
        let rows = self.report.forces.iter().map(|row| {
            let mut figures = Figures::new(self.scene.units);
            figures.described("source", "source", Some(self.name_of(&row.source)), row.source.as_str());
            figures.plain("face", "face", row.face.as_str());
            figures.told("force x, y, z", Dimension::FORCE, Some(self.without_noise(row.force, |row| row.force)));
            figures.told("moment x, y, z", Dimension::MOMENT, Some(self.without_noise(row.moment, |row| row.moment)));
            figures.json_only("force", row.force);
            figures.json_only("moment", row.moment);
            figures
        });
        FigureTable::new("Forces on the body and their moments about the origin", rows)
    }

    /// A force or moment with zeros for what is below the digits of the largest one: rounding, and what the solve is off by.
    pub(super) fn without_noise<const N: usize>(
        &self,
        vector: [f64; N],
        of: fn(&SourceForce) -> [f64; 3],
    ) -> [f64; N] {
        let noise = self.noise(of);
        vector.map(|part| if part.abs() <= noise { 0.0 } else { part })
    }

    /// What a part of a force or moment has to exceed.
    pub(super) fn noise(&self, of: fn(&SourceForce) -> [f64; 3]) -> f64 {
        let all = self.report.forces.iter().flat_map(of);
        let largest = all.fold(0.0, |most: f64, part| most.max(part.abs()));
        // Forces that no equilibrium balances are none.
        let imbalance = self.report.resultants.force_imbalance;
        // An imbalance from which on forces are not in equilibrium.
        let share = if imbalance < 1e-6 { imbalance } else { 0.0 };
        // Parts of forces below this share of the largest are no figures: it is the default accuracy of a solve, and below the digits shown.
        share.max(1e-12) * largest
    }

    /// The name that the scene gives a clamp, load or contact face, before the one by its number.
    fn name_of(&self, source: &str) -> String {
        let scene = self.scene;
        let given = source.split_once('.').and_then(|(kind, number)| {
            let number: usize = number.parse().ok()?;
            match kind {
                "clamp" => scene.clamps.get(number)?.name.as_deref(),
                "traction" => scene.tractions.get(number)?.name.as_deref(),
                "pressure" => scene.pressures.get(number)?.name.as_deref(),
                "force" => scene.forces.get(number)?.name.as_deref(),
                "contact" => scene.contacts.get(number)?.name.as_deref(),
                "tool" => scene.tools.get(number)?.name.as_deref(),
                _ => None,
            }
        });
        given.map_or_else(
            || source.to_owned(),
            |name| format!("{} ({source})", escape_control(name)),
        )
    }

    #[rustfmt::skip]
    fn of_body(&self) -> Figures {
        let report = self.report;
        let r = &report.resultants;
        let mut figures = Figures::new(self.scene.units);
        for row in &report.forces {
            let mut name = format!("force of {}", self.name_of(&row.source));
            if self.scene.has_pairs() && row.source.starts_with("contact") {
                name += &format!(" on {}", escape_control(&row.face));
            }
            figures.told(&name, Dimension::FORCE, Some(self.without_noise(row.force, |row| row.force)));
        }
        let known = self.first_quantities();
        let energy = Functional::StrainEnergy;
        if !known.contains(&energy) {
            figures.human_only(&name_of_quantity(energy), self.quantity(energy));
        }
        // The largest von Mises stress has a line of its own.
        let told = [energy, Functional::LargestVonMises];
        let others = report.functionals.iter().map(|it| it.functional);
        for of in others.filter(|of| !told.contains(of) && !known.contains(of)) {
            figures.human_only(&name_of_quantity(of), self.quantity(of));
        }
        figures.json_only("strain_energy", r.strain_energy);
        figures.json_only("energy", r.strain_energy - r.load_work);
        let largest = report.largest_von_mises;
        figures.json_only("largest_von_mises.value", largest.value);
        figures.json_only("largest_von_mises.error", largest.error);
        figures.json_only("largest_von_mises.place", largest.at);
        figures.json_only("largest_von_mises.concentration", largest.concentration.map(StressConcentration::word));
        figures.json_only("largest_von_mises.concentration_place", largest.concentration.map(|_| largest.limit));
        figures.json_only("largest_displacement", r.largest_displacement);
        figures.told("largest |u_x|, |u_y|, |u_z|", Dimension::LENGTH, Some(r.largest_displacement_along));
        figures.json_only("largest_displacement_along", r.largest_displacement_along);
        figures
    }

    /// The largest von Mises stress with its error bar or why it has no limit, and its place; `None` without a solution.
    pub fn largest_von_mises(&self) -> Option<String> {
        let largest = self.report.largest_von_mises;
        let [stress, length] =
            [Dimension::STRESS, Dimension::LENGTH].map(|it| self.scene.units.of(it));
        let elsewhere = (largest.limit != largest.at).then(|| length.told(&largest.limit));
        let grows = largest.concentration.map(|what| (what, elsewhere));
        let mut place = format!(" at {}", length.told(&largest.at));
        if grows.is_none() && largest.error.is_infinite() {
            place += self.if_unresolved();
        }
        let shown = || with_bar(&stress, [largest.value, largest.error], &place, grows);
        let is_stressed = largest.value > 0.0 && self.is_strained();
        (self.solution.has_computed_solution() && is_stressed).then(shown)
    }

    /// Whether strains are more than the rounding of displacements, as those of a body that moves as a whole are not.
    pub(super) fn is_strained(&self) -> bool {
        let moved = self.report.resultants.largest_displacement / self.mesh.extent();
        self.report.largest_strain(self.mesh) > 1e-12 * moved
    }

    /// What is said of a quantity of a mesh that sees too little of the solution to tell errors of quantities.
    pub(super) fn if_unresolved(&self) -> &'static str {
        match self.report.discretisation_error.is_unreliable() {
            true => ", not resolved: refine the mesh",
            false => "",
        }
    }

    #[rustfmt::skip]
    fn of_errors(&self) -> Figures {
        let report = self.report;
        let r = &report.resultants;
        let mut figures = Figures::new(self.scene.units);
        figures.number("", "force, moment imbalance", Scientific(1), [r.force_imbalance, r.moment_imbalance]);
        figures.json_only("force_imbalance", r.force_imbalance);
        figures.json_only("moment_imbalance", r.moment_imbalance);
        if !self.solution.has_computed_solution() {
            return figures;
        }
        for (name, part) in self.estimate().1.relative_parts() {
            figures.json_only(&format!("discretisation_error.{name}"), part);
        }
        let kinks = report.functionals.iter().map(|it| it.kinks).max().filter(|kinks| *kinks > 0);
        let one_sided = |kinks| format!("those of one side: {kinks} pane(s) between two contact states");
        figures.human_only("error bars", kinks.map(one_sided));
        figures.json_only("quantities", quantities_json(self.scene.units, &report.functionals));
        figures
    }

    /// How well the discrete problem is satisfied.
    pub fn certificate(&self) -> Figures {
        let mut figures = Figures::new(self.scene.units);
        if !self.solution.has_computed_solution() {
            return figures;
        }
        for (name, value) in self.report.certificate.figures() {
            let (key, words) = (format!("certificate.{name}"), format!("certificate {name}"));
            figures.number(&key, &words, Scientific(1), value);
        }
        figures
    }

    /// Everything for programs, with the cost of the assembly where it is in memory.
    pub fn json(&self, assembly: Option<&Assembly>) -> Value {
        let (mesh, solution) = (self.mesh, self.solution);
        let faces = self.faces();
        let rigid = solution.rigid.as_ref();
        let mut figures = Figures::new(self.scene.units);
        figures.json_only("title", &self.scene.title);
        figures.json_only("forces", self.forces().json());
        figures.json_only("faces", (!faces.rows.is_empty()).then(|| faces.json()));
        let (places, volumes) = (&mesh.coordinates, mesh.corner_volumes());
        let motion = |rows| rigid_json(&BodyMotion::fitted(places, &volumes, rows));
        let moves = rigid.is_some() && mesh.bodies.is_empty();
        figures.json_only("motion", moves.then(|| motion(&self.report.displacement)));
        let mechanism = rigid.and_then(|rigid| rigid.mechanism.as_deref());
        let of_body = mechanism.map(|rows| &rows[..mesh.coordinates.len()]);
        figures.json_only("mechanism", of_body.map(motion));
        figures.json_only("tools", tools_json(self.scene, &self.report.tools));
        let motions = || null_space_motions(mesh, solution);
        let null_space = || motions().iter().map(rigid_json).collect::<Value>();
        figures.json_only("null_space_motions", moves.then(null_space));
        figures.json_only("assembly_seconds", assembly.map(seconds));
        figures.json_only("factor", assembly.map(factor));
        figures.with(self.figures()).with(self.certificate()).json()
    }
}

/// Steps of each algorithm that ran.
fn steps(solution: &Solution) -> String {
    let trace = &solution.trace;
    let fallbacks = trace.newton.iter().filter(|step| step.safeguard).count();
    match (trace.newton.len(), trace.history.len()) {
        (0, 0) => "one solve".into(),
        (0, outer) => format!("{outer} outer"),
        (newton, 0) => format!("{newton} Newton, {fallbacks} of them safeguards"),
        (newton, 1) if trace.solved_by == SolvedBy::Minimisation => format!("{newton} Newton"),
        (newton, outer) => format!("{newton} Newton, given up, then {outer} outer"),
    }
}

/// A share in percent with two digits, without a power of ten from 0.01 % on.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        1e5.. => format!("{percent:.1e} %"),
        10.0.. => format!("{percent:.0} %"),
        1.0..10.0 => format!("{percent:.1} %"),
        0.1..1.0 => format!("{percent:.2} %"),
        0.01..0.1 => format!("{percent:.3} %"),
        0.0 => "0 %".to_owned(),
        _ if percent.is_nan() => "unknown".to_owned(),
        _ => format!("{percent:.1e} %"),
    }
}

/// An estimated share in per cent, of which an order of magnitude is all that counts where it is large.
pub fn estimated_percent(share: f64) -> String {
    if share >= 10.0 {
        "over 1000 %".to_owned()
    } else {
        percent(share)
    }
}

/// Smallest and largest F₁ and F₂ over the panes; `None` where none was evaluated.
fn friction_ranges(report: &ContactReport) -> Option<String> {
    let coefficients = || {
        let panes = report.panes.iter();
        panes.filter_map(|pane| Some(pane.friction?.coulomb?.coefficients))
    };
    coefficients().next()?;
    let ranges = [0, 1].map(|i| {
        let values = || coefficients().map(|f| f[i]);
        let low = values().fold(f64::INFINITY, f64::min);
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        format!("F{} {low:.4} to {high:.4}", i + 1)
    });
    Some(ranges.join(", "))
}

/// What the parts of an assembly took.
fn seconds(assembly: &Assembly) -> Value {
    let parts = assembly.seconds.parts().into_iter();
    let parts = parts.map(|(name, seconds)| (name.to_owned(), json!(seconds)));
    Value::Object(parts.collect::<Map<_, _>>())
}

/// The factor: its precision, its coefficients, and the operations that made it.
fn factor(assembly: &Assembly) -> Value {
    let structure = assembly.factor.structure();
    json!({
        "precision": assembly.factor.precision().word(),
        "coefficients": structure.value_count(),
        "operations": structure.operations(),
    })
}

/// The tools with their names; `None` where there are none.
pub(super) fn tools_json(scene: &Scene, tools: &[ToolState]) -> Option<Value> {
    let rows = tools.iter().enumerate().map(|(k, tool)| {
        json!({
            "name": scene.tool_name(k),
            "point": tool.point,
            "displacement": tool.displacement,
            "turn": tool.turn,
            "force": tool.force,
            "moment": tool.moment,
        })
    });
    (!tools.is_empty()).then(|| rows.collect())
}

/// A rigid motion: translation of a point, rotation vector, the point.
fn rigid_json(motion: &BodyMotion) -> Value {
    json!({
        "translation": motion.translation,
        "rotation": motion.rotation,
        "point": motion.point,
    })
}
