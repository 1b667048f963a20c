//! `/VTKHDF` of a run file, read back for a series of several files.

use runfile::{GroupWriter, Reader, StoreError};

use super::{
    vtkhdf::{
        CONNECTIVITY, Field, N_CELLS, N_CONNECTIVITY, N_POINTS, OFFSETS, POINTS, TABLE, TYPE,
        TYPES, VERSION,
    },
    vtkhdf_series::VALUES,
};

/// The fields that a file has on its points and cells.
#[must_use]
pub fn field_paths(reader: &Reader) -> Vec<&'static str> {
    let on_grid = |path: &&str| {
        path.starts_with("/VTKHDF/PointData/") || path.starts_with("/VTKHDF/CellData/")
    };
    let paths = TABLE.iter().map(|row| row.path);
    paths
        .filter(on_grid)
        .filter(|path| reader.has(path))
        .collect()
}

/// The values of these fields, at the last time where the file is a series itself.
pub(super) fn last_fields(reader: &Reader) -> Result<Vec<Field>, StoreError> {
    let steps = match reader.has(VALUES) {
        true => reader.read_vec::<f64>(VALUES)?.len(),
        false => 1,
    };
    let field = |path: &str| {
        let values = reader.read::<f64>(path)?;
        let components = values.shape().get(1).copied().unwrap_or(1);
        let mut values = values.into_raw_vec_and_offset().0;
        let last = values.len() / steps.max(1);
        values.drain(..values.len() - last);
        Ok(Field {
            path: path.to_owned(),
            components,
            values,
        })
    };
    field_paths(reader).into_iter().map(field).collect()
}

/// Writes the grid of another file.
pub(super) fn copy_grid(writer: &mut GroupWriter<'_>, reader: &Reader) -> Result<(), StoreError> {
    writer.write_ascii_attribute("Type", TYPE)?;
    writer.write_number_attribute("Version", &VERSION)?;
    for path in [N_POINTS, N_CELLS, N_CONNECTIVITY, CONNECTIVITY, OFFSETS] {
        let values = reader.read_vec::<i64>(path)?;
        writer.write(path, &values, &[values.len()])?;
    }
    let points = reader.read_vec::<f64>(POINTS)?;
    writer.write(POINTS, &points, &[points.len() / 3, 3])?;
    let types = reader.read_vec::<u8>(TYPES)?;
    writer.write(TYPES, &types, &[types.len()])
}
