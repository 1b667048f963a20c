//! Steps of a load history, and the loads at each of their increments.

use std::{collections::BTreeMap, ops::RangeInclusive};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    Expression, Follow, InvalidValue, Measure, POSITION, ProblemPart, Quantity, Scene, SlipMeasure,
    Written,
    validate::require,
    varying::{Varies, Varying, VaryingKey, varies},
};

/// Most increments of a history, over all steps.
pub const MOST_INCREMENTS: usize = 100_000;

/// One step of a load history: what loads, gap and prescribed displacements are when it ends. What a step does
/// not name stays as it was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Step {
    /// What the step does, for tables and pictures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// The time at its end in s, greater than that of the step before; 1, 2, … where no step has one. Nothing
    /// depends on it but tables, charts and films.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Time))]
    pub time: Option<f64>,
    /// Equal parts of the step, each solved by itself, between which loads change linearly.
    #[serde(skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 1))]
    pub increments: usize,
    /// How many times their values loads, gap and prescribed displacements have, by name or by key.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub factor: BTreeMap<String, f64>,
    /// Other values of theirs, by name or by key; a factor of the same step scales them.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub value: BTreeMap<String, StepValue>,
}

/// A value that a step gives, as the key that it replaces has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum StepValue {
    /// A pressure or a gap.
    Number(Quantity),
    /// A traction, a force, a moment, a body force, or a displacement or turn that is given.
    Vector([Quantity; 3]),
}

varies!(Step: value);

impl Varies for StepValue {
    fn add_varying<'s>(&'s mut self, at: &VaryingKey, found: &mut Vec<(VaryingKey, Varying<'s>)>) {
        self.components_mut()
            .iter_mut()
            .for_each(|it| it.add_varying(at, found));
    }
}

impl StepValue {
    /// Its components, one or three.
    pub(super) fn components(&self) -> &[Quantity] {
        match self {
            Self::Number(value) => std::slice::from_ref(value),
            Self::Vector(value) => value,
        }
    }

    pub(super) fn components_mut(&mut self) -> &mut [Quantity] {
        match self {
            Self::Number(value) => std::slice::from_mut(value),
            Self::Vector(value) => value,
        }
    }
}

impl Default for Step {
    fn default() -> Self {
        Self {
            title: None,
            time: None,
            increments: 1,
            factor: BTreeMap::new(),
            value: BTreeMap::new(),
        }
    }
}

impl Step {
    /// A step that changes nothing yet.
    #[must_use]
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: Some(title.into()),
            ..Self::default()
        }
    }

    /// The step with a factor of what a name or a key stands for.
    #[must_use]
    pub fn with_factor(mut self, key: impl Into<String>, factor: f64) -> Self {
        self.factor.insert(key.into(), factor);
        self
    }

    /// The step in equal parts.
    #[must_use]
    pub fn in_increments(self, increments: usize) -> Self {
        Self { increments, ..self }
    }
}

fn is_one(increments: &usize) -> bool {
    *increments == 1
}

/// One of the problems that a history consists of.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Increment {
    /// The step it belongs to, from 0.
    pub step: usize,
    /// Its number within the step, from 1.
    pub number: usize,
    /// The share of the step that is done at its end, in (0, 1].
    pub share: f64,
    /// The time at its end in s.
    pub time: f64,
}

/// Something that a step may change: a load, a prescribed displacement, a gap.
struct Target<'s> {
    /// Its key, without `value` at the end, as steps write it.
    key: String,
    /// Its name, by which steps may know it, too.
    name: Option<String>,
    /// Its components, one or three.
    values: Vec<&'s mut Quantity>,
}

/// What a target has at the end of a step: a factor of a value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct EndValue {
    name: Option<String>,
    value: Vec<Quantity>,
    factor: f64,
}

/// What all targets have when the next step begins and when it ends.
fn advance(
    [before, held]: &mut [BTreeMap<String, EndValue>; 2],
    k: usize,
    given: &Step,
) -> Result<(), InvalidValue> {
    before.clone_from(held);
    if k == 0 {
        held.values_mut().for_each(|held| held.factor = 1.0);
    }
    change(k, given, held)
}

impl Scene {
    /// Whether the scene has a load history.
    #[must_use]
    pub fn has_history(&self) -> bool {
        !self.steps.is_empty()
    }

