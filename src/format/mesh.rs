//! `/mesh`: nodes, tetrahedra, boundary, contact surface, quality.

use std::ops::Range;

use contact3d::{
    linalg::CscMatrix,
    mesh::{ContactSurface, Mesh, MidEdgeNodes, Quality, SurfaceFace},
};
use runfile::{
    DatasetSpec,
    Extent::{Fixed, Named, Plus},
    Group, GroupWriter, Kind, Reader, StoreError,
};
use units::Dimension;

use super::{
    FormatError, Stage, axes, columns, read_finite_rows, read_finite_vec, read_index_vec,
    require_below,
};

/// Mesh, boundary and panes.
pub(super) const GROUP: Group = Group::new("mesh", Stage::Mesh.command());

const COORDINATES: &str = "/mesh/coordinates";
const TETRAHEDRA: &str = "/mesh/tetrahedra";
const FACETS: &str = "/mesh/facets";
const FACET_FACE: &str = "/mesh/facet_face";
const FACE_NAMES: &str = "/mesh/face_names";
const TETRAHEDRON_MIDDLES: &str = "/mesh/tetrahedron_mid_edges";
const FACET_MIDDLES: &str = "/mesh/facet_mid_edges";
const REGION: &str = "/mesh/tetrahedron_region";
const CONTACT_NORMAL: &str = "/mesh/contact_normal";
const CONTACT_CLEARANCE: &str = "/mesh/contact_clearance";
pub(super) const CONTACT_NODES: &str = "/mesh/contact_nodes";
pub(super) const CONTACT_FACE_NAMES: &str = "/mesh/contact_face_names";
pub(super) const CONTACT_FACE_NODES: &str = "/mesh/contact_face_nodes";
const CONTACT_FACE_FACETS: &str = "/mesh/contact_face_facets";
pub(super) const CONTACT_FACE_PANES: &str = "/mesh/contact_face_panes";
const CONTACT_FACE_IS_NODAL: &str = "/mesh/contact_face_is_nodal";
const CONTACT_NODE_NORMAL: &str = "/mesh/contact_node_normal";
const CONTACT_FACETS: &str = "/mesh/contact_facets";
const CONTACT_FACET_PANE: &str = "/mesh/contact_facet_pane";
pub(super) const PANE_AREA: &str = "/mesh/pane_area";
const PANE_AVERAGE: &str = "/mesh/pane_average";

