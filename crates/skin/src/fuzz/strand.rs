//! One strand of fuzz, and the mesh of many.

use super::options::FuzzOptions;
use glam::{DVec2, DVec3};
use greenstick_geometry::{Attribute, Mesh};
use greenstick_wood::tissue::Zone;

/// Parts of a strand's length at which it has a cross section, and its width there: it swells out of the wood and tapers off. A
/// short one bends too little to need as many.
const SECTIONS: [(f64, f64); 3] = [(0.0, 0.75), (0.42, 1.0), (0.76, 0.65)];
const SECTIONS_OF_SHORT: [(f64, f64); 2] = [(0.0, 0.8), (0.55, 1.0)];
/// The same of a sliver, which is as wide as it was torn off over most of its length, and of stubs: one that ends in a point, one that
/// ends blunt, and one with a kink.
const SECTIONS_OF_SLIVER: [(f64, f64); 4] = [(0.0, 0.9), (0.3, 1.0), (0.58, 0.9), (0.84, 0.62)];
const SECTIONS_OF_SPIKE: [(f64, f64); 1] = [(0.0, 1.0)];
const SECTIONS_OF_CHISEL: [(f64, f64); 2] = [(0.0, 1.0), (1.0, 0.8)];
const SECTIONS_OF_STRAP: [(f64, f64); 4] = [(0.0, 0.9), (0.33, 1.0), (0.68, 0.95), (1.0, 0.65)];
const SECTIONS_OF_KINKED: [(f64, f64); 2] = [(0.0, 1.0), (0.5, 0.9)];
/// Widths below which a strand is short.
const SHORT: f64 = 16.0;
/// Difference of parts of a length by which the direction at one of them is told.
const NEARBY: f64 = 0.02;
/// Corners of a cross section.
const SIDES: usize = 3;
/// How much of its own roundness the normal of a strand has beside that of the face that it lies on. Fibres let light through and
/// are thinner than a pixel: lit as solid bodies they would be dark lines.
const ROUNDNESS: f64 = 0.45;
/// How much of the direction of the grain the normal of a stub has beside its own.
const UPRIGHT: f64 = 0.5;
/// Depth of a strand's beginning within the wood, in thicknesses.
const DEPTH: f64 = 1.2;

/// Where a strand begins.
pub(super) struct Root {
    /// On the face.
    pub position: DVec3,
    /// Its grain coordinates, m.
    pub grain: DVec3,
    /// Unit directions: beside the strand in the face, out of the face, along the strand.
    pub directions: [DVec3; 3],
    /// The first two of them in the section.
    pub across: [DVec2; 2],
    /// Code of its tissue.
    pub zone: f32,
    /// Its sector.
    pub sector: f32,
}

/// What a strand is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StrandKind {
    /// A few fibres.
    Hair,
    /// A lath that came half off its splinter.
    Sliver,
    /// A strap of inner or outer bark that hangs on at the torn edge of the bark, with a ragged end.
    Strap,
    /// The short end of a bundle that broke across, pointed, blunt or kinked.
    Spike,
    Chisel,
    Kinked,
}

impl StrandKind {
    /// Whether it is the end of a bundle that broke across.
    fn is_stub(self) -> bool {
        matches!(self, Self::Spike | Self::Chisel | Self::Kinked)
    }

    /// Whether it ends in a ragged edge rather than in a point.
    fn is_blunt(self) -> bool {
        matches!(self, Self::Strap | Self::Chisel)
    }
}

/// A kink: fibres that were bent too far fold in one place and are straight beyond it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Kink {
    /// Part of the length at which it is.
    pub at: f64,
    /// Angle, rad.
    pub angle: f64,
    /// Direction that it turns to, rad: 0 out of the face, a right angle to the side.
    pub toward: f64,
}

