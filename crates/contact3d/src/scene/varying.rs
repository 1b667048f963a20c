//! The values of a scene that may be formulas, and the parameters these use.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    Coefficient, Expression, ExpressionError, InvalidValue, LAW_VARIABLES, ProblemPart, Quantity,
    Scene,
    expression::{is_identifier, meaning},
    key::key,
    validate::require,
};

/// A value that may be a formula.
pub(super) enum Varying<'s> {
    Quantity(&'s mut Quantity),
    Coefficient(&'s mut Coefficient),
}

/// The key of such a value.
#[derive(Debug, Clone, Default)]
pub(super) struct VaryingKey {
    pub(super) path: String,
    /// The name of the load or clamp that it belongs to, where that has one.
    pub(super) name: Option<String>,
}

/// A part of a scene that has such values.
pub(super) trait Varies {
    /// Adds them, with the keys that they have where this part has a key.
    fn add_varying<'s>(&'s mut self, at: &VaryingKey, found: &mut Vec<(VaryingKey, Varying<'s>)>);
}

/// Says which fields of a table have such values, and which one has its name.
macro_rules! varies {
    ($table:ident $(named $name:ident)?: $($field:ident),+) => {
        impl $crate::scene::varying::Varies for $table {
            fn add_varying<'s>(
                &'s mut self,
                at: &$crate::scene::varying::VaryingKey,
                found: &mut Vec<($crate::scene::varying::VaryingKey, $crate::scene::varying::Varying<'s>)>,
            ) {
                $(let at = &at.named(self.$name.clone());)?
                $(self.$field.add_varying(&at.below(stringify!($field)), found);)+
            }
        }
    };
}
pub(super) use varies;

impl VaryingKey {
    pub(super) fn below(&self, name: impl std::fmt::Display) -> Self {
        let path = format!("{}.{name}", self.path);
        Self {
            path: path.trim_start_matches('.').to_owned(),
            name: self.name.clone(),
        }
    }

    pub(super) fn named(&self, name: Option<String>) -> Self {
        Self {
            name,
            ..self.clone()
        }
    }

    /// What of the problem it is part of.
    pub(super) fn part(&self) -> Option<ProblemPart> {
        key(&self.path)?.part
    }
}

impl Varies for Quantity {
    fn add_varying<'s>(&'s mut self, at: &VaryingKey, found: &mut Vec<(VaryingKey, Varying<'s>)>) {
        found.push((at.clone(), Varying::Quantity(self)));
    }
}

impl Varies for Coefficient {
    fn add_varying<'s>(&'s mut self, at: &VaryingKey, found: &mut Vec<(VaryingKey, Varying<'s>)>) {
        found.push((at.below(self.kind()), Varying::Coefficient(self)));
    }
}

impl<T: Varies> Varies for Option<T> {
    fn add_varying<'s>(&'s mut self, at: &VaryingKey, found: &mut Vec<(VaryingKey, Varying<'s>)>) {
        self.iter_mut().for_each(|it| it.add_varying(at, found));
    }
}

/// Components have the key of their vector.
impl<T: Varies, const N: usize> Varies for [T; N] {
    fn add_varying<'s>(&'s mut self, at: &VaryingKey, found: &mut Vec<(VaryingKey, Varying<'s>)>) {
        self.iter_mut().for_each(|it| it.add_varying(at, found));
    }
}

impl<T: Varies> Varies for Vec<T> {
    fn add_varying<'s>(&'s mut self, at: &VaryingKey, found: &mut Vec<(VaryingKey, Varying<'s>)>) {
        let items = self.iter_mut().enumerate();
        items.for_each(|(i, item)| item.add_varying(&at.below(i), found));
    }
}

impl<T: Varies> Varies for BTreeMap<String, T> {
    fn add_varying<'s>(&'s mut self, at: &VaryingKey, found: &mut Vec<(VaryingKey, Varying<'s>)>) {
        self.iter_mut()
            .for_each(|(name, item)| item.add_varying(&at.below(name), found));
    }
}

impl Scene {
    /// The parameters that the formulas of some parts use, with their values.
    #[must_use]
    pub(super) fn parameters_used(
        &self,
        of: impl Fn(Option<ProblemPart>) -> bool,
    ) -> BTreeMap<String, f64> {
        let mut used = BTreeMap::new();
        let mut scene = self.clone();
        for (key, formula) in scene.formulas_mut() {
            if of(key.part()) {
                let known = formula
                    .parameters()
                    .filter_map(|name| Some((name.to_owned(), *self.parameters.get(name)?)));
                used.extend(known);
            }
        }
        used
    }

    /// The names of parameters that no formula uses.
    #[must_use]
    pub(super) fn unused_parameters(&self) -> Vec<String> {
        let used = self.parameters_used(|_| true);
        let given: BTreeSet<&String> = self.parameters.keys().collect();
        let used: BTreeSet<&String> = used.keys().collect();
        given.difference(&used).copied().cloned().collect()
    }

    /// Gives the parameters in all formulas their values.
    ///
    /// # Errors
    /// A parameter that cannot be one, and a name in a formula that means nothing.
    pub(super) fn bind_parameters(&mut self) -> Result<(), InvalidValue> {
        for name in self.parameters.keys() {
            check(name)?;
        }
        let parameters = self.parameters.clone();
        for (key, formula) in self.formulas_mut() {
            let bound = formula.bind(&parameters);
            bound.map_err(|error| unbound(key.path, &formula.text(), error))?;
        }
        Ok(())
    }

    /// Whether anything varies from place to place: loads, clamps, springs, gaps, obstacles, axes or coefficients.
    pub(super) fn depends_on_place(&self) -> bool {
        let mut scene = self.clone();
        let mut varying = scene.varying_mut().into_iter();
        varying.any(|(_, value)| match value {
            Varying::Quantity(quantity) => quantity.constant().is_none(),
            Varying::Coefficient(law) => law.depends_on_place(),
        })
    }

    /// All formulas.
    fn formulas_mut(&mut self) -> impl Iterator<Item = (VaryingKey, &mut Expression)> {
        let varying = self.varying_mut().into_iter();
        varying.filter_map(|(key, value)| {
            let formula = match value {
                Varying::Quantity(Quantity::Varying(formula)) => formula,
                Varying::Coefficient(Coefficient::Expression(formula)) => &mut formula.0,
                Varying::Quantity(_) | Varying::Coefficient(_) => return None,
            };
            Some((key, formula))
        })
    }
}

/// Refuses a parameter that formulas cannot use.
fn check(name: &str) -> Result<(), InvalidValue> {
    let key = || format!("parameters.{name}");
    let other = meaning(name, LAW_VARIABLES);
    require(
        other.is_none(),
        key(),
        "a name that means nothing else in formulas",
        format!("{name}, {} of formulas", other.unwrap_or_default()),
        &format!("give the parameter another name, such as {name}_0"),
    )?;
    require(
        is_identifier(name),
        key(),
        "a name of letters, digits and _ that does not begin with a digit",
        format!("{name:?}"),
        "formulas could not tell it from other names, numbers and signs",
    )
}

/// A formula with a name that means nothing.
fn unbound(key: String, text: &str, error: ExpressionError) -> InvalidValue {
    match error {
        ExpressionError::Unknown { name, known } => InvalidValue {
            key,
            expected: known,
            found: format!("the unknown name {name} in \"{text}\""),
            help: format!(
                "correct the name, or make it a parameter: {name} = 1.0, with the value you mean, below a line [parameters]"
            ),
        },
        error => InvalidValue {
            key,
            expected: "a formula".into(),
            found: format!("\"{text}\""),
            help: error.to_string(),
        },
    }
}
