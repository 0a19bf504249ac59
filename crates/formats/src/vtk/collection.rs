//! Lists of files: multi-block data sets and time series.

use super::appended::{escape, file_start};
use crate::companions::Encoded;

/// A block of a multi-block data set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// Name of the block.
    pub name: String,
    /// Path of its file.
    pub file: String,
}

/// Writes a `.vtm` file with a multi-block data set.
///
/// ```
/// use greenstick_formats::vtk::{Block, write_multiblock};
///
/// let block = |name: &str| Block { name: name.to_owned(), file: format!("{name}.vti") };
/// let file = write_multiblock(&[block("trunk"), block("limb")], "tree.vtm");
/// assert!(String::from_utf8_lossy(&file.bytes).contains("name=\"limb\" file=\"limb.vti\""));
/// ```
pub fn write_multiblock(blocks: &[Block], name: &str) -> Encoded {
    let mut text = file_start("vtkMultiBlockDataSet", "1.0");
    text += "  <vtkMultiBlockDataSet>\n";
    for (i, block) in blocks.iter().enumerate() {
        text += &format!(
            "    <DataSet index=\"{i}\" name=\"{}\" file=\"{}\"/>\n",
            escape(&block.name),
            escape(&block.file)
        );
    }
    text += "  </vtkMultiBlockDataSet>\n</VTKFile>\n";
    Encoded {
        name: name.to_owned(),
        bytes: text.into_bytes(),
    }
}

/// A file of a time series.
#[derive(Debug, Clone, PartialEq)]
pub struct TimedFile {
    /// Time, s.
    pub time: f64,
    /// Path of the file.
    pub file: String,
}

/// Writes the text of a `.pvd` file with a time series. Consecutive files with the same time are parts of one data set, such
/// as rods and bonds.
pub fn collection(files: &[TimedFile]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  <Collection>\n",
    );
    let mut part = 0;
    for (k, TimedFile { time, file }) in files.iter().enumerate() {
        let same_time = k > 0 && files[k - 1].time == *time;
        part = if same_time { part + 1 } else { 0 };
        text += &format!(
            "    <DataSet timestep=\"{time}\" group=\"\" part=\"{part}\" file=\"{}\"/>\n",
            escape(file)
        );
    }
    text + "  </Collection>\n</VTKFile>\n"
}
