//! The files of a stem's inside on their way out: each gets its metadata and the coordinates that are wanted.

use crate::Error;
use glam::{DAffine3, DVec3};
use greenstick_formats::vtk::{Image, write_image};
use greenstick_formats::{
    DescribedTable, Encoded, Format, LengthUnit, TableFormat, write_csv_metadata, write_table,
};
use greenstick_geometry::{Metadata, Scene, Table, Values};
use greenstick_picture::Picture;
use greenstick_wood::anatomy::ScaledImage;
use greenstick_wood::colour::RgbImage;

/// Endings of the names of columns that hold coordinates.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Where files go, and what all of them carry.
pub(super) struct Outputs<'a, E> {
    sink: &'a mut dyn FnMut(Encoded) -> Result<(), E>,
    metadata: Metadata,
    /// What is added to coordinates, m.
    offset: DVec3,
    /// The CSV files so far.
    tables: Vec<DescribedTable>,
}

impl<'a, E: From<Error>> Outputs<'a, E> {
    pub fn new(
        sink: &'a mut dyn FnMut(Encoded) -> Result<(), E>,
        metadata: Metadata,
        offset: DVec3,
    ) -> Self {
        Outputs {
            sink,
            metadata,
            offset,
            tables: Vec::new(),
        }
    }

    /// What all files carry.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// What is added to coordinates, m.
    pub fn offset(&self) -> DVec3 {
        self.offset
    }

    /// Adds a file as it is.
    pub fn add(&mut self, file: Encoded) -> Result<(), E> {
        (self.sink)(file)
    }

    /// Adds a table as `stem` with the ending of a format.
    pub fn table(&mut self, mut table: Table, stem: &str, format: TableFormat) -> Result<(), E> {
        shift_table(&mut table, self.offset);
        table.metadata = self.metadata.clone();
        let name = format!("{stem}.{}", format.extension());
        if format == TableFormat::Csv {
            self.tables.push(DescribedTable::new(&table, &name));
        }
        self.add(write_table(format, &table, &name).map_err(Error::from)?)
    }

    /// Adds a picture with a scale bar below it.
    pub fn picture(&mut self, scaled: ScaledImage, name: String) -> Result<(), E> {
        let RgbImage { width, height, rgb } = scaled.image;
        let mut picture = Picture { width, height, rgb };
        picture.add_scale_bar(scaled.pixel);
        let Picture { width, height, rgb } = picture;
        let bytes = RgbImage { width, height, rgb }.png_with(&self.metadata);
        self.add(Encoded::new(name, bytes))
    }

    /// Adds a volume.
    pub fn volume(&mut self, mut image: Image, name: &str) -> Result<(), E> {
        image.origin += self.offset;
        image.metadata = self.metadata.clone();
        self.add(write_image(&image, name).map_err(Error::from)?)
    }

    /// Adds a scene as GLB.
    pub fn scene(&mut self, mut scene: Scene, name: &str) -> Result<(), E> {
        for node in &mut scene.nodes {
            node.transform = DAffine3::from_translation(self.offset) * node.transform;
        }
        scene.metadata = self.metadata.clone();
        let files = greenstick_formats::write(Format::Glb, &scene, name, LengthUnit::Metre);
        let files = files.map_err(Error::from)?;
        files.into_iter().try_for_each(|file| self.add(file))
    }

    /// Adds the metadata of the tables.
    pub fn finish(mut self) -> Result<(), E> {
        if self.tables.is_empty() {
            return Ok(());
        }
        let file = write_csv_metadata(&self.tables, &self.metadata);
        self.add(file)
    }
}

/// Adds an offset to the coordinates of a table: its columns `x`, `y` and `z`, and those that end in `_x`, `_y` and `_z`.
fn shift_table(table: &mut Table, offset: DVec3) {
    if offset == DVec3::ZERO {
        return;
    }
    for column in &mut table.columns {
        let axis = column.name.rsplit('_').next().unwrap_or_default();
        let place = AXES.iter().position(|a| *a == axis);
        if let (Some(k), "m", Values::F64(values)) =
            (place, column.unit.as_str(), &mut column.values)
        {
            values.iter_mut().for_each(|v| *v += offset[k]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick_geometry::Column;

    #[test]
    fn places_are_shifted_and_nothing_else() {
        let column = |name: &str, unit: &str| Column::new(name, unit, "", Values::F64(vec![1.0]));
        let mut table = Table {
            columns: vec![
                column("x", "m"),
                column("pith_y", "m"),
                column("direction_z", ""),
                column("length", "m"),
            ],
            ..Table::default()
        };
        shift_table(&mut table, DVec3::new(10.0, 20.0, 30.0));
        let values: Vec<&Values> = table.columns.iter().map(|c| &c.values).collect();
        let expected = [11.0, 21.0, 1.0, 1.0].map(|x| Values::F64(vec![x]));
        assert_eq!(values, expected.iter().collect::<Vec<_>>());
    }
}
