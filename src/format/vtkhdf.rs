//! `/VTKHDF`: the results as an unstructured grid that ParaView opens (VTKHDF 2.0).
//!
//! Cells are all tetrahedra, then the contact triangles. Fields that live on one kind of cell only
//! are NaN on the other, which ParaView draws in its NaN colour. Fields of panes are cell data,
//! those of nodal multipliers point data.

use contact3d::{
    contact::ContactFrame,
    mesh::{ContactSurface, MaterialNodes, Mesh},
    post::ContactReport,
};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named, Plus},
    GroupWriter, Kind, StoreError,
};
use units::Dimension;

use super::{
    fields::{write_list, write_value},
    result_fields::{FieldPlace, FieldShape, RESULT_FIELDS, ResultState, VTKHDF, offsets_row},
};

pub(super) const N_POINTS: &str = "/VTKHDF/NumberOfPoints";
pub(super) const N_CELLS: &str = "/VTKHDF/NumberOfCells";
pub(super) const N_CONNECTIVITY: &str = "/VTKHDF/NumberOfConnectivityIds";
pub(super) const POINTS: &str = "/VTKHDF/Points";
pub(super) const CONNECTIVITY: &str = "/VTKHDF/Connectivity";
pub(super) const OFFSETS: &str = "/VTKHDF/Offsets";
pub(super) const TYPES: &str = "/VTKHDF/Types";
const ERROR_INDICATOR: &str = "/VTKHDF/CellData/error_indicator";
const CONTACT_FACE: &str = "/VTKHDF/CellData/contact_face";
const BODY: &str = "/VTKHDF/CellData/body";
pub(super) const NORMAL: &str = "/VTKHDF/CellData/contact_normal";
const NORMAL_OFFSETS: &str = "/VTKHDF/Steps/CellDataOffsets/contact_normal";
const MECHANISM: &str = "/VTKHDF/PointData/mechanism";

/// Value of the attribute `Type` of the group.
pub(super) const TYPE: &[u8; 16] = b"UnstructuredGrid";
/// Value of the attribute `Version` of the group: VTKHDF 2.0.
pub(super) const VERSION: [i64; 2] = [2, 0];

/// VTK's number of a triangle cell.
const VTK_TRIANGLE: u8 = 5;
/// VTK's number of a tetrahedron cell.
const VTK_TETRA: u8 = 10;
/// VTK's number of a triangle cell with mid-edge nodes.
const VTK_QUADRATIC_TRIANGLE: u8 = 22;
/// VTK's number of a tetrahedron cell with mid-edge nodes.
const VTK_QUADRATIC_TETRA: u8 = 24;

const CELLS: &[Extent] = &[Named("n_cells")];
#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    VTKHDF.row(N_POINTS, Kind::I64, &[Fixed(1)], Dimension::Number, "Number of points."),
    VTKHDF.row(N_CELLS, Kind::I64, &[Fixed(1)], Dimension::Number, "Number of cells."),
    VTKHDF.row(N_CONNECTIVITY, Kind::I64, &[Fixed(1)], Dimension::Number, "Length of Connectivity."),
    VTKHDF.row(POINTS, Kind::F64, &[Named("n_points"), Fixed(3)], Dimension::LENGTH, "Node coordinates; nodes where materials meet come again at the end, once for each further one.").compressed(),
    VTKHDF.row(CONNECTIVITY, Kind::I64, &[Named("n_connectivity")], Dimension::Number, "Nodes of all cells, one after the other.").compressed(),
    VTKHDF.row(OFFSETS, Kind::I64, &[Plus("n_cells", 1)], Dimension::Number, "Where each cell begins in Connectivity.").compressed(),
    VTKHDF.row(TYPES, Kind::U8, CELLS, Dimension::Number, "VTK cell type: 10 tetrahedron, 5 triangle, 24 and 22 the quadratic ones.").compressed(),
    VTKHDF.row(CONTACT_FACE, Kind::F64, &[Named("n_cell_values")], Dimension::Number, "Number of the contact face from 0, in the order of /mesh/contact_face_names; NaN on tetrahedra.").compressed().optional("absent without several contact faces"),
    offsets_row("/VTKHDF/Steps/CellDataOffsets/contact_face"),
    VTKHDF.row(BODY, Kind::F64, &[Named("n_cell_values")], Dimension::Number, "Number of the body from 0, in the order of /mesh/body_names.").compressed().optional("absent without several bodies"),
    offsets_row("/VTKHDF/Steps/CellDataOffsets/body"),
];

/// Fields that no step of a series has of its own.
#[rustfmt::skip]
pub(super) const ONCE: &[DatasetSpec] = &[
    VTKHDF.row(NORMAL, Kind::F64, &[Named("n_cells"), Fixed(3)], Dimension::Number, "Unit normal of contact in the middle of each contact triangle, out of the body and into the obstacle, one array for all steps of a series; NaN on tetrahedra.").symbol("nu").compressed().optional("absent without contact, and with one face whose normal is the same everywhere"),
    offsets_row(NORMAL_OFFSETS),
    VTKHDF.row(MECHANISM, Kind::F64, &[Named("n_points"), Fixed(3)], Dimension::Number, "Without equilibrium the rigid motion that contact cannot resist, of largest component one; warp by this vector.").compressed().optional("absent with equilibrium, and in a series"),
];

