//! Scenes of bricks on z_min in a mirror, and with two axes exchanged.

use contact3d::scene::{
    Brick, Clamp, Coefficient, Component, Contact, Expression, Formula, Friction, Functional,
    LAW_VARIABLES, Material, Obstacle, POSITION, Part, Quantity, Scene, Spring,
};

/// A symmetry of space that takes bricks on z_min to bricks on z_min, and their meshes to the meshes of those.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Symmetry {
    /// y → L_y − y for this L_y.
    Mirror(f64),
    /// x ↔ y.
    Exchange,
}

/// The same without the size of the brick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Mirror,
    Exchange,
}

impl Symmetry {
    pub(super) fn new(kind: Kind, scene: &Scene) -> Self {
        match kind {
            Kind::Mirror => Self::Mirror(scene.as_brick().expect("a brick").size[1]),
            Kind::Exchange => Self::Exchange,
        }
    }

    /// Where a point goes, and where it comes from.
    pub(super) fn image(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Mirror(width) => [x, width - y, z],
            Self::Exchange => [y, x, z],
        }
    }

    /// Where a direction goes, also that of a pair along t₁ and t₂.
    pub(super) fn direction(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Mirror(_) => [x, -y, z],
            Self::Exchange => [y, x, z],
        }
    }

    /// What belongs to x and y, or to t₁ and t₂, without signs.
    fn exchanged<T, const N: usize>(self, mut values: [T; N]) -> [T; N] {
        if self == Self::Exchange {
            values.swap(0, 1);
        }
        values
    }

    /// The image of a scene.
    pub(super) fn apply(self, scene: &Scene) -> Scene {
        let mut image = scene.clone();
        self.brick(image.as_brick_mut().expect("a brick"));
        let regions = image.regions.iter_mut();
        for region in regions {
            self.material(&mut region.material);
            if let Part::Box(corners) = &mut region.part {
                self.corners(corners);
            }
        }
        image.material.iter_mut().for_each(|own| self.material(own));
        image.clamps.iter_mut().for_each(|it| self.clamp(it));
        image.springs.iter_mut().for_each(|it| self.spring(it));
        for traction in &mut image.tractions {
            self.face(&mut traction.face);
            self.vector(&mut traction.value);
        }
        for force in &mut image.forces {
            self.face(&mut force.face);
            self.vector(&mut force.value);
            // A moment turns the other way round in a mirror.
            self.vector(&mut force.moment);
            force.moment = force.moment.clone().map(|part| part.times(-1.0));
            let discs = force.disc.iter_mut();
            discs.for_each(|disc| disc.centre = self.image(disc.centre));
        }
        for pressure in &mut image.pressures {
            self.face(&mut pressure.face);
            self.quantity(&mut pressure.value);
        }
        let forces = image.body_force.iter_mut();
        forces.for_each(|force| self.vector(&mut force.value));
        image.contacts.iter_mut().for_each(|it| self.contact(it));
        let laws = image.friction.iter_mut();
        laws.for_each(|law| self.friction(law));
        if let Some(Functional::MeanDisplacement { corners, component }) =
            image.adapt.as_mut().and_then(|adapt| adapt.of.as_mut())
        {
            self.corners(corners);
            *component = self.component(*component);
        }
        image
    }

    fn face(self, face: &mut String) {
        let [axis, end] = match face.split_once('_') {
            Some((axis, end)) => [axis, end],
            None => return,
        };
        let other_end = if end == "min" { "max" } else { "min" };
        *face = match (self, axis) {
            (Self::Mirror(_), "y") => format!("y_{other_end}"),
            (Self::Exchange, "x") => format!("y_{end}"),
            (Self::Exchange, "y") => format!("x_{end}"),
            _ => return,
        };
    }

    fn corners(self, corners: &mut [[f64; 3]; 2]) {
        let [a, b] = corners.map(|corner| self.image(corner));
        let ordered = |pick: fn(f64, f64) -> f64| std::array::from_fn(|c| pick(a[c], b[c]));
        *corners = [ordered(f64::min), ordered(f64::max)];
    }

    fn brick(self, brick: &mut Brick) {
        brick.size = self.exchanged(brick.size);
        brick.cells = self.exchanged(brick.cells);
        let (grading, planes) = (&mut brick.grading, &mut brick.coordinates);
        match self {
            Self::Mirror(width) => {
                std::mem::swap(&mut grading.y_min, &mut grading.y_max);
                if let Some(given) = &mut planes.y {
                    given.reverse();
                    given.iter_mut().for_each(|y| *y = width - *y);
                }
            }
            Self::Exchange => {
                std::mem::swap(&mut grading.x_min, &mut grading.y_min);
                std::mem::swap(&mut grading.x_max, &mut grading.y_max);
                std::mem::swap(&mut planes.x, &mut planes.y);
            }
        }
    }

    fn component(self, component: Component) -> Component {
        match (self, component) {
            (Self::Exchange, Component::X) => Component::Y,
            (Self::Exchange, Component::Y) => Component::X,
            (_, same) => same,
        }
    }

    fn clamp(self, clamp: &mut Clamp) {
        clamp.face.iter_mut().for_each(|face| self.face(face));
        clamp.corners.iter_mut().for_each(|it| self.corners(it));
        let components = clamp.components.iter_mut();
        components.for_each(|component| *component = self.component(*component));
        self.vector(&mut clamp.value);
    }

    /// M K Mᵀ for the map M of vectors.
    fn spring(self, spring: &mut Spring) {
        self.face(&mut spring.face);
        let of_face = spring.normal.iter_mut().chain(&mut spring.tangential);
        of_face.for_each(|value| self.quantity(value));
        if let Some(tensor) = &mut spring.tensor {
            *tensor = self.exchanged(tensor.clone().map(|row| self.exchanged(row)));
            let signs = self.direction([1.0; 3]);
            for (i, row) in tensor.iter_mut().enumerate() {
                for (j, value) in row.iter_mut().enumerate() {
                    self.quantity(value);
                    *value = value.times(signs[i] * signs[j]);
                }
            }
        }
    }

    fn material(self, material: &mut Material) {
        match material {
            Material::Isotropic(_) => {}
            Material::Orthotropic(constants) => {
                constants.axes = constants.axes.map(|axis| self.direction(axis));
            }
            Material::Voigt(voigt) => {
                let old = voigt.stiffness;
                // The components xx, yy, zz, yz, xz, xy of a strain seen in the image.
                let (places, signs) = match self {
                    Self::Mirror(_) => ([0, 1, 2, 3, 4, 5], [1.0, 1.0, 1.0, -1.0, 1.0, -1.0]),
                    Self::Exchange => ([1, 0, 2, 4, 3, 5], [1.0; 6]),
                };
                let entry = |i: usize, j: usize| signs[i] * signs[j] * old[places[i]][places[j]];
                voigt.stiffness = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
            }
        }
    }

    /// Coordinates of the scene by those of the image.
    fn places(self, variables: &'static [&'static str]) -> Vec<(&'static str, Expression)> {
        let formula = |text: &str| Expression::parse(text, variables).expect("a formula");
        match self {
            Self::Mirror(width) => vec![("y", formula(&format!("{width:?} - y")))],
            Self::Exchange => vec![("x", formula("y")), ("y", formula("x"))],
        }
    }

    fn quantity(self, quantity: &mut Quantity) {
        match quantity {
            Quantity::Constant(_) => {}
            Quantity::Varying(formula) => *formula = formula.substitute(&self.places(POSITION)),
        }
    }

    fn vector(self, vector: &mut [Quantity; 3]) {
        *vector = self.exchanged(vector.clone());
        for (value, sign) in vector.iter_mut().zip(self.direction([1.0; 3])) {
            self.quantity(value);
            *value = value.times(sign);
        }
    }

    fn contact(self, contact: &mut Contact) {
        assert_eq!(contact.face, "z_min");
        if let Some(axis) = &mut contact.axis_1 {
            // An exchange makes t₁ of a given axis what it was, and t₂ its opposite: no exchange of t₁ and t₂.
            assert!(matches!(self, Self::Mirror(_)), "an axis that is given");
            self.vector(axis);
        }
        self.quantity(&mut contact.gap);
        contact.corners.iter_mut().for_each(|it| self.corners(it));
        if let Some(angle) = &mut contact.angle {
            self.quantity(angle);
            *angle = angle.times(-1.0);
        }
        match &mut contact.obstacle {
            None => {}
            Some(Obstacle::HalfSpace(half)) => {
                half.point = self.image(half.point);
                half.normal = self.direction(half.normal);
            }
            Some(Obstacle::Sphere(sphere)) => sphere.centre = self.image(sphere.centre),
            Some(Obstacle::Cylinder(cylinder)) => {
                cylinder.point = self.image(cylinder.point);
                cylinder.direction = self.direction(cylinder.direction);
            }
            Some(Obstacle::Height(height)) => self.quantity(&mut height.value),
            Some(Obstacle::Surface(_)) => panic!("a file has no image"),
        }
        let laws = contact.friction.iter_mut();
        laws.for_each(|law| self.friction(law));
    }

    fn friction(self, law: &mut Friction) {
        law.slip_bound.iter_mut().for_each(|it| self.quantity(it));
        let pair = [law.coefficient_1.take(), law.coefficient_2.take()];
        [law.coefficient_1, law.coefficient_2] = self.exchanged(pair);
        let common = law.coefficient.iter_mut();
        let pair = law.coefficient_1.iter_mut().chain(&mut law.coefficient_2);
        common.chain(pair).for_each(|it| self.coefficient(it));
    }

    fn coefficient(self, coefficient: &mut Coefficient) {
        match coefficient {
            Coefficient::Constant(_) | Coefficient::Ramp(_) | Coefficient::Table(_) => {}
            Coefficient::Grid(grid) if self == Self::Exchange => {
                let column = |j: usize| grid.value.iter().map(|row| row[j]).collect();
                grid.value = (0..grid.slip_2.len()).map(column).collect();
                std::mem::swap(&mut grid.slip_1, &mut grid.slip_2);
            }
            Coefficient::Grid(_) => {}
            Coefficient::Expression(formula) => {
                let slip = |text: &str| Expression::parse(text, LAW_VARIABLES).expect("a slip");
                let mut old = self.places(LAW_VARIABLES);
                if self == Self::Exchange {
                    old.extend([("s1", slip("s2")), ("s2", slip("s1"))]);
                }
                *formula = Formula::substitute(formula, &old);
            }
        }
    }
}
