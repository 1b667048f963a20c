//! The six panels of a run file, its von Mises stress, where its discretisation error sits, and the faces of a mesh file, as SVG and PNG.

use std::{
    fs,
    ops::Range,
    path::{Path, PathBuf},
    slice::from_ref,
};

use contact3d::{
    contact::ContactFrame,
    mesh::{MaterialNodes, Mesh, MeshInspection, tetrahedron_volume},
    post::{ContactReport, PaneState, Zone},
    scene::{ContactFeatures, Scene, SlipBound, escape_control},
};
use plots::{
    BodyField, BodyMark, ContactPicture, DrawnFriction, DrawnObstacle, FrictionKind, MeshPicture,
    Picture, mesh_page,
};
use units::Dimension;

use super::{
    Drawing, PictureFolder,
    contact_cells::ContactCells,
    history_charts,
    picture_folder::CHART_WIDTH,
    surroundings::{body_marks, obstacle_beside},
};
use crate::{
    pipeline::{Results, StageError},
    report::SolvedRun,
};

/// Width of the six-panel page in pixels.
pub(super) const PAGE_WIDTH: u32 = 1920;

/// The folder beside a run file in which its pictures go by default.
pub fn figures_folder(run_file: &Path) -> PathBuf {
    let stem = run_file.file_stem().unwrap_or_default().to_string_lossy();
    run_file.with_file_name(format!("{stem}-figures"))
}

/// The picture of where the discretisation error sits.
const ERROR: &str = "discretisation_error";

/// The picture of the von Mises stress.
const STRESS: &str = "von_mises";

/// The page of all panels, which is drawn last.
const OVERVIEW: &str = "overview";

/// What is drawn of a scene: one set of panels, or one for each of several contact faces, whose names end the names of the files.
pub fn drawing_of(scene: &Scene) -> Drawing {
    Drawing::Run(endings_of(scene))
}

/// What the names of pictures of each contact face end in: nothing for one.
pub(super) fn endings_of(scene: &Scene) -> Vec<String> {
    let faces = scene.contact_features();
    if faces.len() < 2 {
        return vec![String::new()];
    }
    let mut endings: Vec<String> = Vec::new();
    for face in faces {
        let plain = |c: char| if c.is_alphanumeric() { c } else { '_' };
        let mut ending: String = format!("-{}", face.name.chars().map(plain).collect::<String>());
        while endings.contains(&ending) {
            ending.push('_');
        }
        endings.push(ending);
    }
    endings
}

/// The names of all pictures with these endings.
pub(super) fn names(endings: &[String]) -> Vec<String> {
    let panels = || plots::PANELS.iter().chain([&OVERVIEW]);
    let of_faces = endings
        .iter()
        .flat_map(|ending| panels().map(move |name| format!("{name}{ending}")));
    let of_history = history_charts::HISTORY.map(str::to_owned);
    let others = [ERROR, STRESS].map(str::to_owned).into_iter();
    let others = others.chain(of_history);
    others.chain(of_faces).collect()
}

/// Whether all pictures of a run file are in a folder and no older than it.
pub fn are_drawn(folder: &Path, run_file: &Path, scene: &Scene) -> bool {
    let modified = |file: &Path| fs::metadata(file).and_then(|metadata| metadata.modified());
    let last = match drawing_of(scene) {
        Drawing::Run(endings) => endings.last().cloned().unwrap_or_default(),
        _ => String::new(),
    };
    let last = modified(&folder.join(format!("{OVERVIEW}{last}.png")));
    matches!((last, modified(run_file)), (Ok(drawn), Ok(stored)) if drawn >= stored)
}

