//! A scene that depends on one parameter, and the contact problem at each value of it.

use std::{cell::RefCell, collections::VecDeque, path::Path, sync::Arc};

use super::{
    assembled::{assemble, dual_of, explicit, no_friction},
    ends::ParameterRange,
    point::FamilyMember,
    straight::{between, on_line},
};
use contact3d::{
    AssembledProblem, ProblemError,
    contact::Interface,
    dual::{ExplicitDual, LocalStiffness},
    linalg::norm,
    scene::{Invalid, Scene},
};

/// Places in the range at which the loads must lie on a straight line to be taken from it, and the whole scene be valid.
const PROBES: [f64; 3] = [0.289, 0.5, 0.781];

/// Problems that are kept in memory at a time: a point and both sides of its difference.
const KEPT: usize = 6;

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

/// The scene at a value of the parameter.
pub type SceneAt<'a> = dyn Fn(f64) -> Result<Scene, Invalid> + 'a;

/// The contact problems of a scene in a range of a parameter.
pub struct Family<'a> {
    range: ParameterRange,
    scene_at: &'a SceneAt<'a>,
    folder: &'a Path,
    base: Arc<AssembledProblem>,
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
        scene_at: &'a SceneAt<'a>,
        folder: &'a Path,
    ) -> Result<Self, ProblemError> {
        if !(range.from.is_finite() && range.to.is_finite() && range.from != range.to) {
            return Err(Invalid {
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
        let interface = |problem: &AssembledProblem| {
            let interface = Interface::new(problem.scene(), problem.mesh())?;
            match interface {
                Some(interface) if interface.coulomb().is_some() => Ok(Arc::new(interface)),
                _ => Err(ProblemError::from(no_friction())),
            }
        };
        let interfaces = [interface(&first)?, interface(&second)?];
        // The one whose law follows the slip has the compliance that laws of both kinds can use.
        let base = if interfaces[0].follows_slip() {
            &first
        } else {
            &second
        };
        let shares = |scene: &Scene| base.with_scene(explicit(scene.clone()));
        let others: Vec<_> = PROBES
            .iter()
            .map(|s| Ok(shares(&scene(*s)?)))
            .chain([Ok(shares(&ends[0])), Ok(shares(&ends[1]))])
            .collect::<Result<_, ProblemError>>()?;
        let same_operator = others
            .iter()
            .all(|other| !matches!(other, Err(ProblemError::OtherOperator { .. })));
        let dependence = if same_operator {
            let others = others.into_iter().collect::<Result<Vec<_>, _>>()?;
            let (probes, ends) = others.split_at(PROBES.len());
            let is_straight = PROBES
                .iter()
                .zip(probes)
                .all(|(s, probe)| on_line(&ends[0], &ends[1], range.share(*s), probe));
            let law = others
                .iter()
                .any(|other| other.scene().friction != ends[0].scene().friction);
            if is_straight {
                Dependence::Straight {
                    ends: Box::new([dual_of(&ends[0]).clone(), dual_of(&ends[1]).clone()]),
                    law,
                }
            } else {
                Dependence::Curved
            }
        } else {
            Dependence::Operator
        };
        let base = Arc::clone(base);
        Ok(Self {
            local: Arc::new(
                LocalStiffness::new(dual_of(&base))
                    .dragged_by(&dual_of(&first).rhs)
                    .dragged_by(&dual_of(&second).rhs),
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

    /// The range.
    #[must_use]
    pub fn range(&self) -> &ParameterRange {
        &self.range
    }

    /// The assembled problem from which those of all values follow.
    #[must_use]
    pub fn base(&self) -> &AssembledProblem {
        &self.base
    }

    /// The scene at s.
    pub(super) fn scene(&self, s: f64) -> Result<Scene, Invalid> {
        (self.scene_at)(self.range.value(s)).and_then(Scene::checked)
    }

    /// The assembled problem at s, to solve.
    pub(super) fn problem(&self, s: f64) -> Result<AssembledProblem, ProblemError> {
        self.problem_at(self.range.value(s))
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
        if kept.len() == KEPT {
            kept.pop_front();
        }
        kept.push_back((s.to_bits(), Arc::clone(&member)));
        Ok(member)
    }

    fn make(&self, s: f64) -> Result<FamilyMember, ProblemError> {
        let law_at = |changes: bool, problem: &AssembledProblem| -> Result<_, ProblemError> {
            if !changes {
                return Ok(Arc::clone(&self.interface));
            }
            let interface = Interface::new(&self.scene(s)?, problem.mesh())?;
            match interface {
                Some(interface) if interface.coulomb().is_some() => Ok(Arc::new(interface)),
                _ => Err(no_friction().into()),
            }
        };
        match &self.dependence {
            Dependence::Straight { ends, law } => Ok(FamilyMember {
                interface: law_at(*law, &self.base)?,
                base: Arc::clone(&self.base),
                dual: between(ends, self.range.share(s)),
                local: Arc::clone(&self.local),
            }),
            Dependence::Curved => {
                let problem = self.base.with_scene(explicit(self.scene(s)?))?;
                Ok(FamilyMember {
                    interface: law_at(true, &problem)?,
                    dual: dual_of(&problem).clone(),
                    base: Arc::new(problem),
                    local: Arc::clone(&self.local),
                })
            }
            Dependence::Operator => {
                let problem = assemble(&self.scene(s)?, self.folder)?;
                let dual = dual_of(&problem).clone();
                Ok(FamilyMember {
                    interface: law_at(true, &problem)?,
                    local: Arc::new(LocalStiffness::new(&dual)),
                    dual,
                    base: Arc::new(problem),
                })
            }
        }
    }

    /// The size of stresses in Pa, a power of two near ‖S⁻¹h‖ of the glued face at the harder end.
    pub(super) fn stress(&self) -> Result<f64, ProblemError> {
        let glued = |s: f64| -> Result<f64, ProblemError> {
            let member = self.member(s)?;
            Ok(norm(&member.local.glued(&member.dual.rhs)))
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

/// The nearest power of two above a size; 1 for none. Scales that are powers of two round nothing.
pub(super) fn power_of_two(size: f64) -> f64 {
    if size > 0.0 && size.is_finite() {
        size.log2().ceil().exp2()
    } else {
        1.0
    }
}