    /// The title of a step, counted from 0, or its number, counted from 1.
    #[must_use]
    pub fn step_title(&self, step: usize) -> String {
        let given = self.steps[step].title.clone();
        given.unwrap_or_else(|| format!("step {}", step + 1))
    }

    /// The slip that coefficients of friction follow in a history: the same on all faces.
    #[must_use]
    pub fn slip_measure(&self) -> SlipMeasure {
        let first = self.friction_tables().next();
        first.map_or(SlipMeasure::default(), |(_, friction)| friction.follows)
    }

    /// Refuses a scene with a load history where there can be none.
    ///
    /// # Errors
    /// The steps, named as what `task` cannot have.
    pub fn require_no_history(&self, task: &str) -> Result<(), InvalidValue> {
        require(
            !self.has_history(),
            "step",
            &format!("no load history, for {task} is about one problem"),
            format!("{} steps", self.steps.len()),
            "leave out [[step]], and give the loads of the step that is meant",
        )
    }

    /// The problems of its history, in their order; none without steps.
    #[must_use]
    pub fn increments(&self) -> Vec<Increment> {
        let mut increments = Vec::new();
        let mut from = 0.0;
        for (step, given) in self.steps.iter().enumerate() {
            let to = given.time.unwrap_or((step + 1) as f64);
            for number in 1..=given.increments {
                let is_last = number == given.increments;
                let share = number as f64 / given.increments as f64;
                increments.push(Increment {
                    step,
                    number,
                    share: if is_last { 1.0 } else { share },
                    time: if is_last {
                        to
                    } else {
                        from + share * (to - from)
                    },
                });
            }
            from = to;
        }
        increments
    }

    /// The scene without steps whose loads, gap and prescribed displacements are those at the end of an increment.
    ///
    /// # Errors
    /// A key that the scene does not have, a value of another shape.
    pub fn at_increment(&self, increment: Increment) -> Result<Self, InvalidValue> {
        let ends = self.ends_of(increment.step)?;
        self.without_steps().with_loads(&ends, increment.share)
    }

    /// The scenes as the steps end, in their order.
    ///
    /// # Errors
    /// As [`Self::at_increment`].
    pub fn at_ends(&self) -> impl Iterator<Item = Result<Self, InvalidValue>> {
        let bare = self.without_steps();
        let held = bare.initial_values();
        let mut ends = [held.clone(), held];
        self.steps.iter().enumerate().map(move |(k, given)| {
            advance(&mut ends, k, given)?;
            bare.clone().with_loads(&ends, 1.0)
        })
    }

    /// The steps of the cycle that ends with a step: the loads are then where they were before its first; `None` without one.
    #[must_use]
    pub fn cycle_until(&self, last: usize) -> Option<RangeInclusive<usize>> {
        let ends: Vec<Scene> = self.at_ends().collect::<Result<_, _>>().ok()?;
        let before = (0..last.saturating_sub(1)).rev();
        let start = before.into_iter().find(|step| ends[*step] == ends[last])?;
        Some(start + 1..=last)
    }

    fn without_steps(&self) -> Self {
        let mut scene = self.clone();
        for (entry, contact) in scene.contacts.iter_mut().enumerate() {
            contact.follow = contact
                .follow
                .or((self.follow_of(entry) == Follow::Increment).then_some(Follow::Increment));
        }
        scene.steps.clear();
        let own = scene.contacts.iter_mut();
        let own = own.filter_map(|contact| contact.friction.as_mut());
        for friction in own.chain(&mut scene.friction) {
            friction.follows = SlipMeasure::default();
        }
        scene
    }

    /// The scene with what a share of the way between two ends gives.
    fn with_loads(
        mut self,
        [before, after]: &[BTreeMap<String, EndValue>; 2],
        share: f64,
    ) -> Result<Self, InvalidValue> {
        for target in self.targets() {
            let values = between((&before[&target.key], &after[&target.key]), share);
            let pairs = target.values.into_iter().zip(values);
            pairs.for_each(|(old, new)| *old = new);
        }
        self.bind_parameters()?;
        Ok(self)
    }

    /// The clamps that are held elsewhere than at zero when any step ends, by their places.
    ///
    /// # Errors
    /// As [`Self::at_increment`].
    pub(crate) fn moved_clamps(&self) -> Result<Vec<usize>, InvalidValue> {
        let mut moved = vec![false; self.clamps.len()];
        for end in self.at_ends() {
            let clamps = end?.clamps;
            let pairs = moved.iter_mut().zip(&clamps);
            pairs.for_each(|(moved, clamp)| *moved |= clamp.is_moved());
        }
        Ok((0..moved.len()).filter(|clamp| moved[*clamp]).collect())
    }

