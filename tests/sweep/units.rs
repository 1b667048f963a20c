//! Units in a sweep: one system for all cases, spoken in the tables.

use std::fs;

use hdf5_metno as hdf5;

use crate::program::Sweep;

const AXIS: &str = "[set]\n\"body.brick.cells\" = [6, 2, 2]\n\
                    [[axis]]\nkey = \"friction.coefficient_1\"\n\
                    values = [{ constant = 0.2 }, { constant = 0.4 }]\n";

fn with(setting: &str) -> String {
    AXIS.replacen("[set]\n", &format!("[set]\n{setting}\n"), 1)
}

#[test]
fn the_default_said_or_not_names_the_same_cases() {
    let sweep = Sweep::new(AXIS);
    let unsaid = sweep.plan();
    sweep.write(&with("\"units.length\" = \"m\""));
    assert_eq!(sweep.plan(), unsaid);
    sweep.write(&with("\"units.length\" = \"mm\""));
    assert_ne!(sweep.plan()[0]["id"], unsaid[0]["id"]);
}

#[test]
fn tables_speak_the_units_of_the_plan_and_hold_no_other_cases() {
    let sweep = Sweep::new(AXIS);
    let (code, said) = sweep.run("out", &["--no-figures"]);
    assert_eq!(code, 0, "{said}");
    sweep.write(&with("\"units.length\" = \"mm\""));
    let (code, said) = sweep.run("out", &["--no-figures"]);
    assert_eq!(code, 0, "{said}");
    let table = fs::read_to_string(sweep.path("out/summary.csv")).unwrap();
    assert!(
        table
            .lines()
            .next()
            .unwrap()
            .ends_with("length_unit,force_unit,stress_unit,energy_unit")
    );
    let rows: Vec<&str> = table.lines().skip(1).collect();
    assert_eq!(rows.len(), 2, "{table}");
    assert!(
        rows.iter().all(|row| row.ends_with(",mm,N,MPa,mJ")),
        "{table}"
    );
    let file = hdf5::File::open(sweep.path("out/summary.h5")).unwrap();
    for (dataset, unit) in [
        ("/cases/largest_pressure", "MPa"),
        ("/cases/largest_displacement_along", "mm"),
        ("/cases/normal_force", "N"),
        ("/cases/strain_energy", "mJ"),
    ] {
        let units = file.dataset(dataset).unwrap().attr("units").unwrap();
        let found = units.read_scalar::<hdf5::types::VarLenUnicode>().unwrap();
        assert_eq!(found.as_str(), unit, "{dataset}");
    }
}

#[test]
fn units_on_an_axis_are_refused_before_anything_is_written() {
    let sweep = Sweep::new(AXIS);
    for axis in [
        "[[axis]]\nkey = \"units.length\"\nvalues = [\"m\", \"mm\"]\n",
        "[[axis]]\nkey = \"units\"\nvalues = [{ length = \"m\" }, { length = \"mm\" }]\n",
    ] {
        sweep.write(&format!("{AXIS}{axis}"));
        let (code, said) = sweep.run("out", &[]);
        assert_eq!(code, 2, "{said}");
        assert!(said.contains("nothing is converted"), "{said}");
        assert!(!sweep.path("out").exists());
    }
}
