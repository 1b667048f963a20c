use super::{Body, Coefficient, Face, Invalid, Material, Scene};

/// Refuses `found` at `key` unless `ok`.
fn require(
    ok: bool,
    key: impl Into<String>,
    expected: &str,
    found: impl std::fmt::Debug,
    help: &str,
) -> Result<(), Invalid> {
    if ok {
        return Ok(());
    }
    Err(Invalid {
        key: key.into(),
        expected: expected.to_owned(),
        found: format!("{found:?}"),
        help: help.to_owned(),
    })
}

fn positive(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

impl Scene {
    /// Checks every value of the scene against what the model allows (SPEC: HKL §2, §4).
    ///
    /// # Errors
    /// The first offending key.
    pub fn validate(&self) -> Result<(), Invalid> {
        self.validate_body()?;
        self.validate_material()?;
        self.validate_supports()?;
        self.validate_contact()?;
        self.validate_friction()?;
        self.validate_solve()
    }

    fn validate_body(&self) -> Result<(), Invalid> {
        let Body::Brick(brick) = &self.body;
        require(
            brick.size.iter().all(|&l| positive(l)),
            "body.brick.size",
            "three positive lengths [m]",
            brick.size,
            "give the edge lengths Lx, Ly, Lz",
        )?;
        let contact_axis = self.contact.face.axis();
        for (axis, &cells) in brick.cells.iter().enumerate() {
            let name = ["nx", "ny", "nz"][axis];
            let even = axis == contact_axis || cells % 2 == 0;
            require(
                (1..=4096).contains(&cells) && even,
                "body.brick.cells",
                &format!("{name} from 1 to 4096, even along the contact face"),
                brick.cells,
                "a pane is 2 x 2 cells of the contact face, so both of its cell counts are even",
            )?;
        }
        Ok(())
    }

    fn validate_material(&self) -> Result<(), Invalid> {
        let Material::Isotropic(material) = &self.material;
        require(
            positive(material.young_modulus),
            "material.isotropic.young_modulus",
            "a positive modulus [Pa]",
            material.young_modulus,
            "steel has 2.1e11 Pa",
        )?;
        require(
            material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5,
            "material.isotropic.poisson_ratio",
            "a ratio with -1 < ratio < 0.5",
            material.poisson_ratio,
            "at 0.5 the material is incompressible and this displacement method has no solution; use 0.499 or less",
        )
    }

    fn validate_supports(&self) -> Result<(), Invalid> {
        let mut held = [false; 3];
        for (i, clamp) in self.clamps.iter().enumerate() {
            require(
                !clamp.components.is_empty(),
                format!("clamp.{i}.components"),
                "at least one of x, y, z",
                &clamp.components,
                "leave the key out to hold all three components",
            )?;
            require(
                clamp.face != self.contact.face,
                format!("clamp.{i}.face"),
                "a face other than the contact face",
                clamp.face.name(),
                "a face is either held or in contact",
            )?;
            for &component in &clamp.components {
                held[component as usize] = true;
            }
        }
        require(
            held == [true; 3],
            "clamp",
            "clamps that hold u_x, u_y and u_z somewhere",
            format!("u_x {}, u_y {}, u_z {}", held[0], held[1], held[2]),
            "an unheld body can move as a rigid one; add [[clamp]] with a face",
        )?;
        for (i, traction) in self.tractions.iter().enumerate() {
            require(
                traction.value.iter().all(|p| p.is_finite()),
                format!("traction.{i}.value"),
                "three finite numbers [Pa]",
                traction.value,
                "give the traction vector p",
            )?;
            require(
                self.is_free(traction.face),
                format!("traction.{i}.face"),
                "a face that is neither held nor in contact",
                traction.face.name(),
                "tractions act on free faces only",
            )?;
        }
        Ok(())
    }

    fn is_free(&self, face: Face) -> bool {
        face != self.contact.face
            && !self
                .clamps
                .iter()
                .any(|c| c.face == face && c.components.len() >= 3)
    }

    fn validate_contact(&self) -> Result<(), Invalid> {
        require(
            self.contact.gap >= 0.0 && self.contact.gap.is_finite(),
            "contact.gap",
            "a gap d >= 0 [m]",
            self.contact.gap,
            "the body may not start inside the foundation",
        )?;
        if let Some(axis) = self.contact.axis_1 {
            let along_normal = axis[self.contact.face.axis()];
            let length = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
            require(
                positive(length) && along_normal == 0.0,
                "contact.axis_1",
                "a non-zero vector in the plane of the contact face",
                axis,
                "t1 must be tangential, for example [1.0, 0.0, 0.0] on z_min",
            )?;
        }
        Ok(())
    }

    fn validate_friction(&self) -> Result<(), Invalid> {
        let coefficients = [
            ("1", self.friction.coefficient_1),
            ("2", self.friction.coefficient_2),
        ];
        for (i, coefficient) in coefficients {
            let key = format!("friction.coefficient_{i}");
            match coefficient {
                Coefficient::Constant(value) => require(
                    positive(value),
                    key + ".constant",
                    "a positive coefficient",
                    value,
                    "the theory needs 0 < F; for no friction use a very small value",
                )?,
                Coefficient::Ramp(ramp) => require(
                    positive(ramp.initial)
                        && positive(ramp.residual)
                        && positive(ramp.rate)
                        && ramp.onset >= 0.0
                        && ramp.onset.is_finite(),
                    key + ".ramp",
                    "initial > 0, residual > 0, rate > 0 [1/m], onset >= 0 [m]",
                    ramp,
                    "rate is the steepness |dF/dslip|; whether F falls or rises follows from initial and residual",
                )?,
            }
        }
        Ok(())
    }

    fn validate_solve(&self) -> Result<(), Invalid> {
        self.solve.validate("solve")
    }
}

impl super::SolveSettings {
    /// Checks the settings; `prefix` is put before the key's name in a message.
    ///
    /// # Errors
    /// The first offending key.
    pub fn validate(&self, prefix: &str) -> Result<(), Invalid> {
        let unit_interval = |value: f64| value > 0.0 && value < 1.0;
        let checks = [
            (
                "epsilon",
                unit_interval(self.epsilon()),
                "0 < epsilon < 1",
                self.epsilon(),
            ),
            (
                "r_tol",
                unit_interval(self.r_tol),
                "0 < r_tol < 1",
                self.r_tol,
            ),
            (
                "c_fact",
                unit_interval(self.c_fact),
                "0 < c_fact < 1",
                self.c_fact,
            ),
            ("gamma", positive(self.gamma), "gamma > 0", self.gamma),
        ];
        for (key, ok, expected, found) in checks {
            require(
                ok,
                format!("{prefix}.{key}"),
                expected,
                found,
                "the paper uses epsilon = 1e-4, r_tol = 0.1, c_fact = 0.99, gamma = 1",
            )?;
        }
        let counts = [
            ("max_outer_steps", self.max_outer_steps),
            ("max_inner_actions", self.max_inner_actions),
        ];
        for (key, count) in counts {
            require(
                count > 0,
                format!("{prefix}.{key}"),
                "at least 1",
                count,
                "leave the key out for the default",
            )?;
        }
        Ok(())
    }
}
