//! Points as a table.

use super::PointCloud;
use crate::table::{Column, Table, Values};
use glam::DVec3;

/// Returns points with what was measured at each as a table.
pub fn points_table(cloud: &PointCloud) -> Table {
    let coordinates = |names: [&str; 3], meaning: &str, unit: &str, vectors: &[DVec3]| {
        let values = |k: usize| Values::F64(vectors.iter().map(|v| v[k]).collect());
        [0, 1, 2].map(|k| Column::new(names[k], unit, meaning, values(k)))
    };
    let mut columns =
        coordinates(["x", "y", "z"], "place in the world", "m", &cloud.points).to_vec();
    if !cloud.normals.is_empty() {
        columns.extend(coordinates(
            ["nx", "ny", "nz"],
            "normal",
            "",
            &cloud.normals,
        ));
    }
    if !cloud.colours.is_empty() {
        for (k, name) in ["red", "green", "blue"].into_iter().enumerate() {
            let values = Values::U8(cloud.colours.iter().map(|c| c[k]).collect());
            columns.push(Column::new(name, "", "colour, sRGB", values));
        }
    }
    Table {
        columns,
        ..Table::default()
    }
}
