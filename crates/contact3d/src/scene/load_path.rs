//! The loads of a history at each of its increments.

use std::collections::BTreeMap;

use super::{
    Expression, InvalidValue, POSITION, PlaceFunction, Quantity, Scene, SlipMeasure, Step, Written,
    validate::require,
};

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

/// Something that a step may change, with its number in the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum SteppedValue {
    /// A traction in Pa.
    Traction(usize),
    /// A pressure in Pa.
    Pressure(usize),
    /// The body force in N/m³.
    BodyForce,
    /// The prescribed displacement of a clamp in m.
    Clamp(usize),
    /// The initial gap of a contact face in m.
    Gap(usize),
}

/// What a target has at the end of a step: a factor of a value.
#[derive(Debug, Clone, PartialEq)]
struct EndValue {
    value: Vec<Quantity>,
    factor: f64,
}

impl SteppedValue {
    /// The values it has in a scene.
    fn values(self, scene: &mut Scene) -> &mut [Quantity] {
        match self {
            Self::Traction(i) => &mut scene.tractions[i].value,
            Self::Pressure(i) => std::slice::from_mut(&mut scene.pressures[i].value),
            Self::Clamp(i) => &mut scene.clamps[i].value,
            Self::BodyForce => scene
                .body_force
                .as_mut()
                .map_or(&mut [], |force| &mut force.value),
            Self::Gap(i) => std::slice::from_mut(&mut scene.contacts[i].gap),
        }
    }

