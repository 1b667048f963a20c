//! `/VTKHDF`: the results as an unstructured grid that ParaView opens (VTKHDF 2.0).
//!
//! Cells are all tetrahedra, then the contact triangles. Fields that live on one kind of cell only
//! are NaN on the other, which ParaView draws in its NaN colour. Fields of panes are cell data,
//! those of nodal multipliers point data.

use contact3d::{
    contact::ContactFrame,
    history::StepRecord,
    mesh::{ContactSurface, Mesh},
    post::{ContactReport, PaneState, Zone},
};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named, Plus},
    Group, GroupWriter, Kind, StoreError,
};
use units::Dimension;

use super::{
    Stage,
    fields::{write_list, write_value},
    series::offsets_row,
};

/// The same results as ParaView reads them.
pub const GROUP: Group = Group::new("VTKHDF", Stage::Post.command());

pub(super) const N_POINTS: &str = "/VTKHDF/NumberOfPoints";
pub(super) const N_CELLS: &str = "/VTKHDF/NumberOfCells";
pub(super) const N_CONNECTIVITY: &str = "/VTKHDF/NumberOfConnectivityIds";
pub(super) const POINTS: &str = "/VTKHDF/Points";
pub(super) const CONNECTIVITY: &str = "/VTKHDF/Connectivity";
pub(super) const OFFSETS: &str = "/VTKHDF/Offsets";
pub(super) const TYPES: &str = "/VTKHDF/Types";
const DISPLACEMENT: &str = "/VTKHDF/PointData/displacement";
const ERROR_INDICATOR: &str = "/VTKHDF/CellData/error_indicator";
const CONTACT_FACE: &str = "/VTKHDF/CellData/contact_face";
const VON_MISES: &str = "/VTKHDF/CellData/von_mises";
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
/// Values on cells and on points: as many as there are, once for each step of a series.
const CELL_VALUES: &[Extent] = &[Named("n_cell_values")];
const POINT_VALUES: &[Extent] = &[Named("n_point_values")];
const CELL_VECTORS: &[Extent] = &[Named("n_cell_values"), Fixed(3)];
const POINT_VECTORS: &[Extent] = &[Named("n_point_values"), Fixed(3)];
const ON_CELLS: &str = "only with panes, where the scene has the effect";
const ON_POINTS: &str = "only with nodal multipliers, where the scene has the effect";

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(N_POINTS, Kind::I64, &[Fixed(1)], Dimension::Number, "Number of points."),
    GROUP.row(N_CELLS, Kind::I64, &[Fixed(1)], Dimension::Number, "Number of cells."),
    GROUP.row(N_CONNECTIVITY, Kind::I64, &[Fixed(1)], Dimension::Number, "Length of Connectivity."),
    GROUP.row(POINTS, Kind::F64, &[Named("n_nodes"), Fixed(3)], Dimension::LENGTH, "Node coordinates.").compressed(),
    GROUP.row(CONNECTIVITY, Kind::I64, &[Named("n_connectivity")], Dimension::Number, "Nodes of all cells, one after the other.").compressed(),
    GROUP.row(OFFSETS, Kind::I64, &[Plus("n_cells", 1)], Dimension::Number, "Where each cell begins in Connectivity.").compressed(),
    GROUP.row(TYPES, Kind::U8, CELLS, Dimension::Number, "VTK cell type: 10 tetrahedron, 5 triangle, 24 and 22 the quadratic ones.").compressed(),
    GROUP.row(DISPLACEMENT, Kind::F64, POINT_VECTORS, Dimension::LENGTH, "Displacement; warp by this vector.").compressed(),
    GROUP.row(VON_MISES, Kind::F64, CELL_VALUES, Dimension::STRESS, "Von Mises stress, NaN on contact triangles.").compressed(),
    GROUP.row(ERROR_INDICATOR, Kind::F64, CELL_VALUES, Dimension::Number, "Share in the estimated discretisation error, NaN on contact triangles.").compressed().optional("absent for a body at rest, and with a load history"),
    GROUP.row(CONTACT_FACE, Kind::F64, CELL_VALUES, Dimension::Number, "Number of the contact face from 0, in the order of /mesh/contact_face_names; NaN on tetrahedra.").compressed().optional("absent without several contact faces"),
    GROUP.row("/VTKHDF/CellData/contact_normal_stress", Kind::F64, CELL_VALUES, Dimension::STRESS, "Normal contact stress; NaN on tetrahedra.").compressed().optional(ON_CELLS),
    GROUP.row("/VTKHDF/PointData/contact_normal_stress", Kind::F64, POINT_VALUES, Dimension::STRESS, "Normal contact stress; NaN where no multiplier is.").compressed().optional(ON_POINTS),
    GROUP.row("/VTKHDF/CellData/contact_gap", Kind::F64, CELL_VALUES, Dimension::LENGTH, "Gap d - u_nu; NaN on tetrahedra.").compressed().optional(ON_CELLS),
    GROUP.row("/VTKHDF/PointData/contact_gap", Kind::F64, POINT_VALUES, Dimension::LENGTH, "Gap d - u_nu; NaN where no multiplier is.").compressed().optional(ON_POINTS),
    GROUP.row("/VTKHDF/CellData/contact_zone", Kind::F64, CELL_VALUES, Dimension::Number, "0 open, 1 stick, 2 slip; NaN on tetrahedra.").compressed().optional(ON_CELLS),
    GROUP.row("/VTKHDF/PointData/contact_zone", Kind::F64, POINT_VALUES, Dimension::Number, "0 open, 1 stick, 2 slip; NaN where no multiplier is.").compressed().optional(ON_POINTS),
    GROUP.row("/VTKHDF/CellData/contact_tangential_stress", Kind::F64, CELL_VECTORS, Dimension::STRESS, "Tangential contact stress in the global axes; NaN on tetrahedra.").compressed().optional(ON_CELLS),
    GROUP.row("/VTKHDF/PointData/contact_tangential_stress", Kind::F64, POINT_VECTORS, Dimension::STRESS, "Tangential contact stress in the global axes; NaN where no multiplier is.").compressed().optional(ON_POINTS),
    GROUP.row("/VTKHDF/CellData/friction_1", Kind::F64, CELL_VALUES, Dimension::Number, "Coefficient F_1; NaN on tetrahedra.").compressed().optional(ON_CELLS),
    GROUP.row("/VTKHDF/PointData/friction_1", Kind::F64, POINT_VALUES, Dimension::Number, "Coefficient F_1; NaN where no multiplier is.").compressed().optional(ON_POINTS),
    GROUP.row("/VTKHDF/CellData/friction_2", Kind::F64, CELL_VALUES, Dimension::Number, "Coefficient F_2; NaN on tetrahedra.").compressed().optional(ON_CELLS),
    GROUP.row("/VTKHDF/PointData/friction_2", Kind::F64, POINT_VALUES, Dimension::Number, "Coefficient F_2; NaN where no multiplier is.").compressed().optional(ON_POINTS),
];