const ONLY_QUADRATIC: &str = "absent with linear tetrahedra";
const NO_CONTACT: &str = "absent without contact";
const ONE_FACE: &str = "absent without several contact faces";

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(COORDINATES, Kind::F64, &[Named("n_nodes"), axes::XYZ], Dimension::LENGTH, "Node coordinates.").symbol("x").compressed(),
    GROUP.row(TETRAHEDRA, Kind::I64, &[Named("n_tetrahedra"), Fixed(4)], Dimension::Number, "Corners of each tetrahedron, positively oriented.").compressed(),
    GROUP.row(FACETS, Kind::I64, &[Named("n_facets"), Fixed(3)], Dimension::Number, "Corners of each boundary triangle, counter-clockwise seen from outside.").compressed(),
    GROUP.row(FACET_FACE, Kind::I64, &[Named("n_facets")], Dimension::Number, "Face that each boundary triangle belongs to, as a line number of face_names from 0.").compressed(),
    GROUP.row(FACE_NAMES, Kind::Text, &[], Dimension::Number, "Names of the faces, one a line."),
    GROUP.row(TETRAHEDRON_MIDDLES, Kind::I64, &[Named("n_tetrahedra"), Fixed(6)], Dimension::Number, "Nodes in the middle of the edges 0-1, 1-2, 0-2, 0-3, 1-3, 2-3 of each tetrahedron.").compressed().optional(ONLY_QUADRATIC),
    GROUP.row(FACET_MIDDLES, Kind::I64, &[Named("n_facets"), Fixed(3)], Dimension::Number, "Nodes in the middle of the edges 0-1, 1-2, 2-0 of each boundary triangle.").compressed().optional(ONLY_QUADRATIC),
    GROUP.row(REGION, Kind::I64, &[Named("n_tetrahedra")], Dimension::Number, "Region of each tetrahedron: 0 for the body's own material, k for the k-th region of the scene.").compressed().optional("absent without regions"),
    GROUP.row(CONTACT_NORMAL, Kind::F64, &[axes::XYZ], Dimension::Number, "Outward unit normal of the contact face.").symbol("nu").optional("absent without contact, with several contact faces, and where normals vary"),
    GROUP.row(CONTACT_NODE_NORMAL, Kind::F64, &[Named("n_contact_nodes"), axes::XYZ], Dimension::Number, "Unit normal of contact at each contact node, out of the body and into the obstacle.").symbol("nu").compressed().optional("absent with one face whose normal is the same everywhere"),
    GROUP.row(CONTACT_CLEARANCE, Kind::F64, &[Named("n_contact_nodes")], Dimension::LENGTH, "Initial distance of each contact node from the obstacle along its normal, 0 on faces without one; the gap of the scene comes on top.").optional("absent without an obstacle"),
    GROUP.row(CONTACT_FACE_NAMES, Kind::Text, &[], Dimension::Number, "Names of the contact faces, one a line; those with friction come first.").optional(ONE_FACE),
    GROUP.row(CONTACT_FACE_NODES, Kind::I64, &[Plus("n_contact_faces", 1)], Dimension::Number, "Where the nodes of each contact face begin in contact_nodes, then their number.").optional(ONE_FACE),
    GROUP.row(CONTACT_FACE_FACETS, Kind::I64, &[Plus("n_contact_faces", 1)], Dimension::Number, "Where the triangles of each contact face begin in contact_facets, then their number.").optional(ONE_FACE),
    GROUP.row(CONTACT_FACE_PANES, Kind::I64, &[Plus("n_contact_faces", 1)], Dimension::Number, "First pane of each contact face, then their number.").optional(ONE_FACE),
    GROUP.row(CONTACT_FACE_IS_NODAL, Kind::I64, &[Named("n_contact_faces")], Dimension::Number, "1 where the multipliers of a contact face belong to its nodes, 0 where they are constant on panes.").optional(ONE_FACE),
    GROUP.row(CONTACT_NODES, Kind::I64, &[Named("n_contact_nodes")], Dimension::Number, "Nodes on the contact face, increasing; on several faces one after the other, a node on two of them twice.").compressed().optional(NO_CONTACT),
    GROUP.row(CONTACT_FACETS, Kind::I64, &[Named("n_contact_facets")], Dimension::Number, "Boundary triangles on the contact face, as indices into facets.").compressed().optional(NO_CONTACT),
    GROUP.row(CONTACT_FACET_PANE, Kind::I64, &[Named("n_pane_facets")], Dimension::Number, "Pane of each contact triangle; with several faces of those with panes.").compressed().optional("absent without contact and with nodal multipliers"),
    GROUP.row(PANE_AREA, Kind::F64, &[Named("n_panes")], Dimension::AREA, "Area of each pane; with nodal multipliers the integral of the node's hat function.").symbol("|R_i|").optional(NO_CONTACT),
    GROUP.row(PANE_AVERAGE, Kind::CscMatrix, &[Named("n_contact_nodes"), Named("n_panes")], Dimension::Number, "Mean of each contact node's hat function over each pane; columns sum to 1. With nodal multipliers 1 at the node itself.").optional(NO_CONTACT),
    GROUP.row("/mesh/quality/longest_edge", Kind::F64, &[], Dimension::LENGTH, "Longest edge.").symbol("h"),
    GROUP.row("/mesh/quality/shortest_edge", Kind::F64, &[], Dimension::LENGTH, "Shortest edge."),
    GROUP.row("/mesh/quality/smallest_volume", Kind::F64, &[], Dimension::VOLUME, "Smallest tetrahedron volume."),
    GROUP.row("/mesh/quality/total_volume", Kind::F64, &[], Dimension::VOLUME, "Volume of the body."),
    GROUP.row("/mesh/quality/smallest_shape", Kind::F64, &[], Dimension::Number, "Smallest shape measure 12 (3V)^(2/3) / sum of squared edges; 1 is a regular tetrahedron."),
    GROUP.row("/mesh/quality/mean_shape", Kind::F64, &[], Dimension::Number, "Mean of the shape measure."),
];

