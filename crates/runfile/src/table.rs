//! The whole table of a file format and the rules it must obey.

use std::collections::BTreeSet;

use units::Units;

use super::layout::{DatasetSpec, Group, Presence};

/// A file format: its identity and every dataset it knows.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Value of the root attribute `filetype`.
    pub filetype: &'static str,
    /// Value of the root attribute `filetype` of a file beside the run file that holds one group.
    pub linked_filetype: &'static str,
    /// Value of the root attribute `format_version`: major, minor.
    pub format_version: [i64; 2],
    /// The first version of the format whose files have seals.
    pub sealed_since: [i64; 2],
    /// Value of the root attribute `creator`: program and version.
    pub creator: &'static str,
    /// The groups a file of this format can hold, each after those it builds on.
    pub groups: &'static [Group],
    /// The rows of all groups.
    pub tables: &'static [&'static [DatasetSpec]],
    /// The units that numbers are written in.
    pub units: Units,
    /// Every symbolic size with its meaning.
    pub extents: &'static [(&'static str, &'static str)],
}

impl Layout {
    /// The same format for numbers in other units.
    #[must_use]
    pub const fn in_units(self, units: Units) -> Self {
        Layout { units, ..self }
    }

    /// Every group, each after those it builds on.
    pub fn groups(&self) -> impl Iterator<Item = Group> + use<> {
        self.groups.iter().copied()
    }

    /// The groups that a group may build on.
    pub(super) fn upstream_of(&self, group: Group) -> impl Iterator<Item = Group> + use<> {
        self.groups().take_while(move |other| *other != group)
    }

    /// Every row, in the order of the table.
    pub fn datasets(&self) -> impl Iterator<Item = &'static DatasetSpec> + use<> {
        self.tables.iter().flat_map(|table| table.iter())
    }

    /// The row of a path.
    #[must_use]
    pub fn find(&self, path: &str) -> Option<&'static DatasetSpec> {
        self.datasets().find(|spec| spec.path == path)
    }

    /// The rows of one group.
    pub fn of_group(&self, group: Group) -> impl Iterator<Item = &'static DatasetSpec> + use<> {
        self.datasets().filter(move |spec| spec.group == group)
    }

    /// Every breach of the rules of the table, one sentence each; empty for a sound table.
    ///
    /// Rules: groups are listed once; paths are unique, below their group, which is listed, and not
    /// inside one another; meanings are given; matrices have two extents and texts at most one;
    /// enumerations have distinct names and codes; every symbolic size is explained, and every
    /// explained one is used.
    #[must_use]
    pub fn problems(&self) -> Vec<String> {
        let mut problems = self.group_problems();
        let mut paths = BTreeSet::new();
        for spec in self.datasets() {
            if !paths.insert(spec.path) {
                problems.push(format!("{}: listed twice", spec.path));
            }
            problems.extend(
                row_problems(spec)
                    .into_iter()
                    .map(|problem| format!("{}: {problem}", spec.path)),
            );
        }
        for spec in self.datasets() {
            let inside = format!("{}/", spec.path);
            if self.datasets().any(|other| other.path.starts_with(&inside)) {
                problems.push(format!("{}: another dataset lies inside it", spec.path));
            }
        }
        problems.extend(self.extent_problems());
        problems
    }

    fn group_problems(&self) -> Vec<String> {
        let mut names = BTreeSet::new();
        let twice = self.groups().filter(|group| !names.insert(group.name()));
        let mut problems: Vec<_> = twice
            .map(|group| format!("/{group}: listed twice"))
            .collect();
        let is_listed = |spec: &&DatasetSpec| self.groups.contains(&spec.group);
        let strangers = self.datasets().filter(|spec| !is_listed(spec));
        problems.extend(strangers.map(|spec| format!("{}: its group is not listed", spec.path)));
        problems
    }

    fn extent_problems(&self) -> Vec<String> {
        let used: BTreeSet<_> = self
            .datasets()
            .flat_map(|spec| spec.shape.iter().filter_map(|extent| extent.name()))
            .collect();
        let explained: BTreeSet<_> = self.extents.iter().map(|(name, _)| *name).collect();
        let mut problems: Vec<_> = used
            .difference(&explained)
            .map(|name| format!("size {name} is not explained"))
            .collect();
        problems.extend(
            explained
                .difference(&used)
                .map(|name| format!("size {name} is explained but not used")),
        );
        problems
    }
}

fn row_problems(spec: &DatasetSpec) -> Vec<&'static str> {
    use super::layout::Kind;
    let rank_fits = match spec.kind {
        Kind::CscMatrix | Kind::CsrMatrix => spec.shape.len() == 2,
        Kind::Text => spec.shape.len() <= 1,
        _ => true,
    };
    let members_distinct = match spec.kind {
        Kind::Enum(members) => {
            let names: BTreeSet<_> = members.members.iter().map(|(name, _)| name).collect();
            let codes: BTreeSet<_> = members.members.iter().map(|(_, code)| code).collect();
            names.len() == members.members.len() && codes.len() == members.members.len()
        }
        _ => true,
    };
    [
        (
            spec.name() == spec.path || spec.name().is_empty(),
            "not below its group",
        ),
        (spec.description.is_empty(), "has no meaning"),
        (
            spec.presence == Presence::Optional(""),
            "is optional without a reason",
        ),
        (!rank_fits, "has a rank its kind cannot have"),
        (!members_distinct, "has members with equal names or codes"),
    ]
    .into_iter()
    .filter_map(|(broken, problem)| broken.then_some(problem))
    .collect()
}