/// Fields that no step of a series has of its own.
#[rustfmt::skip]
pub(super) const ONCE: &[DatasetSpec] = &[
    GROUP.row(NORMAL, Kind::F64, &[Named("n_cells"), Fixed(3)], Dimension::Number, "Unit normal of contact in the middle of each contact triangle, out of the body and into the obstacle, one array for all steps of a series; NaN on tetrahedra.").symbol("nu").compressed().optional("absent without contact, and with one face whose normal is the same everywhere"),
    offsets_row(NORMAL_OFFSETS),
    GROUP.row(MECHANISM, Kind::F64, &[Named("n_nodes"), Fixed(3)], Dimension::Number, "Without equilibrium the rigid motion that contact cannot resist, of largest component one; warp by this vector.").compressed().optional("absent with equilibrium, and in a series"),
];

/// Writes the grid and its fields, with the mechanism where there is one.
pub fn write(
    writer: &mut GroupWriter<'_>,
    mesh: &Mesh,
    report: &ContactReport,
    frame: Option<&ContactFrame>,
    mechanism: Option<&[[f64; 3]]>,
) -> Result<(), StoreError> {
    write_grid(writer, mesh)?;
    write_normals(writer, mesh, None)?;
    if let Some(motion) = mechanism {
        write_list(writer, MECHANISM, motion)?;
    }
    for field in fields(mesh, &GridValues::from(report), frame) {
        // A body at rest has no error to share.
        if field.path == ERROR_INDICATOR && report.discretisation_error.displacement == 0.0 {
            continue;
        }
        writer.write(&field.path, &field.values, &field.shape(1))?;
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

    /// The shape of its dataset for some steps.
    pub(super) fn shape(&self, steps: usize) -> Vec<usize> {
        match self.components {
            1 => vec![steps * self.rows()],
            components => vec![steps * self.rows(), components],
        }
    }
}

/// What the grid shows at one time.
#[derive(Debug)]
pub struct GridValues<'a> {
    /// Displacement of the nodes.
    pub displacement: &'a [[f64; 3]],
    /// Von Mises stress of the tetrahedra.
    pub von_mises: &'a [f64],
    /// Share of each tetrahedron in the estimated error; `None` where it is not kept.
    error: Option<Vec<f64>>,
    /// What it shows of each pane.
    pub panes: Vec<PaneValues>,
}

