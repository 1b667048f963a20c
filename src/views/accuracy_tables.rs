//! The tables of errors in a report.

use contact3d::{
    convergence::{AlgebraicLadder, Cost, DiscretisationLadder, Ways},
    solver::Status,
};
use plots::html::Table;
use units::Units;

/// The meshes of the discretisation ladder.
pub(super) fn levels(ladder: &DiscretisationLadder, units: Units) -> Table {
    let order = |orders: &[Option<f64>], k: usize| optional(orders[k], 2);
    let rows = ladder.levels.iter().enumerate().map(|(k, level)| {
        let mut row = vec![
            level.n_div.to_string(),
            level.n_free.to_string(),
            format!("{:.4}", level.energy_difference),
            optional(level.energy_error, 4),
            order(&ladder.energy_norm.orders, k),
            format!("{:.6e}", level.potential_energy),
            order(&ladder.potential_energy.orders, k),
            level
                .forces
                .map_or("-".into(), |f| format!("{:.6e}", f.normal)),
            ladder
                .forces
                .first()
                .map_or("-".into(), |t| order(&t.orders, k)),
            level.applications.to_string(),
        ];
        row.extend(cost_and_status(&level.cost, level.status));
        row
    });
    let head = [
        "n_div",
        "unknowns",
        "error to finest",
        "error to limit",
        "order",
        &format!("potential energy [{}]", units.energy()),
        "its order",
        &format!("normal force [{}]", units.force()),
        "its order",
        "n_A",
        "seconds",
        "median of",
        "peak MB",
        "status",
    ];
    Table {
        caption: "Discretisation error, relative, in the energy norm; - where no order is observed"
            .into(),
        head: head.map(str::to_owned).into(),
        rows: rows.collect(),
    }
}

/// The meshes of all ways and their reference.
pub(super) fn ways(ways: &Ways) -> Table {
    let levels = ways
        .ways
        .iter()
        .flat_map(|way| way.levels.iter().map(|l| (way.kind.words(), l)));
    let rows = levels
        .chain([("reference", &ways.reference.level)])
        .map(|(name, level)| {
            let mut row = vec![
                name.to_owned(),
                level.n_free.to_string(),
                level.n_multipliers.to_string(),
                format!("{:.4}", level.estimated_error),
                format!("{:.4}", level.contact_error),
                optional(level.error, 4),
                optional(level.effectivity(), 2),
            ];
            row.extend(cost_and_status(&level.cost, level.status));
            row
        });
    let head = [
        "way",
        "unknowns",
        "multipliers",
        "estimated error",
        "of contact",
        "error",
        "estimated over true",
        "seconds",
        "median of",
        "peak MB",
        "status",
    ];
    Table {
        caption: "Ways to accuracy: relative errors in the energy norm, uncertain by the estimated error of the \
                  reference; - where that is too large to tell"
            .into(),
        head: head.map(str::to_owned).into(),
        rows: rows.collect(),
    }
}

/// The solves of the algebraic ladder.
pub(super) fn entries(ladder: &AlgebraicLadder) -> Table {
    let rows = ladder.entries.iter().map(|entry| {
        let mut row = vec![
            entry.method.to_string(),
            entry.operator.to_string(),
            format!("{:.0e}", entry.epsilon),
        ];
        match &entry.result {
            None => {
                row.extend(["-"; 6].map(str::to_owned));
                row.push("not run: over the budget".into());
            }
            Some(result) => {
                row.extend([
                    format!("{:.2e}", result.energy_error),
                    format!("{:.2e}", result.multiplier_error),
                    result.applications.to_string(),
                ]);
                row.extend(cost_and_status(&result.cost, result.status));
            }
        }
        row
    });
    let head = [
        "method",
        "operator",
        "epsilon",
        "error of u",
        "error of λ",
        "n_A",
        "seconds",
        "median of",
        "peak MB",
        "status",
    ];
    Table {
        caption: "Algebraic error, relative to the discrete solution to rounding".into(),
        head: head.map(str::to_owned).into(),
        rows: rows.collect(),
    }
}

fn cost_and_status(cost: &Cost, status: Status) -> [String; 4] {
    [
        format!("{:.4}", cost.seconds),
        cost.repeats.to_string(),
        optional(cost.peak_bytes.map(|bytes| bytes / 1e6), 0),
        status.word().to_owned(),
    ]
}

fn optional(value: Option<f64>, decimals: usize) -> String {
    value.map_or("-".into(), |value| format!("{value:.decimals$}"))
}
