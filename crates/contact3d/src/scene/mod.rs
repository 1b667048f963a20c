//! The scene: everything a user says about a problem, parsed from TOML and validated.
//!
//! Lengths are metres, forces newtons, stresses pascals in the documentation; a scene may name other
//! units, because no constant of the program has a unit.

mod body;
mod build;
mod coefficient;
mod contact;
mod error;
mod expression;
mod features;
mod file;
mod friction;
mod functional;
mod key;
mod load;
mod load_path;
mod material;
mod obstacle;
mod one_or_several;
mod quantity;
mod rescaled;
mod schema;
mod solve;
mod source;
mod tool;
mod validate;
mod varying;

pub use body::{Body, Brick, BrickFace, ElementOrder, GivenPlanes, GmshFile, Grading, MOST_CELLS};
pub use coefficient::{
    Coefficient, Formula, Grid, LAW_VARIABLES, LawPoint, Ramp, SlipDerivative, Table,
};
pub(crate) use coefficient::{LEAST_COEFFICIENT, is_coefficient};
pub use contact::{Contact, Follow, MultiplierSpace};
pub use error::{InvalidValue, SceneError, SyntaxProblem, Warning, numbers};
pub(crate) use error::{UNDEFINED, place_words};
pub use expression::{BranchEnd, Expression, ExpressionError, FUNCTIONS, FormulaBranch, OnBranch};
pub use features::ContactFeatures;
pub(crate) use file::other_file;
pub use file::{
    LONGEST_SCENE, SceneFile, Written, escape_control, escape_control_lines, is_hidden_control,
    read_bounded, require_regular, to_toml,
};
pub use friction::{Friction, FrictionLaw, FrictionModel, LawWords, SlipBound, SlipMeasure};
pub use functional::Functional;
use key::unwritable;
pub use key::{Key, Measure, ProblemPart, key, keys, unit_of_key};
pub use load::{
    BodyForce, Clamp, Component, Disc, FaceLoad, FacePart, Force, Pressure, Spring, Traction,
};
pub use load_path::{Increment, MOST_INCREMENTS, Step, StepValue};
pub use material::{Isotropic, Material, Orthotropic, Part, Region, Voigt};
pub use obstacle::{Cylinder, Direction, HalfSpace, Height, Obstacle, Side, Sphere, SurfaceFile};
pub use quantity::{POSITION, Quantity};
pub use rescaled::UnitChange;
pub(crate) use schema::nearest;
pub use solve::{
    AdaptSettings, AssembleSettings, DualOperatorKind, FactorPrecision, FirstMesh, InnerSolver,
    Method, PrecisionControl, SMALLEST_ERROR, SolveSettings,
};
pub use source::{Source, number_limit};
pub use tool::{Tool, ToolMotion};

use std::{collections::BTreeMap, path::PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use units::Units;

use one_or_several::entry_key;
use varying::{Varies, Varying, VaryingKey};

/// One contact problem, or a history of them: the body, what holds and loads it, and the law on its contact face.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// A line that names the case in reports and pictures.
    #[serde(default = "untitled")]
    pub title: String,
    /// Where the case comes from (a paper, a table, a drawing).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
    /// The units of all its numbers, in place of the m, N and Pa that descriptions name: only words, nothing is
    /// converted.
    #[serde(default, skip_serializing_if = "Units::is_default")]
    pub units: Units,
    /// Numbers with names, which formulas may use.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, f64>,
    /// The body Ω and its mesh: one as a table, several as an array of tables.
    #[serde(rename = "body", with = "one_or_several")]
    #[schemars(with = "one_or_several::OneOrSeveral<Body>")]
    #[schemars(extend("part" = ProblemPart::Mesh))]
    pub bodies: Vec<Body>,
    /// The elastic law σ = C ε wherever no body and no region has another.
    /// Not given where every body has its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("part" = ProblemPart::Operator))]
    pub material: Option<Material>,
    /// Parts of the body with a material of their own; the last one that holds a tetrahedron counts.
    #[serde(rename = "region", default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("part" = ProblemPart::Operator))]
    pub regions: Vec<Region>,
    /// Faces on which displacement components are held (Γ_u), at zero or at given values.
    #[serde(rename = "clamp", default)]
    #[schemars(extend("part" = ProblemPart::Mesh))]
    pub clamps: Vec<Clamp>,
    /// Springs on faces.
    #[serde(rename = "spring", default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("part" = ProblemPart::Operator))]
    pub springs: Vec<Spring>,
    /// Surface tractions p on faces (Γ_p); tractions on the same face add up.
    #[serde(rename = "traction", default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("part" = ProblemPart::Loads))]
    pub tractions: Vec<Traction>,
    /// Pressures on faces; they add to tractions.
    #[serde(rename = "pressure", default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("part" = ProblemPart::Loads))]
    pub pressures: Vec<Pressure>,
    /// Total forces and moments on faces; they add to both.
    #[serde(rename = "force", default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("part" = ProblemPart::Loads))]
    pub forces: Vec<Force>,
    /// The body force f; none when not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("part" = ProblemPart::Loads))]
    pub body_force: Option<BodyForce>,
    /// The contact faces Γ_c: one as a table, several as an array of tables; without any the problem is elastic only.
    #[serde(
        rename = "contact",
        default,
        with = "one_or_several",
        skip_serializing_if = "Vec::is_empty"
    )]
    #[schemars(with = "one_or_several::OneOrSeveral<Contact>")]
    #[schemars(extend("part" = ProblemPart::Mesh))]
    pub contacts: Vec<Contact>,
    /// Rigid tools, to which the obstacles of contact faces may belong.
    #[serde(rename = "tool", default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("part" = ProblemPart::Mesh))]
    pub tools: Vec<Tool>,
    /// The law of friction on contact faces without one of their own; without it they are frictionless.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("part" = ProblemPart::Law))]
    pub friction: Option<Friction>,
    /// A load history: problems that are solved one after the other, each from where the one before left the body;
    /// without it there is one.
    #[serde(rename = "step", default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(extend("part" = ProblemPart::Loads))]
    pub steps: Vec<Step>,
    /// How the elastic problem is prepared.
    #[serde(default)]
    #[schemars(extend("part" = ProblemPart::Operator))]
    pub assemble: AssembleSettings,
    /// How the discrete problem is solved.
    #[serde(default)]
    #[schemars(extend("part" = ProblemPart::Solve))]
    pub solve: SolveSettings,
    /// How accurate the mesh has to be; without it the mesh is the body's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adapt: Option<AdaptSettings>,
}

