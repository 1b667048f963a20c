//! Symbolic sizes and the values the file gives them.

use std::collections::BTreeMap;

use crate::layout::{DatasetSpec, Extent};

#[derive(Clone, Copy, Debug)]
struct Binding {
    size: usize,
    source: &'static str,
}

/// The values of the symbolic sizes, each with the dataset that fixed it.
#[derive(Clone, Debug, Default)]
pub(super) struct Sizes(BTreeMap<&'static str, Binding>);

impl Sizes {
    /// Checks a shape and remembers the sizes it fixes for the first time; a conflict leaves the
    /// sizes as they were. It says what is expected, and what is found.
    pub(super) fn bind(
        &mut self,
        spec: &'static DatasetSpec,
        shape: &[usize],
    ) -> Result<(), (String, String)> {
        if shape.len() != spec.shape.len() {
            return self.check(spec, shape);
        }
        let known = self.clone();
        for (extent, &size) in spec.shape.iter().zip(shape) {
            let named = extent.named();
            let fixed = named.and_then(|(name, more)| Some((name, size.checked_sub(more)?)));
            if let Some((name, size)) = fixed {
                self.0.entry(name).or_insert(Binding {
                    size,
                    source: spec.path,
                });
            }
        }
        let checked = self.check(spec, shape);
        if checked.is_err() {
            *self = known;
        }
        checked
    }

    /// Checks a shape against the table and the sizes known so far.
    pub(super) fn check(
        &self,
        spec: &DatasetSpec,
        shape: &[usize],
    ) -> Result<(), (String, String)> {
        let fits = |(extent, &size): (&Extent, &usize)| match *extent {
            Extent::Fixed(fixed) => size == fixed,
            Extent::Labelled(axis) => size == axis.labels.len(),
            Extent::Named(name) | Extent::Plus(name, _) => {
                let more = extent.named().map_or(0, |(_, more)| more);
                let known = self.0.get(name);
                known.map_or(size >= more, |bound| {
                    bound.size.checked_add(more) == Some(size)
                })
            }
        };
        let fits = shape.len() == spec.shape.len() && spec.shape.iter().zip(shape).all(fits);
        if fits {
            return Ok(());
        }
        let expected: Vec<_> = spec
            .shape
            .iter()
            .map(|extent| self.explain(*extent))
            .collect();
        Err((
            format!("shape [{}]", expected.join(", ")),
            format!("shape {shape:?}"),
        ))
    }

    /// Takes over the sizes that are not known yet.
    pub(super) fn adopt(&mut self, others: Sizes) {
        for (name, binding) in others.0 {
            self.0.entry(name).or_insert(binding);
        }
    }

    fn explain(&self, extent: Extent) -> String {
        match extent.named().and_then(|it| self.0.get_key_value(it.0)) {
            Some((name, bound)) => {
                format!("{extent} where {name} = {} by {}", bound.size, bound.source)
            }
            None => extent.to_string(),
        }
    }
}
