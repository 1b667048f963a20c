//! Panes of the contact part as plane polygons, and what is known of their friction.

use std::collections::BTreeMap;

use units::{Dimension, Unit, Units, in_digits};

use super::{
    outline::{edge_loops, surface_edges},
    picture::ContactPicture,
    scale::{UnitScale, bounds},
    text::Label,
    view::dot,
};

/// Panes in contact in less than this share of the face's box fill the picture.
const SMALL_PART: f64 = 0.25;

/// A pane in the plane of t₁ and t₂ \[m\].
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PaneShape {
    /// Index of the pane.
    pub(super) pane: usize,
    /// Closed loops of its outline; together they bound the pane by the even–odd rule.
    pub(super) outline: Vec<Vec<[f64; 2]>>,
    /// Area centroid.
    pub(super) centre: [f64; 2],
    /// Extents of the bounding box.
    pub(super) extent: [f64; 2],
}

/// Interval of the contact part along t₁ and t₂ \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ContactBox {
    pub(super) low: [f64; 2],
    pub(super) high: [f64; 2],
}

impl ContactBox {
    /// The box around all contact triangles, or around the whole body without contact; an extent
    /// of zero is widened so that it can be drawn.
    pub(super) fn new(picture: &ContactPicture<'_>) -> Self {
        let nodes = match picture.contact_triangles {
            [] => picture.boundary_triangles.as_flattened(),
            triangles => triangles.as_flattened(),
        };
        let along = |axis| bounds(nodes.iter().map(|&n| dot(picture.coordinates[n], axis)));
        let (left, right) = along(picture.axis_1);
        let (bottom, top) = along(picture.axis_2);
        let (width, height) = (right - left, top - bottom);
        let smallest = 1e-12 * (1.0 + left.abs() + bottom.abs()).max(width.max(height));
        Self {
            low: [left, bottom],
            high: [left + width.max(smallest), bottom + height.max(smallest)],
        }
    }

    /// The part around the panes in contact, with a margin, where their box takes less than [`SMALL_PART`] of the whole one; else the whole.
    pub(super) fn framed(picture: &ContactPicture<'_>) -> Self {
        let whole = Self::new(picture);
        let panes = picture.contact_triangle_pane.iter();
        let triangles = picture.contact_triangles.iter().zip(panes);
        let closed = triangles.filter(|(_, pane)| picture.pressure[**pane] > 0.0);
        let nodes: Vec<usize> = closed.flat_map(|(nodes, _)| *nodes).collect();
        let [x, y] = [picture.axis_1, picture.axis_2]
            .map(|axis| bounds(nodes.iter().map(|&n| dot(picture.coordinates[n], axis))));
        let extent = [x.1 - x.0, y.1 - y.0];
        let [width, height] = whole.extent();
        let is_small = extent[0] * extent[1] < SMALL_PART * width * height;
        if nodes.is_empty() || !is_small {
            return whole;
        }
        // What is shown around them, as a share of the longer side of their box.
        let margin = 0.25 * extent[0].max(extent[1]);
        Self {
            low: [0, 1].map(|k| (([x, y][k]).0 - margin).max(whole.low[k])),
            high: [0, 1].map(|k| (([x, y][k]).1 + margin).min(whole.high[k])),
        }
    }

    /// Whether a point is in it.
    pub(super) fn contains(&self, point: [f64; 2]) -> bool {
        (0..2).all(|k| (self.low[k]..=self.high[k]).contains(&point[k]))
    }

    /// The part of a polygon in it: cut along each of its four sides (I. Sutherland, G. Hodgman, Commun. ACM 17 (1974) 32).
    fn cut(&self, mut polygon: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
        for k in 0..2 {
            for (sign, bound) in [(1.0, self.low[k]), (-1.0, self.high[k])] {
                let inside = |point: [f64; 2]| sign * (point[k] - bound) >= 0.0;
                let mut kept = Vec::new();
                for (i, &b) in polygon.iter().enumerate() {
                    let a = polygon[(i + polygon.len() - 1) % polygon.len()];
                    if inside(a) != inside(b) {
                        let share = (bound - a[k]) / (b[k] - a[k]);
                        let mut on_side = [0, 1].map(|c| a[c] + share * (b[c] - a[c]));
                        on_side[k] = bound;
                        kept.push(on_side);
                    }
                    if inside(b) {
                        kept.push(b);
                    }
                }
                polygon = kept;
            }
        }
        polygon
    }

    pub(super) fn extent(&self) -> [f64; 2] {
        [self.high[0] - self.low[0], self.high[1] - self.low[1]]
    }
}

impl PaneShape {
    /// What of it lies in a frame; `None` where nothing does.
    pub(super) fn within(self, frame: &ContactBox) -> Option<Self> {
        if self
            .outline
            .iter()
            .flatten()
            .all(|&point| frame.contains(point))
        {
            return Some(self);
        }
        let cut = self.outline.into_iter().map(|polygon| frame.cut(polygon));
        let outline: Vec<Vec<[f64; 2]>> = cut.filter(|polygon| polygon.len() > 2).collect();
        (!outline.is_empty()).then_some(Self { outline, ..self })
    }
}

