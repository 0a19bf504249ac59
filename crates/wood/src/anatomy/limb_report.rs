//! Limbs that grow from a stem, as numbers of a report and as a table.

use crate::stem::Limb;
use greenstick_geometry::{Column, Table, Values};
use serde::{Deserialize, Serialize};

/// A limb that was left out of the stem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LimbReport {
    /// Where it meets the stem, m along it from the base.
    pub at_m: f64,
    /// The middle of its mouth, where it leaves the stem, m.
    pub mouth_m: [f64; 3],
    /// From its mouth to the middle of its surface (unit vector).
    pub direction: [f64; 3],
    /// Angle between it and the stem, rad.
    pub angle_rad: f64,
    /// Diameter where it is free of the stem all round: of the circle with the area of its section, m.
    pub diameter_m: f64,
    /// How far it reaches from its mouth along its direction, m.
    pub length_m: f64,
    /// Volume, closed flat at its mouth, m³.
    pub volume_m3: f64,
}

impl From<&Limb> for LimbReport {
    fn from(limb: &Limb) -> Self {
        LimbReport {
            at_m: limb.at_m,
            mouth_m: limb.mouth.to_array(),
            direction: limb.direction.to_array(),
            angle_rad: limb.angle,
            diameter_m: limb.diameter_m,
            length_m: limb.length_m,
            volume_m3: limb.volume_m3,
        }
    }
}

/// Limbs as a table, the largest first.
pub fn limb_table(limbs: &[LimbReport]) -> Table {
    let column = |name: &str, unit: &str, meaning: &str, of: &dyn Fn(&LimbReport) -> f64| {
        let values = limbs.iter().map(of).collect();
        Column::new(name, unit, meaning, Values::F64(values))
    };
    let mouth = "middle of the mouth, where it leaves the stem";
    let direction = "from the mouth to the middle of its surface";
    Table {
        columns: vec![
            column("at", "m", "along the stem's axis from its butt", &|l| {
                l.at_m
            }),
            column("mouth_x", "m", mouth, &|l| l.mouth_m[0]),
            column("mouth_y", "m", mouth, &|l| l.mouth_m[1]),
            column("mouth_z", "m", mouth, &|l| l.mouth_m[2]),
            column("direction_x", "", direction, &|l| l.direction[0]),
            column("direction_y", "", direction, &|l| l.direction[1]),
            column("direction_z", "", direction, &|l| l.direction[2]),
            column("angle", "rad", "between it and the stem", &|l| l.angle_rad),
            column(
                "diameter",
                "m",
                "where it is free of the stem all round",
                &|l| l.diameter_m,
            ),
            column("length", "m", "from its mouth along its direction", &|l| {
                l.length_m
            }),
            column("volume", "m3", "closed flat at its mouth", &|l| l.volume_m3),
        ],
        ..Table::default()
    }
}