    /// The scene as its last increment has it; itself without steps.
    ///
    /// # Errors
    /// As [`Self::at_increment`].
    pub fn at_end(&self) -> Result<Self, InvalidValue> {
        match self.increments().last() {
            None => Ok(self.clone()),
            Some(last) => self.at_increment(*last),
        }
    }

    /// What all targets have when a step begins and when it ends.
    fn ends_of(&self, step: usize) -> Result<[BTreeMap<String, EndValue>; 2], InvalidValue> {
        let held = self.initial_values();
        let mut ends = [held.clone(), held];
        let mut steps = self.steps.iter().enumerate().take(step + 1);
        steps.try_for_each(|(k, given)| advance(&mut ends, k, given))?;
        Ok(ends)
    }

    /// What all targets have before the first step: nothing loads or moves the body yet, and the gap is what it is.
    pub(super) fn initial_values(&self) -> BTreeMap<String, EndValue> {
        let mut scene = self.clone();
        let values = scene.targets().into_iter().map(|target| {
            let first = EndValue {
                name: target.name,
                value: target
                    .values
                    .into_iter()
                    .map(|value| value.clone())
                    .collect(),
                factor: if target.key.ends_with(".gap") {
                    1.0
                } else {
                    0.0
                },
            };
            (target.key, first)
        });
        values.collect()
    }

    /// All that steps of this scene may change.
    fn targets(&mut self) -> Vec<Target<'_>> {
        let mut targets: Vec<Target<'_>> = Vec::new();
        for (key, value) in self.varying_mut() {
            let Varying::Quantity(value) = value else {
                continue;
            };
            if key.part() != Some(ProblemPart::Loads) || key.path.starts_with("step.") {
                continue;
            }
            let own = key.path.trim_end_matches(".value");
            match targets.last_mut() {
                Some(vector) if vector.key == own => vector.values.push(value),
                _ => targets.push(Target {
                    key: own.to_owned(),
                    name: key.name.map(|name| name + suffix_of(own)),
                    values: vec![value],
                }),
            }
        }
        targets
    }

    /// The names that loads and clamps have, each with its key.
    pub(super) fn given_names(&self) -> Vec<(String, String)> {
        let named = self.initial_values().into_iter();
        let named = named.filter_map(|(key, value)| {
            let suffix = suffix_of(&key);
            let owner = key.strip_suffix(suffix)?.to_owned();
            // Of the vectors of a load or a tool the first one stands for all.
            let is_first = suffix.is_empty() || suffix == ".displacement";
            let name = value.name.filter(|_| is_first)?;
            Some((owner, name.strip_suffix(suffix)?.to_owned()))
        });
        named
            .map(|(key, name)| (format!("{key}.name"), name))
            .collect()
    }
}

/// What a step changes.
fn change(
    k: usize,
    given: &Step,
    held: &mut BTreeMap<String, EndValue>,
) -> Result<(), InvalidValue> {
    refuse_twice(&format!("step.{k}.value"), held, given.value.keys())?;
    refuse_twice(&format!("step.{k}.factor"), held, given.factor.keys())?;
    for (name, value) in &given.value {
        let now = target(held, &format!("step.{k}.value"), name)?;
        let is_one = now.value.len() == 1;
        let (count, plural) = if is_one { ("one", "") } else { ("three", "s") };
        require(
            now.value.len() == value.components().len(),
            format!("step.{k}.value.{name}"),
            &format!("{count} number{plural} or formula{plural}"),
            Written(value),
            &format!("{name} has {count} in the scene"),
        )?;
        now.value = value.components().to_vec();
        now.factor = 1.0;
    }
    let mut factors: Vec<_> = given.factor.iter().collect();
    // The factor of a force is that of its moment, and that of a tool that of all its vectors, where these have none of their own.
    factors.sort_by_key(|(name, _)| !suffix_of(name).is_empty());
    for (name, factor) in factors {
        let mut known = false;
        let owned = held
            .iter_mut()
            .filter(|(key, now)| is_owned(key, now, name));
        for (_, now) in owned {
            now.factor = *factor;
            known = true;
        }
        match target(held, &format!("step.{k}.factor"), name) {
            Ok(now) => now.factor = *factor,
            Err(_) if known => {}
            Err(unknown) => return Err(unknown),
        }
    }
    Ok(())
}

