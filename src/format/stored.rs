//! Values as datasets hold them: what stands in the file for a Rust type, and back.

use runfile::{GroupWriter, Kind, Reader, StoreError, StoredEnum};

/// What a dataset is made of: numbers, texts, members of an enumeration.
pub(super) trait Item: Sized {
    /// The type of such datasets.
    const KIND: Kind;

    /// Writes items in row-major order.
    fn write(
        to: &mut GroupWriter<'_>,
        path: &str,
        items: &[Self],
        shape: &[usize],
    ) -> Result<(), StoreError>;

    /// Reads items in row-major order, with their shape; finite numbers alone, where `is_finite`.
    fn read(
        reader: &Reader,
        path: &str,
        is_finite: bool,
    ) -> Result<(Vec<Self>, Vec<usize>), StoreError>;
}

/// A value that a dataset holds, alone or as one of many rows.
pub(super) trait Stored: Clone {
    /// What the dataset is made of.
    type Item: Item;

    /// The extents of one value, of which the lengths of lists are those of an example.
    fn shape(_example: Option<&Self>) -> Vec<usize> {
        Vec::new()
    }

    /// Whether there is nothing to store.
    fn is_absent(&self) -> bool {
        false
    }

    /// Appends the items of one value.
    fn flatten(&self, items: &mut Vec<Self::Item>);

    /// Takes the next value of some extents, whose items are there.
    fn take(items: &mut dyn Iterator<Item = Self::Item>, shape: &[usize]) -> Self;
}

/// What stands in a table for a figure of something that is not there.
pub(super) trait Absent {
    /// The value that says so.
    fn absent() -> Self;
}

/// Numbers: their kind, how they are written, read, and read where only finite ones are allowed.
macro_rules! elements {
    ($($element:ident is $kind:ident: $write:ident, $read:ident, $read_finite:ident);+) => {$(
        impl Item for $element {
            const KIND: Kind = Kind::$kind;

            fn write(to: &mut GroupWriter<'_>, path: &str, items: &[Self], shape: &[usize]) -> Result<(), StoreError> {
                to.$write(path, items, shape)
            }

            fn read(reader: &Reader, path: &str, is_finite: bool) -> Result<(Vec<Self>, Vec<usize>), StoreError> {
                let array = if is_finite { reader.$read_finite(path)? } else { reader.$read(path)? };
                let shape = array.shape().to_vec();
                Ok((array.into_raw_vec_and_offset().0, shape))
            }
        }
    )+};
}

elements! {
    f64 is F64: write, read, read_finite_f64;
    i64 is I64: write, read, read;
    u8 is U8: write, read, read;
    usize is I64: write_indices, read_indices, read_indices
}

impl Item for String {
    const KIND: Kind = Kind::Text;

    fn write(
        to: &mut GroupWriter<'_>,
        path: &str,
        items: &[Self],
        shape: &[usize],
    ) -> Result<(), StoreError> {
        match (items, shape) {
            ([text], []) => to.write_text(path, text),
            _ => {
                let texts: Vec<&str> = items.iter().map(String::as_str).collect();
                to.write_texts(path, &texts)
            }
        }
    }

    fn read(reader: &Reader, path: &str, _: bool) -> Result<(Vec<Self>, Vec<usize>), StoreError> {
        let texts = reader.read_texts(path)?;
        let shape = vec![texts.len()];
        Ok((texts, shape))
    }
}

/// A member of an enumeration in the file.
#[derive(Clone, Copy)]
pub(super) struct Member<E>(pub(super) E);

impl<E: StoredEnum> Item for Member<E> {
    const KIND: Kind = Kind::Enum(E::SPEC);

    fn write(
        to: &mut GroupWriter<'_>,
        path: &str,
        items: &[Self],
        shape: &[usize],
    ) -> Result<(), StoreError> {
        let members: Vec<E> = items.iter().map(|item| item.0).collect();
        to.write_enum(path, &members, shape)
    }

    fn read(reader: &Reader, path: &str, _: bool) -> Result<(Vec<Self>, Vec<usize>), StoreError> {
        let array = reader.read_enum::<E>(path)?;
        let shape = array.shape().to_vec();
        Ok((array.into_iter().map(Self).collect(), shape))
    }
}

