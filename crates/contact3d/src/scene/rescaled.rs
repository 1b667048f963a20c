//! The same problem in other units, or with other loads.

use toml::Table;

use super::{
    Coefficient, Expression, LAW_VARIABLES, Measure, POSITION, Quantity, Scene,
    key::{for_each_number, key, retain_keys},
    load_path::key_of_target,
    varying::{Varying, VaryingKey},
};

/// Factors by which numbers change when units do. All three are free: linear elasticity scales with
/// displacement and stress apart from the size of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitChange {
    /// Of coordinates.
    pub length: f64,
    /// Of displacements, gaps, and the slips that a law of friction knows.
    pub displacement: f64,
    /// Of stresses and multipliers.
    pub stress: f64,
}

impl UnitChange {
    fn factor(self, measure: Measure) -> f64 {
        measure.factor([self.length, self.displacement, self.stress])
    }
}

impl Scene {
    /// The scene with all its numbers and formulas in other units; the words for units stay.
    ///
    /// # Panics
    /// For whole numbers beyond those of TOML, which no validated scene has.
    #[must_use]
    pub fn in_units(&self, change: UnitChange) -> Self {
        let mut numbers = self.clone();
        for (_, value) in numbers.varying_mut() {
            // What varies follows below.
            if let Varying::Quantity(quantity) = value {
                *quantity = Quantity::default();
            }
        }
        let mut table = Table::try_from(numbers).expect("a table");
        retain_keys(&mut table, "", &mut |path, value| {
            let measure = key(path).map(|key| key.measure);
            let factor = change.factor(measure.unwrap_or_default());
            for_each_number(value, &mut |number| *number *= factor);
            true
        });
        let mut image: Self = table.try_into().expect("a scene");
        let (targets, mut scene) = (self.initial_values(), self.clone());
        let measure = |key: &VaryingKey| match key.path.split_once(".value.") {
            // A step gives the value of another key.
            Some((_, name)) => key_of_target(&targets, name).map(|key| key + ".value"),
            None => Some(key.path.clone()),
        };
        let varying = image.varying_mut().into_iter().zip(scene.varying_mut());
        for ((place, new), (_, old)) in varying {
            let measure = measure(&place).and_then(|path| Some(key(&path)?.measure));
            match (new, old) {
                (Varying::Quantity(new), Varying::Quantity(old)) => {
                    let factor = change.factor(measure.unwrap_or_default());
                    *new = old.at_scale(change.length).times(factor);
                }
                (Varying::Coefficient(new), Varying::Coefficient(old)) => {
                    if let Some(law) = old.in_units(change) {
                        *new = law;
                    }
                }
                _ => {}
            }
        }
        image
    }
}

/// Variables in old units, by those in new ones.
fn scaled<const N: usize>(
    names: [&'static str; N],
    variables: &'static [&'static str],
    factor: f64,
) -> impl Iterator<Item = (&'static str, Expression)> {
    let old = move |name| {
        let new = Expression::variable(name, variables);
        (name, new.times(1.0 / factor))
    };
    names.into_iter().map(old)
}

impl Quantity {
    /// The quantity where coordinates are so many times larger.
    fn at_scale(&self, factor: f64) -> Self {
        match self {
            Self::Constant(_) => self.clone(),
            Self::Varying(formula) => {
                let places: Vec<_> = scaled(["x", "y", "z"], POSITION, factor).collect();
                Self::Varying(formula.substitute(&places))
            }
        }
    }
}

impl Coefficient {
    /// The coefficient where it is a formula; `None` for numbers.
    fn in_units(&self, change: UnitChange) -> Option<Self> {
        let Self::Expression(formula) = self else {
            return None;
        };
        let places = scaled(["x", "y", "z"], LAW_VARIABLES, change.length);
        let slips = scaled(["s", "s1", "s2"], LAW_VARIABLES, change.displacement);
        let old: Vec<_> = places.chain(slips).collect();
        Some(Self::Expression(formula.substitute(&old)))
    }
}
