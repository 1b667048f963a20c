//! Areas of contact and of stick: counts of panes, which have no derivative and so no adjoint.

use super::{FunctionalEstimate, PaneState, Solved, SolvedContact, Zone, estimate::SolutionData};
use crate::scene::Functional;

/// The areas of contact and of stick, enclosed by those of the panes that may be in another zone: panes beside one of another zone.
pub(super) fn areas(
    solved: &Solved<'_>,
    known: &SolutionData<'_>,
    wanted: Option<Functional>,
) -> Vec<FunctionalEstimate> {
    let Some(contact) = &solved.contact else {
        return Vec::new();
    };
    let has_friction = contact.state.interface.has_friction();
    let pressed = |pane: &PaneState| pane.zone != Zone::Open;
    let sticks = |pane: &PaneState| pane.zone == Zone::Stick;
    let area = |functional, counts: fn(&PaneState) -> bool| {
        enclosed(solved, contact, known, functional, counts, wanted)
    };
    let mut areas = vec![area(Functional::ContactArea, pressed)];
    if has_friction {
        areas.push(area(Functional::StickArea, sticks));
    }
    areas
}

fn enclosed(
    solved: &Solved<'_>,
    contact: &SolvedContact<'_>,
    known: &SolutionData<'_>,
    functional: Functional,
    counts: impl Fn(&PaneState) -> bool,
    wanted: Option<Functional>,
) -> FunctionalEstimate {
    let surface = contact.state.surface;
    let inside: Vec<bool> = known.panes.iter().map(counts).collect();
    // Whether a node has panes in the zone and panes beside it.
    let mut around = vec![[false; 2]; surface.nodes.len()];
    let nodes_of = |place: usize| {
        let face = surface.face_of_facet(place);
        let nodes = solved.mesh.facet_nodes(surface.facets[place]);
        nodes.filter_map(move |node| surface.contact_node(face, node))
    };
    let panes_of = |place: usize| -> Vec<usize> {
        let face = surface.face_of_facet(place);
        match surface.pane_of_facet(place) {
            Some(pane) => vec![pane],
            None => nodes_of(place)
                .filter_map(|node| surface.carried_by(face, node))
                .collect(),
        }
    };
    for place in 0..surface.facets.len() {
        for pane in panes_of(place) {
            nodes_of(place).for_each(|node| around[node][usize::from(inside[pane])] = true);
        }
    }
    let mut uncertain = vec![false; surface.n_panes()];
    let mut indicator = vec![0.0; solved.mesh.tetrahedra.len()];
    let behind = solved.mesh.behind_contact();
    for place in 0..surface.facets.len() {
        if nodes_of(place).any(|node| around[node] == [true; 2]) {
            panes_of(place)
                .into_iter()
                .for_each(|pane| uncertain[pane] = true);
            if wanted == Some(functional) {
                indicator[behind[place]] += solved.mesh.facet_area(surface.facets[place]);
            }
        }
    }
    let area = |of: &dyn Fn(usize) -> bool| -> f64 {
        let panes = (0..surface.n_panes()).filter(|&pane| of(pane));
        // An empty sum of floats is −0.
        0.0 + panes.map(|pane| surface.pane_area[pane]).sum::<f64>()
    };
    let value = area(&|pane| inside[pane]);
    let range = [
        area(&|pane| inside[pane] && !uncertain[pane]),
        area(&|pane| inside[pane] || uncertain[pane]),
    ];
    FunctionalEstimate {
        functional,
        value,
        error: (range[1] - value).max(value - range[0]),
        range,
        corners: None,
        kinks: 0,
        indicator,
    }
}
