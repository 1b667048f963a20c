//! `/VTKHDF`: the results as an unstructured grid that ParaView opens (VTKHDF 2.0).
//!
//! Cells are all tetrahedra, then the contact triangles. Fields that live on one kind of cell only
//! are NaN on the other, which ParaView draws in its NaN colour.

use crate::{
    mesh::Mesh,
    post::{ContactReport, PaneState},
    store::{
        DatasetSpec, Extent,
        Extent::{Fixed, Named, Plus},
        Kind, Stage, StageWriter, StoreError,
    },
};

const N_POINTS: &str = "/VTKHDF/NumberOfPoints";
const N_CELLS: &str = "/VTKHDF/NumberOfCells";
const N_CONNECTIVITY: &str = "/VTKHDF/NumberOfConnectivityIds";
const POINTS: &str = "/VTKHDF/Points";
const CONNECTIVITY: &str = "/VTKHDF/Connectivity";
const OFFSETS: &str = "/VTKHDF/Offsets";
const TYPES: &str = "/VTKHDF/Types";
const DISPLACEMENT: &str = "/VTKHDF/PointData/displacement";
const VON_MISES: &str = "/VTKHDF/CellData/von_mises";
const NORMAL_STRESS: &str = "/VTKHDF/CellData/contact_normal_stress";
const TANGENTIAL_STRESS: &str = "/VTKHDF/CellData/contact_tangential_stress";
const GAP: &str = "/VTKHDF/CellData/contact_gap";
const FRICTION_1: &str = "/VTKHDF/CellData/friction_1";
const FRICTION_2: &str = "/VTKHDF/CellData/friction_2";
const ZONE: &str = "/VTKHDF/CellData/contact_zone";

/// VTK's number of a triangle cell.
const VTK_TRIANGLE: u8 = 5;
/// VTK's number of a tetrahedron cell.
const VTK_TETRA: u8 = 10;

const CELLS: &[Extent] = &[Named("n_cells")];

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    Stage::Vtk.row(N_POINTS, Kind::I64, &[Fixed(1)], "1", "Number of points."),
    Stage::Vtk.row(N_CELLS, Kind::I64, &[Fixed(1)], "1", "Number of cells."),
    Stage::Vtk.row(N_CONNECTIVITY, Kind::I64, &[Fixed(1)], "1", "Length of Connectivity."),
    Stage::Vtk.row(POINTS, Kind::F64, &[Named("n_nodes"), Fixed(3)], "m", "Node coordinates.").compressed(),
    Stage::Vtk.row(CONNECTIVITY, Kind::I64, &[Named("n_connectivity")], "1", "Nodes of all cells, one after the other.").compressed(),
    Stage::Vtk.row(OFFSETS, Kind::I64, &[Plus("n_cells", 1)], "1", "Where each cell begins in Connectivity.").compressed(),
    Stage::Vtk.row(TYPES, Kind::U8, CELLS, "1", "VTK cell type: 10 tetrahedron, 5 triangle.").compressed(),
    Stage::Vtk.row(DISPLACEMENT, Kind::F64, &[Named("n_nodes"), Fixed(3)], "m", "Displacement; warp by this vector.").compressed(),
    Stage::Vtk.row(VON_MISES, Kind::F64, CELLS, "Pa", "Von Mises stress, NaN on contact triangles.").compressed(),
    Stage::Vtk.row(NORMAL_STRESS, Kind::F64, CELLS, "Pa", "Normal contact stress, NaN on tetrahedra.").compressed(),
    Stage::Vtk.row(TANGENTIAL_STRESS, Kind::F64, &[Named("n_cells"), Fixed(3)], "Pa", "Tangential contact stress in the global axes, NaN on tetrahedra.").compressed(),
    Stage::Vtk.row(GAP, Kind::F64, CELLS, "m", "Mean gap of the pane, NaN on tetrahedra.").compressed(),
    Stage::Vtk.row(FRICTION_1, Kind::F64, CELLS, "1", "F_1 of the pane, NaN on tetrahedra.").compressed(),
    Stage::Vtk.row(FRICTION_2, Kind::F64, CELLS, "1", "F_2 of the pane, NaN on tetrahedra.").compressed(),
    Stage::Vtk.row(ZONE, Kind::F64, CELLS, "1", "0 open, 1 stick, 2 slip; NaN on tetrahedra.").compressed(),
];