/// The shape of every pane that owns a contact triangle, in the order of the panes.
///
/// The outline consists of the edges that occur once among the triangles of a pane.
pub(super) fn pane_shapes(picture: &ContactPicture<'_>) -> Vec<PaneShape> {
    let mut triangles_of_pane: BTreeMap<usize, Vec<[usize; 3]>> = BTreeMap::new();
    for (&triangle, &pane) in picture
        .contact_triangles
        .iter()
        .zip(picture.contact_triangle_pane)
    {
        triangles_of_pane.entry(pane).or_default().push(triangle);
    }
    let position = |node: usize| {
        let x = picture.coordinates[node];
        [dot(x, picture.axis_1), dot(x, picture.axis_2)]
    };
    triangles_of_pane
        .into_iter()
        .map(|(pane, triangles)| {
            let corners = triangles.as_flattened().iter().map(|&node| position(node));
            let (left, right) = bounds(corners.clone().map(|p| p[0]));
            let (bottom, top) = bounds(corners.map(|p| p[1]));
            let loops = edge_loops(&single_edges(&triangles));
            PaneShape {
                pane,
                outline: loops
                    .into_iter()
                    .map(|nodes| nodes.into_iter().map(position).collect())
                    .collect(),
                centre: centroid(&triangles, position),
                extent: [right - left, top - bottom],
            }
        })
        .collect()
}

/// The edges, smaller node first, that belong to one triangle only.
pub(super) fn single_edges(triangles: &[[usize; 3]]) -> Vec<[usize; 2]> {
    let edges = surface_edges(triangles).into_iter();
    edges
        .filter(|edge| edge.triangles.len() == 1)
        .map(|edge| edge.nodes)
        .collect()
}

/// Area centroid of a union of triangles; the mean of the corners when its area is zero.
fn centroid(triangles: &[[usize; 3]], position: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
    let mut weighted = [0.0; 3];
    let mut plain = [0.0; 3];
    for triangle in triangles {
        let [a, b, c] = triangle.map(&position);
        let area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs() / 2.0;
        for (sum, weight) in [(&mut weighted, area), (&mut plain, 1.0)] {
            sum[0] += weight * (a[0] + b[0] + c[0]) / 3.0;
            sum[1] += weight * (a[1] + b[1] + c[1]) / 3.0;
            sum[2] += weight;
        }
    }
    let [x, y, weight] = if weighted[2] > 0.0 { weighted } else { plain };
    [x / weight, y / weight]
}

/// A value in the multiple of its unit that suits it; `None` without a unit.
fn with_unit(value: f64, unit: &Unit) -> Option<Label> {
    let scale = UnitScale::new(value, unit);
    let number = Label::plain(in_digits(scale.scaled(value), 3, 1e4));
    (!unit.is_none()).then(|| {
        number
            .upright(" ")
            .then(&scale.unit.clone().without_brackets())
    })
}

/// How stresses are drawn in the ellipses of a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrictionKind {
    /// Over the pressure λ_ν, as in Coulomb's law.
    OverPressure,
    /// Over a slip bound g that follows the pressure.
    OverBound,
    /// As they are, where the slip bound is given, as in Tresca's law.
    Plain,
}

impl FrictionKind {
    /// Unit of semi-axes and of the stress in an ellipse.
    pub(super) fn unit(self, units: Units) -> Unit {
        self.either(Unit::none(), units.of(Dimension::STRESS))
    }

    /// Unit of the scaled tangential stress.
    pub(super) fn scaled_unit(self, units: Units) -> Unit {
        self.either(units.of(Dimension::STRESS), Unit::none())
    }

    /// F₁ or F₂; of Tresca's law g F₁ or g F₂.
    pub(super) fn semi_axis_symbol(self, axis: usize) -> Label {
        self.before_index().subscript(["1", "2"][axis])
    }

    /// ‖F⁻¹σ_t‖; of Tresca's law ‖(g F)⁻¹σ_t‖.
    pub(super) fn scaled_symbol(self) -> Label {
        let bound = Label::plain("‖(").italic("gF").upright(")");
        let matrix = self.either(Label::plain("‖").italic("F"), bound);
        let stress = matrix.superscript("−1").italic("σ").subscript("t");
        stress.upright("‖")
    }

