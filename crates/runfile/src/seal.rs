//! Seals: digests over what no other digest covers, the attributes and the set of objects.
//!
//! The seal of a group covers the attributes of everything in it, the datasets that its own digest leaves out and the
//! labels of its axes; that of the root its attributes and the seals of its groups. Both are written at the commit, and
//! [`crate::Reader::problems`] compares them. Files of older
//! formats have none.

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

/// No axis of ours has more entries with labels.
const MOST_LABELS: usize = 64;

/// What stands as the seal of an object, and what it should be.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Seal {
    stored: Option<String>,
    found: String,
}

impl Seal {
    fn new(object: &hdf5::Location, place: Place<'_>, found: String) -> Result<Self, StoreError> {
        let stored = if has(object, place, SEAL)? {
            Some(read_text(object, place, SEAL)?)
        } else {
            None
        };
        Ok(Self { stored, found })
    }

    fn of_group(file: &hdf5::File, place: Place<'_>) -> Result<Self, StoreError> {
        let object = file.group(place.dataset).at(place, "open the group")?;
        Self::new(&object, place, of_group(&object, place)?)
    }

    fn of_root(file: &hdf5::File, place: Place<'_>) -> Result<Self, StoreError> {
        Self::new(file, place, of_root(file, place)?)
    }

    fn same(&self, other: &Self, place: Place<'_>) -> Result<(), StoreError> {
        let in_one =
            |seal: &Self| format!("{} {}", seal.stored.as_deref().unwrap_or("-"), seal.found);
        place.same_digest(in_one(other), in_one(self))
    }

    /// Stores the seal where none stands.
    fn store(&mut self, object: &hdf5::Location, place: Place<'_>) -> Result<(), StoreError> {
        match self.stored {
            Some(_) => Ok(()),
            None => write_text(object, place, SEAL, self.stored.insert(self.found.clone())),
        }
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
    ///
    /// # Errors
    /// `Hdf5` if reading or writing fails.
    pub(super) fn set(
        file: &hdf5::File,
        place: Place<'_>,
        groups: &[Group],
    ) -> Result<Self, StoreError> {
        let mut sealed = Vec::new();
        for group in groups {
            let place = group_place(place, *group);
            let mut seal = Seal::of_group(file, place)?;
            let object = file.group(place.dataset).at(place, "open the group")?;
            seal.store(&object, place)?;
            sealed.push((*group, seal));
        }
        let mut root = Seal::of_root(file, place)?;
        root.store(file, place)?;
        Ok(Self {
            groups: sealed,
            root,
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
        let root = Place::new(&volume.path, "/");
        for (group, seal) in &self.groups {
            let place = group_place(root, *group);
            Seal::of_group(&volume.file, place)?.same(seal, place)?;
            if seal.stored.as_ref() != Some(&seal.found) {
                // What a copy lost was wrong before the file was closed.
                let before = match previous {
                    Some(previous) => Seal::of_group(&previous.volume(*group)?.file, place)?,
                    None => Seal {
                        found: seal.stored.clone().unwrap_or_default(),
                        ..seal.clone()
                    },
                };
                seal.same(&before, place)?;
            }
        }
        Seal::of_root(&volume.file, root)?.same(&self.root, root)
    }
}

fn group_place<'a>(place: Place<'a>, group: Group) -> Place<'a> {
    place.beside(group.name())
}

impl Reader {
    /// What the seals of the roots give away: that of the run file, and those of the files that hold its groups.
    pub(super) fn root_problems(&self) -> Vec<StoreError> {
        let linked = self.linked.values();
        let volumes = linked.filter_map(|linked| linked.volume.as_ref().ok());
        let roots = [&self.home].into_iter().chain(volumes);
        roots
            .filter_map(|volume| self.root_problem(volume).err())
            .collect()
    }

    fn root_problem(&self, volume: &Volume) -> Result<(), StoreError> {
        let place = Place::new(&volume.path, "/");
        self.sound(volume, &Seal::of_root(&volume.file, place)?, place)
    }

    /// Refuses a group whose seal is broken, or missing where it must be.
    pub(super) fn refuse_unsealed(&self, group: Group) -> Result<(), StoreError> {
        let volume = self.volume(group)?;
        if !volume.holds(&format!("/{group}")) {
            return Ok(());
        }
        let place = Place::new(&volume.path, group.name());
        self.sound(volume, &Seal::of_group(&volume.file, place)?, place)
    }

    fn sound(&self, volume: &Volume, seal: &Seal, place: Place<'_>) -> Result<(), StoreError> {
        match &seal.stored {
            None if volume.format_version < self.layout.sealed_since => Ok(()),
            None => Err(place.mismatch(format!("the attribute `{SEAL}`"), "none")),
            Some(stored) => place.same_digest(stored.clone(), seal.found.clone()),
        }
    }
}

fn of_group(group: &hdf5::Group, place: Place<'_>) -> Result<String, StoreError> {
    let mut hasher = Hasher::new();
    add_group(&mut hasher, group, place)?;
    Ok(hasher.finalize().to_hex().to_string())
}

fn of_root(file: &hdf5::File, place: Place<'_>) -> Result<String, StoreError> {
    let mut hasher = Hasher::new();
    add_attributes(&mut hasher, file, place)?;
    for name in members(file, place)? {
        add_text(&mut hasher, &name);
        let group = file.group(&name).at(place, "open the group")?;
        if has(&group, place, SEAL)? {
            add_text(&mut hasher, &read_text(&group, place, SEAL)?);
        }
    }
    Ok(hasher.finalize().to_hex().to_string())
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
    let has_labels = is_scale(dataset) && matches!(dtype, Ok(TypeDescriptor::VarLenUnicode));
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
        Ok(TypeDescriptor::FixedAscii(_)) => add_fixed(hasher, attribute)?,
        Ok(_) => {}
        // Texts that end with a zero have no descriptor.
        Err(_) => add_fixed(hasher, attribute)?,
    }
    Ok(())
}

fn add_fixed(hasher: &mut Hasher, attribute: &hdf5::Attribute) -> hdf5::Result<()> {
    let text = attribute.read_scalar::<FixedAscii<TEXT_BYTES>>()?;
    add_text(hasher, &text);
    Ok(())
}

fn add_text(hasher: &mut Hasher, text: &str) {
    hasher.update(&(text.len() as u64).to_le_bytes());
    hasher.update(text.as_bytes());
}

/// The objects of a group, without links to other places.
pub(super) fn members(group: &hdf5::Group, place: Place<'_>) -> Result<Vec<String>, StoreError> {
    let links = group.links(IndexType::Name, IterationOrder::Native);
    let links = links.at(place, "list the members")?.into_iter();
    let hard = links.filter(|(_, link)| link.link_type == LinkType::Hard);
    Ok(sorted(hard.map(|(name, _)| name).collect()))
}

fn sorted(mut names: Vec<String>) -> Vec<String> {
    names.sort_unstable();
    names
}