/// Draws the six panels of HKL Fig. 5, the page of all six, for each contact face, where the discretisation error sits and the
/// charts of a load history, as SVG and PNG; returns the files.
pub fn draw_run(
    folder: &PictureFolder,
    scene: &Scene,
    results: &Results,
) -> Result<Vec<PathBuf>, StageError> {
    let Drawing::Run(endings) = drawing_of(scene) else {
        return Ok(Vec::new());
    };
    let marks = marks_of(scene, results);
    let charts = history_charts::charts(&results.increments, scene.units);
    let charts = charts.map(|(name, chart)| (name.to_owned(), chart.figure(), CHART_WIDTH));
    let mut drawings: Vec<(String, Picture, u32)> = charts.collect();
    for (face, ending) in endings.iter().enumerate() {
        let drawn = Drawn {
            scene,
            results,
            marks: &marks,
            face,
        };
        let (panels, page) =
            drawn.with_picture(|picture| (plots::panels(picture), plots::page(picture)));
        let named = |name: &str| format!("{name}{ending}");
        for (name, panel) in panels {
            drawings.push((named(name), panel, 1280));
        }
        if face == 0 {
            drawings.push((ERROR.to_owned(), error_page(&drawn), PAGE_WIDTH));
            drawings.push((STRESS.to_owned(), stress_page(&drawn), PAGE_WIDTH));
        }
        drawings.push((named(OVERVIEW), page, PAGE_WIDTH));
    }
    let stamp = SolvedRun::new(scene, results).stamp();
    let stamped = drawings.into_iter().map(|(name, picture, width)| {
        let picture = picture.stamped(stamp.as_deref());
        (name, picture, width)
    });
    folder.save(stamped)
}

/// What holds and loads the body where its results are: at the end of the last increment that was solved.
pub(super) fn marks_of(scene: &Scene, results: &Results) -> Vec<BodyMark> {
    let last = results.increments.last();
    let then = last.map_or_else(|| scene.at_end(), |last| scene.at_increment(last.increment));
    then.map_or_else(|_| Vec::new(), |scene| body_marks(&scene, results.mesh()))
}

/// The page of the estimated error as SVG.
pub(super) fn error_page(drawn: &Drawn<'_>) -> Picture {
    let (mesh, report) = (drawn.results.mesh(), &drawn.results.report);
    let density = error_density(mesh, report, mesh.coordinates.len());
    drawn.body_figure(BodyField {
        title: "Estimated discretisation error per volume over its mean",
        symbol: "log10, 0: the mean",
        dimension: Dimension::Number,
        values: &density.iter().map(|v| v.log10()).collect::<Vec<_>>(),
    })
}

/// The page of the von Mises stress as SVG; where materials meet, of the larger one.
pub(super) fn stress_page(drawn: &Drawn<'_>) -> Picture {
    let nodes = MaterialNodes::new(drawn.results.mesh());
    drawn.body_figure(BodyField {
        title: "Von Mises stress at the nodes",
        symbol: "von Mises",
        dimension: Dimension::STRESS,
        values: &nodes.largest(&drawn.results.report.von_mises),
    })
}

/// Squared error per volume around each node over that of the whole body, its root; NaN for the `n_points`
/// beyond the mesh, which are no corners.
pub(super) fn error_density(mesh: &Mesh, report: &ContactReport, n_points: usize) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]; n_points];
    let mut whole = [0.0; 2];
    for (nodes, error) in mesh
        .tetrahedra
        .iter()
        .zip(&report.discretisation_error.indicator)
    {
        let share = [error * error, tetrahedron_volume(&mesh.corners(nodes))];
        let add = |sum: &mut [f64; 2]| *sum = [sum[0] + share[0], sum[1] + share[1]];
        nodes.iter().for_each(|node| add(&mut sums[*node]));
        add(&mut whole);
    }
    let density = |[error, volume]: [f64; 2]| (error / volume).sqrt();
    sums.into_iter()
        .map(|sum| density(sum) / density(whole))
        .collect()
}

/// The results of a scene with the contact face that is looked at.
#[derive(Clone, Copy)]
pub(super) struct Drawn<'a> {
    pub(super) scene: &'a Scene,
    pub(super) results: &'a Results,
    /// What holds and loads the body.
    pub(super) marks: &'a [BodyMark],
    /// The number of the face, in the order of the multipliers.
    pub(super) face: usize,
}

