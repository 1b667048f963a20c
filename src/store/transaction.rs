//! A change of a run file: written beside it, then put in its place in one step, or not at all.

use std::fs::{self, File};
use std::io;

use std::path::Path;

use hdf5_metno as hdf5;

use super::error::{LayoutError, StoreError};
use super::extents::Sizes;
use super::header;
use super::layout::Stage;
use super::lock::RunFile;
use super::place::{AtFile, AtPlace, Place};
use super::reader::Reader;
use super::signals::Temporary;
use super::table::Layout;
use super::writer::StageWriter;

/// A new state of a run file, in the hidden file `.NAME.part`; dropping it leaves the run file as it was.
///
/// New groups are written to an empty file and the groups that stay are copied at the commit, object by object:
/// the file never holds dead space, however often a stage runs again.
#[derive(Debug)]
pub struct Transaction {
    // Declared before the temporary, so that HDF5 lets go of the file before it is removed.
    file: hdf5::File,
    previous: Option<Reader>,
    replaced: Vec<Stage>,
    unfinished: Option<Stage>,
    sizes: Sizes,
    layout: Layout,
    target: std::path::PathBuf,
    folder: std::path::PathBuf,
    temporary: Temporary,
}

impl Transaction {
    /// Begins a change of a locked run file.
    ///
    /// # Errors
    /// Those of [`Reader::open`] for the present file, `Io` if it is write-protected, `Hdf5` if the temporary file
    /// cannot be created.
    pub fn begin(run_file: &RunFile) -> Result<Self, StoreError> {
        let previous = match Reader::open(&run_file.path, run_file.layout) {
            Ok(previous) => Some(previous),
            Err(StoreError::NotFound { .. }) => None,
            Err(error) => return Err(error),
        };
        if let Some(previous) = &previous {
            let metadata =
                fs::metadata(previous.path()).at_file(previous.path(), "look at the file")?;
            if metadata.permissions().readonly() {
                let refused = Err(io::Error::from(io::ErrorKind::PermissionDenied));
                return refused.at_file(previous.path(), "replace a write-protected file");
            }
        }
        let temporary = Temporary::new(run_file.temporary.clone());
        let file = header::create(temporary.path(), &run_file.layout)?;
        Ok(Transaction {
            file,
            previous,
            replaced: Vec::new(),
            unfinished: None,
            sizes: Sizes::default(),
            layout: run_file.layout,
            target: run_file.path.clone(),
            folder: run_file.folder.clone(),
            temporary,
        })
    }

    /// The state before this change, to read upstream stages from; `None` for a new file.
    pub fn previous(&self) -> Option<&Reader> {
        self.previous.as_ref()
    }

    /// Begins to write a stage in place of what the file held of it.
    ///
    /// Symbolic sizes must agree with the upstream stages that stay and with the stages already written.
    ///
    /// # Errors
    /// `Internal` if the stage was written before or another one is unfinished.
    pub fn stage(&mut self, stage: Stage) -> Result<StageWriter<'_>, StoreError> {
        if let Some(stage) = self.unfinished {
            return Err(LayoutError::NotFinished { stage }.into());
        }
        if self.file.link_exists(stage.group()) {
            return Err(LayoutError::Twice {
                path: stage.group().into(),
            }
            .into());
        }
        self.remove(stage);
        self.learn_upstream_sizes(stage);
        let place = Place {
            file: &self.target,
            dataset: stage.group(),
        };
        let group = self
            .file
            .create_group_builder()
            .obj_track_times(false)
            .create(stage.group())
            .at(place, "create the group")?;
        self.unfinished = Some(stage);
        Ok(StageWriter::new(self, stage, group))
    }

    /// Leaves a stage out of the new state.
    pub fn remove(&mut self, stage: Stage) {
        if !self.replaced.contains(&stage) {
            self.replaced.push(stage);
        }
    }

    /// Puts the new state in the place of the old one, safe against loss of power.
    ///
    /// # Errors
    /// `Internal` if a stage is unfinished; `Hdf5` or `Io` if copying, closing, syncing or renaming fails, with the
    /// old state kept.
    pub fn commit(self) -> Result<(), StoreError> {
        if let Some(stage) = self.unfinished {
            return Err(LayoutError::NotFinished { stage }.into());
        }
        self.copy_kept_groups()?;
        let Transaction {
            file,
            previous,
            temporary,
            target,
            folder,
            ..
        } = self;
        file.close().at(
            Place {
                file: temporary.path(),
                dataset: "/",
            },
            "close the temporary file",
        )?;
        if let Some(previous) = previous {
            let permissions = fs::metadata(&target)
                .at_file(&target, "look at the file")?
                .permissions();
            fs::set_permissions(temporary.path(), permissions)
                .at_file(&target, "keep the permissions")?;
            drop(previous);
        }
        let written =
            File::open(temporary.path()).at_file(temporary.path(), "open the temporary file")?;
        written
            .sync_all()
            .at_file(temporary.path(), "sync the temporary file")?;
        temporary
            .publish(&target)
            .at_file(&target, "rename the temporary file")?;
        File::open(&folder)
            .and_then(|folder| folder.sync_all())
            .at_file(&folder, "sync the folder")
    }

    pub(super) fn layout(&self) -> Layout {
        self.layout
    }

    pub(super) fn path(&self) -> &Path {
        &self.target
    }

    pub(super) fn sizes_mut(&mut self) -> &mut Sizes {
        &mut self.sizes
    }

    pub(super) fn stage_finished(&mut self) {
        self.unfinished = None;
    }

    fn learn_upstream_sizes(&mut self, stage: Stage) {
        let Some(previous) = &self.previous else {
            return;
        };
        let kept: Vec<_> = Stage::ALL
            .into_iter()
            .filter(|other| *other < stage && !self.replaced.contains(other))
            .collect();
        self.sizes.adopt(previous.sizes_of(&kept));
    }

    fn copy_kept_groups(&self) -> Result<(), StoreError> {
        let Some(previous) = &self.previous else {
            return Ok(());
        };
        let place = Place {
            file: previous.path(),
            dataset: "/",
        };
        for name in previous.file.member_names().at(place, "list the groups")? {
            if self.replaced.iter().any(|stage| stage.group() == name) {
                continue;
            }
            let place = Place {
                dataset: &name,
                ..place
            };
            let info = previous
                .file
                .loc_info_by_name(&name)
                .at(place, "find the group")?;
            let object = previous
                .file
                .open_by_token(info.token)
                .at(place, "open the group")?;
            object
                .copy_to(&self.file, &name)
                .at(place, "copy the group")?;
        }
        Ok(())
    }
}
