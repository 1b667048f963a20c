//! Checks of the law of friction.

use super::{holds, positive, require};
use crate::scene::{
    Coefficient, Friction, Grid, InvalidValue, LEAST_COEFFICIENT, Quantity, Scene, Table, Written,
    is_coefficient,
};

pub(super) fn check(scene: &Scene) -> Result<(), InvalidValue> {
    if scene.friction.is_some() {
        require(
            !scene.contacts.is_empty(),
            "friction",
            "a [contact] table beside [friction]",
            "no contact",
            "friction acts on the contact face; name it in [contact]",
        )?;
        let own = (0..scene.contacts.len())
            .filter(|entry| scene.contacts[*entry].friction.is_some())
            .map(|entry| format!("{}.friction", scene.contact_key(entry)));
        let own: Vec<String> = own.collect();
        require(
            own.len() < scene.contacts.len(),
            "friction",
            "a contact face that it can be the law of",
            format!("none, for each has {} in its place", own.join(" or ")),
            "[friction] is for contact faces without friction of their own: leave one of the two out",
        )?;
    }
    for (key, friction) in scene.friction_tables() {
        check_law(scene, friction, &key)?;
    }
    Ok(())
}

fn check_law(scene: &Scene, friction: &Friction, key: &str) -> Result<(), InvalidValue> {
    check_choice(friction, key)?;
    for (name, coefficient) in friction.given() {
        let key = format!("{key}.{name}");
        check_coefficient(coefficient, &key, scene.units.length())?;
        check_variables(coefficient, name == "coefficient", &key)?;
    }
    let stress = scene.units.stress();
    if let Some(bound) = &friction.slip_bound {
        check_tresca(friction, bound, &stress, key)?;
    }
    match friction.pressure_cap {
        Some(cap) => check_cap(friction, cap, &stress, key),
        None => Ok(()),
    }
}

fn check_choice(friction: &Friction, key: &str) -> Result<(), InvalidValue> {
    let names: Vec<&str> = friction.given().map(|(name, _)| name).collect();
    require(
        friction.law().is_some(),
        key,
        "coefficient (isotropic), or coefficient_1 and coefficient_2 (orthotropic)",
        match names.as_slice() {
            [] => "none of them".to_owned(),
            names => names.join(" and "),
        },
        "give one isotropic coefficient or both orthotropic ones; leave [friction] out for frictionless contact",
    )
}

fn check_tresca(
    friction: &Friction,
    bound: &Quantity,
    stress: &str,
    key: &str,
) -> Result<(), InvalidValue> {
    require(
        holds(bound, |g| g >= 0.0 && g.is_finite()),
        format!("{key}.slip_bound"),
        &format!("a slip bound g >= 0 [{stress}] or an expression in x, y, z"),
        Written(bound),
        "Tresca's law bounds the tangential stress by a given g",
    )?;
    for (name, coefficient) in friction.given() {
        require(
            match coefficient {
                Coefficient::Constant(_) => true,
                Coefficient::Ramp(_)
                | Coefficient::Table(_)
                | Coefficient::Grid(_)
                | Coefficient::Expression(_)
                | Coefficient::Function(_) => false,
            },
            format!("{key}.{name}"),
            "a constant beside slip_bound",
            Written(coefficient),
            "for coefficients that vary use Coulomb's law: leave slip_bound out",
        )?;
    }
    Ok(())
}

fn check_cap(friction: &Friction, cap: f64, stress: &str, key: &str) -> Result<(), InvalidValue> {
    let key = format!("{key}.pressure_cap");
    require(
        positive(cap),
        key.clone(),
        &format!("a finite pressure > 0 [{stress}]"),
        Written(&cap),
        "friction grows with the pressure up to this one; leave pressure_cap out where nothing limits it",
    )?;
    require(
        friction.slip_bound.is_none(),
        key,
        "no pressure_cap beside slip_bound",
        Written(&cap),
        "Tresca's law has a given bound and follows no pressure: leave one of the two out",
    )
}

