//! The formulas of a scene and the parameters they use.

use std::{collections::BTreeSet, slice::from_mut};

use ProblemPart::{Law, Loads, Mesh, Operator};

use super::{
    Coefficient, Contact, Expression, ExpressionError, Friction, InvalidValue, LAW_VARIABLES,
    Obstacle, Parameters, Quantity, Scene,
    contact::contact_key,
    expression::{is_identifier, meaning},
    validate::require,
};

/// What of the discrete problem a varying value of a scene is part of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProblemPart {
    /// The mesh with the normals and distances of its obstacles.
    Mesh,
    /// A with its springs, and T with the axes of friction.
    Operator,
    /// What loads, moves and opens.
    Loads,
    /// The law of friction.
    Law,
}

impl Scene {
    /// The parameters that the formulas of some parts use, with their values.
    #[must_use]
    pub fn parameters_used(&self, of: impl Fn(ProblemPart) -> bool) -> Parameters {
        let mut used = Parameters::new();
        let mut scene = self.clone();
        for ((part, _), formula) in scene.formulas_mut() {
            if of(part) {
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
        for (name, value) in &self.parameters {
            check(name, *value)?;
        }
        let parameters = self.parameters.clone();
        for ((_, key), formula) in self.formulas_mut() {
            let text = formula.text().to_owned();
            formula
                .bind(&parameters)
                .map_err(|error| unbound(key, &text, error))?;
        }
        Ok(())
    }

    /// The key of a Rust function, which no text holds; `None` where the scene has none.
    pub(super) fn function_key(&self) -> Option<String> {
        let mut scene = self.clone();
        let mut varying = scene.varying_mut().into_iter();
        let found = varying.find(|(_, value)| value.is_function());
        // The kind of a coefficient that is a function is none of a scene.
        found.map(|((_, key), _)| key.trim_end_matches(".function").to_owned())
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

    /// All formulas with their keys.
    fn formulas_mut(&mut self) -> impl Iterator<Item = (Key, &mut Expression)> {
        let varying = self.varying_mut().into_iter();
        varying.filter_map(|(key, value)| {
            let formula = match value {
                Varying::Quantity(Quantity::Varying(formula)) => formula,
                Varying::Coefficient(Coefficient::Expression(formula)) => formula.expression_mut(),
                Varying::Quantity(_) | Varying::Coefficient(_) => return None,
            };
            Some((key, formula))
        })
    }

    /// All that may vary with its keys.
    fn varying_mut<'s>(&'s mut self) -> Vec<(Key, Varying<'s>)> {
        // Every key by name, so that a new one does not compile before it is said whether it varies.
        let Self {
            title: _,
            reference: _,
            units: _,
            parameters: _,
            body: _,
            material: _,
            regions: _,
            clamps,
            springs,
            tractions,
            pressures,
            body_force,
            contacts,
            friction,
            steps,
            assemble: _,
            solve: _,
            adapt: _,
        } = self;
        let mut found = Vec::new();
        let mut add = |part, key: String, values: &'s mut [Quantity]| {
            let values = values.iter_mut().map(Varying::Quantity);
            found.extend(values.map(|value| ((part, key.clone()), value)));
        };
        for (i, clamp) in clamps.iter_mut().enumerate() {
            add(Loads, format!("clamp.{i}.value"), &mut clamp.value);
        }
        for (i, spring) in springs.iter_mut().enumerate() {
            for (name, value) in spring.quantities_mut() {
                add(Operator, format!("spring.{i}.{name}"), from_mut(value));
            }
        }
        for (i, traction) in tractions.iter_mut().enumerate() {
            add(Loads, format!("traction.{i}.value"), &mut traction.value);
        }
        for (i, pressure) in pressures.iter_mut().enumerate() {
            let value = from_mut(&mut pressure.value);
            add(Loads, format!("pressure.{i}.value"), value);
        }
        for (k, step) in steps.iter_mut().enumerate() {
            for (name, value) in &mut step.value {
                let key = format!("step.{k}.value.{name}");
                add(Loads, key, value.components_mut());
            }
        }
        if let Some(force) = body_force {
            add(Loads, "body_force.value".to_owned(), &mut force.value);
        }
        let mut laws = Vec::new();
        let count = contacts.len();
        for (entry, contact) in contacts.iter_mut().enumerate() {
            let key = contact_key(count, entry);
            let Contact {
                face: _,
                obstacle,
                name: _,
                corners: _,
                gap,
                axis_1,
                angle,
                multipliers: _,
                slip_interpolation: _,
                friction,
            } = contact;
            match obstacle {
                Some(Obstacle::Height(height)) => {
                    let value = from_mut(&mut height.value);
                    add(Mesh, format!("{key}.obstacle.height.value"), value);
                }
                Some(Obstacle::HalfSpace(_) | Obstacle::Sphere(_) | Obstacle::Cylinder(_))
                | None => {}
            }
            add(Loads, format!("{key}.gap"), from_mut(gap));
            if let Some(axis) = axis_1 {
                add(Operator, format!("{key}.axis_1"), axis);
            }
            if let Some(angle) = angle {
                add(Operator, format!("{key}.angle"), from_mut(angle));
            }
            if let Some(friction) = friction {
                laws.push((format!("{key}.friction"), friction));
            }
        }
        if let Some(friction) = friction {
            laws.push(("friction".to_owned(), friction));
        }
        let mut coefficients = Vec::new();
        for (
            key,
            Friction {
                slip_bound,
                pressure_cap: _,
                coefficient,
                coefficient_1,
                coefficient_2,
                follows: _,
            },
        ) in laws
        {
            if let Some(bound) = slip_bound {
                add(Law, format!("{key}.slip_bound"), from_mut(bound));
            }
            let given = [
                ("coefficient", coefficient),
                ("coefficient_1", coefficient_1),
                ("coefficient_2", coefficient_2),
            ];
            for (name, law) in given {
                if let Some(law) = law {
                    let key = (Law, format!("{key}.{name}.{}", law.kind()));
                    coefficients.push((key, Varying::Coefficient(law)));
                }
            }
        }
        found.extend(coefficients);
        found
    }
}

/// A key of the scene, and what it is part of.
type Key = (ProblemPart, String);

/// A value that may be a formula or a function.
enum Varying<'a> {
    Quantity(&'a mut Quantity),
    Coefficient(&'a mut Coefficient),
}

impl Varying<'_> {
    fn is_function(&self) -> bool {
        match self {
            Self::Quantity(quantity) => matches!(quantity, Quantity::Function(_)),
            Self::Coefficient(law) => matches!(law, Coefficient::Function(_)),
        }
    }
}

/// Refuses a parameter that formulas cannot use.
fn check(name: &str, value: f64) -> Result<(), InvalidValue> {
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
    )?;
    require(
        value.is_finite(),
        key(),
        "a finite number",
        value,
        "give a number such as 0.3",
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
