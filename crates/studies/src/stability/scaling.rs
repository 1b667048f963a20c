//! The same problem in other units, and with other coefficients.

use super::Symmetry;
use contact3d::scene::{
    Coefficient, Friction, Grid, Invalid, LawPoint, Material, POSITION, Part, Quantity, Ramp,
    Scene, SlipDerivative, Spring, SteppedValue, Table,
};

/// Factors by which numbers change when units do. All three are free: linear elasticity scales with
/// displacement and stress apart from the size of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct UnitChange {
    /// Of coordinates.
    pub length: f64,
    /// Of displacements, gaps, and the slips that a law of friction knows.
    pub displacement: f64,
    /// Of stresses and multipliers.
    pub stress: f64,
}

impl UnitChange {
    /// Whether distances between points scale as displacements do, which an obstacle asks for.
    pub(super) fn is_similarity(&self) -> bool {
        self.length == self.displacement
    }

    /// The scene with all numbers scaled; its multipliers are those of the scene times `stress`.
    ///
    /// # Errors
    /// A step that changes what the scene does not have.
    pub(crate) fn apply(&self, scene: &Scene) -> Result<Scene, Invalid> {
        let mut scaled = scene.clone();
        self.scale_body(&mut scaled);
        for value in scaled.clamps.iter_mut().flat_map(|clamp| &mut clamp.value) {
            *value = self.quantity(value, self.displacement);
        }
        for (_, value) in scaled.springs.iter_mut().flat_map(Spring::quantities_mut) {
            *value = self.quantity(value, self.stress / self.displacement);
        }
        for traction in &mut scaled.tractions {
            for value in &mut traction.value {
                *value = self.quantity(value, self.stress);
            }
        }
        for pressure in &mut scaled.pressures {
            pressure.value = self.quantity(&pressure.value, self.stress);
        }
        for value in scaled.body_force.iter_mut().flat_map(|f| &mut f.value) {
            *value = self.quantity(value, self.stress / self.length);
        }
        for contact in &mut scaled.contacts {
            contact.gap = self.quantity(&contact.gap, self.displacement);
            let obstacle = contact.obstacle.as_ref();
            contact.obstacle = obstacle.map(|o| self.obstacle(o));
            if let Some(angle) = &mut contact.angle {
                *angle = self.quantity(angle, 1.0);
            }
            for component in contact.axis_1.iter_mut().flatten() {
                *component = self.quantity(component, 1.0);
            }
        }
        scaled.map_step_values(|target, values| {
            let factor = match target {
                SteppedValue::Traction(_) | SteppedValue::Pressure(_) => self.stress,
                SteppedValue::BodyForce => self.stress / self.length,
                SteppedValue::Gap(_) | SteppedValue::Clamp(_) => self.displacement,
            };
            let values = values.iter().map(|value| self.quantity(value, factor));
            values.collect()
        })?;
        let own = scaled.contacts.iter_mut();
        let own = own.filter_map(|contact| contact.friction.as_mut());
        for friction in own.chain(&mut scaled.friction) {
            // Every key by name, so that a new one is not forgotten.
            let Friction {
                slip_bound,
                pressure_cap,
                coefficient,
                coefficient_1,
                coefficient_2,
                follows: _,
            } = friction;
            if let Some(bound) = slip_bound {
                *bound = self.quantity(bound, self.stress);
            }
            if let Some(cap) = pressure_cap {
                *cap *= self.stress;
            }
            let coefficients = [coefficient, coefficient_1, coefficient_2];
            for coefficient in coefficients.into_iter().flatten() {
                *coefficient = self.coefficient(coefficient);
            }
        }
        Ok(scaled)
    }

    fn scale_body(&self, scene: &mut Scene) {
        let elasticity = self.stress * self.length / self.displacement;
        scene.body.scale(self.length);
        let corners = |corners: &mut [[f64; 3]; 2]| {
            *corners = corners.map(|corner| corner.map(|x| x * self.length));
        };
        scale_material(&mut scene.material, elasticity);
        for region in &mut scene.regions {
            scale_material(&mut region.material, elasticity);
            if let Part::Box(part) = &mut region.part {
                corners(part);
            }
        }
        let clamped = scene.clamps.iter_mut().map(|clamp| &mut clamp.corners);
        let touching = scene.contacts.iter_mut();
        let touching = touching.map(|contact| &mut contact.corners);
        clamped.chain(touching).flatten().for_each(corners);
    }

