//! A bound of the discretisation error.

use contact3d::scene::{Quantity, Scene};
use studies::bound::RelativeBound;

use super::{Figures, percent};

/// The bound and its parts, and an estimate of the same error where there is one.
pub fn figures(bound: &RelativeBound, scene: &Scene, estimate: Option<f64>) -> Figures {
    let mut figures = Figures::new(scene.units);
    let whole = "error in the energy norm";
    add(&mut figures, "total", whole, bound.total);
    if bound.total.is_none() {
        let why = why_none(scene);
        let words = format!("no bound: {why}, and the contact stresses have an error of their own");
        figures.human_only(whole, Some(words));
    }
    let parts = [
        (
            "elements",
            "under these contact stresses",
            Some(bound.elements),
        ),
        ("lifting", "of it penetration", bound.lifting),
        (
            "complementarity",
            "of it pressure on gaps",
            bound.complementarity,
        ),
        ("friction", "of it slip", bound.friction),
    ];
    let n_parts = if bound.lifting.is_some() { 4 } else { 1 };
    for (key, words, share) in &parts[..n_parts] {
        add(&mut figures, key, words, *share);
    }
    let shown = estimate.map(|share| format!("about {}", percent(share)));
    figures.described("estimate", "estimated", shown, estimate);
    figures
}

fn add(figures: &mut Figures, key: &str, words: &str, share: Option<f64>) {
    let shown = share.map(|share| {
        let percent = percent(rounded_up(share));
        format!("guaranteed at most {percent}, rounded up")
    });
    figures.described(key, words, shown, share);
}

/// Why only the error for the contact stresses as they are has a bound.
fn why_none(scene: &Scene) -> &'static str {
    if scene
        .contacts
        .iter()
        .any(|face| face.gap.depends_on_place())
    {
        return "a gap is a formula";
    }
    let laws = (0..scene.contacts.len()).filter_map(|entry| scene.friction_on(entry));
    let mut bounds = laws.map(|(_, law)| law.slip_bound.as_ref());
    if bounds.clone().any(|bound| bound.is_none()) {
        return "friction follows the pressure";
    }
    match bounds.any(|bound| bound.is_some_and(Quantity::depends_on_place)) {
        true => "a slip bound is a formula",
        false => "friction in a load history",
    }
}

/// The next larger number of two digits.
fn rounded_up(share: f64) -> f64 {
    let unit = 10_f64.powf(share.log10().floor() - 1.0);
    if unit > 0.0 {
        (share / unit).ceil() * unit
    } else {
        share
    }
}
