//! The folder of a command's pictures, looked at before anything is stored.

use std::path::{Path, PathBuf};

use plots::{self, Chart, Picture};

use super::sweep;
use crate::{
    output::{self, Folder, Inputs, OutputError, OutputFile, OutputKind},
    pipeline::StageError,
};

/// Width of charts in pixels.
pub(super) const CHART_WIDTH: u32 = 1720;

/// What is drawn.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Drawing {
    /// The panels of a run file, one set with each of these endings.
    Run(Vec<String>),
    /// The diagrams of the studies of accuracy.
    Accuracy,
    /// The diagrams of paths of solutions.
    Branches,
    /// The charts of a sweep.
    Sweep,
    /// The laws of friction of the contact faces, one with each of these endings.
    Law(Vec<String>),
    /// A mesh file.
    Mesh,
}

impl Drawing {
    /// The names of all pictures it may have.
    fn names(&self) -> Vec<String> {
        let names = match self {
            Self::Run(endings) => return super::picture::names(endings),
            Self::Accuracy => super::charts::ACCURACY.to_vec(),
            Self::Branches => super::charts::BRANCHES.to_vec(),
            Self::Sweep => sweep::columns().collect(),
            Self::Mesh => vec![super::picture::MESH],
            Self::Law(endings) => return super::law::names(endings),
        };
        names.into_iter().map(str::to_owned).collect()
    }
}

/// The folder in the current directory in which pictures of a file that is only read go by default.
pub fn folder_here(file: &Path, ending: &str) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    PathBuf::from(format!("{stem}-{ending}"))
}

/// A folder that takes the pictures of a command.
#[derive(Debug)]
pub struct PictureFolder {
    folder: Folder,
    inputs: Inputs,
}

impl PictureFolder {
    /// Makes the folder unless it is there, and refuses it if a picture would replace one of the inputs or a file
    /// that is no such picture. A folder made here vanishes again if nothing is drawn.
    ///
    /// # Errors
    /// [`OutputError`], with nothing changed.
    pub fn claim(path: &Path, drawing: Drawing, inputs: Inputs) -> Result<Self, OutputError> {
        let folder = Folder::make(path)?;
        for name in drawing.names() {
            for (file, kind) in files(path, &name) {
                output::admit(&file, kind, &inputs)?;
            }
        }
        Ok(Self { folder, inputs })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Saves drawings of some width in pixels by their names, as SVG and PNG; returns the files.
    pub(super) fn save(
        &self,
        drawings: impl IntoIterator<Item = (impl AsRef<str>, Picture, u32)>,
    ) -> Result<Vec<PathBuf>, StageError> {
        let mut outputs = Vec::new();
        for (name, figure, width) in drawings {
            let [(svg_file, svg_kind), (png_file, png_kind)] = files(self.path(), name.as_ref());
            let png = figure.png(width).map_err(|source| StageError::Figure {
                file: png_file.clone(),
                source,
            })?;
            outputs.push(OutputFile {
                path: svg_file,
                kind: svg_kind,
                bytes: figure.svg().into_bytes(),
            });
            outputs.push(OutputFile {
                path: png_file,
                kind: png_kind,
                bytes: png,
            });
        }
        output::write(&outputs, &self.inputs)?;
        Ok(outputs.into_iter().map(|output| output.path).collect())
    }

    /// Saves charts by their names; returns the files.
    pub(super) fn save_charts(
        &self,
        charts: impl IntoIterator<Item = (impl AsRef<str>, Chart)>,
    ) -> Result<Vec<PathBuf>, StageError> {
        let drawn = charts.into_iter();
        self.save(drawn.map(|(name, chart)| (name, chart.figure(), CHART_WIDTH)))
    }
}

/// The two files of a picture.
fn files(folder: &Path, name: &str) -> [(PathBuf, OutputKind); 2] {
    [("svg", OutputKind::Svg), ("png", OutputKind::Png)]
        .map(|(ending, kind)| (folder.join(format!("{name}.{ending}")), kind))
}
