//! What there is to look at in a solution: nothing touches, something is too large for the theory, or contact is too narrow for its panes.

use contact3d::{
    history::StepRecord,
    mesh::extents,
    post::{PaneState, Zone},
    scene::{Clamp, Follow, Obstacle, escape_control},
};
use units::Dimension;

use super::{SolvedRun, percent};

impl SolvedRun<'_> {
    /// All of it, in the order of its weight.
    pub(super) fn all_cautions(&self) -> Vec<String> {
        let nothing = self.nothing_moves().into_iter();
        let nothing = nothing.chain(self.nothing_touches());
        let cautions = nothing.chain(self.beyond_theory());
        cautions.chain(self.narrow_contact()).collect()
    }

    /// That a scene without a load history leaves everything where it is.
    fn nothing_moves(&self) -> Option<String> {
        let is_static = self.solution.has_computed_solution() && self.increments.is_empty();
        let is_still = is_static && self.report.resultants.largest_displacement == 0.0;
        let words = "nothing moves: no load acts on displacements that are free, and no clamp or tool moves";
        is_still.then(|| words.to_owned())
    }

    /// That all panes are open, by how much at least, and what to look at; `None` where one touches.
    pub(super) fn nothing_touches(&self) -> Option<String> {
        let panes = &self.report.panes;
        let is_open = |pane: &PaneState| pane.zone == Zone::Open;
        let touched = |record: &StepRecord| record.panes.iter().any(|it| it.zone != Zone::Open);
        if panes.is_empty()
            || !self.solution.has_computed_solution()
            || !panes.iter().all(is_open)
            || self.increments.iter().any(touched)
        {
            return None;
        }
        let error = &self.report.discretisation_error;
        if error
            .contact
            .is_some_and(|contact| contact.penetration > 0.0)
        {
            return Some("no pane is in contact, but the obstacle lies inside the body within panes: the mesh is too coarse there; run ... --error 5% refines it".into());
        }
        let gap = panes
            .iter()
            .map(|pane| pane.gap)
            .fold(f64::INFINITY, f64::min);
        if gap <= 0.0 {
            let what = match self.scene.bodies_touch() {
                true => "the bodies only touch each other",
                false => "the contact face only touches the foundation",
            };
            return Some(format!("no pane is pressed: {what}"));
        }
        let gap = self.scene.units.of(Dimension::LENGTH).told(&[gap]);
        let what = match self.scene.bodies_touch() {
            true => "bodies",
            false => "obstacle",
        };
        Some(format!(
            "no pane is in contact, the smallest gap left is {gap}: check the place of the {what}, the directions of the loads (a positive pressure pushes into the body) and the unit of lengths"
        ))
    }

    /// What is too large for the theory of small deformations, and what to look at.
    fn beyond_theory(&self) -> Vec<String> {
        if !self.solution.has_computed_solution() {
            return Vec::new();
        }
        let size = |vectors: &[[f64; 3]]| {
            let [x, y, z] = extents(vectors);
            x.hypot(y).hypot(z)
        };
        let [_, stress, _] = StepRecord::LOADS;
        let (_, report, place) = self.results.loaded_most(stress);
        let when = self.in_increment(place);
        let share = size(&report.displacement) / size(&self.mesh.coordinates);
        let strain = report.largest_strain(self.mesh);
        let look =
            "but small deformations are assumed: check the units of material, loads and lengths";
        // What displacements may differ from each other, over the size of the body, and strains may be, before they are not small.
        let deformation = if share > 0.1 {
            Some(format!(
                "displacements differ by {} of the body's size{when}, {look}",
                percent(share)
            ))
        } else {
            (strain > 0.1).then(|| format!("strains reach {}{when}, {look}", percent(strain)))
        };
        // A newton strains a steel cube of a metre by 5e-12, lengths of mm taken for metres make strains of 1e-5 to 1e-4 as small.
        let unstrained = (strain < 1e-10 && self.is_strained()).then(|| {
            format!("strains are no more than {strain:.1e}: check the units of material, loads and lengths")
        });
        let depth = self.results.interference() / self.mesh.extent();
        let interference = (depth > 0.02).then(|| {
            let depth = percent(depth);
            match self.scene.bodies_touch() {
                true => format!("bodies cut into each other by {depth} of their size, {look}"),
                false => format!("the foundation cuts {depth} of the body's size into it, {look}"),
            }
        });
        let overlap = self.results.dropped_overlap();
        let along = report.resultants.largest_displacement_along;
        // Where it counts beside what the loads do.
        let overlap = (overlap > 0.01 * along.into_iter().fold(0.0, f64::max)).then(|| {
            let depth = self.scene.units.of(Dimension::LENGTH).told(&[overlap]);
            format!(
                "bodies overlap by up to {depth}, no more than their triangles leave of curved faces, and are taken to touch: finer meshes tell, interference = true presses them apart"
            )
        });
        let slide = self.slide().map(|share| {
            format!(
                "the body slides by {} of its size before it rests: the load is at the limit of what friction bears, and contact is that of where it began",
                percent(share)
            )
        });
        let all = deformation
            .into_iter()
            .chain(unstrained)
            .chain(interference)
            .chain(overlap)
            .chain(slide);
        all.chain(self.far_tools())
            .chain(self.long_slips())
            .collect()
    }

    /// Tools whose free motions take them further than a tenth of the body's size: gaps are those of where they began.
    fn far_tools(&self) -> impl Iterator<Item = String> {
        let states = self.scene.tools.iter().zip(&self.report.tools).enumerate();
        states.filter_map(|(number, (tool, state))| {
            let free = (0..3).filter(|c| tool.is_free(*c));
            let moved = free.map(|c| state.displacement[c].powi(2)).sum::<f64>();
            let share = moved.sqrt() / self.mesh.extent();
            (share > 0.1 && !self.scene.follows_tools()).then(|| {
                format!(
                    "the tool {} moves by {} of the body's size before it rests, and gaps are those of where it began: check its place, radius and loads",
                    escape_control(&self.scene.tool_name(number)),
                    percent(share)
                )
            })
        })
    }

    /// That contact is hardly wider than panes, and what to do; `None` where panes tell how its pressure falls.
    fn narrow_contact(&self) -> Option<String> {
        let (share, place) = self.results.narrow_share()?;
        let mut what = String::new();
        if self.scene.adapt.is_none() {
            what += "; run ... --error 5% refines the mesh there";
        }
        if self.has_panes() {
            what += "; contact.multipliers = \"nodal\" sees more";
        }
        Some(format!(
            "{} of the normal force{} is on panes beside open ones: contact is hardly wider than panes, which round its pressures and areas{what}",
            percent(share),
            self.in_increment(place)
        ))
    }

    /// How far a body slides that friction alone holds, over its size; `None` up to a tenth, and of loads on a flat face up to ten times
    /// what it deforms by.
    fn slide(&self) -> Option<f64> {
        let n_motions = self.solution.rigid.as_ref()?.motion.len();
        if n_motions == self.scene.n_free_tool_motions() {
            return None;
        }
        let faces = self.mesh.contact.iter().flat_map(|it| &it.faces);
        let least = faces.map(|face| {
            let panes = self.report.panes[face.panes.clone()].iter();
            let contact = panes.filter(|pane| pane.zone != Zone::Open);
            let slips = contact.filter_map(|pane| pane.friction);
            let lengths = slips.map(|it| it.slip[0].hypot(it.slip[1]));
            lengths.reduce(f64::min).unwrap_or(0.0)
        });
        let [x, y, z] = extents(&self.mesh.coordinates);
        let share = least.fold(0.0, f64::max) / x.hypot(y).hypot(z);
        let scene = self.scene;
        let friction = self.solution.friction.as_ref();
        let is_of_loads = matches!(&scene.contacts[..], [only] if only.obstacle.is_none())
            && friction.is_some_and(|it| it.slip.is_none())
            && !scene.clamps.iter().any(Clamp::is_moved)
            && scene.springs.is_empty()
            && scene.tools.is_empty();
        let deformed = 10.0 * self.report.largest_strain(self.mesh);
        let most = if is_of_loads { deformed.min(0.1) } else { 0.1 };
        (share > most).then_some(share)
    }

    /// Slips along round obstacles after which their normal is another one.
    fn long_slips(&self) -> impl Iterator<Item = String> {
        let faces = self.mesh.contact.iter().flat_map(|surface| &surface.faces);
        let entries = self.scene.contact_order().into_iter().zip(faces);
        entries.filter_map(|(entry, face)| {
            let contact = &self.scene.contacts[entry];
            if !self.scene.steps.is_empty() && self.scene.follow_of(entry) == Follow::Increment {
                return None;
            }
            let radius = match contact.obstacle.as_ref()? {
                Obstacle::Sphere(sphere) => sphere.radius,
                Obstacle::Cylinder(cylinder) => cylinder.radius,
                Obstacle::HalfSpace(_) | Obstacle::Height(_) | Obstacle::Surface(_) => return None,
            };
            let slip_of = |pane: usize| {
                let state = self.report.panes.get(pane).filter(|it| it.zone != Zone::Open);
                let slip = state.and_then(|state| state.friction).map(|it| it.slip);
                // Of a history those since it began, where it is pressed.
                let pressed = self.increments.iter().filter(|it| it.panes[pane].zone != Zone::Open);
                let of_history = pressed.filter(|it| !it.tangential.is_empty()).map(|it| {
                    let nodes = self.mesh.contact.iter().flat_map(|at| at.pane_weights(pane));
                    nodes.fold([0.0, 0.0], |[a, b], (node, weight)| {
                        let [first, second] = it.tangential[node];
                        [a + weight * first, b + weight * second]
                    })
                });
                let slips = slip.filter(|_| self.increments.is_empty()).into_iter();
                let lengths = slips.chain(of_history).map(|[a, b]: [f64; 2]| a.hypot(b));
                lengths.reduce(f64::max)
            };
            let longest = face.panes.clone().filter_map(slip_of).fold(0.0, f64::max);
            // The normal turns by the slip over the radius, 3 degrees here.
            (longest > radius / 20.0).then(|| {
                format!(
                    "contact.{entry}: it slips by {} of the radius of its obstacle, but normals are those of where it began: {}",
                    percent(longest / radius),
                    match contact.tool {
                        Some(_) => "write follow = \"increment\" and more increments",
                        None => "apply the load in parts, each on the moved body",
                    }
                )
            })
        })
    }
}
