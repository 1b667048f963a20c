//! Refusal of problems whose assembled numbers overflow.

use super::DualSystem;
use crate::scene::Invalid;

impl DualSystem {
    /// Refuses a problem whose assembled numbers overflowed: no solve could begin, and no file would hold them.
    pub(super) fn require_finite(&self) -> Result<(), Invalid> {
        let found = [
            ("stiffness", self.assembly.primal.stiffness.data.as_slice()),
            ("load", self.assembly.primal.load.as_slice()),
        ];
        let contact = self.contact.iter().flat_map(|contact| {
            let dense = contact.explicit();
            let compliance = dense.and_then(|dense| dense.compliance.as_ref());
            [
                Some(("right-hand side h", contact.dual_rhs())),
                dense.map(|dense| ("dual operator S", dense.operator.as_slice())),
                compliance.map(|c| ("compliance of the contact face", c.matrix.as_slice())),
                compliance.map(|c| ("free slip", c.slip_free.as_flattened())),
            ]
        });
        let mut arrays = found.into_iter().chain(contact.flatten());
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        match arrays.find(|(_, values)| !finite(values)) {
            None => Ok(()),
            Some((name, _)) => Err(Invalid {
                key: "material".into(),
                expected: "moduli, loads and sizes that double precision can compute with".into(),
                found: format!("a {name} that is not finite"),
                help: "choose units in which stiffness, loads and lengths are moderate".into(),
            }),
        }
    }
}
