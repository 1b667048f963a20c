//! A scene that depends on one parameter in a range, and the contact problem at each value of it.

use std::{cell::RefCell, collections::VecDeque, path::Path, sync::Arc};

use super::point::FamilyMember;
use crate::shared::{dual_of, refuse_floating};
use contact3d::{
    AssembledProblem, Problem, ProblemError,
    contact::Interface,
    dual::{ExplicitDual, LocalStiffness},
    linalg::norm,
    mesh::Mesh,
    scene::{DualOperatorKind, FactorPrecision, InvalidValue, Scene},
};

/// Places in the range at which the loads must lie on a straight line to be taken from it, and the whole scene be valid.
const PROBES: [f64; 3] = [0.289, 0.5, 0.781];

/// What changes with the parameter.
enum Dependence {
    /// Loads and gap along a straight line: h and the free slip at both ends; and perhaps the law.
    Straight {
        ends: Box<[ExplicitDual; 2]>,
        law: bool,
    },
    /// Loads and gap along a curve, and perhaps the law.
    Curved,
    /// The operators.
    Operator,
}

/// The contact problems of a scene in a range of a parameter.
pub struct Family<'a> {
    /// The range.
    pub range: ParameterRange,
    /// The scene at a value of the parameter.
    scene_at: &'a dyn Fn(f64) -> Result<Scene, InvalidValue>,
    folder: &'a Path,
    /// The assembled problem from which those of all values follow.
    pub base: Arc<AssembledProblem>,
    local: Arc<LocalStiffness>,
    interface: Arc<Interface>,
    dependence: Dependence,
    kept: RefCell<VecDeque<(u64, Arc<FamilyMember>)>>,
}

impl<'a> Family<'a> {
    /// Assembles the problem at one end of the range, and finds out what the parameter changes. Mesh files are looked
    /// for in `folder`.
    ///
    /// # Errors
    /// An empty range, a scene without Coulomb friction, a value in the range that no problem can have.
    pub fn new(
        range: ParameterRange,
        scene_at: &'a dyn Fn(f64) -> Result<Scene, InvalidValue>,
        folder: &'a Path,
    ) -> Result<Self, ProblemError> {
        if !(range.from.is_finite() && range.to.is_finite() && range.from != range.to) {
            return Err(InvalidValue {
                key: range.key,
                expected: "a range between two different numbers".into(),
                found: format!("{} to {}", range.from, range.to),
                help: "give other values with --from and --to".into(),
            }
            .into());
        }
        let scene = |s: f64| scene_at(range.value(s)).and_then(Scene::checked);
        for s in PROBES {
            scene(s)?.require_no_history("a path of solutions")?;
            scene(s)?.require_one_body("a path of solutions")?;
        }
        let ends = [scene(0.0)?, scene(1.0)?];
        let first = Arc::new(assemble(&ends[0], folder)?);
        let second = match first.with_scene(explicit(ends[1].clone())) {
            Err(ProblemError::OtherOperator { .. } | ProblemError::Invalid(_)) => {
                assemble(&ends[1], folder)?
            }
            shared => shared?,
        };
        let second = Arc::new(second);
        let interface = |problem: &AssembledProblem| coulomb(problem.scene(), problem.mesh());
        let interfaces = [interface(&first)?, interface(&second)?];
        // The one whose law follows the slip has the compliance that laws of both kinds can use.
        let base = if interfaces[0].follows_slip() {
            &first
        } else {
            &second
        };
        let shares = |scene: &Scene| base.with_scene(explicit(scene.clone()));
        let probes = PROBES.map(scene).into_iter();
        let [from, to] = ends.each_ref().map(shares);
        let others: Vec<_> = probes
            .map(|probe| Ok(shares(&probe?)))
            .chain([Ok(from), Ok(to)])
            .collect::<Result<_, InvalidValue>>()?;
        let is_other = |other: &Result<AssembledProblem, ProblemError>| {
            matches!(other, Err(ProblemError::OtherOperator { .. }))
        };
        let dependence = if others.iter().any(is_other) {
            Dependence::Operator
        } else {
            let others = others.into_iter().collect::<Result<Vec<_>, _>>()?;
            let (probes, ends) = others.split_at(PROBES.len());
            let mut places = PROBES.iter().zip(probes);
            let is_straight =
                places.all(|(s, probe)| on_line(&ends[0], &ends[1], range.share(*s), probe));
            let friction = |problem: &AssembledProblem| problem.scene().friction.clone();
            let law = others
                .iter()
                .any(|other| friction(other) != friction(&ends[0]));
            if is_straight {
                Dependence::Straight {
                    ends: Box::new([dual_of(&ends[0]).clone(), dual_of(&ends[1]).clone()]),
                    law,
                }
            } else {
                Dependence::Curved
            }
        };
        let base = Arc::clone(base);
        Ok(Self {
            local: Arc::new(
                LocalStiffness::new(dual_of(&base))
                    .with_friction_stiffness(&dual_of(&first).rhs)
                    .with_friction_stiffness(&dual_of(&second).rhs),
            ),
            interface: interface(&base)?,
            range,
            scene_at,
            folder,
            base,
            dependence,
            kept: RefCell::default(),
        })
    }

