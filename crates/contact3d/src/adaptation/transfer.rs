//! Multipliers of one mesh on a finer one.

use std::collections::HashMap;

use crate::{contact::MultiplierLayout, mesh::Mesh};

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
    if !surface.is_nodal() {
        return surface
            .facet_pane
            .iter()
            .map(|pane| stress(*pane))
            .collect();
    }
    let carried = carried(mesh);
    let mean = |facet: &usize| {
        let held = mesh
            .facet_nodes(*facet)
            .filter_map(|node| carried.get(&node));
        let known: Vec<[f64; 3]> = held.map(|pane| stress(*pane)).collect();
        let n = known.len().max(1) as f64;
        std::array::from_fn(|c| known.iter().map(|s| s[c]).sum::<f64>() / n)
    };
    surface.facets.iter().map(mean).collect()
}

/// The multiplier that each mesh node carries, where multipliers belong to nodes.
fn carried(mesh: &Mesh) -> HashMap<usize, usize> {
    let Some(surface) = &mesh.contact else {
        return HashMap::new();
    };
    let panes = (0..surface.n_panes()).map(|pane| {
        let place = surface.pane_average.indices[surface.pane_average.indptr[pane]];
        (surface.nodes[place], pane)
    });
    panes.collect()
}

/// Multipliers in Pa of a mesh as a start on a finer one: each takes the mean of the stresses on the
/// triangles it is made of, and a triangle has those of the one it lies in. `parents` names the
/// coarse tetrahedron that each fine one lies in, `[n_tetrahedra of the fine mesh]`.
#[must_use]
pub fn transferred(
    coarse: &Mesh,
    fine: &Mesh,
    parents: &[usize],
    friction: bool,
    multiplier: &[f64],
) -> Vec<f64> {
    let (Some(known), Some(wanted)) = (&coarse.contact, &fine.contact) else {
        return Vec::new();
    };
    let stresses = on_facets(
        coarse,
        MultiplierLayout::new(known.n_panes(), friction),
        multiplier,
    );
    // A tetrahedron has at most one side on a flat face.
    let stress_of: HashMap<usize, [f64; 3]> =
        coarse.behind_contact().into_iter().zip(stresses).collect();
    let layout = MultiplierLayout::new(wanted.n_panes(), friction);
    let mut sums = vec![([0.0; 3], 0.0); wanted.n_panes()];
    let carried = if wanted.is_nodal() {
        carried(fine)
    } else {
        HashMap::new()
    };
    for (place, (facet, behind)) in wanted.facets.iter().zip(fine.behind_contact()).enumerate() {
        let stress = stress_of.get(&parents[behind]).copied().unwrap_or_default();
        let area = fine.facet_area(*facet);
        let mut add = |pane: usize| {
            let (sum, weight) = &mut sums[pane];
            *sum = std::array::from_fn(|c| sum[c] + area * stress[c]);
            *weight += area;
        };
        match wanted.facet_pane.get(place) {
            Some(pane) => add(*pane),
            None => fine
                .facet_nodes(*facet)
                .filter_map(|n| carried.get(&n))
                .for_each(|p| add(*p)),
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