    /// Title of the panel of the scaled tangential stress, without its symbol.
    pub(super) fn scaled_title(self) -> &'static str {
        self.either(
            "(b) Scaled tangential contact stress ",
            "(b) Tangential contact stress over its bound ",
        )
    }

    /// Title of a map of semi-axes, without its symbol.
    pub(super) fn semi_axis_title(self) -> &'static str {
        self.either(
            "Coefficient of friction ",
            "Bound of the tangential stress ",
        )
    }

    /// The legend's words for the ellipses.
    pub(super) fn semi_axes_label(self) -> Label {
        let first = Label::plain("semi-axes ").then(&self.semi_axis_symbol(0));
        first.upright(", ").then(&self.semi_axis_symbol(1))
    }

    /// The legend's words for the line in an ellipse: σ_t/λ_ν, with a cap σ_t/g; of Tresca's law σ_t.
    pub(super) fn stress_label(self) -> Label {
        let stress = Label::default().italic("σ").subscript("t");
        match self {
            Self::OverPressure => stress.upright("/").italic("λ").subscript("ν"),
            Self::OverBound => stress.upright("/").italic("g"),
            Self::Plain => stress,
        }
    }

    /// The value of the scale bar of the ellipses.
    pub(super) fn scale_bar_label(self, value: f64, unit: &Unit) -> Label {
        let number = || UnitScale::new(value, unit).number(value);
        let value = with_unit(value, unit).unwrap_or_else(number);
        self.before_index().upright(" = ").then(&value)
    }

    /// The semi-axes that are the same on all panes; empty where both vary.
    pub(super) fn constants_label(self, constants: [Option<f64>; 2], unit: &Unit) -> Label {
        let equal = |label: Label, value: f64| {
            let number = || Label::plain(in_digits(value, 3, 1e4));
            let value = with_unit(value, unit).unwrap_or_else(number);
            label.upright(" = ").then(&value)
        };
        let [first, second] = [0, 1].map(|axis| self.semi_axis_symbol(axis));
        match constants {
            [None, None] => Label::default(),
            [Some(a), None] => equal(first, a),
            [None, Some(b)] => equal(second, b),
            [Some(a), Some(b)] if a == b => equal(first.upright(" = ").then(&second), a),
            [Some(a), Some(b)] => equal(first, a).upright(", ").then(&equal(second, b)),
        }
    }

    /// What a pane says of its semi-axes and its stress, both in `unit`.
    pub(super) fn describe(self, semi_axes: [f64; 2], stress: [f64; 2], unit: &Unit) -> String {
        let ([a, b], [t1, t2]) = (semi_axes, stress);
        let bound = match self {
            Self::OverPressure => "λν",
            Self::OverBound => "g",
            Self::Plain => {
                return format!(
                    "gF1 = {a:.4e}, gF2 = {b:.4e}, σt = ({t1:.4e}, {t2:.4e}){}",
                    unit.beside()
                );
            }
        };
        format!("F1 = {a:.4}, F2 = {b:.4}, σt/{bound} = ({t1:.4}, {t2:.4})")
    }

    fn before_index(self) -> Label {
        Label::default().italic(self.either("F", "gF"))
    }

    /// One of two: of stresses over what bounds them, or of those as they are.
    fn either<T>(self, over_bound: T, plain: T) -> T {
        match self {
            Self::OverPressure | Self::OverBound => over_bound,
            Self::Plain => plain,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight triangles around node 4 of a 3 × 3 grid of nodes.
    const MACRO_FACE: [[usize; 3]; 8] = [
        [4, 0, 1],
        [4, 1, 2],
        [4, 2, 5],
        [4, 5, 8],
        [4, 8, 7],
        [4, 7, 6],
        [4, 6, 3],
        [4, 3, 0],
    ];

    #[test]
    fn outline_of_a_macro_face_is_one_loop_of_its_eight_outer_nodes() {
        let loops = edge_loops(&single_edges(&MACRO_FACE));
        assert_eq!(loops, [vec![0, 1, 2, 5, 8, 7, 6, 3]]);
    }

    #[test]
    fn panes_that_meet_in_a_node_give_closed_loops_over_all_edges() {
        let edges = single_edges(&[[0, 1, 2], [2, 3, 4]]);
        let loops = edge_loops(&edges);
        assert_eq!(loops.iter().map(Vec::len).sum::<usize>(), edges.len());
    }

    #[test]
    fn a_polygon_is_cut_to_its_frame() {
        let frame = ContactBox {
            low: [0.0; 2],
            high: [1.0; 2],
        };
        let cut = frame.cut(vec![[-1.0, 0.5], [0.5, -1.0], [2.0, 0.5], [0.5, 2.0]]);
        // A square on its corner, of which the frame cuts all four.
        assert_eq!(cut.len(), 4);
        assert!(cut.iter().all(|&point| frame.contains(point)));
        assert!(
            frame
                .cut(vec![[2.0, 0.0], [3.0, 0.0], [2.0, 1.0]])
                .is_empty()
        );
    }

    #[test]
    fn centroid_of_a_macro_face_is_its_centre() {
        let grid = |node: usize| [(node % 3) as f64, (node / 3) as f64];
        let [x, y] = centroid(&MACRO_FACE, grid);
        // A sum of 8 terms of order 1.
        assert!((x - 1.0).abs() < 1e-14 && (y - 1.0).abs() < 1e-14);
    }
}
