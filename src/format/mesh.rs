//! `/mesh`: nodes, tetrahedra, boundary, contact surface, quality.

use std::ops::Range;

use contact3d::mesh::{ContactSurface, Mesh, MidEdgeNodes, Quality, SurfaceFace};
use runfile::{
    Extent::{Fixed, Named, Plus},
    Group, GroupWriter, Kind, Reader, StoreError,
};
use units::Dimension;

use super::{
    FormatError, Stage, as_columns, columns, extents,
    fields::{Condition, Fields, fields, read_value, write_value},
    require_below,
};

/// Mesh, boundary and panes.
pub(super) const GROUP: Group = Group::new("mesh", Stage::Mesh.command());

const TETRAHEDRA: &str = "/mesh/tetrahedra";
const FACETS: &str = "/mesh/facets";
const FACET_FACE: &str = "/mesh/facet_face";
const TETRAHEDRON_MIDDLES: &str = "/mesh/tetrahedron_mid_edges";
const FACET_MIDDLES: &str = "/mesh/facet_mid_edges";
pub(super) const CONTACT_NODES: &str = "/mesh/contact_nodes";
pub(super) const CONTACT_FACE_NAMES: &str = "/mesh/contact_face_names";
pub(super) const CONTACT_FACE_NODES: &str = "/mesh/contact_face_nodes";
const CONTACT_FACE_FACETS: &str = "/mesh/contact_face_facets";
pub(super) const CONTACT_FACE_PANES: &str = "/mesh/contact_face_panes";
const CONTACT_FACE_IS_NODAL: &str = "/mesh/contact_face_is_nodal";
const CONTACT_FACETS: &str = "/mesh/contact_facets";
const CONTACT_FACET_PANE: &str = "/mesh/contact_facet_pane";
pub(super) const PANE_AREA: &str = "/mesh/pane_area";
const PANE_AVERAGE: &str = "/mesh/pane_average";
const PANE_CENTRE: &str = "/mesh/pane_centre";

const ONLY_QUADRATIC: Condition<Mesh> = ("absent with linear tetrahedra", |mesh| {
    mesh.mid_edges.is_some()
});
const NO_CONTACT: &str = "absent without contact";
const ONE_FACE: &str = "absent without several contact faces";

pub(super) const BODY: Fields<Mesh> = fields! { Mesh => GROUP;
    (coordinates) "/mesh/coordinates", &[Named("n_nodes"), extents::XYZ], Dimension::LENGTH, "Node coordinates.".symbol("x").compressed().finite();
    (tetrahedra) TETRAHEDRA, &[Named("n_tetrahedra"), Fixed(4)], Dimension::Number, "Corners of each tetrahedron, positively oriented.".compressed();
    (facets) FACETS, &[Named("n_facets"), Fixed(3)], Dimension::Number, "Corners of each boundary triangle, counter-clockwise seen from outside.".compressed();
    (facet_face) FACET_FACE, &[Named("n_facets")], Dimension::Number, "Face that each boundary triangle belongs to, as a line number of face_names from 0.".compressed();
    [|mesh| mesh.face_names.join("\n"), |mesh, names: String| mesh.face_names = names.lines().map(str::to_owned).collect()] "/mesh/face_names", &[], Dimension::Number, "Names of the faces, one a line.";
    (mid_edges?.tetrahedra) TETRAHEDRON_MIDDLES, &[Named("n_tetrahedra"), Fixed(6)], Dimension::Number, "Nodes in the middle of the edges 0-1, 1-2, 0-2, 0-3, 1-3, 2-3 of each tetrahedron.".compressed().when(ONLY_QUADRATIC).missing(|mesh| mesh.mid_edges = None);
    (mid_edges?.facets) FACET_MIDDLES, &[Named("n_facets"), Fixed(3)], Dimension::Number, "Nodes in the middle of the edges 0-1, 1-2, 2-0 of each boundary triangle.".compressed().when(ONLY_QUADRATIC);
    (tetrahedron_region) "/mesh/tetrahedron_region", &[Named("n_tetrahedra")], Dimension::Number, "Region of each tetrahedron: 0 for the body's own material, k for the k-th region of the scene.".compressed().optional("absent without regions");
};