/// Writes the grid and its fields, with the mechanism where there is one.
pub fn write(
    writer: &mut GroupWriter<'_>,
    mesh: &Mesh,
    report: &ContactReport,
    frame: Option<&ContactFrame>,
    mechanism: Option<&[[f64; 3]]>,
) -> Result<(), StoreError> {
    let points = MaterialNodes::new(mesh);
    write_grid(writer, mesh, &points)?;
    write_normals(writer, mesh, None)?;
    if let Some(motion) = mechanism {
        write_list(writer, MECHANISM, &points.of_nodes(motion))?;
    }
    let is_at_rest = report.discretisation_error.displacement == 0.0;
    for array in grid_arrays(mesh, &points, &ResultState::from(report), frame) {
        // A body at rest has no error to share.
        if !(is_at_rest && array.path == ERROR_INDICATOR) {
            writer.write(&array.path, &array.values, &array.shape())?;
        }
    }
    Ok(())
}

/// One array of the grid.
pub(super) struct GridArray {
    pub(super) path: String,
    /// One, or three of a vector.
    pub(super) components: usize,
    /// Row by row.
    pub(super) values: Vec<f64>,
}

impl GridArray {
    fn new<const K: usize>(path: String, rows: &[[f64; K]]) -> Self {
        Self {
            path,
            components: K,
            values: rows.as_flattened().to_vec(),
        }
    }

    /// Points or cells that it has values on.
    pub(super) fn rows(&self) -> usize {
        self.values.len() / self.components
    }

    /// The shape of its dataset.
    pub(super) fn shape(&self) -> Vec<usize> {
        match self.components {
            1 => vec![self.rows()],
            components => vec![self.rows(), components],
        }
    }
}

/// The fields of results on the grid, always the same ones for the same scene.
pub(super) fn grid_arrays(
    mesh: &Mesh,
    points: &MaterialNodes,
    state: &ResultState<'_>,
    frame: Option<&ContactFrame>,
) -> Vec<GridArray> {
    let n_cells = mesh.tetrahedra.len() + contact_triangles(mesh).len();
    let contact = mesh.contact.as_ref().zip(frame);
    let mut arrays = Vec::new();
    for field in RESULT_FIELDS {
        let Some(mut values) = (field.values)(state) else {
            continue;
        };
        let components = field.shape.components();
        match field.place {
            FieldPlace::Nodes | FieldPlace::MaterialNodes => {
                if field.place == FieldPlace::Nodes {
                    let rows = points.nodes.iter();
                    let rows = rows.map(|node| node * components..(node + 1) * components);
                    values = rows.flat_map(|row| values[row].iter().copied()).collect();
                }
                arrays.push(GridArray {
                    path: on_points(field.name),
                    components,
                    values,
                });
            }
            FieldPlace::Tetrahedra => {
                values.resize(n_cells * components, f64::NAN);
                arrays.push(GridArray {
                    path: on_cells(field.name),
                    components,
                    values,
                });
            }
            FieldPlace::Panes => {
                arrays.extend(
                    contact
                        .into_iter()
                        .flat_map(|(surface, frame)| match field.shape {
                            FieldShape::Tangential => {
                                let pairs: &[[f64; 2]] = values.as_chunks().0;
                                let pairs = pairs.iter().enumerate();
                                let vectors = pairs.map(|(pane, pair)| {
                                    frame.pane_vector(surface, pane, 0.0, *pair)
                                });
                                spread(
                                    mesh,
                                    points,
                                    surface,
                                    field.name,
                                    &vectors.collect::<Vec<[f64; 3]>>(),
                                )
                            }
                            _ => {
                                spread::<1>(mesh, points, surface, field.name, values.as_chunks().0)
                            }
                        }),
                )
            }
        }
    }
    arrays.extend(contact_faces(mesh));
    arrays.extend(bodies(mesh));
    arrays
}

/// Values of panes on cells and values of nodal multipliers on points, as far as there are any; NaN elsewhere.
fn spread<const K: usize>(
    mesh: &Mesh,
    points: &MaterialNodes,
    surface: &ContactSurface,
    name: &str,
    of_panes: &[[f64; K]],
) -> Vec<GridArray> {
    let mut arrays = Vec::new();
    if surface.faces.iter().any(|face| !face.is_nodal) {
        let mut values = vec![[f64::NAN; K]; mesh.tetrahedra.len()];
        let triangles = 0..surface.facets.len();
        values.extend(triangles.map(|place| {
            let pane = surface.pane_of_facet(place);
            pane.map_or([f64::NAN; K], |pane| of_panes[pane])
        }));
        arrays.push(GridArray::new(on_cells(name), &values));
    }
    if surface.faces.iter().any(|face| face.is_nodal) {
        let mut values = vec![[f64::NAN; K]; mesh.coordinates.len()];
        let nodal = surface.faces.iter().filter(|face| face.is_nodal);
        for pane in nodal.flat_map(|face| face.panes.clone()) {
            for (node, _) in surface.pane_weights(pane) {
                values[surface.nodes[node]] = of_panes[pane];
            }
        }
        arrays.push(GridArray::new(on_points(name), &points.of_nodes(&values)));
    }
    arrays
}