impl Drawn<'_> {
    fn frame(&self) -> Option<&ContactFrame> {
        self.results.interface().map(|interface| &interface.frame)
    }

    /// The page of all panels as SVG.
    pub(super) fn page(&self) -> Picture {
        self.with_picture(plots::page)
    }

    /// A field of the nodes on the boundary of the body.
    fn body_figure(&self, field: BodyField<'_>) -> Picture {
        let mesh = self.results.mesh();
        let n_faces = mesh.contact.as_ref().map_or(0, |it| it.faces.len());
        let n_bodies = mesh.bodies.len();
        self.with_picture(|picture| {
            let sides = match (n_faces, n_bodies) {
                (0, _) => ["from above", "from below"],
                (1, 0) if picture.is_contact_above() => {
                    ["contact face in front", "contact face behind"]
                }
                (1, 0) => ["contact face behind", "contact face in front"],
                _ => ["from one side", "from the opposite side"],
            };
            let mut values = field.values.to_vec();
            values.resize(picture.coordinates.len(), f64::NAN);
            let field = BodyField {
                values: &values,
                ..field
            };
            plots::body_figure(picture, &field, sides)
        })
    }

    /// Whether what lies opposite, an obstacle or any of the bodies, is curved or not touched at first.
    fn is_to_scale(&self, obstacle: Option<&DrawnObstacle>) -> bool {
        let surface = self.results.mesh().contact.as_ref();
        let is_of_bodies = surface.is_some_and(|surface| surface.opposite.is_some());
        let faces = self.frame().map_or(&[][..], |frame| &frame.references);
        let faces = if is_of_bodies {
            faces
        } else {
            faces.get(self.face..=self.face).unwrap_or_default()
        };
        let apart = |gap: &[f64; 3]| *gap != [0.0; 3];
        faces.iter().any(|face| !face.is_flat)
            || is_of_bodies && surface.is_some_and(|it| it.clearance.iter().any(|gap| *gap > 0.0))
            || obstacle.is_some_and(|shape| shape.gaps.iter().any(apart))
    }

    /// Title of the scene, with the name of the face where there are several.
    fn title(&self, features: &[ContactFeatures]) -> String {
        let title = self.scene.shown_title();
        match features {
            [] | [_] => title,
            several => format!("{title}: {}", escape_control(&several[self.face].name)),
        }
    }

    /// Lends the arrays of the figures.
    fn with_picture<T>(&self, draw: impl FnOnce(&ContactPicture<'_>) -> T) -> T {
        let (mesh, report) = (self.results.mesh(), &self.results.report);
        let features = self.scene.contact_features();
        let surface = mesh.contact.as_ref();
        let face = surface.and_then(|surface| Some((surface, surface.faces.get(self.face)?)));
        let cells = ContactCells::new(mesh, face);
        let panes = face.map_or(0..0, |(_, face)| face.panes.clone());
        let states = &report.panes[panes.clone()];
        let displacement = cells.interpolate(&report.displacement);
        let pressure = cells.of_cells(states, &f64::NAN, |p| 0.0 - p.normal_stress);
        let law = features
            .get(self.face)
            .and_then(|has| has.friction.as_ref());
        let kind = law.map(|law| kind(&law.bound));
        let given = kind == Some(FrictionKind::Plain);
        let friction = states.iter().map(|pane| pane_friction(pane, given));
        let friction: Option<Vec<_>> = friction.collect();
        let friction = friction.filter(|panes| !panes.is_empty());
        let mut friction = friction.map(|panes| cells.of_cells(&panes, &NO_MULTIPLIER, |p| *p));
        let reference = self
            .frame()
            .and_then(|frame| frame.references.get(self.face));
        let [axis_1, axis_2] =
            reference.map_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], |frame| frame.axes);
        // A mean normal that leans a little would shift the numbers on the axes by its part of the height.
        let [drawn_1, drawn_2] = match [axis_1, axis_2].map(nearest_axis) {
            [Some(first), Some(second)] => [first, second],
            _ => [axis_1, axis_2],
        };
        if let (Some(frame), Some(surface), Some(friction)) = (self.frame(), surface, &mut friction)
        {
            for (state, pane) in friction.iter_mut().zip(panes) {
                state.turn = frame.mean_turn(surface, pane);
            }
        }
        let obstacle = face.map(|(surface, face)| {
            let tools = (self.scene, &report.tools[..]);
            obstacle_beside(mesh, surface, from_ref(face), tools)
        });
        let obstacle = obstacle.filter(|shape| !shape.points.is_empty());
        draw(&ContactPicture {
            title: &self.title(&features),
            units: self.scene.units,
            coordinates: &cells.coordinates,
            displacement: &displacement,
            boundary_triangles: &mesh.facets,
            bodies: &nodes_of_bodies(mesh),
            boundary_face: &mesh.facet_face,
            contact_triangles: &cells.triangles,
            contact_triangle_pane: &cells.pane,
            is_to_scale: self.is_to_scale(obstacle.as_ref()),
            normal: reference.map_or([0.0, 0.0, -1.0], |frame| frame.normal),
            obstacle: obstacle.as_ref(),
            marks: self.marks,
            axis_1: drawn_1,
            axis_2: drawn_2,
            pressure: &pressure,
            friction: kind.zip(friction.as_deref()),
        })
    }
}