pub(super) const SURFACE: Fields<ContactSurface> = fields! { ContactSurface => GROUP;
    [only_normal, |surface, normal| surface.normals.extend(normal)] "/mesh/contact_normal", &[extents::XYZ], Dimension::Number, "Outward unit normal of the contact face.".symbol("nu").optional("absent without contact, with several contact faces, and where normals vary").finite();
    [nodal_normals, |surface, normals| surface.normals.extend(normals)] "/mesh/contact_node_normal", &[Named("n_contact_nodes"), extents::XYZ], Dimension::Number, "Unit normal of contact at each contact node, out of the body and into the obstacle.".symbol("nu").compressed().optional("absent with one face whose normal is the same everywhere").finite();
    (clearance) "/mesh/contact_clearance", &[Named("n_contact_nodes")], Dimension::LENGTH, "Initial distance of each contact node from the obstacle along its normal, 0 on faces without one; the gap of the scene comes on top.".optional("absent without an obstacle").finite();
    {Kind::Text} CONTACT_FACE_NAMES, &[], Dimension::Number, "Names of the contact faces, one a line; those with friction come first.".optional(ONE_FACE);
    {Kind::I64} CONTACT_FACE_NODES, &[Plus("n_contact_faces", 1)], Dimension::Number, "Where the nodes of each contact face begin in contact_nodes, then their number.".optional(ONE_FACE);
    {Kind::I64} CONTACT_FACE_FACETS, &[Plus("n_contact_faces", 1)], Dimension::Number, "Where the triangles of each contact face begin in contact_facets, then their number.".optional(ONE_FACE);
    {Kind::I64} CONTACT_FACE_PANES, &[Plus("n_contact_faces", 1)], Dimension::Number, "First pane of each contact face, then their number.".optional(ONE_FACE);
    {Kind::I64} CONTACT_FACE_IS_NODAL, &[Named("n_contact_faces")], Dimension::Number, "1 where the multipliers of a contact face belong to its nodes, 0 where they are constant on panes.".optional(ONE_FACE);
    (nodes) CONTACT_NODES, &[Named("n_contact_nodes")], Dimension::Number, "Nodes on the contact face, increasing; on several faces one after the other, a node on two of them twice.".compressed().optional(NO_CONTACT);
    (facets) CONTACT_FACETS, &[Named("n_contact_facets")], Dimension::Number, "Boundary triangles on the contact face, as indices into facets.".compressed().optional(NO_CONTACT);
    (facet_pane) CONTACT_FACET_PANE, &[Named("n_pane_facets")], Dimension::Number, "Pane of each contact triangle; with several faces of those with panes.".compressed().optional("absent without contact and with nodal multipliers");
    (pane_area) PANE_AREA, &[Named("n_panes")], Dimension::AREA, "Area of each pane; with nodal multipliers the integral of the node's hat function.".symbol("|R_i|").optional(NO_CONTACT).finite();
    {Kind::F64} PANE_CENTRE, &[Named("n_panes"), extents::XYZ], Dimension::LENGTH, "Centre of each pane, the mean over it; with nodal multipliers the node.".optional(NO_CONTACT);
    {Kind::CscMatrix} PANE_AVERAGE, &[Named("n_contact_nodes"), Named("n_panes")], Dimension::Number, "Mean of each contact node's hat function over each pane; columns sum to 1. With nodal multipliers 1 at the node itself.".optional(NO_CONTACT);
};

pub(super) const QUALITY: Fields<Quality> = fields! { Quality => GROUP;
    (longest_edge) "/mesh/quality/longest_edge", &[], Dimension::LENGTH, "Longest edge.".symbol("h");
    (shortest_edge) "/mesh/quality/shortest_edge", &[], Dimension::LENGTH, "Shortest edge.";
    (smallest_volume) "/mesh/quality/smallest_volume", &[], Dimension::VOLUME, "Smallest tetrahedron volume.";
    (total_volume) "/mesh/quality/total_volume", &[], Dimension::VOLUME, "Volume of the body.";
    (smallest_shape) "/mesh/quality/smallest_shape", &[], Dimension::Number, "Smallest shape measure 12 (3V)^(2/3) / sum of squared edges; 1 is a regular tetrahedron.";
    (mean_shape) "/mesh/quality/mean_shape", &[], Dimension::Number, "Mean of the shape measure.";
};

/// The normal of one face that is the same everywhere.
fn only_normal(surface: &ContactSurface) -> Option<[f64; 3]> {
    match (surface.faces.as_slice(), surface.normals.as_slice()) {
        ([_], [everywhere]) => Some(*everywhere),
        _ => None,
    }
}

/// The normals at all contact nodes, where there is no [`only_normal`].
fn nodal_normals(surface: &ContactSurface) -> Vec<[f64; 3]> {
    match only_normal(surface) {
        Some(_) => Vec::new(),
        None => surface.normals.clone(),
    }
}