/// A strand. Lengths are m.
pub(super) struct Strand {
    pub kind: StrandKind,
    pub root: Root,
    /// Distance of its root beside the place that it begins at, and depth of it along the grain.
    pub beside: f64,
    pub sunk: f64,
    pub kink: Kink,
    /// 1 where it points along the grain, −1 where it points back.
    pub forward: f64,
    pub length: f64,
    pub width: f64,
    pub thickness: f64,
    /// Turn of its width out of the face, rad.
    pub roll: f64,
    /// Slope at which it leaves the face, and how much that grows and turns aside to its end.
    pub lift: f64,
    pub curl: f64,
    pub sway: f64,
    /// Parts of the length at which the corners of a blunt end lie.
    pub ends: [f64; SIDES],
    /// Ring coordinate of its wood.
    pub ring: f64,
}

impl Strand {
    fn sections(&self) -> &'static [(f64, f64)] {
        match self.kind {
            StrandKind::Hair if self.length < SHORT * self.width => &SECTIONS_OF_SHORT,
            StrandKind::Hair => &SECTIONS,
            StrandKind::Sliver => &SECTIONS_OF_SLIVER,
            StrandKind::Strap => &SECTIONS_OF_STRAP,
            StrandKind::Spike => &SECTIONS_OF_SPIKE,
            StrandKind::Chisel => &SECTIONS_OF_CHISEL,
            StrandKind::Kinked => &SECTIONS_OF_KINKED,
        }
    }

    /// Number of its triangles.
    pub fn triangles(&self) -> usize {
        let end = if self.kind.is_blunt() { 1 } else { SIDES };
        2 * SIDES * (self.sections().len() - 1) + end + 1
    }

    /// How far the strand lies beside its root, out of it and along the grain from it at a part of its length, m.
    pub fn offset(&self, part: f64) -> DVec3 {
        let depth = DEPTH * self.thickness * (1.0 - part);
        let mut at = DVec3::new(
            self.beside + self.length * self.sway * part * part,
            self.length * (self.lift * part + self.curl * part * part) - depth,
            self.length * part - self.sunk,
        );
        let beyond = self.length * (part - self.kink.at).max(0.0);
        if self.kink.angle != 0.0 && beyond > 0.0 {
            let (sin, cos) = libm::sincos(self.kink.angle);
            let (aside, out) = libm::sincos(self.kink.toward);
            at += DVec3::new(aside * sin, out * sin, cos - 1.0) * beyond;
        }
        at
    }

    /// Unit direction of the strand at a part of its length, in the coordinates of [`Strand::offset`].
    fn direction(&self, part: f64) -> DVec3 {
        (self.offset(part + NEARBY) - self.offset(part - NEARBY)).normalize_or(DVec3::Z)
    }
}

/// A flat bundle of fibres of any curve, in the coordinates of the piece.
pub(super) struct Ribbon {
    /// Ring coordinate of its wood, and its tissue.
    pub ring: f64,
    pub zone: Zone,
    pub sections: Vec<RibbonSection>,
}

impl Ribbon {
    /// Number of its triangles.
    pub fn triangles(&self) -> usize {
        8 * (self.sections.len() - 1) + 4
    }
}

/// A section of a ribbon.
pub(super) struct RibbonSection {
    pub place: DVec3,
    /// Half its width and half its thickness.
    pub flat: DVec3,
    pub ridge: DVec3,
    /// Grain coordinates of its wood, m.
    pub grain: DVec3,
}

/// A vertex of a strand, in the coordinates of the piece.
pub(super) struct StrandVertex {
    pub position: DVec3,
    pub normal: DVec3,
    pub coordinates: [f32; 2],
    /// Ring coordinate, sector, tissue and grain coordinates (m) of its wood.
    pub ring: f64,
    pub sector: f32,
    pub zone: f32,
    pub grain: DVec3,
}

/// The mesh of all strands of a piece.
pub(super) struct StrandMesh<'a> {
    options: &'a FuzzOptions<'a>,
    mesh: Mesh,
    materials: Vec<u32>,
    normals: Vec<f32>,
    coordinates: Vec<f32>,
    rings: Vec<f32>,
    sectors: Vec<f32>,
    zones: Vec<f32>,
    grain: Vec<f32>,
}

