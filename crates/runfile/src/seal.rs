//! Seals: digests over what no other digest covers, the attributes and the set of objects.
//!
//! The seal of a group covers the attributes of everything in it, the datasets that its own digest leaves out and the
//! labels of its axes; that of the root its attributes and the seals of its groups. Both are written at the commit, and
//! [`crate::Reader::problems`] compares them.

use blake3::Hasher;
use hdf5::types::{FixedAscii, TypeDescriptor, VarLenUnicode};
use hdf5::{IndexType, IterationOrder, LinkType};
use hdf5_metno as hdf5;

use crate::attribute::{has, read_text, write_text};
use crate::dimension::{TEXT_BYTES, is_scale};
use crate::error::{AtPlace, Place, StoreError};
use crate::layout::Group;
use crate::reader::Reader;
use crate::volume::Volume;

/// The attribute of a group and of the root that holds the seal.
pub(super) const SEAL: &str = "seal";

/// Where the root of a file is.
const ROOT: &str = "/";

/// No axis of ours has more entries with labels.
const MOST_LABELS: usize = 64;

/// What stands as the seal of a group or the root, and what it should be.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Seal {
    stored: Option<String>,
    found: String,
}

impl Seal {
    /// That of the group at a place, or of the root at `/`.
    fn of(file: &hdf5::File, place: Place<'_>) -> Result<Self, StoreError> {
        let object = file.group(place.dataset).at(place, "open the group")?;
        Self::of_object(&object, place)
    }

    fn of_object(object: &hdf5::Group, place: Place<'_>) -> Result<Self, StoreError> {
        let mut hasher = Hasher::new();
        if place.dataset == ROOT {
            add_root(&mut hasher, object, place)?;
        } else {
            add_group(&mut hasher, object, place)?;
        }
        let is_sealed = has(object, place, SEAL)?;
        let stored = is_sealed.then(|| read_text(object, place, SEAL));
        Ok(Self {
            stored: stored.transpose()?,
            found: hasher.finalize().to_hex().to_string(),
        })
    }

    /// Stores the seal of what has none yet.
    fn set(file: &hdf5::File, place: Place<'_>) -> Result<Self, StoreError> {
        let object = file.group(place.dataset).at(place, "open the group")?;
        let mut seal = Self::of_object(&object, place)?;
        if seal.stored.is_none() {
            write_text(&object, place, SEAL, &seal.found)?;
            seal.stored = Some(seal.found.clone());
        }
        Ok(seal)
    }

    fn same(&self, other: &Self, place: Place<'_>) -> Result<(), StoreError> {
        let in_one =
            |seal: &Self| format!("{} {}", seal.stored.as_deref().unwrap_or("-"), seal.found);
        place.same_digest(in_one(other), in_one(self))
    }
}

/// The seals of a file: those of the groups that it holds itself, and of its root.
#[derive(Debug)]
pub(super) struct Seals {
    groups: Vec<(Group, Seal)>,
    root: Seal,
}

impl Seals {
    /// Seals groups of a file that have no seals yet, which those that were copied have, and its root.
    pub(super) fn set(
        file: &hdf5::File,
        place: Place<'_>,
        groups: &[Group],
    ) -> Result<Self, StoreError> {
        let seal = |group: &Group| Ok((*group, Seal::set(file, place.beside(group.name()))?));
        Ok(Self {
            groups: groups.iter().map(seal).collect::<Result<_, StoreError>>()?,
            root: Seal::set(file, place.beside(ROOT))?,
        })
    }

    /// The groups that the file holds itself.
    pub(super) fn groups(&self) -> impl Iterator<Item = Group> + '_ {
        self.groups.iter().map(|(group, _)| *group)
    }

    /// Refuses a file that has other seals, or one that is broken and was not in the state before.
    ///
    /// # Errors
    /// `Altered`, `Hdf5` if reading fails.
    pub(super) fn require(
        &self,
        volume: &Volume,
        previous: Option<&Reader>,
    ) -> Result<(), StoreError> {
        let root = Place::new(&volume.path, ROOT);
        for (group, seal) in &self.groups {
            let place = root.beside(group.name());
            Seal::of(&volume.file, place)?.same(seal, place)?;
            if seal.stored.as_ref() != Some(&seal.found) {
                // What a copy lost was wrong before the file was closed.
                let before = match previous {
                    Some(previous) => Seal::of(&previous.volume(*group)?.file, place)?,
                    None => Seal {
                        found: seal.stored.clone().unwrap_or_default(),
                        ..seal.clone()
                    },
                };
                seal.same(&before, place)?;
            }
        }
        Seal::of(&volume.file, root)?.same(&self.root, root)
    }
}

impl Reader {
    /// What the seals of the roots give away: that of the run file, and those of the files that hold its groups.
    pub(super) fn root_problems(&self) -> Vec<StoreError> {
        let linked = self.linked.values();
        let volumes = linked.filter_map(|linked| linked.volume.as_ref().ok());
        let roots = [&self.home].into_iter().chain(volumes);
        let problem = |volume: &Volume| self.require_sound(volume, ROOT).err();
        roots.filter_map(problem).collect()
    }

