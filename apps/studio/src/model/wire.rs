//! How what the window knows is written as bytes, for a worker that shares no memory with it: helpers for serde, for types that do not
//! know it themselves, and for lists of plain numbers, which are copied as they lie in memory.

use bytemuck::{AnyBitPattern, NoUninit};
use greenstick::geometry::Pixels;
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Bytes that were read.
struct Bytes;

impl<'de> Visitor<'de> for Bytes {
    type Value = &'de [u8];

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("bytes")
    }

    fn visit_borrowed_bytes<E>(self, bytes: &'de [u8]) -> Result<&'de [u8], E> {
        Ok(bytes)
    }
}

fn plain_list<'de, T: NoUninit + AnyBitPattern, D: Deserializer<'de>>(
    from: D,
) -> Result<Vec<T>, D::Error> {
    let bytes = from.deserialize_bytes(Bytes)?;
    if !bytes.len().is_multiple_of(size_of::<T>()) {
        return Err(D::Error::invalid_length(bytes.len(), &"whole entries"));
    }
    Ok(bytemuck::pod_collect_to_vec(bytes))
}

/// Lists of plain numbers.
pub mod plain {
    use super::*;

    /// Writes one.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn serialize<T: NoUninit, S: Serializer>(list: &[T], to: S) -> Result<S::Ok, S::Error> {
        to.serialize_bytes(bytemuck::cast_slice(list))
    }

    /// Reads one.
    ///
    /// # Errors
    /// Where the bytes are not whole entries.
    pub fn deserialize<'de, T: NoUninit + AnyBitPattern, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Vec<T>, D::Error> {
        plain_list(from)
    }
}

/// Plain numbers in one structure.
pub mod one {
    use super::*;

    /// Writes it.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn serialize<T: NoUninit, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_bytes(bytemuck::bytes_of(value))
    }

    /// Reads it.
    ///
    /// # Errors
    /// Where the bytes are not exactly it.
    pub fn deserialize<'de, T: NoUninit + AnyBitPattern, D: Deserializer<'de>>(
        from: D,
    ) -> Result<T, D::Error> {
        match plain_list(from)?[..] {
            [value] => Ok(value),
            ref other => Err(D::Error::invalid_length(other.len(), &"one entry")),
        }
    }
}

/// What may have been worked out.
pub mod once {
    use super::*;
    use std::sync::OnceLock;

    /// Writes it.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn serialize<T: Serialize, S: Serializer>(
        value: &OnceLock<T>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        value.get().serialize(to)
    }

    /// Reads it.
    ///
    /// # Errors
    /// Those of the reader.
    pub fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<OnceLock<T>, D::Error> {
        let known = Option::<T>::deserialize(from)?;
        Ok(known.map(OnceLock::from).unwrap_or_default())
    }
}

/// What is written through another type that serde knows: how it becomes that and is made of it.
macro_rules! through {
    ($(#[doc = $doc:literal] $name:ident: $own:ty, $other:ty, $to:expr, $from:expr;)*) => {$(
        #[doc = $doc]
        pub mod $name {
            use super::*;

            /// Writes it.
            ///
            /// # Errors
            /// Those of the writer.
            pub fn serialize<S: Serializer>(value: &$own, to: S) -> Result<S::Ok, S::Error> {
                let other: fn(&$own) -> $other = $to;
                other(value).serialize(to)
            }

            /// Reads it.
            ///
            /// # Errors
            /// Those of the reader.
            pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<$own, D::Error> {
                let own: fn($other) -> $own = $from;
                Ok(own(<$other>::deserialize(from)?))
            }
        }
    )*};
}

use glam::{DAffine3, DVec3, Vec3};
use greenstick::wood::stem::StemLocation;
use std::sync::Arc;

through! {
    /// Motions.
    motion: DAffine3, [f64; 12], DAffine3::to_cols_array, |m| DAffine3::from_cols_array(&m);
    /// Points.
    point: DVec3, [f64; 3], DVec3::to_array, DVec3::from_array;
    /// Directions and points of the picture.
    vector: Vec3, [f32; 3], Vec3::to_array, Vec3::from_array;
    /// Two directions.
    vectors: [Vec3; 2], [[f32; 3]; 2], |v| v.map(|v| v.to_array()), |v| v.map(Vec3::from_array);
    /// Lines of points of the picture.
    axis: Arc<Vec<Vec3>>, Vec<[f32; 3]>,
        |line| line.iter().map(|p| p.to_array()).collect(),
        |line| Arc::new(line.into_iter().map(Vec3::from_array).collect());
    /// Places on a stem.
    place: Option<StemLocation>, Option<(u8, [f64; 3])>, |place| place.map(place_numbers), |place| place.map(place_of);
    /// Textures.
    images: Vec<Arc<Pixels>>, Vec<(u32, u32, Vec<u8>)>,
        |all| all.iter().map(|i| (i.width, i.height, i.rgba.clone())).collect(),
        |all| all.into_iter().map(|(width, height, rgba)| Arc::new(Pixels { width, height, rgba })).collect();
}

fn place_numbers(place: StemLocation) -> (u8, [f64; 3]) {
    match place {
        StemLocation::Fraction(x) => (0, [x, 0.0, 0.0]),
        StemLocation::Length(x) => (1, [x, 0.0, 0.0]),
        StemLocation::Point(p) => (2, p.to_array()),
    }
}

fn place_of((kind, numbers): (u8, [f64; 3])) -> StemLocation {
    match kind {
        0 => StemLocation::Fraction(numbers[0]),
        1 => StemLocation::Length(numbers[0]),
        _ => StemLocation::Point(DVec3::from_array(numbers)),
    }
}

/// What leaves fields out of its JSON, which formats without names cannot.
pub mod json {
    use super::*;
    use serde::de::DeserializeOwned;
    use serde::ser::Error as _;

    /// Writes it as JSON.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn serialize<T: Serialize, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
        let text = serde_json::to_string(value).map_err(S::Error::custom)?;
        text.serialize(to)
    }

    /// Reads JSON.
    ///
    /// # Errors
    /// Where it is not that.
    pub fn deserialize<'de, T: DeserializeOwned, D: Deserializer<'de>>(
        from: D,
    ) -> Result<T, D::Error> {
        let text = String::deserialize(from)?;
        serde_json::from_str(&text).map_err(D::Error::custom)
    }
}
