//! Tables and JSON of both ladders.

use std::fmt::Write;

use contact3d::{
    convergence::{
        Accuracy, AlgebraicLadder, Cost, DiscretisationLadder, LadderEntry, Trend, WayLevel, Ways,
    },
    solver::Status,
};
use units::Units;

/// Both tables and the advice.
pub(super) fn words(accuracy: &Accuracy, units: Units) -> String {
    let mut text = String::new();
    if let Some(ladder) = &accuracy.algebraic {
        text += &algebraic_table(ladder);
    }
    if let Some(ladder) = &accuracy.discretisation {
        text += &discretisation_table(ladder, units);
    }
    if let Some(ways) = &accuracy.ways {
        text += &ways_table(ways, units);
    }
    text + &accuracy.advice().to_string()
}

fn ways_table(ways: &Ways, units: Units) -> String {
    let mut text = String::from(
        "Ways to accuracy (relative errors in the energy norm)\n\
         way                  unknowns  multipliers  estimated  of contact    true  effectivity   seconds  peak MB\n",
    );
    let known = |value: Option<f64>, digits: usize| match value {
        Some(value) => format!("{value:.digits$}"),
        None => "-".to_owned(),
    };
    let mut add = |name: &str, level: &WayLevel| {
        let _ = writeln!(
            text,
            "{name:<20} {:>8}  {:>11}  {:>9.4}  {:>10.4}  {:>6}  {:>11}  {:>8.3}  {:>7}{}",
            level.n_free,
            level.n_multipliers,
            level.estimated_error,
            level.contact_error,
            known(level.error, 4),
            known(level.effectivity(), 2),
            level.cost.seconds,
            megabytes(&level.cost),
            match level.status {
                status if status.is_solved() => String::new(),
                status => format!("  {}", status.word()),
            }
        );
    };
    for way in &ways.ways {
        way.levels
            .iter()
            .for_each(|level| add(way.kind.words(), level));
    }
    let reference = &ways.reference;
    add("reference", &reference.level);
    let _ = writeln!(
        text,
        "potential energy of the reference: {:.8e} {}\ncheapest way to {}\n",
        reference.potential_energy,
        units.energy(),
        ways.advice()
    );
    text
}

fn algebraic_table(ladder: &AlgebraicLadder) -> String {
    let mut text = format!(
        "Algebraic error, against Newton's method to {:.1e} ({})\n",
        ladder.reference_accuracy,
        ladder.reference_status.word()
    );
    for (operator, cost) in ["implicit", "explicit"].iter().zip(&ladder.assembly) {
        let _ = writeln!(
            text,
            "assembly, {operator}: {:.3} s (median of {}), peak {} MB",
            cost.seconds,
            cost.repeats,
            megabytes(cost)
        );
    }
    text += "method           operator  epsilon  error of u  error of λ      n_A   seconds  of  peak MB\n";
    for entry in &ladder.entries {
        let _ = writeln!(text, "{}", entry_line(entry));
    }
    text + "\n"
}

fn entry_line(entry: &LadderEntry) -> String {
    let head = format!(
        "{:<16} {:<9} {:>7.0e}",
        entry.method.to_string(),
        entry.operator.to_string(),
        entry.epsilon
    );
    match entry.result {
        None => format!("{head}  not run: over the budget"),
        Some(result) => {
            let note = match result.status {
                Status::Converged => String::new(),
                status => format!("  {}", status.word()),
            };
            format!(
                "{head}  {:>10.2e}  {:>10.2e}  {:>7}  {:>8.4}  {:>2}  {:>7}{note}",
                result.energy_error,
                result.multiplier_error,
                result.applications,
                result.cost.seconds,
                result.cost.repeats,
                megabytes(&result.cost)
            )
        }
    }
}

