//! The body of a run file as a page can turn it: boundary, fields and panes in each increment, and the obstacle.

use contact3d::{
    history::largest_norm,
    mesh::{ContactSurface, MaterialNodes, Mesh, SurfaceFace},
    scene::{Scene, escape_control},
};
use plots::{
    DrawnObstacle,
    html::{BodyView, ViewArray, ViewPlace, ViewValues},
};
use units::{Dimension, Units};

use super::{contact_cells::ContactCells, picture::error_density, surroundings::obstacle_beside};
use crate::{
    format::{FieldPlace, FieldShape, FieldView, RESULT_FIELDS, ResultState},
    pipeline::Results,
    report::shown_time,
};

/// The body of results that are solved.
pub(super) fn view(scene: &Scene, results: &Results) -> BodyView {
    let (mesh, report) = (results.mesh(), &results.report);
    let boundary = Boundary::new(mesh);
    let records = &results.increments;
    let states: Vec<ResultState<'_>> = match records.as_slice() {
        [] => vec![ResultState::from(report)],
        records => {
            let norm = largest_norm(records);
            let of = |record| ResultState::of_increment(record, norm);
            records.iter().map(of).collect()
        }
    };
    let names = records.iter().map(|record| {
        let title = scene.step_title(record.increment.step);
        format!(
            "{}, t = {} s",
            escape_control(&title),
            shown_time(record.increment.time)
        )
    });
    let mut names: Vec<String> = names.collect();
    if names.is_empty() {
        names.push("the solution".into());
    }
    let mut arrays = boundary.shape(mesh, scene.units);
    arrays.extend(boundary.fields(mesh, scene.units, &states));
    if report.discretisation_error.displacement > 0.0 {
        let density = error_density(mesh, report, mesh.coordinates.len());
        let logarithm: Vec<[f64; 1]> = density.iter().map(|v| [v.log10()]).collect();
        let values = boundary.at_points(&logarithm);
        arrays.push(ViewArray {
            label: "log10 of error per volume over its mean",
            first: states.len() - 1,
            ..array(
                "error",
                ViewPlace::Point,
                ViewValues::OfBody,
                1,
                vec![values],
            )
        });
    }
    if let Some(surface) = &mesh.contact {
        let shape = obstacle_beside(mesh, surface, &surface.faces, (scene, &report.tools));
        if !shape.points.is_empty() {
            arrays.extend(obstacle(&shape, scene.units));
        }
    }
    BodyView {
        title: scene.shown_title(),
        frames: names,
        bodies: mesh.bodies.iter().map(|body| body.name.clone()).collect(),
        arrays,
    }
}

/// An array without label and unit, from the first frame on.
fn array(
    key: &'static str,
    on: ViewPlace,
    values: ViewValues,
    columns: usize,
    frames: Vec<Vec<f64>>,
) -> ViewArray {
    ViewArray {
        key,
        label: "",
        unit: String::new(),
        on,
        values,
        columns,
        first: 0,
        frames,
    }
}

fn indices<const K: usize>(key: &'static str, on: ViewPlace, rows: &[[usize; K]]) -> ViewArray {
    let values = rows.as_flattened().iter().map(|&index| index as f64);
    array(key, on, ViewValues::Indices, K, vec![values.collect()])
}

/// The boundary of the body with its contact faces cut in panes or cells of nodes.
struct Boundary {
    cells: Vec<ContactCells>,
    /// Nodes of the mesh.
    n_nodes: usize,
    /// The points that triangles have, as nodes of the mesh and then the points that each face adds.
    used: Vec<usize>,
    /// Corners of the triangles among those.
    triangles: Vec<[usize; 3]>,
    /// The tetrahedron behind each triangle.
    behind: Vec<usize>,
    /// The pane of each triangle; `None` beside the contact face and where no multiplier is.
    pane: Vec<Option<usize>>,
}

impl Boundary {
    fn new(mesh: &Mesh) -> Self {
        let n_nodes = mesh.coordinates.len();
        let behind_facet = mesh.behind(0..mesh.facets.len());
        let mut boundary = Self {
            cells: Vec::new(),
            n_nodes,
            used: Vec::new(),
            triangles: Vec::new(),
            behind: Vec::new(),
            pane: Vec::new(),
        };
        let mut touches = vec![false; mesh.facets.len()];
        let mut added = 0;
        for (surface, face) in faces(mesh) {
            let cells = ContactCells::new(mesh, Some((surface, face)));
            let facets = &surface.facets[face.facets.clone()];
            facets.iter().for_each(|&facet| touches[facet] = true);
            let pieces = cells.triangles.len() / facets.len().max(1);
            for (k, (triangle, &cell)) in cells.triangles.iter().zip(&cells.pane).enumerate() {
                let moved = |point| {
                    if point < n_nodes {
                        point
                    } else {
                        point + added
                    }
                };
                boundary.triangles.push(triangle.map(moved));
                boundary.behind.push(behind_facet[facets[k / pieces]]);
                let pane = (cell < cells.carrying).then(|| face.panes.start + cell);
                boundary.pane.push(pane);
            }
            added += cells.coordinates.len() - n_nodes;
            boundary.cells.push(cells);
        }
        for (facet, triangle) in mesh.facets.iter().enumerate() {
            if !touches[facet] {
                boundary.triangles.push(*triangle);
                boundary.behind.push(behind_facet[facet]);
                boundary.pane.push(None);
            }
        }
        boundary.used = boundary.triangles.as_flattened().to_vec();
        boundary.used.sort_unstable();
        boundary.used.dedup();
        for point in boundary.triangles.as_flattened_mut() {
            *point = boundary.used.partition_point(|used| used < point);
        }
        boundary
    }