impl<'a> StrandMesh<'a> {
    pub fn new(options: &'a FuzzOptions<'a>) -> Self {
        StrandMesh {
            options,
            mesh: Mesh::default(),
            materials: Vec::new(),
            normals: Vec::new(),
            coordinates: Vec::new(),
            rings: Vec::new(),
            sectors: Vec::new(),
            zones: Vec::new(),
            grain: Vec::new(),
        }
    }

    /// What fuzz is made of.
    pub fn options(&self) -> &'a FuzzOptions<'a> {
        self.options
    }

    /// Triangles so far.
    pub fn triangles(&self) -> usize {
        self.mesh.triangles.len()
    }

    /// Vertices so far.
    pub fn vertices(&self) -> u32 {
        self.mesh.positions.len() as u32
    }

    /// Adds a triangle of a material.
    pub fn triangle(&mut self, corners: [u32; 3], material: u32) {
        self.mesh.triangles.push(corners);
        self.materials.push(material);
    }

    /// Adds a vertex.
    pub fn push(&mut self, vertex: StrandVertex) {
        // Files have this precision.
        let position = vertex.position.as_vec3().as_dvec3();
        self.mesh.positions.push(position);
        self.normals.extend(vertex.normal.as_vec3().to_array());
        self.coordinates.extend(vertex.coordinates);
        self.grain.extend(vertex.grain.as_vec3().to_array());
        self.rings.push(vertex.ring.min(1.0) as f32);
        self.sectors.push(vertex.sector);
        self.zones.push(vertex.zone);
    }

    /// Adds a strand: a closed blade of three sides.
    pub fn add(&mut self, strand: &Strand) {
        let first = self.mesh.positions.len() as u32;
        let [beside, out, along] = strand.root.directions;
        let (sin, cos) = libm::sincos(strand.roll);
        let lit = |normal: DVec3| match strand.kind.is_stub() {
            true => (normal + along * UPRIGHT).normalize(),
            false => (out + normal * ROUNDNESS).normalize(),
        };
        let (flat, ridge) = (beside * cos + out * sin, out * cos - beside * sin);
        let sections = strand.sections();
        let blunt = strand.kind.is_blunt();
        for (number, &(part, swell)) in sections.iter().enumerate() {
            let ends = match blunt && number + 1 == sections.len() {
                true => strand.ends,
                false => [part; SIDES],
            };
            let way = strand.direction(part);
            let tangent = (beside * way.x + out * way.y + along * way.z).normalize();
            let across = |d: DVec3| (d - tangent * d.dot(tangent)).normalize();
            let (flat, ridge) = (across(flat), across(ridge));
            let (half, thick) = (0.5 * strand.width * swell, strand.thickness * swell);
            for (part, (offset, normal)) in ends.into_iter().zip([
                (-flat * half, (ridge * 0.5 - flat).normalize()),
                (flat * half, (ridge * 0.5 + flat).normalize()),
                (ridge * thick, ridge),
            ]) {
                self.vertex(strand, part, offset, lit(normal));
            }
        }
        if !blunt {
            self.vertex(strand, 1.0, DVec3::ZERO, lit(out));
        }
        let corner = |section: usize, side: usize| first + (SIDES * section + side % SIDES) as u32;
        // Sides run to the left or to the right by whether the strand's own directions are right-handed.
        let turned = beside.cross(out).dot(along) < 0.0;
        let mut add = |[a, b, c]: [u32; 3]| {
            self.mesh
                .triangles
                .push(if turned { [a, c, b] } else { [a, b, c] });
        };
        add([corner(0, 0), corner(0, 2), corner(0, 1)]);
        let last = sections.len() - 1;
        let tip = first + (SIDES * sections.len()) as u32;
        for side in 0..SIDES {
            for section in 0..last {
                let [a, b] = [corner(section, side), corner(section, side + 1)];
                let [c, d] = [corner(section + 1, side), corner(section + 1, side + 1)];
                add([a, b, d]);
                add([a, d, c]);
            }
            if !blunt {
                add([corner(last, side), corner(last, side + 1), tip]);
            }
        }
        if blunt {
            add([corner(last, 0), corner(last, 1), corner(last, 2)]);
        }
        self.complete_materials();
    }

