//! Wrong scenes of a brick: exit code 2, the line, the key, what is allowed, no run file.

use std::fs;

use crate::program::Program;

/// A good scene that says nearly everything a scene can say.
pub(crate) const SCENE: &str = r#"title = "a good scene"

[body.brick]
size = [3.0, 1.0, 1.0]
cells = [6, 2, 2]

[material.isotropic]
young_modulus = 2e11
poisson_ratio = 0.3

[[clamp]]
face = "x_min"

[[traction]]
face = "x_max"
value = [1e7, 0.0, 2e7]

[[pressure]]
face = "z_max"
value = 3e7

[body_force]
value = [0.0, 0.0, -7e4]

[contact]
face = "z_min"
gap = 1e-6
angle = 10.0

[friction.coefficient_1]
constant = 0.3

[friction.coefficient_2.ramp]
initial = 0.3
residual = 0.2
onset = 1e-5
rate = 1000.0

[assemble]
dual_operator = "auto"

[solve]
method = "auto"
epsilon = 1e-9
"#;

const PRESSURE: &str = "[[pressure]]\nface = \"z_max\"\nvalue = 3e7";
const ISOTROPIC: &str = "[material.isotropic]\nyoung_modulus = 2e11\npoisson_ratio = 0.3";
const FIRST: &str = "[friction.coefficient_1]\nconstant = 0.3";
const FRICTION: &str = "[friction.coefficient_1]\nconstant = 0.3\n\n[friction.coefficient_2.ramp]\ninitial = 0.3\nresidual = 0.2\nonset = 1e-5\nrate = 1000.0";
const CONTACT: &str = "[contact]\nface = \"z_min\"\ngap = 1e-6\nangle = 10.0";

/// What is replaced in the good scene, by what, and what the message says.
type Case = (&'static str, &'static str, &'static [&'static str]);

