//! Fields of `/VTKHDF` that no step of a series has of its own: ν of contact faces that are curved or several, and the motion that nothing
//! stops.

use contact3d::mesh::Mesh;
use runfile::{
    DatasetSpec,
    Extent::{Fixed, Named},
    GroupWriter, Kind, Reader, StoreError,
};
use units::Dimension;

use super::{vtkhdf::GROUP, vtkhdf_series::offsets_row};

const NORMAL: &str = "/VTKHDF/CellData/contact_normal";
const UNSTOPPED_MOTION: &str = "/VTKHDF/PointData/unstopped_motion";
const NORMAL_OFFSETS: &str = "/VTKHDF/Steps/CellDataOffsets/contact_normal";

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(NORMAL, Kind::F64, &[Named("n_cells"), Fixed(3)], Dimension::Number, "Unit normal of contact in the middle of each contact triangle, out of the body and into the obstacle, one array for all steps of a series; NaN on tetrahedra.").symbol("nu").compressed().optional("absent without contact, and with one face whose normal is the same everywhere"),
    offsets_row(NORMAL_OFFSETS),
    GROUP.row(UNSTOPPED_MOTION, Kind::F64, &[Named("n_nodes"), Fixed(3)], Dimension::Number, "Without equilibrium the rigid motion that nothing stops, of largest component one; warp by this vector.").compressed().optional("absent with equilibrium, and in a series"),
];

/// Writes the normals, with `n_steps` also that they are those of all steps of a series.
///
/// # Errors
/// HDF5 failures.
pub(super) fn write_normals(
    writer: &mut GroupWriter<'_>,
    mesh: &Mesh,
    n_steps: Option<usize>,
) -> Result<(), StoreError> {
    let surface = mesh.contact.as_ref();
    let Some(surface) = surface.filter(|surface| surface.normals.len() > 1) else {
        return Ok(());
    };
    let mut normals = vec![[f64::NAN; 3]; mesh.tetrahedra.len()];
    normals.extend(surface.facets.iter().enumerate().map(|(place, &facet)| {
        let face = surface.face_of_facet(place);
        let nodes = mesh.facets[facet].into_iter();
        let of_nodes = nodes.filter_map(|node| surface.contact_node(face, node));
        let sum = of_nodes.fold([0.0; 3], |sum: [f64; 3], node| {
            let normal = surface.normal_at(node);
            std::array::from_fn(|c| sum[c] + normal[c])
        });
        let length = sum.iter().map(|v| v * v).sum::<f64>().sqrt();
        sum.map(|v| v / length)
    }));
    write_once(writer, normals.as_flattened(), n_steps)
}

/// Writes the normals of another file for all steps of a series; nothing where it has none.
///
/// # Errors
/// HDF5 failures.
pub(super) fn copy_normals(
    writer: &mut GroupWriter<'_>,
    reader: &Reader,
    n_steps: usize,
) -> Result<(), StoreError> {
    match reader.has(NORMAL) {
        true => write_once(writer, &reader.read_vec::<f64>(NORMAL)?, Some(n_steps)),
        false => Ok(()),
    }
}

fn write_once(
    writer: &mut GroupWriter<'_>,
    normals: &[f64],
    n_steps: Option<usize>,
) -> Result<(), StoreError> {
    writer.write(NORMAL, normals, &[normals.len() / 3, 3])?;
    match n_steps {
        None => Ok(()),
        Some(steps) => writer.write_indices(NORMAL_OFFSETS, &vec![0; steps], &[steps]),
    }
}

/// Writes the motion that nothing stops, `[n_nodes]`.
///
/// # Errors
/// HDF5 failures.
pub(super) fn write_unstopped(
    writer: &mut GroupWriter<'_>,
    motion: &[[f64; 3]],
) -> Result<(), StoreError> {
    writer.write(UNSTOPPED_MOTION, motion.as_flattened(), &[motion.len(), 3])
}
