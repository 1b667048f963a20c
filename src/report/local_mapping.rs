//! What is said about the surroundings of a solution.

use contact3d::solver::LocalMapping;

/// The spectral radius of Ψ' in words.
pub(super) fn radius_words(local: &LocalMapping) -> String {
    let radius = local.spectral_radius;
    if local.is_attracting() {
        format!("{radius:.4}")
    } else {
        format!("{radius:.3e}, not below 1: successive approximations leave this solution")
    }
}

/// What the sign of det R' says about other solutions; `None` where it says nothing.
pub(super) fn sign_words(local: &LocalMapping) -> Option<String> {
    match local.determinant {
        -1 => Some(
            "negative: at least two other solutions exist (`branches --all` searches for them)"
                .to_owned(),
        ),
        0 => Some("zero: other solutions may lie nearby (`branches` follows them)".to_owned()),
        _ => None,
    }
}

/// What the nearness of det R' = 0 says; `None` where it is not near.
pub(super) fn fold_words(local: &LocalMapping) -> Option<String> {
    let distance = local.fold_distance;
    local.is_near_fold().then(|| {
        format!(
            "{distance:.2e}: another solution may be near, and small changes of the data move this one far \
             (`branches` follows it)"
        )
    })
}