/// Single values: the item that stands for each, what an item means, and what stands for none.
macro_rules! scalars {
    ($($value:ty as $item:ty: $to:expr, $from:expr, $absent:expr;)+) => {$(
        impl Stored for $value {
            type Item = $item;

            fn flatten(&self, items: &mut Vec<$item>) {
                let to: fn(Self) -> $item = $to;
                items.push(to(self.clone()));
            }

            fn take(items: &mut dyn Iterator<Item = $item>, _: &[usize]) -> Self {
                let from: fn($item) -> Self = $from;
                from(items.next().expect("as many items as the shape says"))
            }
        }

        impl Absent for $value {
            fn absent() -> Self {
                $absent
            }
        }
    )+};
}

scalars! {
    f64 as f64: |value| value, |item| item, f64::NAN;
    usize as usize: |value| value, |item| item, 0;
    i64 as i64: |value| value, |item| item, -1;
    i8 as i64: i64::from, |sign| sign.signum() as i8, 0;
    u8 as u8: |value| value, |item| item, 0;
    bool as u8: u8::from, |item| item != 0, false;
    String as String: |text| text, |text| text, String::new();
}

impl<V: Stored, const N: usize> Stored for [V; N] {
    type Item = V::Item;

    fn shape(example: Option<&Self>) -> Vec<usize> {
        [vec![N], V::shape(example.and_then(|values| values.first()))].concat()
    }

    fn flatten(&self, items: &mut Vec<V::Item>) {
        self.iter().for_each(|value| value.flatten(items));
    }

    fn take(items: &mut dyn Iterator<Item = V::Item>, shape: &[usize]) -> Self {
        std::array::from_fn(|_| V::take(items, &shape[1..]))
    }
}

impl<V: Absent, const N: usize> Absent for [V; N] {
    fn absent() -> Self {
        std::array::from_fn(|_| V::absent())
    }
}

impl<V: Stored> Stored for Vec<V> {
    type Item = V::Item;

    fn shape(example: Option<&Self>) -> Vec<usize> {
        let values = example.map_or(&[][..], Vec::as_slice);
        [vec![values.len()], V::shape(values.first())].concat()
    }

    fn is_absent(&self) -> bool {
        self.is_empty()
    }

    fn flatten(&self, items: &mut Vec<V::Item>) {
        self.iter().for_each(|value| value.flatten(items));
    }

    fn take(items: &mut dyn Iterator<Item = V::Item>, shape: &[usize]) -> Self {
        (0..shape[0]).map(|_| V::take(items, &shape[1..])).collect()
    }
}

impl<V> Absent for Vec<V> {
    fn absent() -> Self {
        Vec::new()
    }
}

impl<V: Stored> Stored for Option<V> {
    type Item = V::Item;

    fn shape(example: Option<&Self>) -> Vec<usize> {
        V::shape(example.and_then(Option::as_ref))
    }

    fn is_absent(&self) -> bool {
        self.is_none()
    }

    fn flatten(&self, items: &mut Vec<V::Item>) {
        self.iter().for_each(|value| value.flatten(items));
    }

    fn take(items: &mut dyn Iterator<Item = V::Item>, shape: &[usize]) -> Self {
        Some(V::take(items, shape))
    }
}

impl<V> Absent for Option<V> {
    fn absent() -> Self {
        None
    }
}

/// Declares how an enumeration of the mechanics is stored: the name and code of each member.
///
/// Both maps name every member of both, so that a member without a code does not compile; a code
/// without a member is an error of the reader.
macro_rules! stored_as {
    (
        $(#[$meta:meta])*
        $stored:ident of $meaning:ty as $label:literal {
            $($member:ident = $code:literal => $text:literal),+ $(,)?
        }
    ) => {
        runfile::stored_enum! {
            $(#[$meta])*
            pub(in $crate::format) enum $stored as $label {
                $(#[doc = concat!("`", $text, "`.")] $member = $code => $text),+
            }
        }

        impl $crate::format::stored::Stored for $meaning {
            type Item = $crate::format::stored::Member<$stored>;

            fn flatten(&self, items: &mut Vec<Self::Item>) {
                items.push($crate::format::stored::Member(match *self {
                    $(<$meaning>::$member => $stored::$member),+
                }));
            }

            fn take(items: &mut dyn Iterator<Item = Self::Item>, _: &[usize]) -> Self {
                match items.next().expect("as many items as the shape says").0 {
                    $($stored::$member => <$meaning>::$member),+
                }
            }
        }
    };
}

pub(super) use stored_as;