/// Writes the grid and its fields.
///
/// # Errors
/// HDF5 failures.
pub fn write(
    writer: &mut StageWriter<'_>,
    mesh: &Mesh,
    report: &ContactReport,
    axes: [[f64; 3]; 2],
) -> Result<(), StoreError> {
    writer.write_ascii_attribute("Type", b"UnstructuredGrid")?;
    writer.write_number_attribute("Version", &[2_i64, 0])?;
    write_grid(writer, mesh)?;
    let (n_nodes, n_tetrahedra) = (mesh.coordinates.len(), mesh.tetrahedra.len());
    let n_cells = n_tetrahedra + mesh.contact.facets.len();
    writer.write(
        DISPLACEMENT,
        report.displacement.as_flattened(),
        &[n_nodes, 3],
    )?;
    let mut von_mises = report.von_mises.clone();
    von_mises.resize(n_cells, f64::NAN);
    writer.write(VON_MISES, &von_mises, &[n_cells])?;
    type Measure = fn(&PaneState) -> f64;
    let fields: [(&str, Measure); 5] = [
        (NORMAL_STRESS, |p| p.normal_stress),
        (GAP, |p| p.gap),
        (FRICTION_1, |p| p.friction[0]),
        (FRICTION_2, |p| p.friction[1]),
        (ZONE, |p| f64::from(p.zone as u8)),
    ];
    for (path, measure) in fields {
        let mut values = vec![f64::NAN; n_tetrahedra];
        values.extend(
            mesh.contact
                .facet_pane
                .iter()
                .map(|&pane| measure(&report.panes[pane])),
        );
        writer.write(path, &values, &[n_cells])?;
    }
    let mut tangential = vec![[f64::NAN; 3]; n_tetrahedra];
    tangential.extend(mesh.contact.facet_pane.iter().map(|&pane| {
        let stress = report.panes[pane].tangential_stress;
        std::array::from_fn(|c| stress[0] * axes[0][c] + stress[1] * axes[1][c])
    }));
    writer.write(TANGENTIAL_STRESS, tangential.as_flattened(), &[n_cells, 3])
}

fn write_grid(writer: &mut StageWriter<'_>, mesh: &Mesh) -> Result<(), StoreError> {
    let n_tetrahedra = mesh.tetrahedra.len();
    let triangles = mesh.contact.facets.iter().map(|&f| mesh.facets[f]);
    let mut connectivity = mesh.tetrahedra.as_flattened().to_vec();
    connectivity.extend(triangles.flatten());
    let n_cells = n_tetrahedra + mesh.contact.facets.len();
    let offsets: Vec<usize> = (0..=n_tetrahedra)
        .map(|t| 4 * t)
        .chain((1..=mesh.contact.facets.len()).map(|f| 4 * n_tetrahedra + 3 * f))
        .collect();
    let mut types = vec![VTK_TETRA; n_tetrahedra];
    types.resize(n_cells, VTK_TRIANGLE);
    writer.write_indices(N_POINTS, &[mesh.coordinates.len()], &[1])?;
    writer.write_indices(N_CELLS, &[n_cells], &[1])?;
    writer.write_indices(N_CONNECTIVITY, &[connectivity.len()], &[1])?;
    let points = mesh.coordinates.as_flattened();
    writer.write(POINTS, points, &[mesh.coordinates.len(), 3])?;
    writer.write_indices(CONNECTIVITY, &connectivity, &[connectivity.len()])?;
    writer.write_indices(OFFSETS, &offsets, &[offsets.len()])?;
    writer.write(TYPES, &types, &[n_cells])
}
