//! `/theory`: the constants of HKL section 3, and what successive approximations really do.

mod levels;
mod norms;
mod rows;

pub(super) use levels::TABLE as LEVELS_TABLE;
pub(super) use norms::TABLE as NORMS_TABLE;
pub(super) use rows::TABLE as ROWS_TABLE;

use contact3d::theory::{LawConstants, Theory};
use runfile::{DatasetSpec, Group, GroupWriter, Kind, Reader, StoreError};
use units::Dimension;

use super::{FormatError, read_scalar};

/// The theory of HKL section 3, measured; computed from the scene alone.
pub const GROUP: Group = Group::new("theory", "theory");

const FINDINGS: &str = "/theory/findings";
const LAW_SMALLEST: &str = "/theory/law/coefficient_min";
const LAW_LARGEST: &str = "/theory/law/coefficient_max";
const LAW_LIPSCHITZ: &str = "/theory/law/lipschitz";
const LAW_ANISOTROPY: &str = "/theory/law/anisotropy";
const LAW_ESTIMATED: &str = "/theory/law/estimated";

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(FINDINGS, Kind::Text, &[], Dimension::Number, "What the figures mean, in a few sentences."),
    GROUP.row(LAW_SMALLEST, Kind::F64, &[], Dimension::Number, "Smallest coefficient of friction, HKL (2.4).").symbol("F_min"),
    GROUP.row(LAW_LARGEST, Kind::F64, &[], Dimension::Number, "Largest coefficient of friction, HKL (2.4).").symbol("F_max"),
    GROUP.row(LAW_LIPSCHITZ, Kind::F64, &[], Dimension::PER_LENGTH, "Lipschitz modulus of the coefficients by the slips, HKL (3.10).").symbol("L"),
    GROUP.row(LAW_ANISOTROPY, Kind::F64, &[], Dimension::Number, "Largest ratio of the two coefficients at one place and slip, HKL Lemma 3.5.").symbol("kappa"),
    GROUP.row(LAW_ESTIMATED, Kind::U8, &[], Dimension::Number, "1 where these four are estimates, because a coefficient is a formula."),
];

/// Writes all that was measured.
///
/// # Errors
/// HDF5 failures.
pub fn write(writer: &mut GroupWriter<'_>, theory: &Theory) -> Result<(), StoreError> {
    let law = &theory.law;
    writer.write_text(FINDINGS, &theory.findings().to_string())?;
    for (path, value) in [
        (LAW_SMALLEST, law.smallest),
        (LAW_LARGEST, law.largest),
        (LAW_LIPSCHITZ, law.lipschitz),
        (LAW_ANISOTROPY, law.anisotropy),
    ] {
        writer.write(path, &[value], &[])?;
    }
    writer.write(LAW_ESTIMATED, &[u8::from(law.estimated)], &[])?;
    levels::write(writer, &theory.levels)?;
    norms::write(writer, &theory.levels)?;
    rows::write(writer, &theory.levels)
}

/// Reads all that was measured.
///
/// # Errors
/// Missing, altered or contradictory datasets.
pub fn read(reader: &Reader) -> Result<Theory, FormatError> {
    let estimated: Vec<u8> = reader.read_vec(LAW_ESTIMATED)?;
    let mut levels = levels::read(reader)?;
    norms::read(reader, &mut levels)?;
    rows::read(reader, &mut levels)?;
    Ok(Theory {
        law: LawConstants {
            smallest: read_scalar(reader, LAW_SMALLEST)?,
            largest: read_scalar(reader, LAW_LARGEST)?,
            lipschitz: read_scalar(reader, LAW_LIPSCHITZ)?,
            anisotropy: read_scalar(reader, LAW_ANISOTROPY)?,
            estimated: estimated.first() == Some(&1),
        },
        levels,
    })
}

/// A figure that may be missing, stored as NaN.
fn known(value: f64) -> Option<f64> {
    Some(value).filter(|value| !value.is_nan())
}

/// Refuses columns of other lengths than that of the meshes.
fn require_rows<T>(dataset: &'static str, column: &[T], rows: usize) -> Result<(), FormatError> {
    if column.len() == rows {
        return Ok(());
    }
    Err(FormatError::Inconsistent {
        dataset,
        reason: format!("expected {rows} values, found {}", column.len()),
    })
}
