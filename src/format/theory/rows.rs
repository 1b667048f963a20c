//! `/theory/inf_sup` and `/theory/scaled`: several rows for each mesh.

use contact3d::theory::{InfSup, ScaledPoint, TheoryLevel, TrialSpace};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named},
    GroupWriter, Kind, Reader, StoreError, StoredEnum,
};
use units::Dimension;

use super::{GROUP, known, require_rows};
use crate::format::{
    FormatError, columns::Columns, enumeration::stored_as, read_index_vec, require_below,
};

stored_as! {
    /// A space of multipliers, as stored.
    StoredSpace of TrialSpace as "multiplier_space" {
        Cells1 = 0 => "cells_1x1",
        Cells2 = 1 => "cells_2x2",
        Cells4 = 2 => "cells_4x4",
        Linear = 3 => "linear",
    }
}

const LEVEL: &str = "/theory/inf_sup/level";
const SPACE: &str = "/theory/inf_sup/space";
const RATIO: &str = "/theory/inf_sup/size_ratio";
const SMALLEST: &str = "/theory/inf_sup/smallest_eigenvalue";
const INVERSE_HALF: &str = "/theory/inf_sup/inverse_half";
const INF_SUP: &str = "/theory/inf_sup/inf_sup";
const SCALED_LEVEL: &str = "/theory/scaled/level";
const SCALE: &str = "/theory/scaled/scale";
const SOLVED: &str = "/theory/scaled/solved";
const RADIUS: &str = "/theory/scaled/spectral_radius";
const NORM: &str = "/theory/scaled/jacobian_norm_weighted";
const DETERMINANT: &str = "/theory/scaled/determinant_sign";

const SPACES: &[Extent] = &[Named("n_trial_spaces")];
const SCALES: &[Extent] = &[Named("n_scales")];
const NO_BRICK: &str = "absent for mesh files";

const fn space(path: &'static str, kind: Kind, meaning: &'static str) -> DatasetSpec {
    GROUP
        .row(path, kind, SPACES, Dimension::Number, meaning)
        .optional(NO_BRICK)
}

const fn scale(path: &'static str, kind: Kind, meaning: &'static str) -> DatasetSpec {
    GROUP.row(path, kind, SCALES, Dimension::Number, meaning)
}

#[rustfmt::skip]
pub(in crate::format) const TABLE: &[DatasetSpec] = &[
    space(LEVEL, Kind::I64, "Mesh of each row, from 0."),
    space(SPACE, Kind::Enum(StoredSpace::SPEC), "Multipliers constant on pieces of so many cells, or continuous and linear."),
    space(RATIO, Kind::F64, "Diameter of a piece over that of a contact triangle.").symbol("H/h"),
    space(SMALLEST, Kind::F64, "Smallest eigenvalue of |mu|_*,h^2 over |mu|_0^2 in the norm of H1; (3.1) holds where it is positive."),
    space(INVERSE_HALF, Kind::F64, "c_inv(0,-1/2) of (3.16).").symbol("c_inv(0,-1/2)"),
    space(INF_SUP, Kind::F64, "Least |mu|_*,h on this mesh over that on the finest one; NaN on the finest.").symbol("beta"),
    scale(SCALED_LEVEL, Kind::I64, "Mesh of each row, from 0."),
    scale(SCALE, Kind::F64, "Factor of the law of friction.").symbol("t"),
    scale(SOLVED, Kind::U8, "1 where a solution was found; 0 where not, and its figures are NaN and 0."),
    scale(RADIUS, Kind::F64, "Spectral radius of the derivative of Psi at the solution found.").symbol("rho"),
    GROUP.row(NORM, Kind::F64, &[Named("n_scales"), Fixed(2)], Dimension::Number, "Its weighted norm, with the norm of H1 and with the energy norm."),
    scale(DETERMINANT, Kind::I64, "Sign of det R' of the natural map there."),
];

