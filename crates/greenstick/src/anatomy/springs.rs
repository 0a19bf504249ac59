//! The spring network of the particles as files.

use super::outputs::Outputs;
use crate::Error;
use glam::DVec3;
use greenstick_formats::TableFormat;
use greenstick_formats::vtk::{Field, Polylines, write_lines};
use greenstick_geometry::{Context, Values};
use greenstick_wood::anatomy::{Particle, ParticleLayers, Spring};

/// `springs.vtp`, a line of two points for each spring, and the same as tables.
pub(super) fn write<E: From<Error>>(
    layers: &ParticleLayers,
    context: &Context,
    outputs: &mut Outputs<E>,
) -> Result<(), E> {
    context.report(0.0).map_err(Error::from)?;
    let springs = layers.springs();
    context.report(0.3).map_err(Error::from)?;
    add_lines(layers, &springs, outputs)?;
    context.report(0.6).map_err(Error::from)?;
    let table = ParticleLayers::spring_table(&springs);
    // The other formats are those of points.
    let has_no_points = |f: &&TableFormat| !matches!(f, TableFormat::Ply | TableFormat::Vtp);
    for &format in TableFormat::ALL.iter().filter(has_no_points) {
        context.check().map_err(Error::from)?;
        outputs.table(table.clone(), "springs", format)?;
    }
    Ok(())
}

/// Adds springs as lines between particles.
fn add_lines<E: From<Error>>(
    layers: &ParticleLayers,
    springs: &[Spring],
    outputs: &mut Outputs<E>,
) -> Result<(), E> {
    let positions = layers.particles().map(|p| p.position + outputs.offset());
    let points: Vec<DVec3> = positions.collect();
    let corners: Vec<u32> = springs.iter().flat_map(|s| s.particles).collect();
    let ends: Vec<u32> = (1..=springs.len() as u32).map(|k| 2 * k).collect();
    let of_particles = |name, value: &dyn Fn(&Particle) -> u32| {
        Field::scalar(name, Values::U32(layers.particles().map(value).collect()))
    };
    let bytes = |name, value: &dyn Fn(&Spring) -> u8| {
        Field::scalar(name, Values::U8(springs.iter().map(value).collect()))
    };
    let lengths = springs.iter().map(|s| s.rest_length).collect();
    let network = Polylines {
        points: &points,
        corners: &corners,
        ends: &ends,
        point_data: &[
            of_particles("ring", &|p| p.ring.into()),
            of_particles("sector", &|p| p.sector),
            of_particles("layer", &|p| p.layer),
        ],
        line_data: &[
            Field::scalar("rest_length_m", Values::F64(lengths)),
            bytes("direction", &|s| s.direction as u8),
            bytes("zone", &|s| s.tissue.code()),
        ],
        metadata: Some(outputs.metadata()),
    };
    let file = write_lines(&network, "springs.vtp").map_err(Error::from)?;
    outputs.add(file)
}