/// Which of several contact faces each contact triangle belongs to.
fn contact_faces(mesh: &Mesh) -> Option<GridArray> {
    let surface = mesh
        .contact
        .as_ref()
        .filter(|surface| surface.faces.len() > 1)?;
    let mut values = vec![[f64::NAN]; mesh.tetrahedra.len()];
    let triangles = 0..surface.facets.len();
    values.extend(triangles.map(|place| [surface.face_number(place) as f64]));
    Some(GridArray::new(CONTACT_FACE.to_owned(), &values))
}

/// Which of several bodies each cell belongs to.
fn bodies(mesh: &Mesh) -> Option<GridArray> {
    let of_nodes = |nodes: &[usize]| [mesh.body_of_node(nodes[0]) as f64];
    let tetrahedra = mesh.tetrahedra.iter().map(|nodes| of_nodes(nodes));
    let triangles = contact_triangles(mesh).iter();
    let triangles = triangles.map(|&facet| of_nodes(&mesh.facets[facet]));
    let values: Vec<[f64; 1]> = tetrahedra.chain(triangles).collect();
    (!mesh.bodies.is_empty()).then(|| GridArray::new(BODY.to_owned(), &values))
}

fn on_points(name: &str) -> String {
    format!("/VTKHDF/PointData/{name}")
}

fn on_cells(name: &str) -> String {
    format!("/VTKHDF/CellData/{name}")
}

/// Writes the normals, with `n_steps` also that they are those of all steps of a series.
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
    write_once(writer, &normals, n_steps)
}

/// Writes the normals of a grid, with `n_steps` for all steps of a series.
pub(super) fn write_once(
    writer: &mut GroupWriter<'_>,
    normals: &[[f64; 3]],
    n_steps: Option<usize>,
) -> Result<(), StoreError> {
    write_list(writer, NORMAL, normals)?;
    match n_steps {
        None => Ok(()),
        Some(steps) => write_value(writer, NORMAL_OFFSETS, &vec![0_usize; steps]),
    }
}

/// The boundary triangles on Γ_c.
fn contact_triangles(mesh: &Mesh) -> &[usize] {
    mesh.contact.as_ref().map_or(&[], |contact| &contact.facets)
}

/// Writes points and cells; a contact triangle has the points of the tetrahedron behind it.
pub(super) fn write_grid(
    writer: &mut GroupWriter<'_>,
    mesh: &Mesh,
    points: &MaterialNodes,
) -> Result<(), StoreError> {
    writer.write_ascii_attribute("Type", TYPE)?;
    writer.write_number_attribute("Version", &VERSION)?;
    let n_tetrahedra = mesh.tetrahedra.len();
    let contact = contact_triangles(mesh);
    let tetrahedra = (0..n_tetrahedra).map(|t| points.of_tetrahedron(t).to_vec());
    let triangles = contact.iter().zip(mesh.behind(contact.iter().copied()));
    let triangles = triangles.map(|(&facet, t)| {
        let rows = points.of_tetrahedron(t);
        let nodes = mesh.facet_nodes(facet);
        nodes
            .filter_map(|node| rows.iter().copied().find(|&row| points.nodes[row] == node))
            .collect()
    });
    let cells: Vec<Vec<usize>> = tetrahedra.chain(triangles).collect();
    let n_cells = cells.len();
    let ends = cells.iter().scan(0, |end, cell| {
        *end += cell.len();
        Some(*end)
    });
    let offsets: Vec<usize> = [0].into_iter().chain(ends).collect();
    let connectivity = cells.concat();
    let [tetrahedron, triangle] = match mesh.mid_edges {
        None => [VTK_TETRA, VTK_TRIANGLE],
        Some(_) => [VTK_QUADRATIC_TETRA, VTK_QUADRATIC_TRIANGLE],
    };
    let mut types = vec![tetrahedron; n_tetrahedra];
    types.resize(n_cells, triangle);
    write_value(writer, N_POINTS, &[points.nodes.len()])?;
    write_value(writer, N_CELLS, &[n_cells])?;
    write_value(writer, N_CONNECTIVITY, &[connectivity.len()])?;
    write_value(writer, POINTS, &points.of_nodes(&mesh.coordinates))?;
    write_value(writer, CONNECTIVITY, &connectivity)?;
    write_value(writer, OFFSETS, &offsets)?;
    write_value(writer, TYPES, &types)
}
