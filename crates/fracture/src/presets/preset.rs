//! A preset as a value.

use crate::parameters::CrackKind;
use serde::Serialize;

/// A named set of parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Preset {
    /// Name by which recipes and users refer to it.
    pub name: &'static str,
    /// One line on what it gives.
    pub summary: &'static str,
    #[serde(skip)]
    pub(super) settings: Settings,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Settings {
    /// A column of [`TABLE_2`], the rows in `unset` at 0.
    Column {
        column: usize,
        unset: &'static [&'static [&'static str]],
    },
    /// A face of Fig. 14: amplitude λ and frequency β of its Perlin noise.
    Roughness { lambda: f64, beta: f64 },
    /// Settings of the broken face, over the defaults.
    Break(&'static [(&'static str, &'static str)]),
    /// Settings of the crack groups, then single cracks: kind and settings.
    Cracks(
        &'static [(&'static str, &'static str)],
        &'static [SingleCrack],
    ),
}

pub(super) type SingleCrack = (CrackKind, &'static [(&'static str, f64)]);