/// What the grid shows of a pane.
#[derive(Debug)]
pub struct PaneValues {
    /// Normal contact stress σ_ν.
    pub normal_stress: f64,
    /// Mean gap d − u_ν.
    pub gap: f64,
    /// What it does.
    pub zone: Zone,
    /// Tangential contact stress σ_t; `None` without friction.
    pub tangential_stress: Option<[f64; 2]>,
    /// (F₁, F₂); `None` without Coulomb's law.
    pub coefficients: Option<[f64; 2]>,
}

impl<'a> From<&'a ContactReport> for GridValues<'a> {
    fn from(report: &'a ContactReport) -> Self {
        let error = &report.discretisation_error;
        let share = |indicator: &f64| match error.displacement {
            0.0 => 0.0,
            displacement => indicator / displacement,
        };
        let pane = |pane: &PaneState| PaneValues {
            normal_stress: pane.normal_stress,
            gap: pane.gap,
            zone: pane.zone,
            tangential_stress: pane.friction.map(|friction| friction.stress),
            coefficients: pane
                .friction
                .and_then(|friction| friction.coulomb)
                .map(|coulomb| coulomb.coefficients),
        };
        Self {
            displacement: &report.displacement,
            von_mises: &report.von_mises,
            error: Some(error.indicator.iter().map(share).collect()),
            panes: report.panes.iter().map(pane).collect(),
        }
    }
}

impl<'a> GridValues<'a> {
    /// Those of an increment, with its share in the error over the largest norm of the history in √J.
    pub fn of_increment(record: &'a StepRecord, norm: f64) -> Self {
        let squares = record.error_energy.iter();
        let shares = squares.map(|square| match *square {
            0.0 => 0.0,
            square => square.sqrt() / norm,
        });
        let (normal, tangential) = record.multiplier.split_at(record.panes.len());
        let pairs: &[[f64; 2]] = tangential.as_chunks().0;
        let panes = record.panes.iter().enumerate();
        let panes = panes.map(|(k, pane)| PaneValues {
            normal_stress: 0.0 - normal[k],
            gap: pane.gap,
            zone: pane.zone,
            tangential_stress: pairs.get(k).map(|pair| pair.map(|stress| 0.0 - stress)),
            coefficients: Some(pane.coefficients).filter(|f| !f[0].is_nan()),
        });
        Self {
            displacement: &record.displacement,
            von_mises: &record.von_mises,
            error: (!record.error_energy.is_empty()).then(|| shares.collect()),
            panes: panes.collect(),
        }
    }
}

/// The fields of results, always the same ones for the same scene.
pub(super) fn fields(
    mesh: &Mesh,
    shown: &GridValues<'_>,
    frame: Option<&ContactFrame>,
) -> Vec<GridArray> {
    let n_cells = mesh.tetrahedra.len() + contact_triangles(mesh).len();
    let on_tetrahedra = |path: &str, values: &[f64]| {
        let mut values = values.to_vec();
        values.resize(n_cells, f64::NAN);
        GridArray {
            path: path.to_owned(),
            components: 1,
            values,
        }
    };
    let mut fields = vec![
        GridArray::new(DISPLACEMENT.to_owned(), shown.displacement),
        on_tetrahedra(VON_MISES, shown.von_mises),
    ];
    let error = shown.error.as_ref();
    fields.extend(error.map(|error| on_tetrahedra(ERROR_INDICATOR, error)));
    if let (Some(surface), Some(frame)) = (&mesh.contact, frame) {
        let contact = ContactFields {
            mesh,
            surface,
            frame,
            panes: &shown.panes,
        };
        fields.extend(contact.fields());
    }
    fields
}