/// Writes the mesh with the names of its contact faces, and its quality figures.
///
/// # Errors
/// HDF5 failures.
pub fn write(
    writer: &mut GroupWriter<'_>,
    mesh: &Mesh,
    contact_names: &[String],
    quality: &Quality,
) -> Result<(), StoreError> {
    writer.write(
        COORDINATES,
        mesh.coordinates.as_flattened(),
        &[mesh.coordinates.len(), 3],
    )?;
    let tetrahedra = mesh.tetrahedra.as_flattened();
    writer.write_indices(TETRAHEDRA, tetrahedra, &[mesh.tetrahedra.len(), 4])?;
    writer.write_indices(FACETS, mesh.facets.as_flattened(), &[mesh.facets.len(), 3])?;
    writer.write_indices(FACET_FACE, &mesh.facet_face, &[mesh.facet_face.len()])?;
    writer.write_text(FACE_NAMES, &mesh.face_names.join("\n"))?;
    if let Some(middles) = &mesh.mid_edges {
        let [tetrahedra, facets] = [middles.tetrahedra.len(), middles.facets.len()];
        let (of_tetrahedra, of_facets) = (&middles.tetrahedra, &middles.facets);
        writer.write_indices(
            TETRAHEDRON_MIDDLES,
            of_tetrahedra.as_flattened(),
            &[tetrahedra, 6],
        )?;
        writer.write_indices(FACET_MIDDLES, of_facets.as_flattened(), &[facets, 3])?;
    }
    if !mesh.tetrahedron_region.is_empty() {
        let region = &mesh.tetrahedron_region;
        writer.write_indices(REGION, region, &[region.len()])?;
    }
    if let Some(contact) = &mesh.contact {
        write_contact_surface(writer, contact, contact_names)?;
    }
    let figures = [
        ("/mesh/quality/longest_edge", quality.longest_edge),
        ("/mesh/quality/shortest_edge", quality.shortest_edge),
        ("/mesh/quality/smallest_volume", quality.smallest_volume),
        ("/mesh/quality/total_volume", quality.total_volume),
        ("/mesh/quality/smallest_shape", quality.smallest_shape),
        ("/mesh/quality/mean_shape", quality.mean_shape),
    ];
    for (path, value) in figures {
        writer.write(path, &[value], &[])?;
    }
    Ok(())
}

fn write_contact_surface(
    writer: &mut GroupWriter<'_>,
    contact: &ContactSurface,
    names: &[String],
) -> Result<(), StoreError> {
    if contact.faces.len() > 1 {
        write_faces(writer, &contact.faces, names)?;
    }
    match (contact.faces.as_slice(), contact.normals.as_slice()) {
        ([_], [everywhere]) => writer.write(CONTACT_NORMAL, everywhere, &[3])?,
        (_, each) => writer.write(CONTACT_NODE_NORMAL, each.as_flattened(), &[each.len(), 3])?,
    }
    if !contact.clearance.is_empty() {
        let clearance = &contact.clearance;
        writer.write(CONTACT_CLEARANCE, clearance, &[clearance.len()])?;
    }
    writer.write_indices(CONTACT_NODES, &contact.nodes, &[contact.nodes.len()])?;
    writer.write_indices(CONTACT_FACETS, &contact.facets, &[contact.facets.len()])?;
    if !contact.is_nodal() {
        let panes = &contact.facet_pane;
        writer.write_indices(CONTACT_FACET_PANE, panes, &[panes.len()])?;
    }
    writer.write(PANE_AREA, &contact.pane_area, &[contact.n_panes()])?;
    writer.write_matrix(PANE_AVERAGE, columns(&contact.pane_average))
}

/// Where several contact faces lie.
fn write_faces(
    writer: &mut GroupWriter<'_>,
    faces: &[SurfaceFace],
    names: &[String],
) -> Result<(), StoreError> {
    writer.write_text(CONTACT_FACE_NAMES, &names.join("\n"))?;
    let mut limits = |path, range: fn(&SurfaceFace) -> &Range<usize>| {
        let ends = faces.iter().map(|face| range(face).end);
        let limits: Vec<usize> = [0].into_iter().chain(ends).collect();
        writer.write_indices(path, &limits, &[limits.len()])
    };
    limits(CONTACT_FACE_NODES, |face| &face.nodes)?;
    limits(CONTACT_FACE_FACETS, |face| &face.facets)?;
    limits(CONTACT_FACE_PANES, |face| &face.panes)?;
    let is_nodal: Vec<usize> = faces
        .iter()
        .map(|face| usize::from(face.is_nodal))
        .collect();
    writer.write_indices(CONTACT_FACE_IS_NODAL, &is_nodal, &[is_nodal.len()])
}

/// Reads the mesh.
///
/// # Errors
/// Missing, altered or contradictory datasets.
pub fn read(reader: &Reader) -> Result<Mesh, FormatError> {
    let coordinates = read_finite_rows::<3>(reader, COORDINATES)?;
    let n_nodes = coordinates.len();
    let tetrahedra = read_index_vec(reader, TETRAHEDRA)?;
    require_below(TETRAHEDRA, tetrahedra.iter().copied(), n_nodes)?;
    let facets = read_index_vec(reader, FACETS)?;
    require_below(FACETS, facets.iter().copied(), n_nodes)?;
    let facets = facets.as_chunks::<3>().0.to_vec();
    let text = reader.read_text(FACE_NAMES)?;
    let face_names: Vec<String> = text.lines().map(str::to_owned).collect();
    let facet_face = read_index_vec(reader, FACET_FACE)?;
    require_below(FACET_FACE, facet_face.iter().copied(), face_names.len())?;
    let contact = match reader.has(CONTACT_NODES) {
        true => Some(read_contact_surface(reader, n_nodes, facets.len())?),
        false => None,
    };
    Ok(Mesh {
        coordinates,
        tetrahedra: tetrahedra.as_chunks::<4>().0.to_vec(),
        tetrahedron_region: match reader.has(REGION) {
            true => read_index_vec(reader, REGION)?,
            false => Vec::new(),
        },
        facets,
        facet_face,
        face_names,
        mid_edges: read_mid_edges(reader, n_nodes)?,
        contact,
    })
}