    /// A quantity of the place, itself times `factor`.
    pub(super) fn quantity(&self, quantity: &Quantity, factor: f64) -> Quantity {
        let length = self.length;
        quantity
            .seen_from(&self.places(), move |at| at.map(|x| x / length))
            .times(factor)
    }

    pub(super) fn places(&self) -> Vec<(&'static str, String)> {
        let old = |name: &'static str| (name, format!("{name}*{:e}", 1.0 / self.length));
        POSITION.iter().map(|name| old(name)).collect()
    }
}

fn scale_material(material: &mut Material, factor: f64) {
    match material {
        Material::Isotropic(constants) => constants.young_modulus *= factor,
        Material::Orthotropic(constants) => {
            constants.young_moduli = constants.young_moduli.map(|e| e * factor);
            constants.shear_moduli = constants.shear_moduli.map(|g| g * factor);
        }
        Material::Voigt(voigt) => {
            voigt.stiffness = voigt.stiffness.map(|row| row.map(|c| c * factor));
        }
    }
}

impl UnitChange {
    /// A coefficient in other units.
    pub(super) fn coefficient(&self, coefficient: &Coefficient) -> Coefficient {
        let (length, d) = (self.length, self.displacement);
        let slips = |slips: &[f64]| slips.iter().map(|s| s * d).collect();
        match coefficient {
            Coefficient::Constant(value) => Coefficient::Constant(*value),
            Coefficient::Ramp(ramp) => Coefficient::Ramp(Ramp {
                onset: ramp.onset * d,
                rate: ramp.rate / d,
                ..*ramp
            }),
            Coefficient::Table(table) => Coefficient::Table(Table {
                slip: slips(&table.slip),
                value: table.value.clone(),
            }),
            Coefficient::Grid(grid) => Coefficient::Grid(Grid {
                slip_1: slips(&grid.slip_1),
                slip_2: slips(&grid.slip_2),
                value: grid.value.clone(),
            }),
            Coefficient::Expression(formula) => {
                let mut old = self.places();
                old.extend(["s", "s1", "s2"].map(|name| (name, format!("{name}*{:e}", 1.0 / d))));
                Coefficient::Expression(formula.with_variables(&old))
            }
            Coefficient::Function(function) => Coefficient::Function(function.seen_from(
                move |at| LawPoint {
                    position: at.position.map(|x| x / length),
                    slip: at.slip.map(|s| s / d),
                    own_slip: at.own_slip / d,
                },
                move |derivative| SlipDerivative {
                    own: derivative.own / d,
                    pair: derivative.pair.map(|slope| slope / d),
                },
            )),
        }
    }
}

impl Symmetry {
    /// A coefficient in the image of a brick of this width.
    pub(super) fn coefficient(self, coefficient: &Coefficient, width: f64) -> Coefficient {
        match coefficient {
            Coefficient::Constant(_) | Coefficient::Ramp(_) | Coefficient::Table(_) => {
                coefficient.clone()
            }
            Coefficient::Grid(grid) => Coefficient::Grid(match self {
                Self::Mirror => grid.clone(),
                Self::Exchange => Grid {
                    slip_1: grid.slip_2.clone(),
                    slip_2: grid.slip_1.clone(),
                    value: (0..grid.slip_2.len())
                        .map(|j| grid.value.iter().map(|row| row[j]).collect())
                        .collect(),
                },
            }),
            Coefficient::Expression(formula) => {
                let mut old = self.places(width);
                if self == Self::Exchange {
                    old.extend([("s1", "s2".to_owned()), ("s2", "s1".to_owned())]);
                }
                Coefficient::Expression(formula.with_variables(&old))
            }
            Coefficient::Function(function) => Coefficient::Function(function.seen_from(
                move |at| LawPoint {
                    position: self.point(at.position, width),
                    slip: self.slips(at.slip),
                    own_slip: at.own_slip,
                },
                move |derivative| SlipDerivative {
                    own: derivative.own,
                    pair: self.slips(derivative.pair),
                },
            )),
        }
    }

    /// What belongs to t₁ and t₂, without signs.
    pub(super) fn slips<T>(self, [first, second]: [T; 2]) -> [T; 2] {
        match self {
            Self::Mirror => [first, second],
            Self::Exchange => [second, first],
        }
    }
}