/// Words and types that no scene has.
#[rustfmt::skip] // one case a line
const MISSPELT: &[Case] = &[
    ("title =", "titel =", &["unknown key", "titel", "title"]),
    ("title = \"a good scene\"", "title = 7", &["title", "string"]),
    ("[body.brick]", "[body.sphere]", &["unknown key", "sphere", "brick", "gmsh"]),
    ("size = [3.0, 1.0, 1.0]", "size = 3.0", &["size", "a list of 3 values"]),
    ("cells = [6, 2, 2]", "cells = [6, 2]", &["body.brick.cells:", "expected 3 values, found 2"]),
    ("cells = [6, 2, 2]", "cells = [6, 2.5, 2]", &["2.5"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, -2]", &["-2"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 99999999999999999999]", &["99999999999999999999"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 2]\ngrading = { x_mid = 2.0 }", &["body.brick.grading.x_mid:", "unknown key", "x_min"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 2]\ngrading = { x_min = \"fine\" }", &["body.brick.grading.x_min:", "expected a number"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 2]\ncoordinates = { w = [0.0, 1.0] }", &["body.brick.coordinates.w:", "unknown key", "x"]),
    ("young_modulus = 2e11", "young_modulus = \"steel\"", &["material.isotropic.young_modulus:", "expected a number", "steel"]),
    ("poisson_ratio = 0.3", "", &["missing key", "poisson_ratio"]),
    ("[[clamp]]", "[clamp]", &["expected several tables [[clamp]], found a table"]),
    ("poisson_ratio = 0.3", "poisson_ratio = 0.3\nyield_stress = 2e8", &["unknown key", "without plasticity", "von Mises"]),
    ("young_modulus = 2e11", "density = 7800.0\nyoung_modulus = 2e11", &["unknown key", "no dynamics", "body_force"]),
    ("[contact]\nface = \"z_min\"", "[temperature]\nvalue = 20.0\n[contact]\nface = \"z_min\"", &["temperature:", "there is no heat"]),
    ("[body.brick]", "[[body]]\nbrick = { size = [1.0, 1.0, 1.0], cells = [2, 2, 2] }\n[[body]]\n[body.brick]", &["body.0.name", "a name without dots and spaces"]),
    ("[contact]\nface = \"z_min\"", "[contact]\nfase = \"z_min\"", &["contact.fase:", "unknown key", "face"]),
    ("angle = 10.0", "multipliers = \"nodes\"", &["unknown word", "nodes", "nodal"]),
    ("constant = 0.3", "constant = 0.3\nramp = 1", &["friction.coefficient_1:", "exactly one of", "found constant and ramp"]),
    ("[solve]", "[solve", &["unclosed table", "]"]),
    ("method = \"auto\"", "method = \"neuton\"", &["solve.method:", "unknown word", "neuton", "newton"]),
    ("method = \"auto\"", "method = \"auto\"\nmethod = \"auto\"", &["duplicate key"]),
    ("dual_operator = \"auto\"", "dual_operator = true", &["dual_operator"]),
    ("epsilon = 1e-9", "inner = \"cg\"", &["unknown word", "cg", "kprgp"]),
    ("value = 3e7", "value = [3e7]", &["pressure.0.value:", "a number, or an expression in x, y, z"]),
    ("face = \"x_min\"", "face = \"x_min\"\ncomponents = [\"u\"]", &["clamp.0.components:", "unknown word", "`x`"]),
];

/// Numbers that no body, material or load has.
#[rustfmt::skip] // one case a line
const BODIES_AND_LOADS: &[Case] = &[
    ("size = [3.0", "size = [-3.0", &["body.brick.size", "positive"]),
    ("size = [3.0", "size = [nan", &["body.brick.size", "found [nan"]),
    ("size = [3.0", "size = [inf", &["body.brick.size", "inf"]),
    ("cells = [6, 2, 2]", "cells = [6, 3, 2]", &["body.brick.cells", "even", "nodal"]),
    ("cells = [6, 2, 2]", "cells = [0, 2, 2]", &["body.brick.cells", "1 to 4096"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 4098]", &["body.brick.cells", "1 to 4096"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 2]\ngrading.x_min = 0.5", &["body.brick.grading.x_min", "from 1", "to 30", "found 0.5"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 2]\ngrading.z_max = nan", &["body.brick.grading.z_max", "found nan"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 2]\ngrading.z_max = 31", &["body.brick.grading.z_max", "to 30", "found 31"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 2]\ngrading.x_max = 20", &["body.brick.grading.x_max", "1e-9 of the edge", "smaller exponents"]),
    ("size = [3.0, 1.0, 1.0]", "grading.z_min = 2\nsize = [3.0, 1.0, 1e-8]", &["body.brick.grading.z_min", "differ at most 1e8 times"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 2]\ncoordinates.z = [0.0, 0.6, 0.6]", &["body.brick.coordinates.z", "greater than the one before", "found 0.6, 0.6"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 2]\ncoordinates.z = [0.0, nan, 1.0]", &["body.brick.coordinates.z", "nan"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 2]\ncoordinates.z = [1.0]", &["body.brick.coordinates.z", "at least two"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 2]\ncoordinates.z = [0.0, 0.5, 2.0]", &["body.brick.coordinates.z", "from 0 to 1.0", "0.0 to 2.0"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 2]\ncoordinates.z = [0.0, 0.1, 0.3, 1.0]", &["body.brick.coordinates.z", "3 coordinates for the 2 cells along z", "[6, 2, 3]"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 2]\ncoordinates.z = [0.0, 1e-10, 1.0]", &["body.brick.coordinates.z", "1e-9 of the edge", "planes apart"]),
    ("cells = [6, 2, 2]", "cells = [6, 2, 2]\ncoordinates.z = [0.0, 0.1, 1.0]\ngrading.z_max = 2", &["body.brick.coordinates.z", "either given coordinates or graded cells", "1.0, 2.0"]),
    ("young_modulus = 2e11", "young_modulus = 0.0", &["material.isotropic.young_modulus", "positive"]),
    ("young_modulus = 2e11", "young_modulus = -2e11", &["material.isotropic.young_modulus", "positive"]),
    ("young_modulus = 2e11", "young_modulus = inf", &["material.isotropic.young_modulus", "positive"]),
    ("poisson_ratio = 0.3", "poisson_ratio = 0.5", &["material.isotropic.poisson_ratio", "incompressible"]),
    ("poisson_ratio = 0.3", "poisson_ratio = -1.0", &["material.isotropic.poisson_ratio", "-1 <"]),
    ("poisson_ratio = 0.3", "poisson_ratio = nan", &["material.isotropic.poisson_ratio", "found nan"]),
    ("face = \"x_min\"", "face = \"left\"", &["clamp.0.face", "left", "x_min"]),
    ("face = \"x_min\"", "face = \"\"", &["clamp.0.face", "x_min"]),
    ("face = \"x_min\"", "face = \"xmin\"", &["clamp.0.face", "did you mean `x_min`?", "six faces"]),
    ("face = \"x_min\"", "face = \"z_min\"", &["clamp.0.face", "contact face"]),
    ("face = \"x_min\"", "face = \"x_min\"\ncomponents = []", &["clamp.0.components", "at least one"]),
    ("face = \"x_max\"", "face = \"x_min\"", &["traction.0.face", "neither held"]),
    ("face = \"x_max\"", "face = \"z_min\"", &["traction.0.face", "nor in contact"]),
    ("face = \"x_max\"", "face = \"top\"", &["traction.0.face", "x_min", "z_max"]),
    ("face = \"z_max\"", "face = \"z_min\"", &["pressure.0.face", "nor in contact"]),
    ("value = 3e7", "value = 3e7\nbox = [[1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]", &["pressure.0.box", "min at most max"]),
    ("value = 3e7", "value = 3e7\nbox = [[5.0, 0.0, 1.0], [6.0, 1.0, 1.0]]", &["pressure.0.box", "some area of \"z_max\"", "move or widen it"]),
    ("value = 3e7", "value = 3e7\nbox = [[1.0, 0.0, 1.0], [1.0, 1.0, 1.0]]", &["pressure.0.box", "a load on a line or a point has no bound", "disc"]),
    ("value = 3e7", "value = 3e7\nbox = [[1.0, 0.0, 1.0], [2.0, 1.0, 1.0]]\ndisc = { centre = [1.0, 0.5, 1.0], radius = 0.1 }", &["pressure.0:", "box or disc", "both"]),
    (PRESSURE, "[[force]]\nface = \"top\"", &["force.0.face", "z_max"]),
    (PRESSURE, "[[force]]\nface = \"z_min\"\nvalue = [0.0, 0.0, 1.0]", &["force.0.face", "nor in contact"]),
    (PRESSURE, "[[force]]\nface = \"x_min\"\nvalue = [0.0, 0.0, 1.0]", &["force.0.face", "neither held"]),
    (PRESSURE, "[[force]]\nface = \"z_max\"\nvalue = [0.0, 0.0, nan]", &["force.0.value", "three finite numbers [N]"]),
    (PRESSURE, "[[force]]\nface = \"z_max\"\nmoment = [\"1/(1 - 1)\", 0, 0]", &["force.0.moment", "finite"]),
    (PRESSURE, "[[force]]\nface = \"z_max\"\nvalue = [0.0, 0.0, \"-5*x\"]", &["force.0.value", "expressions of parameters", "[[traction]]"]),
    (PRESSURE, "[[force]]\nface = \"z_max\"\nmoment = [1.0, 0.0, 0.0]\nbox = [[0.0, 0.5, 0.0], [3.0, 0.5000001, 1.0]]", &["force.0.moment", "wide enough", "disc"]),
    (PRESSURE, "[[force]]\nface = \"z_max\"\ndisc = { centre = [1.0, 0.5, 0.9], radius = 0.3 }", &["force.0.disc.centre", "a point of the face \"z_max\"", "move the centre"]),
    (PRESSURE, "[[force]]\nface = \"z_max\"\ndisc = { centre = [4.0, 0.5, 1.0], radius = 0.3 }", &["force.0.disc.centre", "4.0"]),
    (PRESSURE, "[[force]]\nface = \"z_max\"\ndisc = { centre = [1.0, 0.5, 1.0], radius = 0.0 }", &["force.0.disc.radius", "finite positive number", "a load at a point has no bound"]),
    ("value = [1e7, 0.0, 2e7]", "value = [inf, 0.0, 2e7]", &["traction.0.value", "finite"]),
    ("value = [1e7, 0.0, 2e7]", "value = [\"1e7*w\", 0.0, 2e7]", &["traction.0.value:", "unknown name", "x, y, z"]),
    ("value = [1e7, 0.0, 2e7]", "value = [\"1e7*(x\", 0.0, 2e7]", &["is no expression"]),
    ("value = [1e7, 0.0, 2e7]", "value = [\"1e7/(x-x)\", 0.0, 2e7]", &["traction.0.value", "finite"]),
    ("value = 3e7", "value = \"ln(-x)\"", &["pressure.0.value", "finite"]),
    ("value = 3e7", "value = nan", &["pressure.0.value", "finite"]),
    ("value = [0.0, 0.0, -7e4]", "value = [0.0, 0.0, \"sqrt(z-2)\"]", &["body_force.value", "finite"]),
];

/// Contact and friction that cannot be.
#[rustfmt::skip] // one case a line
const CONTACTS: &[Case] = &[
    ("face = \"z_min\"", "face = \"bottom\"", &["contact.face", "z_min"]),
    ("gap = 1e-6", "gap = -1.0", &["contact.gap", ">= 0"]),
    ("gap = 1e-6", "gap = inf", &["contact.gap"]),
    ("gap = 1e-6", "gap = \"x - 1\"", &["contact.gap", ">= 0", "every contact node"]),
    ("gap = 1e-6", "gap = \"sin(\"", &["is no expression"]),
    ("gap = 1e-6", "gap = \"step(x)\"", &["\"step\" is no function", "sqrt", "if"]),
    ("angle = 10.0", "angle = nan", &["contact.angle", "finite"]),
    ("angle = 10.0", "angle = \"1/(x-x)\"", &["contact.angle", "finite"]),
    ("angle = 10.0", "angle = 10.0\naxis_1 = [1.0, 0.0, 0.0]", &["contact.angle", "either axis_1 or angle"]),
    ("angle = 10.0", "axis_1 = [0.0, 0.0, 1.0]", &["contact.axis_1", "plane"]),
    ("angle = 10.0", "axis_1 = [0.0, 0.0, 0.0]", &["contact.axis_1", "non-zero"]),
    ("angle = 10.0", "axis_1 = [\"x\", 0.0, 0.0]", &["contact.axis_1", "non-zero"]),
    (CONTACT, "", &["friction", "[contact]"]),
    (FIRST, "", &["friction", "coefficient_1 and coefficient_2"]),
    (FIRST, "[friction.coefficient]\nconstant = 0.3", &["friction", "one isotropic coefficient or both"]),
    (FRICTION, "[friction]", &["friction", "leave [friction] out"]),
    ("constant = 0.3", "constant = 0.0", &["friction.coefficient_1.constant", "positive"]),
    ("constant = 0.3", "constant = -0.3", &["friction.coefficient_1.constant", "positive"]),
    ("initial = 0.3", "initial = -0.3", &["friction.coefficient_2.ramp.initial", "a finite positive number"]),
    ("residual = 0.2", "residual = 0.0", &["friction.coefficient_2.ramp.residual", "a finite positive number"]),
    ("onset = 1e-5", "onset = -1e-5", &["friction.coefficient_2.ramp.onset", "a finite number [m] >= 0"]),
    ("rate = 1000.0", "rate = 0.0", &["friction.coefficient_2.ramp.rate", "a finite positive number"]),
    ("constant = 0.3", "expression = \"0.3 + s\"", &["friction.coefficient_1.expression", "s1 and s2"]),
    ("constant = 0.3", "expression = \"0.3 + u\"", &["unknown name", "s1"]),
    ("constant = 0.3", "expression = \"x - 1\"", &["friction.coefficient_1.expression", "0 < F"]),
    ("constant = 0.3", "expression = \"ln(s1)\"", &["friction.coefficient_1.expression", "0 < F"]),
    (FRICTION, "[friction.coefficient]\nexpression = \"0.3 + s1\"", &["friction.coefficient.expression", "s = |u_t|"]),
    (FRICTION, "[friction.coefficient.grid]\nslip_1 = [0.0]\nslip_2 = [0.0]\nvalue = [[0.3]]", &["friction.coefficient.grid", "isotropic"]),
    (FRICTION, "[friction]\nslip_bound = -1.0", &["friction.slip_bound", "[Pa] >= 0"]),
    (FRICTION, "[friction]\nslip_bound = \"x - 1\"", &["friction.slip_bound", ">= 0"]),
    (FRICTION, "[friction]\ncoefficient.constant = 0.3\npressure_cap = 0.0", &["friction.pressure_cap", "positive number [Pa]", "Leave it out"]),
    (FRICTION, "[friction]\ncoefficient.constant = 0.3\npressure_cap = -1e6", &["friction.pressure_cap", "positive number [Pa]"]),
    (FRICTION, "[friction]\ncoefficient.constant = 0.3\npressure_cap = inf", &["friction.pressure_cap", "finite"]),
    (FRICTION, "[friction]\ncoefficient.constant = 0.3\npressure_cap = \"1e6\"", &["pressure_cap"]),
    (FRICTION, "[friction]\nslip_bound = 1e6\npressure_cap = 1e6", &["friction.pressure_cap", "slip_bound", "leave one of the two out"]),
    (FRICTION, "[friction]\npressure_cap = 1e6", &["friction", "coefficient", "leave [friction] out"]),
    ("[friction.coefficient_1]", "[friction]\nslip_bound = 1e6\n\n[friction.coefficient_1]", &["friction.coefficient_2", "a constant beside slip_bound"]),
    ("constant = 0.3", "table = { slip = [0.0, 2.0, 1.0], value = [0.3, 0.2, 0.1] }", &["friction.coefficient_1.table.slip", "increasing"]),
    ("constant = 0.3", "table = { slip = [1.0, 2.0], value = [0.3, 0.2] }", &["friction.coefficient_1.table.slip", "from 0"]),
    ("constant = 0.3", "table = { slip = [0.0, 2.0], value = [0.3] }", &["friction.coefficient_1.table.value", "2 positive"]),
    ("constant = 0.3", "table = { slip = [0.0, nan], value = [0.3, 0.2] }", &["friction.coefficient_1.table.slip"]),
    ("constant = 0.3", "table = { slip = [], value = [] }", &["friction.coefficient_1.table.slip", "from 0"]),
    ("constant = 0.3", "grid = { slip_1 = [0.0, 1.0], slip_2 = [0.0], value = [[0.3]] }", &["friction.coefficient_1.grid.value", "2 rows of 1"]),
    ("constant = 0.3", "grid = { slip_1 = [0.0], slip_2 = [0.0, 1.0], value = [[0.3, -0.2]] }", &["friction.coefficient_1.grid.value", "positive"]),
    ("constant = 0.3", "grid = { slip_1 = [0.0], slip_2 = [0.0, 0.0], value = [[0.3, 0.2]] }", &["friction.coefficient_1.grid.slip_2", "increasing"]),
    ("epsilon = 1e-9", "epsilon = 2.0", &["solve.epsilon", "0 < epsilon < 1"]),
    ("epsilon = 1e-9", "epsilon = nan", &["solve.epsilon", "0 < epsilon < 1"]),
    ("epsilon = 1e-9", "r_tol = 0.0", &["solve.r_tol", "0 < r_tol < 1"]),
    ("epsilon = 1e-9", "c_fact = 1.0", &["solve.c_fact", "0 < c_fact < 1"]),
    ("epsilon = 1e-9", "gamma = -1.0", &["solve.gamma", "a finite positive number"]),
    ("epsilon = 1e-9", "max_outer_steps = 0", &["solve.max_outer_steps", "at least 1"]),
    ("epsilon = 1e-9", "max_operator_applications = 0", &["solve.max_operator_applications", "at least 1"]),
];

const ORTHOTROPIC: &str = "[material.orthotropic]\nyoung_moduli = [11e9, 8e8, 5e8]\npoisson_ratios = [0.4, 0.45, 0.37]\nshear_moduli = [5e7, 6e8, 7e8]\n";

/// Anisotropic materials and regions that cannot be; each stands in place of the material.
#[rustfmt::skip] // one case a line
const MATERIALS: &[(&str, &str, &[&str])] = &[
    ("[11e9,", "[-11e9,", &["material.orthotropic.young_moduli", "positive"]),
    ("[5e7,", "[0.0,", &["material.orthotropic.shear_moduli", "three finite positive numbers"]),
    ("[0.4,", "[inf,", &["material.orthotropic.poisson_ratios", "finite"]),
    ("[0.4, 0.45, 0.37]", "[2.0, 0.45, 0.37]", &["material.orthotropic", "positive definite", "eigenvalues"]),
    ("[11e9,", "[1e-320,", &["material.orthotropic", "positive definite"]),
    ("shear", "axes = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]\nshear", &["material.orthotropic.axes", "orthogonal"]),
    ("shear", "axes = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]]\nshear", &["material.orthotropic.axes", "positive length"]),
    ("[material", "[[region]]\nmaterial.isotropic = { young_modulus = 1.0, poisson_ratio = 0.3 }\npart.box = [[9.0, 9.0, 9.0], [10.0, 10.0, 10.0]]\n[material", &["region.0.part", "at least one tetrahedron"]),
    ("[material", "[[region]]\nmaterial.isotropic = { young_modulus = 1.0, poisson_ratio = 0.3 }\npart.box = [[1.0, 1.0, 1.0], [0.0, 2.0, 2.0]]\n[material", &["region.0.part.box", "min below max"]),
    ("[material", "[[region]]\nmaterial.isotropic = { young_modulus = 1.0, poisson_ratio = 0.3 }\npart.group = \"steel\"\n[material", &["region.0.part.group", "box"]),
    ("[material", "[[region]]\nmaterial.isotropic = { young_modulus = 1.0, poisson_ratio = 0.6 }\npart.box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]\n[material", &["region.0.material.isotropic.poisson_ratio"]),
];

/// The matrix of a Voigt law with some entries changed.
fn voigt(changes: &[(usize, usize, &str)]) -> String {
    let row = |i: usize| -> String {
        let entry = |j: usize| {
            let change = changes.iter().find(|(r, c, _)| (*r, *c) == (i, j));
            change.map_or(if i == j { "2e11" } else { "0.0" }, |change| change.2)
        };
        format!("[{}]", (0..6).map(entry).collect::<Vec<_>>().join(", "))
    };
    let rows: Vec<String> = (0..6).map(row).collect();
    format!("[material.voigt]\nstiffness = [{}]", rows.join(",\n"))
}

/// Runs a scene that must be refused; what is wrong with the refusal, if anything is: the exit code,
/// a run file, or a fragment that the message lacks.
pub(crate) fn flaw(program: &Program, text: &[u8], fragments: &[&str]) -> Option<String> {
    fs::write(program.path("bad.toml"), text).unwrap();
    let refused = program
        .command(&["run", "bad.toml", "run.h5", "--no-figures"])
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&refused.stderr);
    // Long messages are wrapped and indented.
    let words = message.split_whitespace().filter(|word| *word != "│");
    let message = words.collect::<Vec<_>>().join(" ");
    let missing = fragments.iter().find(|f| !message.contains(**f));
    let flaw = if refused.status.code() != Some(2) {
        format!("exit code {:?}", refused.status.code())
    } else if fs::remove_file(program.path("run.h5")).is_ok() {
        "a run file was left".into()
    } else if message.len() > 4000 {
        format!("{} bytes", message.len())
    } else {
        format!("no {:?}", missing?)
    };
    Some(format!("{flaw} in {message:.2000}"))
}

/// The same for a scene whose line must be shown.
fn flaw_with_line(program: &Program, text: &str, fragments: &[&str]) -> Option<String> {
    // The frame around the lines begins with the file, line and column.
    let fragments = [&["─[bad.toml:"], fragments].concat();
    flaw(program, text.as_bytes(), &fragments)
}

#[test]
fn wrong_scenes_are_refused_with_line_key_and_remedy() {
    let orthotropic = SCENE.replacen(ISOTROPIC, ORTHOTROPIC, 1);
    let cases = [MISSPELT, BODIES_AND_LOADS, CONTACTS].concat();
    let cases = cases.iter().map(|case| (SCENE, case));
    let cases: Vec<_> = cases
        .chain(MATERIALS.iter().map(|case| (orthotropic.as_str(), case)))
        .collect();
    let program = Program::new();
    let mut flaws = Vec::new();
    for (good, (from, to, fragments)) in cases {
        assert!(good.contains(from), "{from}");
        if let Some(flaw) = flaw_with_line(&program, &good.replacen(from, to, 1), fragments) {
            flaws.push(format!("{from} -> {to}: {flaw}"));
        }
    }
    assert!(flaws.is_empty(), "{}", flaws.join("\n"));
}

#[test]
fn a_missing_clamp_has_a_key_but_no_line() {
    let program = Program::new();
    // Contact may hold a body, so there is none.
    let elastic = SCENE.replacen(CONTACT, "", 1).replacen(FRICTION, "", 1);
    let held = "[[clamp]]\nface = \"x_min\"";
    let text = elastic.replacen(held, "", 1);
    let fragments = ["bad.toml: clamp:", "at least one", "rigid"];
    assert_eq!(flaw(&program, text.as_bytes(), &fragments), None);
    let text = elastic.replacen(held, &format!("{held}\ncomponents = [\"x\"]"), 1);
    let fragments = [
        "bad.toml: clamp:",
        "no rigid motion free",
        "translation along y",
    ];
    assert_eq!(flaw(&program, text.as_bytes(), &fragments), None);
}

#[test]
fn wrong_elasticity_tensors_are_refused() {
    let program = Program::new();
    for (changes, fragment) in [
        ([(0, 1, "1e11"), (1, 0, "-1e11")], "symmetric"),
        ([(0, 1, "3e11"), (1, 0, "3e11")], "positive definite"),
        ([(5, 5, "nan"), (5, 5, "nan")], "finite numbers"),
        ([(2, 2, "0.0"), (2, 2, "0.0")], "positive definite"),
    ] {
        let text = SCENE.replacen(ISOTROPIC, &voigt(&changes), 1);
        let flaw = flaw_with_line(&program, &text, &["material.voigt", fragment]);
        assert_eq!(flaw, None);
    }
}

#[test]
fn the_good_scene_is_accepted_and_nodal_multipliers_take_odd_cells() {
    let program = Program::new();
    let odd = SCENE.replacen("[6, 2, 2]", "[5, 3, 1]", 1);
    let odd = odd.replacen("angle = 10.0", "multipliers = \"nodal\"", 1);
    for (name, text) in [("good", SCENE), ("odd", &odd)] {
        let (scene, file) = (format!("{name}.toml"), format!("{name}.h5"));
        fs::write(program.path(&scene), text).unwrap();
        program
            .command(&["run", &scene, &file, "--no-figures"])
            .assert()
            .success();
    }
}

#[test]
fn what_is_no_text_or_no_table_is_refused() {
    let program = Program::new();
    let noise: Vec<u8> = (0..4096_u32)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8)
        .collect();
    let nested = format!("title = {}{}", "[".repeat(5000), "]".repeat(5000));
    let tables = format!("[{}]\n", vec!["a"; 5000].join("."));
    let long_line = format!("title = \"{}\"\ntitel = 1\n", "x".repeat(10_000_000));
    let long_value = format!("{SCENE}# {}\n", "x".repeat(10_000_000));
    for (text, fragments) in [
        (noise.as_slice(), &["bad.toml", "UTF-8", "byte"][..]),
        (b"title = \"\xff\"", &["bad.toml", "UTF-8", "byte 9"]),
        (
            b"",
            &[
                "bad.toml: line 1: expected keys, found none",
                "contact3d-pipe init",
            ],
        ),
        (b"# later\n", &["bad.toml:1:1", "expected keys, found none"]),
        (b"\0\0\0", &["bad.toml"]),
        (nested.as_bytes(), &["bad.toml", "recursion"]),
        (tables.as_bytes(), &["bad.toml"]),
        (long_line.as_bytes(), &["bad.toml", "at most"]),
        (long_value.as_bytes(), &["bad.toml", "at most"]),
    ] {
        assert_eq!(flaw(&program, text, fragments), None);
    }
    fs::create_dir(program.path("folder.toml")).unwrap();
    let refused = program
        .command(&["run", "folder.toml", "run.h5"])
        .assert()
        .code(2);
    let message = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(message.contains("folder.toml"), "{message}");
}
