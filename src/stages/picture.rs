use std::{
    fs,
    path::{Path, PathBuf},
};

use super::StageError;
use crate::{
    figures::{self, ContactPicture, PaneFriction},
    mesh::Mesh,
    post::{ContactReport, Zone},
    scene::Scene,
};

/// Width of the six-panel page and of a single panel in pixels.
const PAGE_WIDTH: u32 = 1920;
const PANEL_WIDTH: u32 = 1280;

/// The folder beside a run file in which its pictures go by default.
#[must_use]
pub fn figures_folder(run_file: &Path) -> PathBuf {
    let stem = run_file.file_stem().unwrap_or_default().to_string_lossy();
    run_file.with_file_name(format!("{stem}-figures"))
}

/// Draws the six panels of HKL Fig. 5 and the page of all six, as SVG and PNG; returns the files.
///
/// # Errors
/// A folder that cannot be written.
pub fn draw(
    folder: &Path,
    scene: &Scene,
    mesh: &Mesh,
    report: &ContactReport,
) -> Result<Vec<PathBuf>, StageError> {
    let frame = scene.contact.frame();
    let contact_triangles: Vec<[usize; 3]> = mesh
        .contact
        .facets
        .iter()
        .map(|&f| mesh.facets[f])
        .collect();
    let normal_stress: Vec<f64> = report.panes.iter().map(|p| p.normal_stress).collect();
    let friction = pane_friction(report);
    let picture = ContactPicture {
        title: &scene.title,
        coordinates: &mesh.coordinates,
        displacement: &report.displacement,
        boundary_triangles: &mesh.facets,
        contact_triangles: &contact_triangles,
        contact_triangle_pane: &mesh.contact.facet_pane,
        normal: frame.normal,
        axis_1: frame.axis_1,
        axis_2: frame.axis_2,
        normal_stress: &normal_stress,
        friction: Some(&friction),
    };
    let figure = |source| StageError::Figure {
        file: folder.to_owned(),
        source,
    };
    fs::create_dir_all(folder).map_err(|source| StageError::Write {
        file: folder.to_owned(),
        source,
    })?;
    let mut files = Vec::new();
    for panel in figures::panels(&picture).map_err(figure)? {
        files.extend(save(folder, panel.name, &panel.svg, PANEL_WIDTH)?);
    }
    let page = figures::page(&picture).map_err(figure)?;
    files.extend(save(folder, "figure5", &page, PAGE_WIDTH)?);
    Ok(files)
}

fn pane_friction(report: &ContactReport) -> Vec<PaneFriction> {
    report
        .panes
        .iter()
        .map(|pane| PaneFriction {
            scaled_tangential: pane.scaled_tangential_stress,
            coefficients: pane.friction,
            tangential_over_normal: match pane.zone {
                Zone::Open => [0.0; 2],
                _ => pane
                    .tangential_stress
                    .map(|stress| stress / -pane.normal_stress),
            },
            zone: match pane.zone {
                Zone::Open => figures::Zone::Open,
                Zone::Stick => figures::Zone::Stick,
                Zone::Slip => figures::Zone::Slip,
            },
        })
        .collect()
}

fn save(folder: &Path, name: &str, svg: &str, width: u32) -> Result<[PathBuf; 2], StageError> {
    let files = [
        folder.join(format!("{name}.svg")),
        folder.join(format!("{name}.png")),
    ];
    let png = figures::rasterise(svg, width).map_err(|source| StageError::Figure {
        file: files[1].clone(),
        source,
    })?;
    for (file, bytes) in files.iter().zip([svg.as_bytes(), &png]) {
        fs::write(file, bytes).map_err(|source| StageError::Write {
            file: file.clone(),
            source,
        })?;
    }
    Ok(files)
}
