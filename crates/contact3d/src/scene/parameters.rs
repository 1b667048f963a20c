//! The formulas of a scene and the parameters they use.

use std::{collections::BTreeSet, slice::from_mut};

use ProblemPart::{Law, Loads, Mesh, Operator};

use super::{
    Coefficient, Contact, Expression, ExpressionError, Invalid, LAW_VARIABLES, Obstacle,
    Parameters, Quantity, Scene,
    contact::contact_key,
    expression::{is_identifier, meaning},
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
    pub(super) fn bind_parameters(&mut self) -> Result<(), Invalid> {
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
        let laws = self.friction_tables();
        let given = laws.flat_map(|(key, law)| law.given().map(move |given| (key.clone(), given)));
        let mut functions = given.filter(|(_, (_, law))| matches!(law, Coefficient::Function(_)));
        if let Some((key, (name, _))) = functions.next() {
            return Some(format!("{key}.{name}"));
        }
        let mut scene = self.clone();
        let (quantities, _) = scene.varying_mut();
        let mut quantities = quantities.into_iter();
        let is_function = |quantity: &Quantity| matches!(quantity, Quantity::Function(_));
        let found = quantities.find(|(_, quantity)| is_function(quantity));
        found.map(|((_, key), _)| key)
    }

    /// Whether anything varies from place to place: loads, clamps, springs, gaps, obstacles, axes or coefficients.
    pub(super) fn depends_on_place(&self) -> bool {
        let laws = self.friction_tables();
        let mut laws = laws.flat_map(|(_, law)| law.given());
        let mut scene = self.clone();
        let (quantities, _) = scene.varying_mut();
        let mut quantities = quantities.into_iter();
        quantities.any(|(_, quantity)| quantity.constant().is_none())
            || laws.any(|(_, law)| law.depends_on_place())
    }

    /// All formulas with their keys.
    fn formulas_mut(&mut self) -> Vec<(Key, &mut Expression)> {
        let (quantities, laws) = self.varying_mut();
        let quantities = quantities
            .into_iter()
            .filter_map(|(key, quantity)| match quantity {
                Quantity::Varying(expression) => Some((key, expression)),
                Quantity::Constant(_) | Quantity::Function(_) => None,
            });
        let laws = laws
            .into_iter()
            .filter_map(|(key, law)| Some((key, law.formula_mut()?.expression_mut())));
        quantities.chain(laws).collect()
    }

    /// All that may vary with its keys: quantities, and coefficients of friction.
    fn varying_mut<'s>(&'s mut self) -> Varying<'s> {
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
        let mut found: Vec<(Key, &mut [Quantity])> = Vec::new();
        let mut add = |part, key: String, values| found.push(((part, key), values));
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
        for (key, friction) in laws {
            let (quantities, laws) = friction.varying_mut();
            for (name, value) in quantities {
                add(Law, format!("{key}.{name}"), from_mut(value));
            }
            coefficients.extend(laws.into_iter().map(|(name, law)| {
                let key = format!("{key}.{name}.{}", law.kind());
                ((Law, key), law)
            }));
        }
        let each = |(key, values): (Key, &'s mut [Quantity])| {
            values.iter_mut().map(move |value| (key.clone(), value))
        };
        (found.into_iter().flat_map(each).collect(), coefficients)
    }
}

/// A key of the scene, and what it is part of.
type Key = (ProblemPart, String);

/// Quantities, then coefficients of friction, with their keys.
type Varying<'a> = (
    Vec<(Key, &'a mut Quantity)>,
    Vec<(Key, &'a mut Coefficient)>,
);

/// Refuses a parameter that formulas cannot use.
fn check(name: &str, value: f64) -> Result<(), Invalid> {
    let refuse = |expected: &str, found: String, help: &str| {
        Err(Invalid {
            key: format!("parameters.{name}"),
            expected: expected.into(),
            found,
            help: help.into(),
        })
    };
    if let Some(meaning) = meaning(name, LAW_VARIABLES) {
        return refuse(
            "a name that means nothing else in formulas",
            format!("{name}, {meaning} of formulas"),
            &format!("give the parameter another name, such as {name}_0"),
        );
    }
    if !is_identifier(name) {
        return refuse(
            "a name of letters, digits and _ that does not begin with a digit",
            format!("{name:?}"),
            "formulas could not tell it from other names, numbers and signs",
        );
    }
    if !value.is_finite() {
        return refuse(
            "a finite number",
            value.to_string(),
            "give a number such as 0.3",
        );
    }
    Ok(())
}

/// A formula with a name that means nothing.
fn unbound(key: String, text: &str, error: ExpressionError) -> Invalid {
    match error {
        ExpressionError::Unknown { name, known } => Invalid {
            key,
            expected: known,
            found: format!("the unknown name {name} in \"{text}\""),
            help: format!(
                "correct the name, or make it a parameter: {name} = 1.0, with the value you mean, below a line [parameters]"
            ),
        },
        error => Invalid {
            key,
            expected: "a formula".into(),
            found: format!("\"{text}\""),
            help: error.to_string(),
        },
    }
}