    /// The scene at s.
    pub(super) fn scene(&self, s: f64) -> Result<Scene, InvalidValue> {
        (self.scene_at)(self.range.value(s)).and_then(Scene::checked)
    }

    /// The assembled problem at a value of the parameter, with the dense operator.
    ///
    /// # Errors
    /// A value that no problem can have.
    pub fn problem_at(&self, parameter: f64) -> Result<AssembledProblem, ProblemError> {
        let scene = explicit((self.scene_at)(parameter).and_then(Scene::checked)?);
        match self.base.with_scene(scene.clone()) {
            Err(ProblemError::OtherOperator { .. }) => assemble(&scene, self.folder),
            shared => shared,
        }
    }

    /// The problem at s.
    pub(super) fn member(&self, s: f64) -> Result<Arc<FamilyMember>, ProblemError> {
        let mut kept = self.kept.borrow_mut();
        if let Some((_, member)) = kept.iter().find(|(bits, _)| *bits == s.to_bits()) {
            return Ok(Arc::clone(member));
        }
        let member = Arc::new(self.make(s)?);
        // Problems that are kept in memory at a time: a point and both sides of its difference.
        if kept.len() == 6 {
            kept.pop_front();
        }
        kept.push_back((s.to_bits(), Arc::clone(&member)));
        Ok(member)
    }

    fn make(&self, s: f64) -> Result<FamilyMember, ProblemError> {
        let (problem, local) = match &self.dependence {
            Dependence::Straight { ends, law } => {
                return Ok(FamilyMember {
                    interface: if *law {
                        coulomb(&self.scene(s)?, self.base.mesh())?
                    } else {
                        Arc::clone(&self.interface)
                    },
                    base: Arc::clone(&self.base),
                    dual: between(ends, self.range.share(s)),
                    local: Arc::clone(&self.local),
                });
            }
            Dependence::Curved => {
                let problem = self.base.with_scene(explicit(self.scene(s)?))?;
                (problem, Arc::clone(&self.local))
            }
            Dependence::Operator => {
                let problem = assemble(&self.scene(s)?, self.folder)?;
                let local = LocalStiffness::new(dual_of(&problem));
                (problem, Arc::new(local))
            }
        };
        Ok(FamilyMember {
            interface: coulomb(problem.scene(), problem.mesh())?,
            dual: dual_of(&problem).clone(),
            base: Arc::new(problem),
            local,
        })
    }

    /// The size of stresses in Pa, a power of two near ‖S⁻¹h‖ of the glued face at the harder end.
    pub(super) fn stress(&self) -> Result<f64, ProblemError> {
        let glued = |s: f64| -> Result<f64, ProblemError> {
            let member = self.member(s)?;
            Ok(norm(&member.local.bonded(&member.dual.rhs)))
        };
        Ok(power_of_two(glued(0.0)?.max(glued(1.0)?)))
    }

    /// The size of slips in m: that of the body without contact, or of a knot of the law where the loads make none.
    pub(super) fn slip(&self) -> Result<f64, ProblemError> {
        let largest = |s: f64| -> Result<f64, ProblemError> {
            let member = self.member(s)?;
            let slips = member.dual.compliance.iter().flat_map(|c| &c.slip_free);
            Ok(slips.flatten().fold(0.0, |most, u| f64::max(most, u.abs())))
        };
        Ok(power_of_two(largest(0.0)?.max(largest(1.0)?)))
    }
}

/// The law of a scene on its mesh.
fn coulomb(scene: &Scene, mesh: &Mesh) -> Result<Arc<Interface>, ProblemError> {
    match Interface::new(scene, mesh)? {
        Some(interface) if interface.coulomb().is_some() => Ok(Arc::new(interface)),
        _ => Err(no_friction().into()),
    }
}

/// The nearest power of two above a size; 1 for none. Scales that are powers of two round nothing.
fn power_of_two(size: f64) -> f64 {
    if size > 0.0 && size.is_finite() {
        size.log2().ceil().exp2()
    } else {
        1.0
    }
}

/// A range of one sign whose ends differ by more than this factor is followed in the logarithm of the parameter.
const LOGARITHMIC_FROM: f64 = 100.0;

