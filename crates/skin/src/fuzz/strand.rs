//! One strand of fuzz, and the mesh of many.

use super::options::FuzzOptions;
use glam::DVec3;
use greenstick_geometry::{Attribute, Mesh};
use greenstick_wood::tissue::Zone;

/// Parts of a strand's length at which it has a cross section, and its width there: it swells out of the wood and tapers off. A
/// short one bends too little to need as many.
const SECTIONS: [(f64, f64); 3] = [(0.0, 0.75), (0.42, 1.0), (0.76, 0.65)];
const SECTIONS_OF_SHORT: [(f64, f64); 2] = [(0.0, 0.8), (0.55, 1.0)];
/// Widths below which a strand is short.
const SHORT: f64 = 16.0;
/// Corners of a cross section.
const SIDES: usize = 3;
/// How much of its own roundness the normal of a strand has beside that of the face that it lies on. Fibres let light through and
/// are thinner than a pixel: lit as solid bodies they would be dark lines.
const ROUNDNESS: f64 = 0.45;
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
    /// Code of its tissue.
    pub zone: f32,
    /// Its sector.
    pub sector: f32,
}

/// A strand. Lengths are m.
pub(super) struct Strand {
    pub root: Root,
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
    /// Ring coordinate of its wood.
    pub ring: f64,
}

impl Strand {
    fn sections(&self) -> &'static [(f64, f64)] {
        match self.length < SHORT * self.width {
            true => &SECTIONS_OF_SHORT,
            false => &SECTIONS,
        }
    }

    /// Number of its triangles.
    pub fn triangles(&self) -> usize {
        2 * SIDES * (self.sections().len() - 1) + SIDES + 1
    }

    /// How far the strand lies beside and out of its root at a part of its length, m.
    pub fn offset(&self, part: f64) -> [f64; 2] {
        [
            self.length * self.sway * part * part,
            self.length * (self.lift * part + self.curl * part * part)
                - DEPTH * self.thickness * (1.0 - part),
        ]
    }

    /// Slopes of [`Strand::offset`] over the length.
    fn slopes(&self, part: f64) -> [f64; 2] {
        [
            2.0 * self.sway * part,
            self.lift + 2.0 * self.curl * part + DEPTH * self.thickness / self.length,
        ]
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

/// The mesh of all strands of a piece.
pub(super) struct StrandMesh<'a> {
    options: &'a FuzzOptions<'a>,
    mesh: Mesh,
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
            normals: Vec::new(),
            coordinates: Vec::new(),
            rings: Vec::new(),
            sectors: Vec::new(),
            zones: Vec::new(),
            grain: Vec::new(),
        }
    }

    /// Triangles so far.
    pub fn triangles(&self) -> usize {
        self.mesh.triangles.len()
    }

    /// Adds a strand: a closed blade of three sides.
    pub fn add(&mut self, strand: &Strand) {
        let first = self.mesh.positions.len() as u32;
        let [beside, out, along] = strand.root.directions;
        let (sin, cos) = libm::sincos(strand.roll);
        let lit = |normal: DVec3| (out + normal * ROUNDNESS).normalize();
        let (flat, ridge) = (beside * cos + out * sin, out * cos - beside * sin);
        let sections = strand.sections();
        for &(part, swell) in sections {
            let [b, o] = strand.slopes(part);
            let tangent = (along + beside * b + out * o).normalize();
            let across = |d: DVec3| (d - tangent * d.dot(tangent)).normalize();
            let (flat, ridge) = (across(flat), across(ridge));
            let (half, thick) = (0.5 * strand.width * swell, strand.thickness * swell);
            for (offset, normal) in [
                (-flat * half, (ridge * 0.5 - flat).normalize()),
                (flat * half, (ridge * 0.5 + flat).normalize()),
                (ridge * thick, ridge),
            ] {
                self.vertex(strand, part, offset, lit(normal));
            }
        }
        self.vertex(strand, 1.0, DVec3::ZERO, out);
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
            add([corner(last, side), corner(last, side + 1), tip]);
        }
    }

    /// Adds a ribbon: a closed strip of four sides, whose edges are sharp and whose broad sides are rounded in the light.
    pub fn add_ribbon(&mut self, ribbon: &Ribbon) {
        let first = self.mesh.positions.len() as u32;
        for section in &ribbon.sections {
            let (flat, ridge) = (section.flat, section.ridge);
            for (f, r) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let at = (section.place + flat * f + ridge * r).as_vec3();
                self.mesh.positions.push(at.as_dvec3());
                let normal =
                    ridge.normalize_or_zero() * r + flat.normalize_or_zero() * (f * ROUNDNESS);
                self.normals
                    .extend(normal.normalize_or_zero().as_vec3().to_array());
                let texture = (self.options.square).side_grain(ribbon.ring, 0.0, section.grain.z);
                self.coordinates.extend(texture.as_vec2().to_array());
                self.grain.extend(section.grain.as_vec3().to_array());
                self.rings.push(ribbon.ring.min(1.0) as f32);
                self.sectors.push(0.0);
                self.zones.push(f32::from(ribbon.zone.code()));
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
    }

    /// Adds a vertex at a part of a strand's length, off its middle by `offset` (m).
    fn vertex(&mut self, strand: &Strand, part: f64, offset: DVec3, normal: DVec3) {
        let Root {
            position,
            grain,
            directions: [beside, out, along],
            ..
        } = strand.root;
        let [b, o] = strand.offset(part);
        let moved = along * (strand.length * part) + beside * b + out * o + offset;
        // Files have this precision.
        let at = (position + moved * self.options.units_per_metre).as_vec3();
        self.mesh.positions.push(at.as_dvec3());
        let normal = normal.as_vec3().to_array();
        self.normals.extend(normal);
        // The wood that it was peeled off.
        let length = grain.z + strand.forward * strand.length * part;
        let texture = (self.options.square).side_grain(strand.ring, 0.0, length);
        self.coordinates.extend(texture.as_vec2().to_array());
        let grain = DVec3::new(grain.x, grain.y, length);
        self.grain.extend(grain.as_vec3().to_array());
        self.rings.push(strand.ring.min(1.0) as f32);
        self.sectors.push(strand.root.sector);
        self.zones.push(strand.root.zone);
    }

    /// The mesh with its attributes.
    pub fn finish(mut self) -> Mesh {
        self.mesh.materials = vec![self.options.material; self.mesh.triangles.len()];
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