    /// A field of the nodes at the points of the triangles, value after value.
    fn at_points<const K: usize>(&self, nodal: &[[f64; K]]) -> Vec<f64> {
        let mut field = nodal.to_vec();
        for cells in &self.cells {
            field.extend_from_slice(&cells.interpolate(nodal)[self.n_nodes..]);
        }
        self.used.iter().flat_map(|&point| field[point]).collect()
    }

    /// The body of each triangle.
    fn bodies(&self, mesh: &Mesh) -> Vec<f64> {
        let behind = self.behind.iter().map(|&t| mesh.tetrahedra[t][0]);
        behind.map(|node| mesh.body_of_node(node) as f64).collect()
    }

    /// Points and triangles.
    fn shape(&self, mesh: &Mesh, units: Units) -> Vec<ViewArray> {
        let place = self.at_points(&mesh.coordinates);
        let pane = self
            .pane
            .iter()
            .map(|pane| pane.map_or(f64::NAN, |pane| pane as f64));
        let of_triangles =
            |key, rows| array(key, ViewPlace::Triangle, ViewValues::Indices, 1, vec![rows]);
        let mut arrays = vec![
            ViewArray {
                unit: units.word(Dimension::LENGTH),
                ..array(
                    "points",
                    ViewPlace::Point,
                    ViewValues::Places,
                    3,
                    vec![place],
                )
            },
            indices("triangles", ViewPlace::Triangle, &self.triangles),
            of_triangles("triangle_pane", pane.collect()),
        ];
        if !mesh.bodies.is_empty() {
            arrays.push(of_triangles("triangle_body", self.bodies(mesh)));
        }
        arrays
    }

    /// The fields that all states have, where materials meet the larger value.
    fn fields(&self, mesh: &Mesh, units: Units, states: &[ResultState<'_>]) -> Vec<ViewArray> {
        let material = MaterialNodes::new(mesh);
        let shown = RESULT_FIELDS
            .iter()
            .filter(|field| field.view != FieldView::Hidden);
        let arrays = shown.filter_map(|field| {
            let columns = field.shape.components();
            let frame = |state: &ResultState<'_>| {
                let values = (field.values)(state)?;
                Some(match (field.place, columns) {
                    (FieldPlace::Panes, _) => values,
                    (FieldPlace::Nodes, 3) => self.at_points::<3>(values.as_chunks().0),
                    (FieldPlace::Nodes, _) => self.at_points::<1>(values.as_chunks().0),
                    (FieldPlace::MaterialNodes, _) => {
                        let largest = material.largest(&values);
                        self.at_points::<1>(largest.as_chunks().0)
                    }
                    (FieldPlace::Tetrahedra, _) => {
                        let rows = self.behind.iter().map(|k| k * columns..(k + 1) * columns);
                        rows.flat_map(|row| values[row].iter().copied()).collect()
                    }
                })
            };
            let on = match field.place {
                FieldPlace::Nodes | FieldPlace::MaterialNodes => ViewPlace::Point,
                FieldPlace::Tetrahedra => ViewPlace::Triangle,
                FieldPlace::Panes => ViewPlace::Pane,
            };
            let values = match (field.view, field.shape, field.place) {
                (FieldView::Numbers | FieldView::Hidden, ..) => ViewValues::Plain,
                (_, FieldShape::Zone, _) => ViewValues::Zones,
                (_, _, FieldPlace::Panes) => ViewValues::OfFace,
                _ => ViewValues::OfBody,
            };
            let frames = states.iter().map(frame).collect::<Option<Vec<_>>>()?;
            Some(ViewArray {
                label: field.words,
                unit: units.of(field.dimension).beside().trim().to_owned(),
                ..array(field.name, on, values, columns, frames)
            })
        });
        arrays.collect()
    }
}

/// The contact faces with the surface they are part of.
fn faces(mesh: &Mesh) -> impl Iterator<Item = (&ContactSurface, &SurfaceFace)> {
    let surfaces = mesh.contact.iter();
    surfaces.flat_map(|surface| surface.faces.iter().map(move |face| (surface, face)))
}

/// The part of the obstacle that contact faces see, with a strip around it where it is flat.
fn obstacle(shape: &DrawnObstacle, units: Units) -> [ViewArray; 3] {
    let place = |key, values, rows: &[[f64; 3]]| ViewArray {
        unit: units.word(Dimension::LENGTH),
        ..array(
            key,
            ViewPlace::Obstacle,
            values,
            3,
            vec![rows.as_flattened().to_vec()],
        )
    };
    [
        place("obstacle_points", ViewValues::Places, &shape.points),
        place("obstacle_gaps", ViewValues::Plain, &shape.gaps),
        indices("obstacle_triangles", ViewPlace::Obstacle, &shape.triangles),
    ]
}