fn read_mid_edges(reader: &Reader, n_nodes: usize) -> Result<Option<MidEdgeNodes>, FormatError> {
    if !reader.has(TETRAHEDRON_MIDDLES) {
        return Ok(None);
    }
    let read = |path| -> Result<Vec<usize>, FormatError> {
        let nodes = read_index_vec(reader, path)?;
        require_below(path, nodes.iter().copied(), n_nodes)?;
        Ok(nodes)
    };
    Ok(Some(MidEdgeNodes {
        tetrahedra: read(TETRAHEDRON_MIDDLES)?.as_chunks::<6>().0.to_vec(),
        facets: read(FACET_MIDDLES)?.as_chunks::<3>().0.to_vec(),
    }))
}

fn read_contact_surface(
    reader: &Reader,
    n_nodes: usize,
    n_facets: usize,
) -> Result<ContactSurface, FormatError> {
    let average = reader.read_matrix(PANE_AVERAGE)?;
    let nodes = read_index_vec(reader, CONTACT_NODES)?;
    let facets = read_index_vec(reader, CONTACT_FACETS)?;
    let is_several = reader.has(CONTACT_FACE_PANES);
    let normal = match reader.has(CONTACT_NODE_NORMAL) {
        false => CONTACT_NORMAL,
        true => CONTACT_NODE_NORMAL,
    };
    let normal = read_finite_vec(reader, normal)?;
    let surface = ContactSurface {
        faces: match is_several {
            false => vec![SurfaceFace::only(
                nodes.len(),
                facets.len(),
                average.shape[1],
                !reader.has(CONTACT_FACET_PANE),
            )],
            true => read_faces(reader, [nodes.len(), facets.len(), average.shape[1]])?,
        },
        normals: normal.as_chunks::<3>().0.to_vec(),
        clearance: match reader.has(CONTACT_CLEARANCE) {
            true => read_finite_vec(reader, CONTACT_CLEARANCE)?,
            false => Vec::new(),
        },
        nodes,
        facets,
        facet_pane: match reader.has(CONTACT_FACET_PANE) {
            true => read_index_vec(reader, CONTACT_FACET_PANE)?,
            false => Vec::new(),
        },
        pane_area: read_finite_vec(reader, PANE_AREA)?,
        pane_average: CscMatrix {
            rows: average.shape[0],
            cols: average.shape[1],
            indptr: average.indptr,
            indices: average.indices,
            data: average.data,
        },
    };
    require_below(CONTACT_NODES, surface.nodes.iter().copied(), n_nodes)?;
    require_below(CONTACT_FACETS, surface.facets.iter().copied(), n_facets)?;
    require_below(
        CONTACT_FACET_PANE,
        surface.facet_pane.iter().copied(),
        surface.n_panes(),
    )?;
    Ok(surface)
}

/// Where several contact faces lie, of that many nodes, triangles and panes.
fn read_faces(reader: &Reader, sizes: [usize; 3]) -> Result<Vec<SurfaceFace>, FormatError> {
    let read = |path: &'static str, size: usize| -> Result<Vec<Range<usize>>, FormatError> {
        let limits = read_index_vec(reader, path)?;
        let ends = limits.first() == Some(&0) && limits.last() == Some(&size);
        if !ends || !limits.is_sorted() {
            return Err(FormatError::Inconsistent {
                dataset: path,
                reason: format!("expected increasing limits from 0 to {size}"),
            });
        }
        Ok(limits.windows(2).map(|pair| pair[0]..pair[1]).collect())
    };
    let nodes = read(CONTACT_FACE_NODES, sizes[0])?;
    let facets = read(CONTACT_FACE_FACETS, sizes[1])?;
    let panes = read(CONTACT_FACE_PANES, sizes[2])?;
    let is_nodal = read_index_vec(reader, CONTACT_FACE_IS_NODAL)?;
    let faces = nodes.into_iter().zip(facets).zip(panes).zip(is_nodal);
    let faces = faces.map(|(((nodes, facets), panes), is_nodal)| SurfaceFace {
        nodes,
        facets,
        panes,
        is_nodal: is_nodal == 1,
    });
    Ok(faces.collect())
}