fn check_coefficient(
    coefficient: &Coefficient,
    key: &str,
    length: &str,
) -> Result<(), InvalidValue> {
    match coefficient {
        Coefficient::Constant(value) => require(
            is_coefficient(*value),
            format!("{key}.constant"),
            &format!("a positive coefficient, {LEAST_COEFFICIENT:e} at least"),
            Written(value),
            "the theory needs 0 < F, and the program 1/F; for frictionless contact leave [friction] out",
        ),
        Coefficient::Ramp(ramp) => require(
            is_coefficient(ramp.initial)
                && is_coefficient(ramp.residual)
                && positive(ramp.rate)
                && ramp.onset >= 0.0
                && ramp.onset.is_finite(),
            format!("{key}.ramp"),
            &format!(
                "initial > 0, residual > 0, both {LEAST_COEFFICIENT:e} at least, rate > 0 [1/{length}], onset >= 0 [{length}]"
            ),
            Written(ramp),
            "rate is the steepness |dF/dslip|; whether F falls or rises follows from initial and residual",
        ),
        Coefficient::Table(table) => check_table(table, &format!("{key}.table"), length),
        Coefficient::Grid(grid) => check_grid(grid, &format!("{key}.grid"), length),
        // Checked where they are evaluated.
        Coefficient::Expression(_) | Coefficient::Function(_) => Ok(()),
    }
}

fn check_slips(slips: &[f64], key: String, length: &str) -> Result<(), InvalidValue> {
    require(
        slips.first() == Some(&0.0)
            && slips.windows(2).all(|w| w[0] < w[1])
            && slips.iter().all(|s| s.is_finite()),
        key,
        &format!("increasing slips from 0 on [{length}]"),
        Written(&slips),
        "the first slip is 0, the law is constant beyond the last",
    )
}

fn check_table(table: &Table, key: &str, length: &str) -> Result<(), InvalidValue> {
    check_slips(&table.slip, format!("{key}.slip"), length)?;
    require(
        table.value.len() == table.slip.len() && table.value.iter().all(|&f| is_coefficient(f)),
        format!("{key}.value"),
        &format!(
            "{} positive coefficients, one for each slip, {LEAST_COEFFICIENT:e} at least",
            table.slip.len()
        ),
        Written(&table.value),
        "the theory needs 0 < F, and the program 1/F",
    )
}

fn check_grid(grid: &Grid, key: &str, length: &str) -> Result<(), InvalidValue> {
    for (name, slips) in [("slip_1", &grid.slip_1), ("slip_2", &grid.slip_2)] {
        check_slips(slips, format!("{key}.{name}"), length)?;
    }
    let shaped = grid.value.len() == grid.slip_1.len()
        && grid.value.iter().all(|row| row.len() == grid.slip_2.len());
    require(
        shaped && grid.value.iter().flatten().all(|&f| is_coefficient(f)),
        format!("{key}.value"),
        &format!(
            "{} rows of {} positive coefficients, {LEAST_COEFFICIENT:e} at least",
            grid.slip_1.len(),
            grid.slip_2.len()
        ),
        Written(&grid.value),
        "one row for each slip_1, one column for each slip_2",
    )
}

/// An isotropic law is a function of |u_t| = s alone, an orthotropic one of s1 and s2.
fn check_variables(
    coefficient: &Coefficient,
    isotropic: bool,
    key: &str,
) -> Result<(), InvalidValue> {
    let (wrong, expected): (&[&str], _) = if isotropic {
        (&["s1", "s2"], "the slip s = |u_t| in an isotropic law")
    } else {
        (&["s"], "the slips s1 and s2 in an orthotropic law")
    };
    let used = match coefficient {
        Coefficient::Expression(formula) => wrong.iter().any(|v| formula.expression().uses(v)),
        Coefficient::Grid(_) => isotropic,
        Coefficient::Function(function) => isotropic && !function.is_of_own_slip_only(),
        Coefficient::Constant(_) | Coefficient::Ramp(_) | Coefficient::Table(_) => false,
    };
    require(
        !used,
        format!("{key}.{}", coefficient.kind()),
        expected,
        wrong.join(", "),
        "use coefficient for F(|u_t|), coefficient_1 and coefficient_2 for F(|u_t1|, |u_t2|)",
    )
}