/// Whether a key has its default and is left out of a scene that is written.
fn untitled() -> String {
    "untitled".to_owned()
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl Scene {
    /// A body of one material, with nothing that holds, loads or touches it yet.
    ///
    /// ```
    /// use contact3d::scene::{Body, Clamp, Contact, Friction, Material, Pressure, Scene};
    ///
    /// let scene = Scene::new(Body::brick([3.0, 1.0, 1.0], [12, 4, 4]), Material::isotropic(2.1e11, 0.3))
    ///     .with_clamp(Clamp::face("x_min"))
    ///     .with_pressure(Pressure::on("z_max", 2e7))
    ///     .with_contact(Contact::on("z_min"))
    ///     .with_friction(Friction::coulomb(0.3));
    /// assert!(scene.validate().is_ok());
    /// ```
    #[must_use]
    pub fn new(body: Body, material: Material) -> Self {
        Self {
            title: untitled(),
            reference: None,
            units: Units::default(),
            parameters: BTreeMap::new(),
            bodies: vec![body],
            material: Some(material),
            regions: Vec::new(),
            clamps: Vec::new(),
            springs: Vec::new(),
            tractions: Vec::new(),
            pressures: Vec::new(),
            forces: Vec::new(),
            body_force: None,
            contacts: Vec::new(),
            tools: Vec::new(),
            friction: None,
            steps: Vec::new(),
            assemble: AssembleSettings::default(),
            solve: SolveSettings::default(),
            adapt: None,
        }
    }

    /// All values that may vary.
    fn varying_mut(&mut self) -> Vec<(VaryingKey, Varying<'_>)> {
        let (at, mut found) = (|name| VaryingKey::default().below(name), Vec::new());
        self.clamps.add_varying(&at("clamp"), &mut found);
        self.springs.add_varying(&at("spring"), &mut found);
        self.tractions.add_varying(&at("traction"), &mut found);
        self.pressures.add_varying(&at("pressure"), &mut found);
        self.forces.add_varying(&at("force"), &mut found);
        self.body_force.add_varying(&at("body_force"), &mut found);
        self.tools.add_varying(&at("tool"), &mut found);
        self.steps.add_varying(&at("step"), &mut found);
        let several = self.contacts.len() > 1;
        for (entry, contact) in self.contacts.iter_mut().enumerate() {
            // A scene writes the only face as a table.
            let contacts = at("contact");
            let key = if several {
                contacts.below(entry)
            } else {
                contacts
            };
            if !contact.glued {
                contact.add_varying(&key, &mut found);
            }
        }
        self.friction.add_varying(&at("friction"), &mut found);
        found
    }

    /// Parses and validates a scene; `name` is the file's name for messages.
    ///
    /// # Errors
    /// [`SceneError::Syntax`] for text that is not TOML or has an unknown, missing or mistyped key;
    /// [`SceneError::Invalid`] for a value that no problem of this kind can have.
    pub fn parse(name: &str, text: &str) -> Result<Self, SceneError> {
        let file = SceneFile::parse(name.to_owned(), text, PathBuf::new())?;
        Ok(file.scene)
    }

    /// The scene as canonical TOML, which parses back to the same scene.
    ///
    /// Its digest names the cases of sweeps, and parts of it tell whether stages are fresh. A key that is added to
    /// scenes is therefore left out while it has its default (`skip_serializing_if`), which
    /// `tests/old_files/digests.rs` checks.
    ///
    /// # Errors
    /// A whole number that TOML cannot hold.
    pub fn to_toml(&self) -> Result<String, InvalidValue> {
        toml::to_string(self).map_err(unwritable)
    }

    /// The JSON Schema of scene files, for editors.
    #[must_use]
    pub fn json_schema() -> String {
        let mut schema = schemars::schema_for!(Self).to_value();
        schema::limit_numbers(&mut schema);
        let schema = schemars::Schema::try_from(schema).expect("limits have moved, no more");
        serde_json::to_string_pretty(&schema).expect("a schema is JSON") + "\n"
    }
}
