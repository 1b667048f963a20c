//! Multipliers of one mesh on a finer one.

use std::collections::HashMap;

use super::MultiplierLayout;
use crate::{
    mesh::{ContactSurface, Mesh, centroid},
    scene::Brick,
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
        let panes = surface.panes_of_facet(mesh, place);
        let known: Vec<[f64; 3]> = panes.into_iter().map(stress).collect();
        let n = known.len().max(1) as f64;
        std::array::from_fn(|c| known.iter().map(|s| s[c]).sum::<f64>() / n)
    };
    (0..surface.facets.len()).map(mean).collect()
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
    let stresses = on_facets(coarse, layout_of(known, n_pairs), multiplier);
    // A tetrahedron has at most one side on each face.
    let behind = coarse.behind_contact().into_iter().enumerate();
    let stress_of: HashMap<(usize, usize), [f64; 3]> = behind
        .map(|(place, behind)| (known.face_number(place), behind))
        .zip(stresses)
        .collect();
    let behind = fine.behind_contact();
    averaged(fine, wanted, fine_pairs(known, wanted, n_pairs), |place| {
        let from = (wanted.face_number(place), parents[behind[place]]);
        stress_of.get(&from).copied().unwrap_or_default()
    })
}

/// Multipliers in Pa of a brick as a start on a finer mesh of it: a triangle has at its centre what lies linearly between the means of
/// the stresses on coarse cells at their centres.
pub(crate) fn transferred_by_cells(
    coarse: (&Mesh, &Brick),
    fine: &Mesh,
    multiplier: &[f64],
) -> Vec<f64> {
    let (mesh, brick) = coarse;
    let (Some(known), Some(wanted)) = (&mesh.contact, &fine.contact) else {
        return Vec::new();
    };
    let centres = [0, 1, 2].map(|axis| {
        let planes = brick.planes(axis);
        planes
            .windows(2)
            .map(|ends| f64::midpoint(ends[0], ends[1]))
            .collect::<Vec<_>>()
    });
    let around = |mesh: &Mesh, surface: &ContactSurface, place: usize| {
        let at = centroid(&mesh.corners(&mesh.facets[surface.facets[place]]));
        std::array::from_fn(|axis| between(&centres[axis], at[axis]))
    };
    let n_pairs = (multiplier.len() - known.n_panes()) / 2;
    let stresses = on_facets(mesh, layout_of(known, n_pairs), multiplier);
    let mut sums: HashMap<(usize, [usize; 3]), ([f64; 3], f64)> = HashMap::new();
    for (place, stress) in stresses.into_iter().enumerate() {
        let nearest = around(mesh, known, place)
            .map(|(cell, share)| if share < 0.5 { cell } else { cell + 1 });
        add_weighted(
            sums.entry((known.face_number(place), nearest)).or_default(),
            1.0,
            stress,
        );
    }
    averaged(fine, wanted, fine_pairs(known, wanted, n_pairs), |place| {
        let around: [(usize, f64); 3] = around(fine, wanted, place);
        let mut mean = ([0.0; 3], 0.0);
        for corner in 0..8 {
            let upper = [0, 1, 2].map(|axis| corner >> axis & 1);
            let cell = std::array::from_fn(|axis| around[axis].0 + upper[axis]);
            let weights = [0, 1, 2].map(|axis| {
                let share = around[axis].1;
                if upper[axis] == 1 { share } else { 1.0 - share }
            });
            let weight: f64 = weights.iter().product();
            if weight > 0.0
                && let Some((sum, count)) = sums.get(&(wanted.face_number(place), cell))
            {
                add_weighted(&mut mean, weight, sum.map(|s| s / count));
            }
        }
        let (sum, weight) = mean;
        if weight > 0.0 {
            sum.map(|s| s / weight)
        } else {
            sum
        }
    })
}

/// The last of some increasing numbers that is no larger than x, and where x lies on the way to the next, from 0 to 1.
fn between(points: &[f64], x: f64) -> (usize, f64) {
    let after = points.partition_point(|point| *point <= x);
    match (after.checked_sub(1), points.get(after)) {
        (None, _) => (0, 0.0),
        (Some(before), None) => (before, 0.0),
        (Some(before), Some(next)) => (before, (x - points[before]) / (next - points[before])),
    }
}

fn add_weighted((sum, weight): &mut ([f64; 3], f64), more: f64, stress: [f64; 3]) {
    *sum = std::array::from_fn(|c| sum[c] + more * stress[c]);
    *weight += more;
}

fn layout_of(surface: &ContactSurface, n_pairs: usize) -> MultiplierLayout {
    MultiplierLayout::new(surface.n_panes(), n_pairs)
}

/// Multipliers that are the means, by area, of given stresses on the contact triangles, by their places.
fn averaged(
    mesh: &Mesh,
    surface: &ContactSurface,
    n_pairs: usize,
    stress: impl Fn(usize) -> [f64; 3],
) -> Vec<f64> {
    let layout = layout_of(surface, n_pairs);
    let mut sums = vec![([0.0; 3], 0.0); surface.n_panes()];
    for (place, facet) in surface.facets.iter().enumerate() {
        let (stress, area) = (stress(place), mesh.facet_area(*facet));
        for pane in surface.panes_of_facet(mesh, place) {
            add_weighted(&mut sums[pane], area, stress);
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::transferred_by_cells;
    use crate::{
        mesh::Mesh,
        scene::{Body, Brick, Clamp, Contact, ElementOrder, Material, Scene},
    };

    fn mesh(brick: &Brick) -> Mesh {
        let mut body = Body::from(brick.clone());
        body.element = ElementOrder::P2;
        let scene = Scene::new(body, Material::isotropic(1.0, 0.3))
            .with_clamp(Clamp::face("z_max"))
            .with_contact(Contact::on("z_min"));
        Mesh::of_scene(&scene, Path::new("")).unwrap()
    }

    /// Panes of P2 are cells, line by line from the origin.
    fn centres(brick: &Brick) -> Vec<[f64; 2]> {
        let along = |axis: usize| -> Vec<f64> {
            let planes = brick.planes(axis);
            planes
                .windows(2)
                .map(|ends| f64::midpoint(ends[0], ends[1]))
                .collect()
        };
        let (x, y) = (along(0), along(1));
        y.iter().flat_map(|y| x.iter().map(|x| [*x, *y])).collect()
    }

    #[test]
    fn pressures_that_grow_along_the_face_keep_their_slope_between_coarse_centres() {
        let coarse =
            Brick::new([3.0, 1.0, 1.0], [3, 2, 1]).with_planes(0, vec![0.0, 0.5, 2.0, 3.0]);
        let fine = Brick::new([3.0, 1.0, 1.0], [10, 6, 2]);
        let pressure = |[x, y]: [f64; 2]| 2.0 * x + 3.0 * y;
        let known: Vec<f64> = centres(&coarse).into_iter().map(pressure).collect();
        let start = transferred_by_cells((&mesh(&coarse), &coarse), &mesh(&fine), &known);
        let panes = centres(&fine).into_iter().zip(&start);
        let inner = |[x, y]: [f64; 2]| (0.5..2.4).contains(&x) && (0.3..0.7).contains(&y);
        let inner: Vec<_> = panes.filter(|(at, _)| inner(*at)).collect();
        assert_eq!(inner.len(), 12);
        // Sums of eight products.
        assert!(
            inner
                .iter()
                .all(|(at, value)| (pressure(*at) - *value).abs() < 1e-14)
        );
    }
}
