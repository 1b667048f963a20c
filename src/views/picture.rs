//! The six panels of a run file, and where its discretisation error sits, as SVG and PNG.

use std::{
    fs,
    path::{Path, PathBuf},
};

use contact3d::{
    contact::ContactFrame,
    mesh::{Mesh, tetrahedron_volume},
    post::{ContactReport, PaneState, Zone},
    scene::{FrictionModel, ModelFeatures, Scene},
};
use plots::{ContactPicture, Figure, FigureError, FrictionKind, PaneFriction};

use super::{PictureFolder, contact_cells::ContactCells, history_charts};
use crate::pipeline::{Results, StageError};

/// Width of the six-panel page and of a single panel in pixels.
pub(super) const PAGE_WIDTH: u32 = 1920;
const PANEL_WIDTH: u32 = 1280;

/// The folder beside a run file in which its pictures go by default.
#[must_use]
pub fn figures_folder(run_file: &Path) -> PathBuf {
    let stem = run_file.file_stem().unwrap_or_default().to_string_lossy();
    run_file.with_file_name(format!("{stem}-figures"))
}

/// The picture of where the discretisation error sits.
pub(super) const ERROR: &str = "discretisation_error";

/// The picture that is drawn last.
pub(super) const LAST: &str = "figure5";

/// Whether all pictures of a run file are in a folder and no older than it.
#[must_use]
pub fn are_drawn(folder: &Path, run_file: &Path) -> bool {
    let modified = |file: &Path| fs::metadata(file).and_then(|metadata| metadata.modified());
    let last = modified(&folder.join(format!("{LAST}.png")));
    matches!((last, modified(run_file)), (Ok(drawn), Ok(stored)) if drawn >= stored)
}

/// Draws the six panels of HKL Fig. 5, the page of all six, where the discretisation error sits and the charts of a load history,
/// as SVG and PNG; returns the files.
///
/// # Errors
/// A folder that cannot be written.
pub fn draw_run(
    folder: &PictureFolder,
    scene: &Scene,
    results: &Results,
) -> Result<Vec<PathBuf>, StageError> {
    let figure = |source| StageError::Figure {
        file: folder.path().to_owned(),
        source,
    };
    let frame = results.interface().map(|interface| &interface.frame);
    let (mesh, report) = (results.mesh(), results.report());
    let drawn = with_picture(scene, mesh, frame, report, |picture| {
        let density = error_density(mesh, report, picture.coordinates.len());
        let error = plots::error_figure(picture, &density)?;
        Ok((plots::panels(picture)?, error, plots::page(picture)?))
    });
    let (panels, error, page) = drawn.map_err(figure)?;
    let panels = panels.into_iter();
    let panels = panels.map(|panel| (panel.name, panel.figure, PANEL_WIDTH));
    let mut files = history_charts::draw(folder, results.increments(), scene.units)?;
    files.extend(
        folder.save(panels.chain([(ERROR, error, PANEL_WIDTH), (LAST, page, PAGE_WIDTH)]))?,
    );
    Ok(files)
}

/// The page of the estimated error as SVG.
///
/// # Errors
/// [`FigureError`] for results that do not fit together.
pub(super) fn error_page(
    scene: &Scene,
    mesh: &Mesh,
    frame: Option<&ContactFrame>,
    report: &ContactReport,
) -> Result<Figure, FigureError> {
    with_picture(scene, mesh, frame, report, |picture| {
        let density = error_density(mesh, report, picture.coordinates.len());
        plots::error_figure(picture, &density)
    })
}

/// Squared error per volume around each node over that of the whole body, its root; NaN for the `n_points`
/// beyond the mesh, which are no corners.
fn error_density(mesh: &Mesh, report: &ContactReport, n_points: usize) -> Vec<f64> {
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

/// The page of all panels as SVG.
///
/// # Errors
/// [`FigureError`] for results that do not fit together.
pub(super) fn page(
    scene: &Scene,
    mesh: &Mesh,
    frame: Option<&ContactFrame>,
    report: &ContactReport,
) -> Result<Figure, FigureError> {
    with_picture(scene, mesh, frame, report, plots::page)
}

/// Lends the arrays of the figures.
fn with_picture<T>(
    scene: &Scene,
    mesh: &Mesh,
    frame: Option<&ContactFrame>,
    report: &ContactReport,
    draw: impl FnOnce(&ContactPicture<'_>) -> T,
) -> T {
    let cells = ContactCells::new(mesh);
    let displacement = cells.interpolate(&report.displacement);
    let normal_stress = cells.of_cells(&report.panes, &f64::NAN, |p| p.normal_stress);
    let kind = ModelFeatures::of(scene).friction().and_then(kind);
    let friction: Option<Vec<_>> = report.panes.iter().map(pane_friction).collect();
    let friction = friction.filter(|panes| !panes.is_empty());
    let mut friction = friction.map(|panes| cells.of_cells(&panes, &NO_MULTIPLIER, |p| *p));
    let [axis_1, axis_2] = frame.map_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], |f| f.reference);
    if let (Some(frame), Some(surface), Some(friction)) = (frame, &mesh.contact, &mut friction) {
        for (pane, state) in friction.iter_mut().enumerate().take(surface.n_panes()) {
            state.turn = frame.mean_turn(surface, pane);
        }
    }
    draw(&ContactPicture {
        title: &scene.shown_title(),
        units: scene.units,
        coordinates: &cells.coordinates,
        displacement: &displacement,
        boundary_triangles: &mesh.facets,
        contact_triangles: &cells.triangles,
        contact_triangle_pane: &cells.pane,
        normal: frame.map_or([0.0, 0.0, -1.0], |f| f.reference_normal),
        axis_1,
        axis_2,
        normal_stress: &normal_stress,
        friction: kind.zip(friction.as_deref()),
    })
}

/// What is drawn where a held node carries no multiplier.
const NO_MULTIPLIER: PaneFriction = PaneFriction {
    scaled_tangential: f64::NAN,
    semi_axes: [f64::NAN; 2],
    stress: [f64::NAN; 2],
    turn: 0.0,
    zone: plots::Zone::Open,
};

/// How a law is drawn; `None` without friction.
fn kind(model: &FrictionModel) -> Option<FrictionKind> {
    match model {
        FrictionModel::Frictionless => None,
        FrictionModel::Tresca { .. } => Some(FrictionKind::Tresca),
        FrictionModel::Coulomb { .. } => Some(FrictionKind::Coulomb),
        FrictionModel::CappedCoulomb { .. } => Some(FrictionKind::CappedCoulomb),
    }
}

/// Friction of one pane: with Coulomb's law stresses over the slip bound; `None` without friction.
fn pane_friction(pane: &PaneState) -> Option<PaneFriction> {
    let friction = pane.friction?;
    let stress = friction.stress;
    let (semi_axes, scaled_tangential, stress) = match friction.coulomb {
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
    Some(PaneFriction {
        scaled_tangential,
        semi_axes,
        stress: match pane.zone {
            Zone::Open => [0.0; 2],
            Zone::Stick | Zone::Slip => stress,
        },
        turn: 0.0,
        zone: match pane.zone {
            Zone::Open => plots::Zone::Open,
            Zone::Stick => plots::Zone::Stick,
            Zone::Slip => plots::Zone::Slip,
        },
    })
}
