//! `/mesh`: nodes, tetrahedra, boundary, contact surface, quality.

use std::{collections::BTreeMap, ops::Range, sync::Arc};

use contact3d::{
    linalg::CscMatrix,
    mesh::{
        BodyRange, ContactSurface, GluedNode, Mesh, MidEdgeNodes, Opposite, Quality, SurfaceFace,
        TriangulatedSurface,
    },
};
use runfile::{
    Extent::{Fixed, Named, Plus},
    Group, GroupWriter, Kind, Reader, StoreError,
};
use units::Dimension;

use super::{
    FormatError, Stage, as_columns, columns, extents,
    fields::{Condition, Fields, fields, read_finite, read_value, write_value},
    require, require_below,
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
const BODY_NAMES: &str = "/mesh/body_names";
const BODY_NODES: &str = "/mesh/body_nodes";
const BODY_TETRAHEDRA: &str = "/mesh/body_tetrahedra";
const OBSTACLE_POINTS: &str = "/mesh/obstacle_points";
const OBSTACLE_TRIANGLES: &str = "/mesh/obstacle_triangles";
const OBSTACLE_NORMALS: &str = "/mesh/obstacle_normals";
const OBSTACLE_CONTACT: &str = "/mesh/obstacle_contact";
const GLUED_NODES: &str = "/mesh/glued_nodes";
const GLUED_SHARES: &str = "/mesh/glued_shares";
const OPPOSITE_POINTS: &str = "/mesh/opposite_points";
const OPPOSITE_PANES: &str = "/mesh/opposite_panes";
const OPPOSITE_PAIRS: &str = "/mesh/opposite_pairs";
const OPPOSITE_INTEGRALS: &str = "/mesh/opposite_integrals";

const ONLY_QUADRATIC: Condition<Mesh> = ("absent with linear tetrahedra", |mesh| {
    mesh.mid_edges.is_some()
});
const NO_CONTACT: &str = "absent without contact";
const ONE_BODY: &str = "absent without several bodies";
const NOTHING_GLUED: &str = "absent without glued faces";
const NO_PAIR: &str = "absent where no bodies touch each other";
const NO_TRIANGLES: &str = "absent without an obstacle of triangles";
const ONE_FACE: &str = "absent without several contact faces";

pub(super) const BODY: Fields<Mesh> = fields! { Mesh => GROUP;
    (coordinates) "/mesh/coordinates", &[Named("n_nodes"), extents::XYZ], Dimension::LENGTH, "Node coordinates.".symbol("x").compressed().finite();
    (tetrahedra) TETRAHEDRA, &[Named("n_tetrahedra"), Fixed(4)], Dimension::Number, "Corners of each tetrahedron, positively oriented.".compressed();
    (facets) FACETS, &[Named("n_facets"), Fixed(3)], Dimension::Number, "Corners of each boundary triangle, counter-clockwise seen from outside.".compressed();
    (facet_face) FACET_FACE, &[Named("n_facets")], Dimension::Number, "Face that each boundary triangle belongs to, as a line number of face_names from 0.".compressed();
    [|mesh| mesh.face_names.join("\n"), |mesh, names: String| mesh.face_names = names.lines().map(str::to_owned).collect()] "/mesh/face_names", &[], Dimension::Number, "Names of the faces, one a line.";
    (mid_edges?.tetrahedra) TETRAHEDRON_MIDDLES, &[Named("n_tetrahedra"), Fixed(6)], Dimension::Number, "Nodes in the middle of the edges 0-1, 1-2, 0-2, 0-3, 1-3, 2-3 of each tetrahedron.".compressed().when(ONLY_QUADRATIC).missing(|mesh| mesh.mid_edges = None);
    (mid_edges?.facets) FACET_MIDDLES, &[Named("n_facets"), Fixed(3)], Dimension::Number, "Nodes in the middle of the edges 0-1, 1-2, 2-0 of each boundary triangle.".compressed().when(ONLY_QUADRATIC);
    (tetrahedron_region) "/mesh/tetrahedron_region", &[Named("n_tetrahedra")], Dimension::Number, "Region of each tetrahedron: 0 for the common material, k for the k-th region of the scene; then the materials of bodies that have their own.".compressed().optional("absent with one material");
    {Kind::Text} BODY_NAMES, &[], Dimension::Number, "Names of the bodies, one a line.".optional(ONE_BODY);
    {Kind::I64} BODY_NODES, &[Plus("n_bodies", 1)], Dimension::Number, "First node of each body, then their number.".optional(ONE_BODY);
    {Kind::I64} BODY_TETRAHEDRA, &[Plus("n_bodies", 1)], Dimension::Number, "First tetrahedron of each body, then their number.".optional(ONE_BODY);
    {Kind::F64} OBSTACLE_POINTS, &[Named("n_obstacle_points"), extents::XYZ], Dimension::LENGTH, "Corners of the triangles of obstacles.".compressed().optional(NO_TRIANGLES).finite();
    {Kind::I64} OBSTACLE_TRIANGLES, &[Named("n_obstacle_triangles"), Fixed(3)], Dimension::Number, "Points of each triangle of an obstacle, counter-clockwise seen from the body.".compressed().optional(NO_TRIANGLES);
    {Kind::F64} OBSTACLE_NORMALS, &[Named("n_obstacle_triangles"), Fixed(3), extents::XYZ], Dimension::Number, "Unit normal out of the obstacle at each corner of its triangles, the same on both sides of an edge that is not sharp.".compressed().optional(NO_TRIANGLES).finite();
    {Kind::I64} OBSTACLE_CONTACT, &[Named("n_obstacle_triangles")], Dimension::Number, "Contact of the scene, from 0, that each triangle is an obstacle of.".compressed().optional(NO_TRIANGLES);
    {Kind::I64} GLUED_NODES, &[Named("n_glued_nodes"), Fixed(3)], Dimension::Number, "Nodes that follow those of faces that theirs is glued to, before those that they follow, the contact of the scene that glues them, and 1 + 2 + 4 for x, y and z, along which they follow; a node once for each.".compressed().optional(NOTHING_GLUED);
    (joint_gap) "/mesh/joint_gap", &[Named("n_joints")], Dimension::LENGTH, "Largest distance that closes between each pair of glued faces, negative where they overlap; 0 up to what triangles leave of curved ones.".optional(NOTHING_GLUED).finite();
    (joint_cover) "/mesh/joint_cover", &[Named("n_joints"), Fixed(2)], Dimension::Number, "Largest share of a triangle of both faces of each of these pairs that is glued.".optional(NOTHING_GLUED).finite();
    {Kind::CscMatrix} GLUED_SHARES, &[Named("n_nodes"), Named("n_glued_nodes")], Dimension::Number, "Shares of the nodes that each of these follows, in displacement and place; those of a node sum to 1, and to 0 of one that comes before it.".optional(NOTHING_GLUED);
};

pub(super) const SURFACE: Fields<ContactSurface> = fields! { ContactSurface => GROUP;
    [only_normal, |surface, normal| surface.normals.extend(normal)] "/mesh/contact_normal", &[extents::XYZ], Dimension::Number, "Outward unit normal of the contact face.".symbol("nu").optional("absent without contact, with several contact faces, and where normals vary").finite();
    [nodal_normals, |surface, normals| surface.normals.extend(normals)] "/mesh/contact_node_normal", &[Named("n_contact_nodes"), extents::XYZ], Dimension::Number, "Unit normal of contact at each contact node, out of the body and into the obstacle, where a history begins.".symbol("nu").compressed().optional("absent with one face whose normal is the same everywhere").finite();
    (clearance) "/mesh/contact_clearance", &[Named("n_contact_nodes")], Dimension::LENGTH, "Initial distance of each contact node from what lies opposite along its normal, negative inside it, 0 on faces without one; the gap of the scene comes on top.".optional("absent without an obstacle").finite();
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
    {Kind::CscMatrix} OPPOSITE_POINTS, &[Named("n_nodes"), Named("n_contact_nodes")], Dimension::Number, "Hat functions of the other body's nodes at the point opposite each contact node; columns sum to 1, or are empty on faces before obstacles.".optional(NO_PAIR);
    {Kind::I64} OPPOSITE_PANES, &[Plus("n_panes", 1)], Dimension::Number, "Where the entries of each pane begin in opposite_pairs, then their number.".optional(NO_PAIR);
    {Kind::I64} OPPOSITE_PAIRS, &[Named("n_opposite"), Fixed(2)], Dimension::Number, "Contact node and node of the other body of each entry.".compressed().optional(NO_PAIR);
    {Kind::F64} OPPOSITE_INTEGRALS, &[Named("n_opposite")], Dimension::AREA, "Integral of the product of both hat functions over the pane.".compressed().optional(NO_PAIR);
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
    if !mesh.bodies.is_empty() {
        write_bodies(writer, &mesh.bodies)?;
    }
    if !mesh.obstacles.is_empty() {
        write_obstacles(writer, &mesh.obstacles)?;
    }
    if !mesh.glued.is_empty() {
        write_glued(writer, mesh)?;
    }
    if let Some(contact) = &mesh.contact {
        if contact.faces.len() > 1 {
            write_faces(writer, &contact.faces, contact_names)?;
        }
        SURFACE.write_one(writer, contact)?;
        writer.write_matrix(PANE_AVERAGE, columns(&contact.pane_average))?;
        let panes = 0..contact.n_panes();
        let centres: Vec<_> = panes.map(|pane| contact.pane_centre(mesh, pane)).collect();
        write_value(writer, PANE_CENTRE, &centres)?;
        if let Some(opposite) = &contact.opposite {
            write_opposite(writer, opposite)?;
        }
    }
    QUALITY.write_one(writer, quality)
}

fn write_bodies(writer: &mut GroupWriter<'_>, bodies: &[BodyRange]) -> Result<(), StoreError> {
    let names: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
    writer.write_text(BODY_NAMES, &names.join("\n"))?;
    write_value(
        writer,
        BODY_NODES,
        &limits(bodies.iter().map(|body| &body.nodes)),
    )?;
    let tetrahedra = bodies.iter().map(|body| &body.tetrahedra);
    write_value(writer, BODY_TETRAHEDRA, &limits(tetrahedra))
}

fn write_obstacles(
    writer: &mut GroupWriter<'_>,
    obstacles: &BTreeMap<usize, Arc<TriangulatedSurface>>,
) -> Result<(), StoreError> {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let (mut normals, mut contacts) = (Vec::new(), Vec::new());
    for (entry, surface) in obstacles {
        let first = points.len();
        let corners = surface.triangles.iter();
        triangles.extend(corners.map(|corners| corners.map(|point| point + first)));
        points.extend_from_slice(&surface.points);
        normals.extend_from_slice(&surface.normals);
        contacts.extend(vec![*entry; surface.triangles.len()]);
    }
    write_value(writer, OBSTACLE_POINTS, &points)?;
    write_value(writer, OBSTACLE_TRIANGLES, &triangles)?;
    write_value(writer, OBSTACLE_NORMALS, &normals)?;
    write_value(writer, OBSTACLE_CONTACT, &contacts)
}

fn write_glued(writer: &mut GroupWriter<'_>, mesh: &Mesh) -> Result<(), StoreError> {
    let nodes = mesh.glued.iter().map(|glued| {
        let axes = [0, 1, 2].map(|c| usize::from(glued.axes[c]) << c);
        [glued.node, glued.entry, axes.iter().sum()]
    });
    write_value(writer, GLUED_NODES, &nodes.collect::<Vec<_>>())?;
    let shares = mesh.glued.iter().map(|glued| glued.shares.iter().copied());
    let shares = CscMatrix::of_columns(mesh.coordinates.len(), shares);
    writer.write_matrix(GLUED_SHARES, columns(&shares))
}

/// Where ranges that follow each other begin, then where the last one ends.
fn limits<'a>(ranges: impl Iterator<Item = &'a Range<usize>>) -> Vec<usize> {
    [0].into_iter()
        .chain(ranges.map(|range| range.end))
        .collect()
}

