//! Where groups are kept: in the run file, beside it, or shared by digest.

use hdf5_metno as hdf5;

use super::linked::{self, Linked};
use crate::error::StoreError;
use crate::layout::Group;
use crate::place::{AtPlace, Place};
use crate::reader::Reader;

/// Carries everything but the replaced groups over to a new file.
///
/// With `embed`, groups in files of their own are copied into the new file too.
///
/// # Errors
/// `ForeignLink` for a link that this program did not make; `Damaged` where the groups cannot be listed; `Hdf5` if copying
/// fails.
pub(crate) fn carry_over(
    previous: &Reader,
    replaced: &[Group],
    embed: bool,
    file: &hdf5::File,
) -> Result<(), StoreError> {
    let home = &previous.home;
    let place = Place::new(&home.path, "/");
    let names = home.file.member_names();
    for name in names.map_err(|error| place.unlisted(&error))? {
        let group = previous.layout.groups().find(|group| group.name() == name);
        if group.is_some_and(|group| replaced.contains(&group)) {
            continue;
        }
        let linked = group.and_then(|group| Some((group, previous.linked.get(&group)?)));
        match linked {
            Some((group, Linked { name, volume })) => match (name, volume) {
                (_, Ok(volume)) if embed => copy(&volume.file, place, group.name(), file)?,
                (Some(name), _) => linked::join(file, place, group, name)?,
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

/// Copies one group of another file as it is.
///
/// # Errors
/// `Hdf5` if copying fails.
pub(crate) fn take_over(from: &Reader, group: Group, file: &hdf5::File) -> Result<(), StoreError> {
    let volume = from.volume(group)?;
    let place = Place::new(&volume.path, "/");
    copy(&volume.file, place, group.name(), file)
}

/// Copies a group; links inside it stay links.
fn copy(
    from: &hdf5::File,
    place: Place<'_>,
    name: &str,
    to: &hdf5::File,
) -> Result<(), StoreError> {
    let place = place.beside(name);
    let info = from.loc_info_by_name(name).at(place, "find the group")?;
    let object = from.open_by_token(info.token).at(place, "open the group")?;
    object.copy_to(to, name).at(place, "copy the group")
}