pub(super) fn write(
    writer: &mut GroupWriter<'_>,
    levels: &[TheoryLevel],
) -> Result<(), StoreError> {
    let spaces: Vec<(usize, InfSup)> = rows(levels, |level| &level.inf_sup);
    if !spaces.is_empty() {
        let mut columns = Columns::new(writer, &spaces);
        columns.counts(LEVEL, |(level, _)| *level)?;
        columns.members(SPACE, |(_, row)| StoredSpace::from(row.space))?;
        columns.numbers(RATIO, |(_, row)| row.ratio)?;
        columns.numbers(SMALLEST, |(_, row)| row.smallest)?;
        columns.numbers(INVERSE_HALF, |(_, row)| row.inverse_half)?;
        columns.numbers(INF_SUP, |(_, row)| row.inf_sup.unwrap_or(f64::NAN))?;
    }
    let scaled: Vec<(usize, ScaledPoint)> = rows(levels, |level| &level.scaled);
    let mut columns = Columns::new(writer, &scaled);
    columns.counts(SCALED_LEVEL, |(level, _)| *level)?;
    columns.numbers(SCALE, |(_, row)| row.scale)?;
    columns.flags(SOLVED, |(_, row)| row.solved)?;
    columns.numbers(RADIUS, |(_, row)| row.spectral_radius)?;
    columns.vectors(NORM, |(_, row)| row.norm)?;
    columns.numbers(DETERMINANT, |(_, row)| i64::from(row.determinant))
}

/// The rows of all meshes, each with the number of its mesh.
fn rows<T: Copy>(levels: &[TheoryLevel], of: impl Fn(&TheoryLevel) -> &Vec<T>) -> Vec<(usize, T)> {
    let levels = levels.iter().enumerate();
    levels
        .flat_map(|(k, level)| {
            of(level)
                .iter()
                .map(move |row| (k, *row))
                .collect::<Vec<_>>()
        })
        .collect()
}

pub(super) fn read(reader: &Reader, levels: &mut [TheoryLevel]) -> Result<(), FormatError> {
    if reader.has(LEVEL) {
        read_spaces(reader, levels)?;
    }
    let places = read_index_vec(reader, SCALED_LEVEL)?;
    require_below(SCALED_LEVEL, places.iter().copied(), levels.len())?;
    let numbers = |path: &'static str, width: usize| -> Result<Vec<f64>, FormatError> {
        let column: Vec<f64> = reader.read_vec(path)?;
        require_rows(path, &column, width * places.len())?;
        Ok(column)
    };
    let (scales, radii, norms) = (numbers(SCALE, 1)?, numbers(RADIUS, 1)?, numbers(NORM, 2)?);
    let solved: Vec<u8> = reader.read_vec(SOLVED)?;
    let signs: Vec<i64> = reader.read_vec(DETERMINANT)?;
    require_rows(SOLVED, &solved, places.len())?;
    require_rows(DETERMINANT, &signs, places.len())?;
    for (k, level) in places.iter().enumerate() {
        levels[*level].scaled.push(ScaledPoint {
            scale: scales[k],
            solved: solved[k] != 0,
            spectral_radius: radii[k],
            norm: [norms[2 * k], norms[2 * k + 1]],
            determinant: signs[k].signum() as i8,
        });
    }
    Ok(())
}

fn read_spaces(reader: &Reader, levels: &mut [TheoryLevel]) -> Result<(), FormatError> {
    let places = read_index_vec(reader, LEVEL)?;
    require_below(LEVEL, places.iter().copied(), levels.len())?;
    let numbers = |path: &'static str| -> Result<Vec<f64>, FormatError> {
        let column: Vec<f64> = reader.read_vec(path)?;
        require_rows(path, &column, places.len())?;
        Ok(column)
    };
    let spaces = reader
        .read_enum::<StoredSpace>(SPACE)?
        .into_raw_vec_and_offset()
        .0;
    require_rows(SPACE, &spaces, places.len())?;
    let (ratio, smallest) = (numbers(RATIO)?, numbers(SMALLEST)?);
    let (inverse_half, inf_sup) = (numbers(INVERSE_HALF)?, numbers(INF_SUP)?);
    for (k, level) in places.iter().enumerate() {
        levels[*level].inf_sup.push(InfSup {
            space: spaces[k].into(),
            ratio: ratio[k],
            smallest: smallest[k],
            inverse_half: inverse_half[k],
            inf_sup: known(inf_sup[k]),
        });
    }
    Ok(())
}