/// The nodes of each of several bodies.
fn nodes_of_bodies(mesh: &Mesh) -> Vec<Range<usize>> {
    let bodies = mesh.bodies.iter();
    bodies.map(|body| body.nodes.clone()).collect()
}

/// The coordinate axis that a direction goes along but for ten degrees.
fn nearest_axis(direction: [f64; 3]) -> Option<[f64; 3]> {
    let along = direction.iter().position(|part| part.abs() > 0.985)?;
    let mut axis = [0.0; 3];
    axis[along] = direction[along].signum();
    Some(axis)
}

/// What is drawn where a held node carries no multiplier.
pub(super) const NO_MULTIPLIER: DrawnFriction = DrawnFriction {
    scaled_tangential: f64::NAN,
    semi_axes: [f64::NAN; 2],
    stress: [f64::NAN; 2],
    turn: 0.0,
    zone: plots::DrawnZone::Open,
};

/// How a law is drawn.
fn kind(bound: &SlipBound) -> FrictionKind {
    match (bound.is_pressure(), bound.follows_pressure()) {
        (true, _) => FrictionKind::OverPressure,
        (false, true) => FrictionKind::OverBound,
        (false, false) => FrictionKind::Plain,
    }
}

/// Friction of one pane: with Coulomb's law stresses over the slip bound, with a given bound stresses; `None` without
/// friction.
fn pane_friction(pane: &PaneState, given: bool) -> Option<DrawnFriction> {
    let friction = pane.friction?;
    let stress = friction.stress;
    let coulomb = friction.coulomb.filter(|_| !given);
    let (semi_axes, scaled_tangential, stress) = match coulomb {
        Some(coulomb) => (
            coulomb.coefficients,
            coulomb.scaled_stress,
            stress.map(|t| t / coulomb.slip_bound),
        ),
        None => {
            let [a, b] = friction.semi_axes;
            let over = (stress[0] / a).hypot(stress[1] / b);
            (friction.semi_axes, over, stress)
        }
    };
    Some(DrawnFriction {
        scaled_tangential,
        semi_axes,
        stress: match (pane.zone, coulomb) {
            (Zone::Open, Some(_)) => [0.0; 2],
            _ => stress,
        },
        turn: 0.0,
        zone: match pane.zone {
            Zone::Open => plots::DrawnZone::Open,
            Zone::Stick => plots::DrawnZone::Stick,
            Zone::Slip => plots::DrawnZone::Slip,
        },
    })
}

/// The picture of a mesh file.
pub(super) const MESH: &str = "mesh";

/// Draws the faces of a mesh by their names, as SVG and PNG; returns the files.
pub fn draw_mesh(
    folder: &PictureFolder,
    title: &str,
    inspection: &MeshInspection,
) -> Result<Vec<PathBuf>, StageError> {
    let mesh = &inspection.mesh;
    let names: Vec<String> = mesh
        .face_names
        .iter()
        .map(|name| escape_control(name))
        .collect();
    let page = mesh_page(&MeshPicture {
        title: &escape_control(title),
        coordinates: &mesh.coordinates,
        triangles: &mesh.facets,
        bodies: &nodes_of_bodies(mesh),
        face: &mesh.facet_face,
        names: &names,
    });
    folder.save([(MESH, page, PAGE_WIDTH)])
}
