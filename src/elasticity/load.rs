use crate::{
    mesh::{Mesh, triangle_area},
    scene::Traction,
};

/// Consistent nodal forces ∫_{Γ_p} φ p of the surface tractions in N, `[n_nodes]`.
#[must_use]
pub fn load_vector(mesh: &Mesh, tractions: &[Traction]) -> Vec<[f64; 3]> {
    let mut load = vec![[0.0; 3]; mesh.coordinates.len()];
    for traction in tractions {
        for facet in mesh.facets_on(traction.face) {
            let share = triangle_area(&mesh.corners(facet)) / 3.0;
            for &node in facet {
                for component in 0..3 {
                    load[node][component] += share * traction.value[component];
                }
            }
        }
    }
    load
}
