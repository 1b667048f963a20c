//! The check of a whole file: every dataset against the table and against its digest.

use hdf5::H5Type;
use hdf5::types::{EnumMember, EnumType, IntSize, TypeDescriptor};
use hdf5_metno as hdf5;
use units::Units;

use super::error::StoreError;
use super::layout::{DatasetSpec, EnumSpec, Group, Kind};
use super::reader::Reader;

impl Reader {
    /// Everything that is wrong with a file; empty for one as it was written.
    ///
    /// Reads every value. Groups that are not there, or not finished, are not wrong; whether they
    /// are fresh is another question.
    #[must_use]
    pub fn problems(&self) -> Vec<StoreError> {
        let groups = self.layout.groups();
        let mut problems: Vec<StoreError> = groups
            .flat_map(|group| self.group_problems(group))
            .collect();
        problems.extend(self.root_problems());
        problems
    }

    /// Everything that is wrong with one group; as [`Self::problems`]. What this process has found sound is not read again before
    /// its file changes.
    #[must_use]
    pub fn group_problems(&self, group: Group) -> Vec<StoreError> {
        let file = self.volume(group).ok().filter(|file| file.is_unchanged());
        if file.is_some_and(|file| file.is_sound(group)) {
            return Vec::new();
        }
        let problems = self.problems_read(group);
        if let Some(file) = file.filter(|_| problems.is_empty()) {
            file.note_sound(group);
        }
        problems
    }

    fn problems_read(&self, group: Group) -> Vec<StoreError> {
        let mut problems = Vec::new();
        match self.whole_group(group) {
            Ok(None) => return problems,
            Ok(Some(stored)) => {
                let held = self.layout.of_group(group).filter(|spec| self.holds(spec));
                let wrong = held.filter_map(|spec| self.check_unit(spec, stored.units).err());
                problems.extend(wrong);
            }
            Err(StoreError::Older { .. }) => {
                return self
                    .problems_as_written(group)
                    .unwrap_or_else(|error| vec![error]);
            }
            Err(error) => problems.push(error),
        }
        problems.extend(self.refuse_unknown(group).err());
        let held = self.layout.of_group(group).filter(|spec| self.holds(spec));
        problems.extend(held.filter_map(|spec| self.check_values(spec).err()));
        // A seal breaks with what is named already.
        if problems.is_empty() {
            problems.extend(self.refuse_unsealed(group).err());
        }
        problems
    }

    /// Refuses a word for the unit of a dataset that is not that of the units its group names.
    fn check_unit(&self, spec: &DatasetSpec, units: Units) -> Result<(), StoreError> {
        let found = self.attribute(spec, "units")?;
        let expected = units.word(spec.dimension);
        if found == expected {
            return Ok(());
        }
        let place = self.place(spec);
        Err(place.mismatch(
            format!("units = \"{expected}\""),
            format!("units = \"{found}\""),
        ))
    }

    fn check_values(&self, spec: &'static DatasetSpec) -> Result<(), StoreError> {
        match spec.kind {
            Kind::F64 => self.check_digest::<f64>(spec, &f64::type_descriptor()),
            Kind::F32 => self.check_digest::<f32>(spec, &f32::type_descriptor()),
            Kind::I64 => self.check_digest::<i64>(spec, &i64::type_descriptor()),
            Kind::U8 => self.check_digest::<u8>(spec, &u8::type_descriptor()),
            Kind::Enum(members) => self.check_digest::<u8>(spec, &descriptor(members)),
            Kind::Text => self.read_texts(spec.path).map(drop),
            Kind::CscMatrix | Kind::CsrMatrix => self.read_matrix(spec.path).map(drop),
        }
    }
}

/// The type of an enumeration in the file.
fn descriptor(spec: &EnumSpec) -> TypeDescriptor {
    let members = spec.members.iter().map(|&(name, code)| EnumMember {
        name: name.into(),
        value: code.into(),
    });
    TypeDescriptor::Enum(EnumType {
        size: IntSize::U1,
        signed: false,
        members: members.collect(),
    })
}