fn write_opposite(writer: &mut GroupWriter<'_>, opposite: &Opposite) -> Result<(), StoreError> {
    writer.write_matrix(OPPOSITE_POINTS, columns(&opposite.points))?;
    let mut panes = vec![0];
    for entries in &opposite.products {
        panes.push(panes[panes.len() - 1] + entries.len());
    }
    write_value(writer, OPPOSITE_PANES, &panes)?;
    let all = || opposite.products.iter().flatten();
    let pairs: Vec<[usize; 2]> = all().map(|(local, node, _)| [*local, *node]).collect();
    write_value(writer, OPPOSITE_PAIRS, &pairs)?;
    let integrals: Vec<f64> = all().map(|(_, _, integral)| *integral).collect();
    write_value(writer, OPPOSITE_INTEGRALS, &integrals)
}

/// Where several contact faces lie.
fn write_faces(
    writer: &mut GroupWriter<'_>,
    faces: &[SurfaceFace],
    names: &[String],
) -> Result<(), StoreError> {
    writer.write_text(CONTACT_FACE_NAMES, &names.join("\n"))?;
    write_value(
        writer,
        CONTACT_FACE_NODES,
        &limits(faces.iter().map(|face| &face.nodes)),
    )?;
    write_value(
        writer,
        CONTACT_FACE_FACETS,
        &limits(faces.iter().map(|face| &face.facets)),
    )?;
    write_value(
        writer,
        CONTACT_FACE_PANES,
        &limits(faces.iter().map(|face| &face.panes)),
    )?;
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
    if reader.has(BODY_NAMES) {
        mesh.bodies = read_bodies(reader, n_nodes, mesh.tetrahedra.len())?;
    }
    if reader.has(OBSTACLE_POINTS) {
        mesh.obstacles = read_obstacles(reader)?;
    }
    if reader.has(GLUED_NODES) {
        mesh.glued = read_glued(reader, n_nodes)?;
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
        opposite: None,
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
    if reader.has(OPPOSITE_POINTS) {
        surface.opposite = Some(read_opposite(reader, n_nodes, sizes[0], n_panes)?);
    }
    Ok(surface)
}

fn read_bodies(
    reader: &Reader,
    n_nodes: usize,
    n_tetrahedra: usize,
) -> Result<Vec<BodyRange>, FormatError> {
    let names: String = read_value(reader, BODY_NAMES)?;
    let nodes = read_ranges(reader, BODY_NODES, n_nodes)?;
    let tetrahedra = read_ranges(reader, BODY_TETRAHEDRA, n_tetrahedra)?;
    let bodies = names.lines().zip(nodes).zip(tetrahedra);
    let bodies = bodies.map(|((name, nodes), tetrahedra)| BodyRange {
        name: name.to_owned(),
        nodes,
        tetrahedra,
    });
    Ok(bodies.collect())
}

fn read_obstacles(
    reader: &Reader,
) -> Result<BTreeMap<usize, Arc<TriangulatedSurface>>, FormatError> {
    let points: Vec<[f64; 3]> = read_finite(reader, OBSTACLE_POINTS)?;
    let triangles: Vec<[usize; 3]> = read_value(reader, OBSTACLE_TRIANGLES)?;
    let normals: Vec<[[f64; 3]; 3]> = read_finite(reader, OBSTACLE_NORMALS)?;
    let contacts: Vec<usize> = read_value(reader, OBSTACLE_CONTACT)?;
    require_below(OBSTACLE_TRIANGLES, triangles.as_flattened(), points.len())?;
    let of_one = |run: &[usize], first: usize| {
        let own = first..first + run.len();
        let corners = || triangles[own.clone()].as_flattened().iter().copied();
        let from = corners().min().unwrap_or_default();
        let to = corners().max().unwrap_or_default();
        let moved = triangles[own.clone()]
            .iter()
            .map(|it| it.map(|point| point - from));
        let points = points[from..=to].to_vec();
        TriangulatedSurface::new(points, moved.collect(), normals[own].to_vec())
    };
    let mut first = 0;
    let runs = contacts.chunk_by(|a, b| a == b).map(|run| {
        let surface = of_one(run, first);
        first += run.len();
        (run[0], Arc::new(surface))
    });
    Ok(runs.collect())
}

fn read_glued(reader: &Reader, n_nodes: usize) -> Result<Vec<GluedNode>, FormatError> {
    let nodes: Vec<[usize; 3]> = read_value(reader, GLUED_NODES)?;
    let shares = as_columns(reader.read_matrix(GLUED_SHARES)?);
    require_below(GLUED_NODES, nodes.iter().map(|[node, ..]| node), n_nodes)?;
    let fits = [shares.rows, shares.cols] == [n_nodes, nodes.len()];
    require(fits, GLUED_SHARES, || {
        format!("expected {} columns of {n_nodes} rows", nodes.len())
    })?;
    let glued = nodes.into_iter().enumerate();
    let glued = glued.map(|(column, [node, entry, axes])| GluedNode {
        node,
        entry,
        axes: [0, 1, 2].map(|c| axes & (1 << c) > 0),
        shares: shares.entries(column).collect(),
    });
    Ok(glued.collect())
}

fn read_opposite(
    reader: &Reader,
    n_nodes: usize,
    n_contact_nodes: usize,
    n_panes: usize,
) -> Result<Opposite, FormatError> {
    let points = as_columns(reader.read_matrix(OPPOSITE_POINTS)?);
    let pairs: Vec<[usize; 2]> = read_value(reader, OPPOSITE_PAIRS)?;
    let integrals: Vec<f64> = read_value(reader, OPPOSITE_INTEGRALS)?;
    let locals: Vec<usize> = pairs.iter().map(|pair| pair[0]).collect();
    let nodes: Vec<usize> = pairs.iter().map(|pair| pair[1]).collect();
    require_below(OPPOSITE_PAIRS, &locals, n_contact_nodes)?;
    require_below(OPPOSITE_PAIRS, &nodes, n_nodes)?;
    let panes = read_ranges(reader, OPPOSITE_PANES, pairs.len())?;
    require(panes.len() == n_panes, OPPOSITE_PANES, || {
        format!("expected {n_panes} panes, found {}", panes.len())
    })?;
    let entry = |i: usize| (pairs[i][0], pairs[i][1], integrals[i]);
    let products = panes.into_iter().map(|range| range.map(entry).collect());
    Ok(Opposite {
        points,
        products: products.collect(),
    })
}

/// Ranges that follow each other, from 0 to `size`.
fn read_ranges(
    reader: &Reader,
    path: &'static str,
    size: usize,
) -> Result<Vec<Range<usize>>, FormatError> {
    let limits: Vec<usize> = read_value(reader, path)?;
    let ends = limits.first() == Some(&0) && limits.last() == Some(&size);
    require(ends && limits.is_sorted(), path, || {
        format!("expected increasing limits from 0 to {size}")
    })?;
    Ok(limits.windows(2).map(|pair| pair[0]..pair[1]).collect())
}

/// Where several contact faces lie, of that many nodes, triangles and panes.
fn read_faces(reader: &Reader, sizes: [usize; 3]) -> Result<Vec<SurfaceFace>, FormatError> {
    let nodes = read_ranges(reader, CONTACT_FACE_NODES, sizes[0])?;
    let facets = read_ranges(reader, CONTACT_FACE_FACETS, sizes[1])?;
    let panes = read_ranges(reader, CONTACT_FACE_PANES, sizes[2])?;
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
