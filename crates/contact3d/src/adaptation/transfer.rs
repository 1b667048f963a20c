//! Multipliers of one mesh on a finer one.

use std::collections::HashMap;

use crate::{
    contact::MultiplierLayout,
    mesh::{ContactSurface, Mesh},
};

/// The three stresses on each contact triangle, `[n_contact_facets]`: those of its pane, or the mean
/// of those at its nodes.
fn on_facets(mesh: &Mesh, layout: MultiplierLayout, multiplier: &[f64]) -> Vec<[f64; 3]> {
    let Some(surface) = &mesh.contact else {
        return Vec::new();
    };
    let stress = |pane: usize| {
        let [first, second] = layout.pair(multiplier, pane);
        [multiplier[layout.normal(pane)], first, second]
    };
    let mean = |place: usize| {
        let known: Vec<[f64; 3]> = panes_at(mesh, surface, place).map(stress).collect();
        let n = known.len().max(1) as f64;
        std::array::from_fn(|c| known.iter().map(|s| s[c]).sum::<f64>() / n)
    };
    let stress_on = |place: usize| match surface.pane_of_facet(place) {
        Some(pane) => stress(pane),
        None => mean(place),
    };
    (0..surface.facets.len()).map(stress_on).collect()
}

/// The nodal multipliers around a contact triangle.
fn panes_at<'a>(
    mesh: &'a Mesh,
    surface: &'a ContactSurface,
    place: usize,
) -> impl Iterator<Item = usize> + 'a {
    let face = surface.face_of_facet(place);
    mesh.facet_nodes(surface.facets[place])
        .filter_map(move |node| surface.carried_by(face, surface.contact_node(face, node)?))
}

/// The panes with friction of the finer mesh: those of the faces whose coarse panes are the first `n_pairs`.
fn fine_pairs(known: &ContactSurface, wanted: &ContactSurface, n_pairs: usize) -> usize {
    let mut faces = known.faces.iter().zip(&wanted.faces);
    let last = faces.rfind(|(face, _)| face.panes.end <= n_pairs);
    last.map_or(0, |(_, face)| face.panes.end)
}

/// Multipliers in Pa of a mesh as a start on a finer one: each takes the mean of the stresses on the
/// triangles it is made of, and a triangle has those of the one it lies in. `parents` names the
/// coarse tetrahedron that each fine one lies in, `[n_tetrahedra of the fine mesh]`.
#[must_use]
pub fn transferred(coarse: &Mesh, fine: &Mesh, parents: &[usize], multiplier: &[f64]) -> Vec<f64> {
    let (Some(known), Some(wanted)) = (&coarse.contact, &fine.contact) else {
        return Vec::new();
    };
    let n_pairs = (multiplier.len() - known.n_panes()) / 2;
    let stresses = on_facets(
        coarse,
        MultiplierLayout::new(known.n_panes(), n_pairs),
        multiplier,
    );
    // A tetrahedron has at most one side on each face.
    let behind = coarse.behind_contact().into_iter().enumerate();
    let stress_of: HashMap<(usize, usize), [f64; 3]> = behind
        .map(|(place, behind)| (known.face_number(place), behind))
        .zip(stresses)
        .collect();
    let layout = MultiplierLayout::new(wanted.n_panes(), fine_pairs(known, wanted, n_pairs));
    let mut sums = vec![([0.0; 3], 0.0); wanted.n_panes()];
    for (place, (facet, behind)) in wanted.facets.iter().zip(fine.behind_contact()).enumerate() {
        let from = (wanted.face_number(place), parents[behind]);
        let stress = stress_of.get(&from).copied().unwrap_or_default();
        let area = fine.facet_area(*facet);
        let mut add = |pane: usize| {
            let (sum, weight) = &mut sums[pane];
            *sum = std::array::from_fn(|c| sum[c] + area * stress[c]);
            *weight += area;
        };
        match wanted.pane_of_facet(place) {
            Some(pane) => add(pane),
            None => panes_at(fine, wanted, place).for_each(add),
        }
    }
    let mut start = vec![0.0; layout.n_multipliers()];
    for (pane, (sum, weight)) in sums.iter().enumerate() {
        let mean = sum.map(|s| s / weight);
        start[layout.normal(pane)] = mean[0];
        if let Some(pair) = layout.tangential(pane) {
            pair.into_iter()
                .zip(&mean[1..])
                .for_each(|(place, value)| start[place] = *value);
        }
    }
    start
}