fn discretisation_table(ladder: &DiscretisationLadder, units: Units) -> String {
    let force = units.force();
    let energy = format!("energy [{}]", units.energy());
    let normal = format!("normal [{force}]");
    let tangential = format!("tangential 1 [{force}]");
    let mut text = format!(
        "Discretisation error (relative, energy norm; order p from each mesh and the two before)\n\
         n_div  unknowns  to finest  to limit     p  {energy:<17}    p  {normal:<13}    p  {tangential:<18}    p    n_A  seconds  of  peak MB\n",
    );
    let order = |trend: Option<&Trend>, k: usize| match trend.and_then(|t| t.orders[k]) {
        Some(order) => format!("{order:.2}"),
        None => "-".to_owned(),
    };
    for (k, level) in ladder.levels.iter().enumerate() {
        let error = level
            .energy_error
            .map_or_else(|| "-".to_owned(), |error| format!("{error:.4}"));
        let normal = level.forces.map(|forces| forces.normal);
        let tangential = level.forces.and_then(|forces| Some(forces.tangential?[0]));
        let number = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{v:.6e}"));
        let _ = writeln!(
            text,
            "{:>5}  {:>8}  {:>9.4}  {error:>8}  {:>4}  {:<17.8e} {:>4}  {:<13} {:>4}  {:<18} {:>4}  {:>5}  {:>7.3}  {:>2}  {:>7}{}",
            level.n_div,
            level.n_free,
            level.energy_difference,
            order(Some(&ladder.energy_norm), k),
            level.potential_energy,
            order(Some(&ladder.potential_energy), k),
            number(normal),
            order(ladder.forces.first(), k),
            number(tangential),
            order(ladder.forces.get(1), k),
            level.applications,
            level.cost.seconds,
            level.cost.repeats,
            megabytes(&level.cost),
            match level.status {
                status if status.is_solved() => String::new(),
                status => format!("  {}", status.word()),
            }
        );
    }
    let limit = |name: &str, unit: &str, trend: Option<&Trend>| match trend {
        None => String::new(),
        Some(Trend { limit: Some(v), .. }) => format!("limit of {name}: {v:.8e} {unit}\n"),
        Some(_) => format!("limit of {name}: no order observed, none claimed\n"),
    };
    text += &limit(
        "the potential energy",
        &units.energy(),
        Some(&ladder.potential_energy),
    );
    text += &limit("the normal force", units.force(), ladder.forces.first());
    text += &limit("tangential force 1", units.force(), ladder.forces.get(1));
    text += &limit("tangential force 2", units.force(), ladder.forces.get(2));
    text + "\n"
}

fn megabytes(cost: &Cost) -> String {
    cost.peak_bytes
        .map_or("unknown".to_owned(), |bytes| format!("{:.0}", bytes / 1e6))
}

/// The same for programs.
pub(super) fn json(accuracy: &Accuracy) -> serde_json::Value {
    let cost = |cost: &Cost| {
        serde_json::json!({
            "seconds": cost.seconds, "repeats": cost.repeats, "peak_bytes": cost.peak_bytes,
        })
    };
    let entries = accuracy.algebraic.iter().flat_map(|ladder| &ladder.entries);
    let entries = entries.map(|entry| {
        let result = entry.result;
        serde_json::json!({
            "method": entry.method.to_string(),
            "operator": entry.operator.to_string(),
            "epsilon": entry.epsilon,
            "status": result.map_or("not_run_over_budget", |r| r.status.word()),
            "energy_error": result.map(|r| r.energy_error),
            "multiplier_error": result.map(|r| r.multiplier_error),
            "actions": result.map(|r| r.applications),
            "cost": result.map(|r| cost(&r.cost)),
        })
    });
    let levels = accuracy.discretisation.iter().flat_map(|ladder| {
        let row = |(k, level): (usize, &contact3d::convergence::Level)| {
            serde_json::json!({
                "n_div": level.n_div,
                "cells": level.cells,
                "n_free": level.n_free,
                "status": level.status.word(),
                "energy_difference": level.energy_difference,
                "energy_error": level.energy_error,
                "energy_order": ladder.energy_norm.orders[k],
                "potential_energy": level.potential_energy,
                "normal_force": level.forces.map(|f| f.normal),
                "tangential_force": level.forces.and_then(|f| f.tangential),
                "actions": level.applications,
                "cost": cost(&level.cost),
            })
        };
        ladder.levels.iter().enumerate().map(row)
    });
    serde_json::json!({
        "rungs": entries.collect::<Vec<_>>(),
        "levels": levels.collect::<Vec<_>>(),
        "advice": accuracy.advice().to_string(),
        "ways": accuracy.ways.as_ref().map(ways_json),
    })
}

fn ways_json(ways: &Ways) -> serde_json::Value {
    let level = |way: &str, level: &WayLevel| {
        serde_json::json!({
            "way": way,
            "n_free": level.n_free,
            "n_tetrahedra": level.n_tetrahedra,
            "status": level.status.word(),
            "estimated_error": level.estimated_error,
            "contact_error": level.contact_error,
            "energy_error": level.error,
            "seconds": level.cost.seconds,
            "peak_bytes": level.cost.peak_bytes,
        })
    };
    let levels = ways
        .ways
        .iter()
        .flat_map(|way| way.levels.iter().map(|row| level(way.kind.words(), row)));
    serde_json::json!({
        "levels": levels.collect::<Vec<_>>(),
        "reference": level("reference", &ways.reference.level),
        "advice": ways.advice().to_string(),
    })
}