    /// Refuses a group whose seal is broken, or missing where it must be.
    pub(super) fn refuse_unsealed(&self, group: Group) -> Result<(), StoreError> {
        let volume = self.volume(group)?;
        if volume.holds(&format!("/{group}")) {
            self.require_sound(volume, group.name())
        } else {
            Ok(())
        }
    }

    fn require_sound(&self, volume: &Volume, object: &str) -> Result<(), StoreError> {
        let place = Place::new(&volume.path, object);
        let seal = Seal::of(&volume.file, place)?;
        match seal.stored {
            None => Err(place.mismatch(format!("the attribute `{SEAL}`"), "none")),
            Some(stored) => place.same_digest(stored, seal.found),
        }
    }
}

/// The attributes of the root and, in the order of their names, the seals of its groups.
fn add_root(hasher: &mut Hasher, root: &hdf5::Group, place: Place<'_>) -> Result<(), StoreError> {
    add_attributes(hasher, root, place)?;
    for name in members(root, place)? {
        add_text(hasher, &name);
        let group = root.group(&name).at(place, "open the group")?;
        if has(&group, place, SEAL)? {
            add_text(hasher, &read_text(&group, place, SEAL)?);
        }
    }
    Ok(())
}

/// The attributes of a group and, in the order of their names, its members.
fn add_group(hasher: &mut Hasher, group: &hdf5::Group, place: Place<'_>) -> Result<(), StoreError> {
    add_attributes(hasher, group, place)?;
    for name in members(group, place)? {
        add_text(hasher, &name);
        if let Ok(dataset) = group.dataset(&name) {
            add_dataset(hasher, &dataset, place)?;
        } else if let Ok(inner) = group.group(&name) {
            add_group(hasher, &inner, place)?;
        }
    }
    Ok(())
}

fn add_dataset(
    hasher: &mut Hasher,
    dataset: &hdf5::Dataset,
    place: Place<'_>,
) -> Result<(), StoreError> {
    add_attributes(hasher, dataset, place)?;
    let shape = dataset.get_shape().at(place, "read the shape")?;
    for extent in &shape {
        hasher.update(&(*extent as u64).to_le_bytes());
    }
    let dtype = dataset.dtype().and_then(|dtype| dtype.to_descriptor());
    // The type first: to look for an attribute that is not there costs more.
    let has_labels = matches!(dtype, Ok(TypeDescriptor::VarLenUnicode)) && is_scale(dataset);
    if has_labels && shape.iter().product::<usize>() <= MOST_LABELS {
        let labels = dataset.read_raw::<VarLenUnicode>();
        for label in labels.at(place, "read the labels")? {
            add_text(hasher, &label);
        }
    }
    Ok(())
}

/// The names and values of all attributes but the seal itself. References, which every copy changes, count by their name.
pub(super) fn add_attributes(
    hasher: &mut Hasher,
    object: &hdf5::Location,
    place: Place<'_>,
) -> Result<(), StoreError> {
    let names = object.attr_names().at(place, "list the attributes")?;
    for name in sorted(names).iter().filter(|name| *name != SEAL) {
        add_text(hasher, name);
        let attribute = object.attr(name).at(place, "open an attribute")?;
        add_value(hasher, &attribute).at(place, "read an attribute")?;
    }
    Ok(())
}

fn add_value(hasher: &mut Hasher, attribute: &hdf5::Attribute) -> hdf5::Result<()> {
    for extent in attribute.shape() {
        hasher.update(&(extent as u64).to_le_bytes());
    }
    match attribute.dtype()?.to_descriptor() {
        Ok(TypeDescriptor::VarLenUnicode | TypeDescriptor::VarLenAscii) => {
            for text in attribute.read_raw::<VarLenUnicode>()? {
                add_text(hasher, &text);
            }
        }
        Ok(TypeDescriptor::Float(_)) => {
            for value in attribute.read_raw::<f64>()? {
                hasher.update(&value.to_le_bytes());
            }
        }
        Ok(TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_)) => {
            for value in attribute.read_raw::<i64>()? {
                hasher.update(&value.to_le_bytes());
            }
        }
        // Texts that end with a zero have no descriptor.
        Ok(TypeDescriptor::FixedAscii(_)) | Err(_) => {
            let text = attribute.read_scalar::<FixedAscii<TEXT_BYTES>>()?;
            add_text(hasher, &text);
        }
        Ok(_) => {}
    }
    Ok(())
}

fn add_text(hasher: &mut Hasher, text: &str) {
    hasher.update(&(text.len() as u64).to_le_bytes());
    hasher.update(text.as_bytes());
}

/// The objects of a group, without links to other places.
fn members(group: &hdf5::Group, place: Place<'_>) -> Result<Vec<String>, StoreError> {
    let links = group.links(IndexType::Name, IterationOrder::Native);
    let links = links.at(place, "list the members")?.into_iter();
    let hard = links.filter(|(_, link)| link.link_type == LinkType::Hard);
    Ok(sorted(hard.map(|(name, _)| name).collect()))
}

fn sorted(mut names: Vec<String>) -> Vec<String> {
    names.sort_unstable();
    names
}
