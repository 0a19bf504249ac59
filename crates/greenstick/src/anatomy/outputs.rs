//! The files of a stem's inside on their way out: each gets its metadata and the coordinates that are wanted.

use crate::Error;
use glam::{DAffine3, DVec3};
use greenstick_formats::vtk::{Image, write_image};
use greenstick_formats::{
    DescribedTable, Encoded, Format, LengthUnit, TableFormat, write_csv_metadata, write_table,
};
use greenstick_geometry::{Metadata, Scene, Table};
use greenstick_picture::Picture;
use greenstick_wood::anatomy::ScaledImage;
use greenstick_wood::colour::RgbImage;

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
        table.translate(self.offset);
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