/// Whether a vector belongs to a load or a tool of this name or key.
fn is_owned(key: &str, vector: &EndValue, owner: &str) -> bool {
    let suffix = suffix_of(key);
    let name = vector
        .name
        .as_deref()
        .and_then(|name| name.strip_suffix(suffix));
    !suffix.is_empty() && (name == Some(owner) || key.strip_suffix(suffix) == Some(owner))
}

/// Refuses two names for one load, gap or motion in a table of a step.
fn refuse_twice<'n>(
    at: &str,
    held: &BTreeMap<String, EndValue>,
    names: impl Iterator<Item = &'n String>,
) -> Result<(), InvalidValue> {
    let mut known: BTreeMap<String, &String> = BTreeMap::new();
    for name in names {
        let owned = || held.iter().find(|(key, now)| is_owned(key, now, name));
        let key = key_of_target(held, name)
            .or_else(|| owned().map(|(key, _)| key.trim_end_matches(suffix_of(key)).to_owned()));
        let Some(other) = key.and_then(|key| known.insert(key, name)) else {
            continue;
        };
        return Err(InvalidValue {
            key: format!("{at}.{name}"),
            expected: "a load, gap or motion once in each table of a step".into(),
            found: format!("{} as well, which is the same", Written(other)),
            help: "leave one of the two out".into(),
        });
    }
    Ok(())
}

/// The end of the key of one of the vectors that a load or a tool has several of, and of its name; nothing for other keys.
fn suffix_of(key: &str) -> &str {
    let ends = [".displacement", ".turn", ".force", ".moment"];
    let mut ends = ends.into_iter();
    ends.find(|end| key.ends_with(end)).unwrap_or("")
}

/// What a name or a key in a step stands for.
fn target<'v>(
    held: &'v mut BTreeMap<String, EndValue>,
    at: &str,
    name: &str,
) -> Result<&'v mut EndValue, InvalidValue> {
    match key_of_target(held, name) {
        Some(key) => Ok(held.get_mut(&key).expect("a key of theirs")),
        None => {
            let known = held.iter();
            let known = known.map(|(key, it)| format!("\"{}\"", it.name.as_ref().unwrap_or(key)));
            Err(InvalidValue {
                key: format!("{at}.{name}"),
                expected: format!(
                    "something that the scene loads, moves or opens: {}",
                    known.collect::<Vec<_>>().join(", ")
                ),
                found: format!("\"{name}\""),
                help: "give the load a name = \"...\", or write its key as \"traction.0\", with quotes".into(),
            })
        }
    }
}

/// The key of what a name or a key in a step stands for.
pub(super) fn key_of_target(targets: &BTreeMap<String, EndValue>, name: &str) -> Option<String> {
    let mut targets = targets.iter();
    let found = targets.find(|(key, it)| *key == name || it.name.as_deref() == Some(name));
    found.map(|(key, _)| key.clone())
}

/// The values at a share of the way from one end of a step to the other.
fn between((before, after): (&EndValue, &EndValue), share: f64) -> Vec<Quantity> {
    let ends = |factor: f64| after.value.iter().map(|v| v.times(factor)).collect();
    if share >= 1.0 {
        return ends(after.factor);
    }
    if before.value == after.value {
        return ends(before.factor + share * (after.factor - before.factor));
    }
    let weights = [(1.0 - share) * before.factor, share * after.factor];
    let pairs = before.value.iter().zip(&after.value);
    pairs
        .map(|(a, b)| sum(a.times(weights[0]), b.times(weights[1])))
        .collect()
}

fn sum(a: Quantity, b: Quantity) -> Quantity {
    let formula = |quantity: &Quantity| match quantity {
        Quantity::Constant(value) => Expression::number(*value, POSITION),
        Quantity::Varying(formula) => formula.clone(),
    };
    match (&a, &b) {
        (Quantity::Constant(a), Quantity::Constant(b)) => Quantity::Constant(a + b),
        (_, Quantity::Constant(0.0)) => a,
        (Quantity::Constant(0.0), _) => b,
        _ => Quantity::Varying(formula(&a).plus(&formula(&b))),
    }
}
