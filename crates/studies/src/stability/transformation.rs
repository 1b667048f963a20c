//! The same problem in other units, in a mirror, or with two axes exchanged.

use contact3d::scene::{
    Body, Clamp, Coefficient, Component, Contact, Friction, Functional, InvalidValue, LawPoint,
    Material, Obstacle, POSITION, Part, Quantity, Scene, SlipDerivative, Spring, SteppedValue,
};

/// Another description of a problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transformation {
    /// Other units.
    Units(UnitChange),
    /// y → L_y − y for this L_y, which takes a brick on z_min to a brick on z_min, and its mesh to the mesh of that brick.
    Mirror(f64),
    /// x ↔ y, which does the same.
    Exchange,
}

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

impl Transformation {
    /// The mirror of a scene.
    #[must_use]
    pub fn mirror(scene: &Scene) -> Self {
        Self::Mirror(scene.body.as_brick().map_or(0.0, |brick| brick.size[1]))
    }

    /// The scene described anew; `None` where it has no such description.
    ///
    /// # Errors
    /// A step that changes what the scene does not have.
    pub fn apply(self, scene: &Scene) -> Result<Option<Scene>, InvalidValue> {
        if !self.covers(scene) {
            return Ok(None);
        }
        let units = self.units();
        let force_density = units.stress / units.length;
        let mut image = scene.clone();
        image.map_step_values(|target, values| {
            let factor = match target {
                SteppedValue::Traction(_) | SteppedValue::Pressure(_) => units.stress,
                SteppedValue::BodyForce => force_density,
                SteppedValue::Gap(_) | SteppedValue::Clamp(_) => units.displacement,
            };
            match values {
                [x, y, z] => self.vector([x, y, z], factor).to_vec(),
                numbers => numbers.iter().map(|n| self.quantity(n, factor)).collect(),
            }
        })?;
        // Every key by name, so that a new one does not compile before it is said what becomes of it.
        let Scene {
            title: _,
            reference: _,
            units: _,
            parameters: _,
            body,
            material,
            regions,
            clamps,
            springs,
            tractions,
            pressures,
            body_force,
            contacts,
            friction,
            steps: _,
            assemble: _,
            solve: _,
            adapt,
        } = &mut image;
        self.map_body(body);
        self.map_material(material);
        for region in regions {
            self.map_material(&mut region.material);
            if let Part::Box(part) = &mut region.part {
                self.map_corners(part);
            }
        }
        clamps.iter_mut().for_each(|clamp| self.map_clamp(clamp));
        springs.iter_mut().for_each(|it| self.map_spring(it));
        for traction in tractions {
            self.map_face(&mut traction.face);
            traction.value = self.vector(traction.value.each_ref(), units.stress);
        }
        for pressure in pressures {
            self.map_face(&mut pressure.face);
            pressure.value = self.quantity(&pressure.value, units.stress);
        }
        if let Some(force) = body_force {
            force.value = self.vector(force.value.each_ref(), force_density);
        }
        contacts.iter_mut().for_each(|it| self.map_contact(it));
        *friction = friction.as_ref().map(|own| self.friction(own));
        if let Some(of) = adapt.as_mut().and_then(|adapt| adapt.of.as_mut()) {
            self.map_functional(of);
        }
        Ok(Some(image))
    }

    /// Whether a scene has the other description. Against an obstacle, distances between points have to scale as displacements do. Maps
    /// of space leave out bodies from mesh files, other contact faces, meshes whose image is another mesh, axes of friction
    /// given as vectors, and heights along x and y, whose formulas have no image as they are.
    fn covers(self, scene: &Scene) -> bool {
        let obstacles = || scene.contacts.iter().filter_map(|c| c.obstacle.as_ref());
        match (self, scene.body.as_brick()) {
            (Self::Units(units), _) => {
                units.length == units.displacement || obstacles().next().is_none()
            }
            (_, None) => false,
            (_, Some(brick)) => {
                let below = |contact: &Contact| contact.face == "z_min" && contact.axis_1.is_none();
                // Exchanged axes make y, not x, the axis that is projected on tangent planes.
                let projected = self == Self::Exchange && scene.has_friction();
                let has_image = |obstacle: &Obstacle| match obstacle {
                    Obstacle::Height(height) => !projected && height.direction.axis().0 == 2,
                    _ => !projected,
                };
                let even = brick.cells[1].is_multiple_of(2);
                scene.contacts.iter().all(below)
                    && (even || self == Self::Exchange)
                    && obstacles().all(has_image)
            }
        }
    }

