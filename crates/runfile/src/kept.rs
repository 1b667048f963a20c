//! What a change leaves as it was: groups are copied, stages in files of their own are linked again.

use hdf5_metno as hdf5;

use super::error::StoreError;
use super::layout::Stage;
use super::linked::{self, Linked};
use super::place::{AtPlace, Place};
use super::reader::Reader;

/// Carries everything but the replaced stages over to a new file.
///
/// With `embed`, stages in files of their own are copied into the new file too.
///
/// # Errors
/// `ForeignLink` for a link that this program did not make; `Hdf5` if copying fails.
pub(super) fn carry_over(
    previous: &Reader,
    replaced: &[Stage],
    embed: bool,
    file: &hdf5::File,
) -> Result<(), StoreError> {
    let home = &previous.home;
    let place = Place {
        file: &home.path,
        dataset: "/",
    };
    for name in home.file.member_names().at(place, "list the groups")? {
        let stage = Stage::ALL.into_iter().find(|stage| stage.group() == name);
        if stage.is_some_and(|stage| replaced.contains(&stage)) {
            continue;
        }
        let linked = stage.and_then(|stage| Some((stage, previous.linked.get(&stage)?)));
        match linked {
            Some((stage, Linked { name, volume })) => match (name, volume) {
                (_, Ok(volume)) if embed => copy(&volume.file, place, stage.group(), file)?,
                (Some(name), _) => linked::join(file, place, stage, name)?,
                // Nothing can be found by it again.
                (None, _) => {}
            },
            None => match home.link_on_the_way(&format!("/{name}")) {
                None => copy(&home.file, place, &name, file)?,
                Some(link) => {
                    return Err(StoreError::ForeignLink {
                        file: home.path.clone(),
                        link: link.into(),
                    });
                }
            },
        }
    }
    Ok(())
}

/// Copies a group; links inside it stay links.
fn copy(
    from: &hdf5::File,
    place: Place<'_>,
    name: &str,
    to: &hdf5::File,
) -> Result<(), StoreError> {
    let place = Place {
        dataset: name,
        ..place
    };
    let info = from.loc_info_by_name(name).at(place, "find the group")?;
    let object = from.open_by_token(info.token).at(place, "open the group")?;
    object.copy_to(to, name).at(place, "copy the group")
}
