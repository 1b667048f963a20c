//! Symbolic sizes and the values the file gives them.

use std::collections::BTreeMap;

use super::layout::{DatasetSpec, Extent};

#[derive(Clone, Copy, Debug)]
struct Binding {
    size: usize,
    source: &'static str,
}

/// The values of the symbolic sizes, each with the dataset that fixed it.
#[derive(Clone, Debug, Default)]
pub(super) struct Sizes(BTreeMap<&'static str, Binding>);

/// A shape that the table, or an earlier dataset, does not allow.
#[derive(Clone, Debug)]
pub(super) struct ShapeConflict {
    pub(super) expected: String,
    pub(super) found: String,
}

impl Sizes {
    /// Checks a shape and remembers the sizes it fixes for the first time; a conflict leaves the
    /// sizes as they were.
    pub(super) fn bind(
        &mut self,
        spec: &'static DatasetSpec,
        shape: &[usize],
    ) -> Result<(), ShapeConflict> {
        let known = self.clone();
        for (extent, &size) in spec.shape.iter().zip(shape) {
            let fixed = match *extent {
                Extent::Fixed(_) | Extent::Labelled(_) => None,
                Extent::Named(name) => Some((name, size)),
                Extent::Plus(name, more) => size.checked_sub(more).map(|size| (name, size)),
            };
            if let Some((name, size)) = fixed {
                self.0.entry(name).or_insert(Binding {
                    size,
                    source: spec.path,
                });
            }
        }
        if self.check(spec, shape).is_err() {
            *self = known;
        }
        self.check(spec, shape)
    }

    /// Checks a shape against the table and the sizes known so far.
    pub(super) fn check(&self, spec: &DatasetSpec, shape: &[usize]) -> Result<(), ShapeConflict> {
        let fits = shape.len() == spec.shape.len()
            && spec
                .shape
                .iter()
                .zip(shape)
                .all(|(extent, &size)| match *extent {
                    Extent::Fixed(fixed) => size == fixed,
                    Extent::Labelled(axis) => size == axis.labels.len(),
                    Extent::Named(name) => self.0.get(name).is_none_or(|bound| bound.size == size),
                    Extent::Plus(name, more) => match self.0.get(name) {
                        Some(bound) => bound.size.checked_add(more) == Some(size),
                        None => size >= more,
                    },
                });
        if fits {
            return Ok(());
        }
        let expected: Vec<_> = spec
            .shape
            .iter()
            .map(|extent| self.explain(*extent))
            .collect();
        Err(ShapeConflict {
            expected: format!("shape [{}]", expected.join(", ")),
            found: format!("shape {shape:?}"),
        })
    }

    /// Takes over the sizes that are not known yet.
    pub(super) fn adopt(&mut self, others: Sizes) {
        for (name, binding) in others.0 {
            self.0.entry(name).or_insert(binding);
        }
    }

    fn explain(&self, extent: Extent) -> String {
        match extent.name().and_then(|name| self.0.get_key_value(name)) {
            Some((name, bound)) => {
                format!("{extent} where {name} = {} by {}", bound.size, bound.source)
            }
            None => extent.to_string(),
        }
    }
}