    /// By what numbers change.
    fn units(self) -> UnitChange {
        match self {
            Self::Units(units) => units,
            Self::Mirror(_) | Self::Exchange => UnitChange {
                length: 1.0,
                displacement: 1.0,
                stress: 1.0,
            },
        }
    }

    /// Where a point of the scene goes.
    fn image(self, at: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Units(units) => at.map(|x| x * units.length),
            Self::Mirror(_) | Self::Exchange => self.origin(at),
        }
    }

    /// The point that goes to a point of the image.
    #[must_use]
    pub fn origin(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Units(units) => [x, y, z].map(|x| x / units.length),
            Self::Mirror(width) => [x, width - y, z],
            Self::Exchange => [y, x, z],
        }
    }

    /// The same in formulas.
    fn origins(self) -> Vec<(&'static str, String)> {
        match self {
            Self::Units(units) => scaled_names(POSITION.iter().copied(), units.length),
            Self::Mirror(width) => vec![("y", format!("{width:e} - y"))],
            Self::Exchange => vec![("x", "y".to_owned()), ("y", "x".to_owned())],
        }
    }

    /// Where a direction goes.
    fn direction(self, direction: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.exchanged(direction);
        match self {
            Self::Mirror(_) => [x, -y, z],
            Self::Units(_) | Self::Exchange => [x, y, z],
        }
    }

    /// The components (along t₁, t₂) that a tangential stress of the image had.
    #[must_use]
    pub fn tangential(self, [first, second]: [f64; 2]) -> [f64; 2] {
        let [first, second, _] = self.direction([first, second, 0.0]);
        [first, second]
    }

    /// What belongs to x and y, or to t₁ and t₂, first, without signs.
    fn exchanged<T, const N: usize>(self, mut values: [T; N]) -> [T; N] {
        if self == Self::Exchange {
            values.swap(0, 1);
        }
        values
    }

    fn map_face(self, face: &mut String) {
        let image = match (self, face.as_str()) {
            (Self::Mirror(_), "y_min") => "y_max",
            (Self::Mirror(_), "y_max") => "y_min",
            (Self::Exchange, "x_min") => "y_min",
            (Self::Exchange, "x_max") => "y_max",
            (Self::Exchange, "y_min") => "x_min",
            (Self::Exchange, "y_max") => "x_max",
            _ => return,
        };
        *face = image.to_owned();
    }

    fn map_corners(self, corners: &mut [[f64; 3]; 2]) {
        let [a, b] = corners.map(|corner| self.image(corner));
        *corners = [
            std::array::from_fn(|c| a[c].min(b[c])),
            std::array::from_fn(|c| a[c].max(b[c])),
        ];
    }

    fn map_body(self, body: &mut Body) {
        if let Self::Units(units) = self {
            body.scale(units.length);
        } else if let Some(brick) = body.as_brick_mut() {
            brick.size = self.exchanged(brick.size);
            brick.cells = self.exchanged(brick.cells);
            let (grading, planes) = (&mut brick.grading, &mut brick.coordinates);
            if let Self::Mirror(width) = self {
                std::mem::swap(&mut grading.y_min, &mut grading.y_max);
                if let Some(given) = &mut planes.y {
                    given.reverse();
                    given.iter_mut().for_each(|y| *y = width - *y);
                }
            } else {
                std::mem::swap(&mut grading.x_min, &mut grading.y_min);
                std::mem::swap(&mut grading.x_max, &mut grading.y_max);
                std::mem::swap(&mut planes.x, &mut planes.y);
            }
        }
    }

    fn map_clamp(self, clamp: &mut Clamp) {
        clamp.face.iter_mut().for_each(|face| self.map_face(face));
        clamp.corners.iter_mut().for_each(|c| self.map_corners(c));
        let components = &mut clamp.components;
        components.iter_mut().for_each(|c| self.map_component(c));
        clamp.value = self.vector(clamp.value.each_ref(), self.units().displacement);
    }

    fn map_component(self, component: &mut Component) {
        *component = match (self, *component) {
            (Self::Exchange, Component::X) => Component::Y,
            (Self::Exchange, Component::Y) => Component::X,
            (_, same) => same,
        };
    }

    fn map_spring(self, spring: &mut Spring) {
        let stiffness = self.units().stress / self.units().displacement;
        self.map_face(&mut spring.face);
        for value in spring.normal.iter_mut().chain(&mut spring.tangential) {
            *value = self.quantity(value, stiffness);
        }
        if let Some(tensor) = &mut spring.tensor {
            *tensor = self.tensor(tensor, stiffness);
        }
    }

    fn map_functional(self, of: &mut Functional) {
        match of {
            Functional::MeanDisplacement { corners, component } => {
                self.map_corners(corners);
                self.map_component(component);
            }
            Functional::MeanPressure { corners } => self.map_corners(corners),
            Functional::NormalForce
            | Functional::TangentialForce
            | Functional::LargestPressure
            | Functional::ContactArea
            | Functional::StickArea
            | Functional::LargestDisplacement
            | Functional::StrainEnergy
            | Functional::Dissipation => {}
        }
    }

    fn map_material(self, material: &mut Material) {
        let units = self.units();
        let factor = units.stress * units.length / units.displacement;
        match material {
            Material::Isotropic(constants) => constants.young_modulus *= factor,
            Material::Orthotropic(constants) => {
                constants.young_moduli = constants.young_moduli.map(|e| e * factor);
                constants.shear_moduli = constants.shear_moduli.map(|g| g * factor);
                constants.axes = constants.axes.map(|axis| self.direction(axis));
            }
            Material::Voigt(voigt) => {
                let old = voigt.stiffness;
                // The components xx, yy, zz, yz, xz, xy of a strain seen in the image.
                let (places, signs) = match self {
                    Self::Units(_) => ([0, 1, 2, 3, 4, 5], [1.0; 6]),
                    Self::Mirror(_) => ([0, 1, 2, 3, 4, 5], [1.0, 1.0, 1.0, -1.0, 1.0, -1.0]),
                    Self::Exchange => ([1, 0, 2, 4, 3, 5], [1.0; 6]),
                };
                let entry =
                    |i: usize, j: usize| signs[i] * signs[j] * old[places[i]][places[j]] * factor;
                voigt.stiffness = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
            }
        }
    }

    /// A quantity of the place, itself times `factor`.
    fn quantity(self, quantity: &Quantity, factor: f64) -> Quantity {
        quantity
            .seen_from(&self.origins(), move |at| self.origin(at))
            .times(factor)
    }

    fn vector(self, components: [&Quantity; 3], factor: f64) -> [Quantity; 3] {
        let (signs, components) = (self.direction([factor; 3]), self.exchanged(components));
        std::array::from_fn(|c| self.quantity(components[c], signs[c]))
    }

    /// M K Mᵀ for the map M of vectors.
    fn tensor(self, tensor: &[[Quantity; 3]; 3], factor: f64) -> [[Quantity; 3]; 3] {
        let (order, signs) = (self.exchanged([0, 1, 2]), self.direction([1.0; 3]));
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let own = &tensor[order[i]][order[j]];
                self.quantity(own, signs[i] * signs[j] * factor)
            })
        })
    }

    fn map_contact(self, contact: &mut Contact) {
        let turned = match self {
            Self::Units(_) => 1.0,
            Self::Mirror(_) | Self::Exchange => -1.0,
        };
        contact.gap = self.quantity(&contact.gap, self.units().displacement);
        contact.corners.iter_mut().for_each(|c| self.map_corners(c));
        let obstacle = contact.obstacle.iter_mut();
        obstacle.for_each(|own| self.map_obstacle(own));
        if let Some(angle) = &mut contact.angle {
            *angle = self.quantity(angle, turned);
        }
        for component in contact.axis_1.iter_mut().flatten() {
            *component = self.quantity(component, 1.0);
        }
        contact.friction = contact.friction.as_ref().map(|own| self.friction(own));
    }

    fn map_obstacle(self, obstacle: &mut Obstacle) {
        let length = self.units().length;
        match obstacle {
            Obstacle::HalfSpace(half) => {
                half.point = self.image(half.point);
                half.normal = self.direction(half.normal);
            }
            Obstacle::Sphere(sphere) => {
                sphere.centre = self.image(sphere.centre);
                sphere.radius *= length;
            }
            Obstacle::Cylinder(cylinder) => {
                cylinder.point = self.image(cylinder.point);
                cylinder.direction = self.direction(cylinder.direction);
                cylinder.radius *= length;
            }
            Obstacle::Height(height) => height.value = self.quantity(&height.value, length),
        }
    }

    fn friction(self, friction: &Friction) -> Friction {
        let stress = self.units().stress;
        let along = [&friction.coefficient_1, &friction.coefficient_2];
        let image = |law: &Option<Coefficient>| law.as_ref().map(|law| self.coefficient(law));
        let [coefficient_1, coefficient_2] = self.exchanged(along.map(image));
        let bound = friction.slip_bound.as_ref();
        Friction {
            slip_bound: bound.map(|bound| self.quantity(bound, stress)),
            pressure_cap: friction.pressure_cap.map(|cap| cap * stress),
            coefficient: image(&friction.coefficient),
            coefficient_1,
            coefficient_2,
            follows: friction.follows,
        }
    }

    fn coefficient(self, coefficient: &Coefficient) -> Coefficient {
        let d = self.units().displacement;
        let mut image = coefficient.clone();
        match &mut image {
            Coefficient::Constant(_) => {}
            Coefficient::Ramp(ramp) => {
                ramp.onset *= d;
                ramp.rate /= d;
            }
            Coefficient::Table(table) => table.slip.iter_mut().for_each(|s| *s *= d),
            Coefficient::Grid(grid) => {
                let slips = grid.slip_1.iter_mut().chain(&mut grid.slip_2);
                slips.for_each(|s| *s *= d);
                if self == Self::Exchange {
                    let column = |j: usize| grid.value.iter().map(|row| row[j]).collect();
                    grid.value = (0..grid.slip_2.len()).map(column).collect();
                    std::mem::swap(&mut grid.slip_1, &mut grid.slip_2);
                }
            }
            Coefficient::Expression(formula) => {
                let mut old = self.origins();
                old.extend(match self {
                    Self::Units(_) => scaled_names(["s", "s1", "s2"].into_iter(), d),
                    Self::Mirror(_) => Vec::new(),
                    Self::Exchange => vec![("s1", "s2".to_owned()), ("s2", "s1".to_owned())],
                });
                *formula = formula.with_variables(&old);
            }
            Coefficient::Function(function) => {
                *function = function.seen_from(
                    move |at| LawPoint {
                        position: self.origin(at.position),
                        slip: self.exchanged(at.slip).map(|s| s / d),
                        own_slip: at.own_slip / d,
                    },
                    move |derivative| SlipDerivative {
                        own: derivative.own / d,
                        pair: self.exchanged(derivative.pair).map(|slope| slope / d),
                    },
                );
            }
        }
        image
    }
}

/// Variables in old units, by those in new ones.
fn scaled_names(
    names: impl Iterator<Item = &'static str>,
    factor: f64,
) -> Vec<(&'static str, String)> {
    let old = |name| (name, format!("{name}*{:e}", 1.0 / factor));
    names.map(old).collect()
}