/// The fields of the contact face.
struct ContactFields<'a> {
    mesh: &'a Mesh,
    surface: &'a ContactSurface,
    frame: &'a ContactFrame,
    panes: &'a [PaneValues],
}

impl ContactFields<'_> {
    fn fields(&self) -> Vec<GridArray> {
        type Measure = fn(&PaneValues) -> Option<f64>;
        let measures: [(&str, Measure); 5] = [
            ("contact_normal_stress", |p| Some(p.normal_stress)),
            ("contact_gap", |p| Some(p.gap)),
            ("contact_zone", |p| Some(f64::from(p.zone as u8))),
            ("friction_1", |p| Some(p.coefficients?[0])),
            ("friction_2", |p| Some(p.coefficients?[1])),
        ];
        let mut fields = Vec::new();
        for (name, measure) in measures {
            if self.panes.iter().any(|pane| measure(pane).is_some()) {
                let value = |pane: usize| [measure(&self.panes[pane]).unwrap_or(f64::NAN)];
                fields.extend(self.spread(name, value));
            }
        }
        let mut panes = self.panes.iter();
        if panes.any(|pane| pane.tangential_stress.is_some()) {
            let stress = |pane: usize| match self.panes[pane].tangential_stress {
                Some(stress) => self.frame.pane_vector(self.surface, pane, 0.0, stress),
                None => [f64::NAN; 3],
            };
            fields.extend(self.spread("contact_tangential_stress", stress));
        }
        fields.extend(self.faces());
        fields
    }

    /// Which of several contact faces each contact triangle belongs to.
    fn faces(&self) -> Option<GridArray> {
        if self.surface.faces.len() == 1 {
            return None;
        }
        let mut values = vec![[f64::NAN]; self.mesh.tetrahedra.len()];
        let triangles = 0..self.surface.facets.len();
        values.extend(triangles.map(|place| [self.surface.face_number(place) as f64]));
        Some(GridArray::new(CONTACT_FACE.to_owned(), &values))
    }

    /// Values of panes on cells and values of nodal multipliers on points, as far as there are any; NaN elsewhere.
    fn spread<const K: usize>(
        &self,
        name: &str,
        value: impl Fn(usize) -> [f64; K],
    ) -> Vec<GridArray> {
        let surface = self.surface;
        let mut fields = Vec::new();
        if surface.faces.iter().any(|face| !face.is_nodal) {
            let mut values = vec![[f64::NAN; K]; self.mesh.tetrahedra.len()];
            let triangles = 0..surface.facets.len();
            values.extend(triangles.map(|place| match surface.pane_of_facet(place) {
                Some(pane) => value(pane),
                None => [f64::NAN; K],
            }));
            fields.push(GridArray::new(format!("/VTKHDF/CellData/{name}"), &values));
        }
        if surface.faces.iter().any(|face| face.is_nodal) {
            let mut values = vec![[f64::NAN; K]; self.mesh.coordinates.len()];
            let nodal = surface.faces.iter().filter(|face| face.is_nodal);
            for pane in nodal.flat_map(|face| face.panes.clone()) {
                for (node, _) in surface.pane_weights(pane) {
                    values[surface.nodes[node]] = value(pane);
                }
            }
            fields.push(GridArray::new(format!("/VTKHDF/PointData/{name}"), &values));
        }
        fields
    }
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

pub(super) fn write_grid(writer: &mut GroupWriter<'_>, mesh: &Mesh) -> Result<(), StoreError> {
    writer.write_ascii_attribute("Type", TYPE)?;
    writer.write_number_attribute("Version", &VERSION)?;
    let n_tetrahedra = mesh.tetrahedra.len();
    let contact = contact_triangles(mesh);
    let nodes = |t: usize| mesh.tetrahedron_nodes(t).collect::<Vec<_>>();
    let cells: Vec<Vec<usize>> = (0..n_tetrahedra)
        .map(nodes)
        .chain(contact.iter().map(|&f| mesh.facet_nodes(f).collect()))
        .collect();
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
    write_value(writer, N_POINTS, &[mesh.coordinates.len()])?;
    write_value(writer, N_CELLS, &[n_cells])?;
    write_value(writer, N_CONNECTIVITY, &[connectivity.len()])?;
    write_value(writer, POINTS, &mesh.coordinates)?;
    write_value(writer, CONNECTIVITY, &connectivity)?;
    write_value(writer, OFFSETS, &offsets)?;
    write_value(writer, TYPES, &types)
}