    /// Gives the triangles that were added last the material of the wood inside.
    fn complete_materials(&mut self) {
        let count = self.mesh.triangles.len();
        self.materials.resize(count, self.options.material);
    }

    /// Adds a ribbon: a closed strip of four sides, whose edges are sharp and whose broad sides are rounded in the light.
    pub fn add_ribbon(&mut self, ribbon: &Ribbon) {
        let first = self.mesh.positions.len() as u32;
        for section in &ribbon.sections {
            let (flat, ridge) = (section.flat, section.ridge);
            for (f, r) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let normal =
                    ridge.normalize_or_zero() * r + flat.normalize_or_zero() * (f * ROUNDNESS);
                let texture = (self.options.square).side_grain(ribbon.ring, 0.0, section.grain.z);
                self.push(StrandVertex {
                    position: section.place + flat * f + ridge * r,
                    normal: normal.normalize_or_zero(),
                    coordinates: texture.as_vec2().to_array(),
                    ring: ribbon.ring,
                    sector: 0.0,
                    zone: f32::from(ribbon.zone.code()),
                    grain: section.grain,
                });
            }
        }
        let corner = |section: usize, side: usize| first + (4 * section + side % 4) as u32;
        let last = ribbon.sections.len() - 1;
        let triangles = &mut self.mesh.triangles;
        triangles.extend([[0, 2, 1], [0, 3, 2]].map(|t: [usize; 3]| t.map(|side| corner(0, side))));
        triangles
            .extend([[0, 1, 2], [0, 2, 3]].map(|t: [usize; 3]| t.map(|side| corner(last, side))));
        for section in 0..last {
            for side in 0..4 {
                let [a, b] = [corner(section, side), corner(section, side + 1)];
                let [c, d] = [corner(section + 1, side), corner(section + 1, side + 1)];
                triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
        self.complete_materials();
    }

    /// Adds a vertex at a part of a strand's length, off its middle by `offset` (m).
    fn vertex(&mut self, strand: &Strand, part: f64, offset: DVec3, normal: DVec3) {
        let Root {
            position,
            grain,
            directions: [beside, out, along],
            across,
            ..
        } = strand.root;
        let at = strand.offset(part);
        let moved = along * at.z + beside * at.x + out * at.y + offset;
        // The wood that it was peeled off.
        let length = grain.z + strand.forward * strand.length * part;
        let texture = (self.options.square).side_grain(strand.ring, 0.0, length);
        let off = across[0] * offset.dot(beside) + across[1] * offset.dot(out);
        self.push(StrandVertex {
            position: position + moved * self.options.units_per_metre,
            normal,
            coordinates: texture.as_vec2().to_array(),
            ring: strand.ring,
            sector: strand.root.sector,
            zone: strand.root.zone,
            grain: (grain.truncate() + off).extend(length),
        });
    }

    /// The mesh with its attributes.
    pub fn finish(mut self) -> Mesh {
        self.mesh.materials = self.materials;
        for (name, width, data) in [
            ("NORMAL", 3, self.normals),
            ("TEXCOORD_0", 2, self.coordinates),
            ("_RING", 1, self.rings),
            ("_SECTOR", 1, self.sectors),
            ("_ZONE", 1, self.zones),
            ("_GRAIN", 3, self.grain),
        ] {
            self.mesh
                .attributes
                .insert(name.to_owned(), Attribute { width, data });
        }
        self.mesh
    }
}