/// A range of a parameter of a scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ParameterRange {
    /// The key, for messages.
    pub key: String,
    /// The value at s = 0.
    pub from: f64,
    /// The value at s = 1.
    pub to: f64,
}

impl ParameterRange {
    /// Whether s is the share of the logarithm, and not of the value.
    #[must_use]
    pub fn is_logarithmic(&self) -> bool {
        let ratio = self.to / self.from;
        ratio > 0.0
            && ratio.is_finite()
            && !(LOGARITHMIC_FROM.recip()..=LOGARITHMIC_FROM).contains(&ratio)
    }

    /// The parameter at s.
    #[must_use]
    pub fn value(&self, s: f64) -> f64 {
        if s == 0.0 {
            self.from
        } else if s == 1.0 {
            self.to
        } else if self.is_logarithmic() {
            self.from * (self.to / self.from).powf(s)
        } else {
            self.from + s * (self.to - self.from)
        }
    }

    /// The share of the way from `from` to `to` of the value at s.
    pub(super) fn share(&self, s: f64) -> f64 {
        if self.is_logarithmic() {
            (self.value(s) - self.from) / (self.to - self.from)
        } else {
            s
        }
    }
}

pub(super) fn explicit(mut scene: Scene) -> Scene {
    scene.assemble.dual_operator = DualOperatorKind::Explicit;
    scene.assemble.factor = FactorPrecision::Double;
    scene
}

pub(super) fn assemble(scene: &Scene, folder: &Path) -> Result<AssembledProblem, ProblemError> {
    match scene.contacts.as_slice() {
        [_] if scene.has_friction() => {}
        [] | [_] => return Err(no_friction().into()),
        several => return Err(several_faces(several.len()).into()),
    }
    let assembled = Problem::in_folder(explicit(scene.clone()), folder)?.assemble()?;
    refuse_floating(&assembled, "paths of solutions")?;
    Ok(assembled)
}

fn several_faces(found: usize) -> InvalidValue {
    InvalidValue {
        key: "contact".into(),
        expected: "one contact face, whose zones and segments of its law name the pieces of a path"
            .into(),
        found: format!("{found} faces"),
        help: "leave all but one out, or solve at single values with a sweep".into(),
    }
}

pub(super) fn no_friction() -> InvalidValue {
    InvalidValue {
        key: "friction".into(),
        expected: "Coulomb friction on a contact face, at every value of the parameter".into(),
        found: "a scene without".into(),
        help: "without friction, or with a given slip bound, there is one solution for every value; a sweep solves for them".into(),
    }
}

/// Whether loads and gap of a problem lie on the line between two others, at a share of it.
pub(super) fn on_line(
    first: &AssembledProblem,
    second: &AssembledProblem,
    share: f64,
    between: &AssembledProblem,
) -> bool {
    let load = |problem: &AssembledProblem| problem.system.assembly.primal.load.clone();
    let held = |problem: &AssembledProblem| {
        let prescribed = problem.system.assembly.primal.dofs.prescribed.as_ref();
        prescribed.map_or_else(Vec::new, |held| held.as_flattened().to_vec())
    };
    let gap = |problem: &AssembledProblem| {
        let state = problem.contact_side();
        state
            .and_then(|state| state.interface.gap.clone())
            .unwrap_or_default()
    };
    let straight = |of: &dyn Fn(&AssembledProblem) -> Vec<f64>| {
        let [a, b, c] = [first, second, between].map(of);
        let longest = a.len().max(b.len()).max(c.len());
        let at = |v: &[f64], i: usize| v.get(i).copied().unwrap_or(0.0);
        let size = [&a, &b]
            .into_iter()
            .flatten()
            .fold(0.0, |m, v| f64::max(m, v.abs()));
        (0..longest).all(|i| {
            let line = at(&a, i) + share * (at(&b, i) - at(&a, i));
            // How far they may be from it, relative to the largest load; their own rounding is some ε.
            (at(&c, i) - line).abs() <= 1e-13 * size
        })
    };
    straight(&load) && straight(&held) && straight(&gap)
}

/// h and the free slip at a share of the way between those of two problems.
pub(super) fn between(ends: &[ExplicitDual; 2], share: f64) -> ExplicitDual {
    let line = |a: f64, b: f64| a + share * (b - a);
    let mut dual = ends[0].clone();
    for (h, other) in dual.rhs.iter_mut().zip(&ends[1].rhs) {
        *h = line(*h, *other);
    }
    if let (Some(own), Some(other)) = (&mut dual.compliance, &ends[1].compliance) {
        let slips = own.slip_free.as_flattened_mut().iter_mut();
        for (u, other) in slips.zip(other.slip_free.as_flattened()) {
            *u = line(*u, *other);
        }
    }
    dual
}