/// Writes the mesh with the names of its contact faces, and its quality figures.
pub fn write(
    writer: &mut GroupWriter<'_>,
    mesh: &Mesh,
    contact_names: &[String],
    quality: &Quality,
) -> Result<(), StoreError> {
    BODY.write_one(writer, mesh)?;
    if let Some(contact) = &mesh.contact {
        if contact.faces.len() > 1 {
            write_faces(writer, &contact.faces, contact_names)?;
        }
        SURFACE.write_one(writer, contact)?;
        writer.write_matrix(PANE_AVERAGE, columns(&contact.pane_average))?;
        let centre = |pane| {
            let (rows, shares) = contact.pane_average.column(pane);
            let places = rows.iter().map(|row| mesh.coordinates[contact.nodes[*row]]);
            let parts = places.zip(shares);
            parts.fold([0.0; 3], |sum: [f64; 3], (x, share)| {
                [0, 1, 2].map(|c| sum[c] + share * x[c])
            })
        };
        let centres: Vec<[f64; 3]> = (0..contact.n_panes()).map(centre).collect();
        write_value(writer, PANE_CENTRE, &centres)?;
    }
    QUALITY.write_one(writer, quality)
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
        write_value(writer, path, &limits)
    };
    limits(CONTACT_FACE_NODES, |face| &face.nodes)?;
    limits(CONTACT_FACE_FACETS, |face| &face.facets)?;
    limits(CONTACT_FACE_PANES, |face| &face.panes)?;
    let is_nodal: Vec<usize> = faces
        .iter()
        .map(|face| usize::from(face.is_nodal))
        .collect();
    write_value(writer, CONTACT_FACE_IS_NODAL, &is_nodal)
}

/// Reads the mesh.
pub fn read(reader: &Reader) -> Result<Mesh, FormatError> {
    let mut mesh = Mesh {
        mid_edges: Some(MidEdgeNodes::default()),
        ..Mesh::default()
    };
    BODY.read_one(reader, &mut mesh, true)?;
    let n_nodes = mesh.coordinates.len();
    require_below(TETRAHEDRA, mesh.tetrahedra.as_flattened(), n_nodes)?;
    require_below(FACETS, mesh.facets.as_flattened(), n_nodes)?;
    require_below(FACET_FACE, &mesh.facet_face, mesh.face_names.len())?;
    if let Some(middles) = &mesh.mid_edges {
        let nodes = middles.tetrahedra.as_flattened();
        require_below(TETRAHEDRON_MIDDLES, nodes, n_nodes)?;
        require_below(FACET_MIDDLES, middles.facets.as_flattened(), n_nodes)?;
    }
    if reader.has(CONTACT_NODES) {
        mesh.contact = Some(read_contact_surface(reader, n_nodes, mesh.facets.len())?);
    }
    Ok(mesh)
}

fn read_contact_surface(
    reader: &Reader,
    n_nodes: usize,
    n_facets: usize,
) -> Result<ContactSurface, FormatError> {
    let pane_average = as_columns(reader.read_matrix(PANE_AVERAGE)?);
    let n_panes = pane_average.cols;
    let mut surface = ContactSurface {
        faces: Vec::new(),
        normals: Vec::new(),
        clearance: Vec::new(),
        nodes: Vec::new(),
        facets: Vec::new(),
        facet_pane: Vec::new(),
        pane_area: Vec::new(),
        pane_average,
    };
    SURFACE.read_one(reader, &mut surface, true)?;
    let sizes = [surface.nodes.len(), surface.facets.len(), n_panes];
    surface.faces = if reader.has(CONTACT_FACE_PANES) {
        read_faces(reader, sizes)?
    } else {
        let is_nodal = !reader.has(CONTACT_FACET_PANE);
        vec![SurfaceFace::only(sizes[0], sizes[1], sizes[2], is_nodal)]
    };
    require_below(CONTACT_NODES, &surface.nodes, n_nodes)?;
    require_below(CONTACT_FACETS, &surface.facets, n_facets)?;
    require_below(CONTACT_FACET_PANE, &surface.facet_pane, surface.n_panes())?;
    Ok(surface)
}

/// Where several contact faces lie, of that many nodes, triangles and panes.
fn read_faces(reader: &Reader, sizes: [usize; 3]) -> Result<Vec<SurfaceFace>, FormatError> {
    let read = |path: &'static str, size: usize| -> Result<Vec<Range<usize>>, FormatError> {
        let limits: Vec<usize> = read_value(reader, path)?;
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
    let is_nodal: Vec<usize> = read_value(reader, CONTACT_FACE_IS_NODAL)?;
    let faces = nodes.into_iter().zip(facets).zip(panes).zip(is_nodal);
    let faces = faces.map(|(((nodes, facets), panes), is_nodal)| SurfaceFace {
        nodes,
        facets,
        panes,
        is_nodal: is_nodal == 1,
    });
    Ok(faces.collect())
}