    /// The factor before the first step: nothing loads or moves the body yet, and the gap is what it is.
    fn first_factor(self) -> f64 {
        match self {
            Self::Traction(_) | Self::Pressure(_) | Self::BodyForce | Self::Clamp(_) => 0.0,
            Self::Gap(_) => 1.0,
        }
    }
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
        let mut scene = self.clone();
        scene.steps.clear();
        let own = scene.contacts.iter_mut();
        let own = own.filter_map(|contact| contact.friction.as_mut());
        for friction in own.chain(&mut scene.friction) {
            friction.follows = SlipMeasure::default();
        }
        let [before, after] = self.ends_of(increment.step)?;
        for (target, after) in after {
            let before = &before[&target];
            let values = between(before, &after, increment.share);
            target.values(&mut scene).clone_from_slice(&values);
        }
        scene.bind_parameters()?;
        Ok(scene)
    }

    /// The clamps that are held elsewhere than at zero when any step ends, by their places.
    ///
    /// # Errors
    /// As [`Self::at_increment`].
    pub(crate) fn moved_clamps(&self) -> Result<Vec<usize>, InvalidValue> {
        let mut moved = vec![false; self.clamps.len()];
        for end in self.increments().iter().filter(|end| end.share >= 1.0) {
            let clamps = self.at_increment(*end)?.clamps;
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
    fn ends_of(&self, step: usize) -> Result<[BTreeMap<SteppedValue, EndValue>; 2], InvalidValue> {
        let mut scene = self.clone();
        let mut held: BTreeMap<SteppedValue, EndValue> = self
            .targets()
            .into_iter()
            .map(|(target, ..)| {
                let first = EndValue {
                    value: target.values(&mut scene).to_vec(),
                    factor: target.first_factor(),
                };
                (target, first)
            })
            .collect();
        let mut before = held.clone();
        for (k, given) in self.steps.iter().enumerate().take(step + 1) {
            before.clone_from(&held);
            if k == 0 {
                held.values_mut().for_each(|held| held.factor = 1.0);
            }
            self.change(k, given, &mut held)?;
        }
        Ok([before, held])
    }

    /// What a step changes.
    fn change(
        &self,
        k: usize,
        given: &Step,
        held: &mut BTreeMap<SteppedValue, EndValue>,
    ) -> Result<(), InvalidValue> {
        for (name, value) in &given.value {
            let target = self.target(&format!("step.{k}.value"), name)?;
            if let Some(now) = held.get_mut(&target) {
                let is_one = now.value.len() == 1;
                let (count, plural) = if is_one { ("one", "") } else { ("three", "s") };
                require(
                    now.value.len() == value.components().len(),
                    format!("step.{k}.value.{name}"),
                    &format!("{count} number{plural} or formula{plural}"),
                    Written(value),
                    &format!("{name} has {count} in the scene"),
                )?;
                *now = EndValue {
                    value: value.components().to_vec(),
                    factor: 1.0,
                };
            }
        }
        for (name, factor) in &given.factor {
            let target = self.target(&format!("step.{k}.factor"), name)?;
            if let Some(now) = held.get_mut(&target) {
                now.factor = *factor;
            }
        }
        Ok(())
    }

    /// All that steps of this scene may change, with the keys and the names that they may use for it.
    fn targets(&self) -> Vec<(SteppedValue, String, Option<&str>)> {
        let mut targets = Vec::new();
        for (i, traction) in self.tractions.iter().enumerate() {
            let name = traction.name.as_deref();
            targets.push((SteppedValue::Traction(i), format!("traction.{i}"), name));
        }
        for (i, pressure) in self.pressures.iter().enumerate() {
            let name = pressure.name.as_deref();
            targets.push((SteppedValue::Pressure(i), format!("pressure.{i}"), name));
        }
        if self.body_force.is_some() {
            targets.push((SteppedValue::BodyForce, "body_force".to_owned(), None));
        }
        for (i, clamp) in self.clamps.iter().enumerate() {
            let name = clamp.name.as_deref();
            targets.push((SteppedValue::Clamp(i), format!("clamp.{i}"), name));
        }
        for i in 0..self.contacts.len() {
            let key = format!("{}.gap", self.contact_key(i));
            targets.push((SteppedValue::Gap(i), key, None));
        }
        targets
    }

    /// What a name or a key in a step stands for.
    fn target(&self, at: &str, name: &str) -> Result<SteppedValue, InvalidValue> {
        let targets = self.targets();
        let mut named = targets.iter();
        let found = named.find(|(_, key, own)| key == name || *own == Some(name));
        found.map(|(target, ..)| *target).ok_or_else(|| {
            let known = targets.iter().map(|(_, key, own)| format!("\"{}\"", own.unwrap_or(key)));
            InvalidValue {
                key: format!("{at}.{name}"),
                expected: format!(
                    "something that the scene loads, moves or opens: {}",
                    known.collect::<Vec<_>>().join(", ")
                ),
                found: format!("\"{name}\""),
                help: "give the load a name = \"...\", or write its key as \"traction.0\", with quotes".into(),
            }
        })
    }

    /// Rewrites the values that steps give, each with what it is a value of.
    ///
    /// # Errors
    /// A key that the scene does not have.
    pub fn map_step_values(
        &mut self,
        by: impl Fn(SteppedValue, &[Quantity]) -> Vec<Quantity>,
    ) -> Result<(), InvalidValue> {
        let mut steps = std::mem::take(&mut self.steps);
        for (k, step) in steps.iter_mut().enumerate() {
            for (name, value) in &mut step.value {
                let target = self.target(&format!("step.{k}.value"), name)?;
                let values = by(target, value.components());
                value.components_mut().clone_from_slice(&values);
            }
        }
        self.steps = steps;
        Ok(())
    }

    /// The names that loads and clamps have, each with its key.
    pub(super) fn given_names(&self) -> Vec<(String, String)> {
        let targets = self.targets().into_iter();
        let named = targets.filter_map(|(_, key, name)| Some((key, name?.to_owned())));
        named
            .map(|(key, name)| (format!("{key}.name"), name))
            .collect()
    }
}

/// The values at a share of the way from one end of a step to the other.
fn between(before: &EndValue, after: &EndValue, share: f64) -> Vec<Quantity> {
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
        Quantity::Constant(value) => Some(Expression::number(*value, POSITION)),
        Quantity::Varying(formula) => Some(formula.clone()),
        Quantity::Function(_) => None,
    };
    match (&a, &b, formula(&a).zip(formula(&b))) {
        (Quantity::Constant(a), Quantity::Constant(b), _) => Quantity::Constant(a + b),
        (_, Quantity::Constant(0.0), _) => a,
        (Quantity::Constant(0.0), ..) => b,
        (.., Some((first, second))) => Quantity::Varying(first.plus(&second)),
        (.., None) => Quantity::Function(PlaceFunction::new(move |x| a.at(x) + b.at(x))),
    }
}
