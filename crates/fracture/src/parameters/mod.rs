//! Parameters of a broken face: those of Table 2 of Yang 2019, those its text names and the table
//! leaves out, and those a fibrous face needs beside them.
//!
//! Heights are ratios to the stem's radius. Angles are degrees, counted about the pith from the
//! section's first axis.
//!
//! The stage that a parameter names is that of a break with straight grain whose cracks, if any, are in the broken face.

mod cracks;
mod size;
mod zone;

pub use cracks::{
    Crack, CrackEnd, CrackGroup, CrackKind, CrackParameters, CrackSettings, RadialCrack,
    TangentialCrack,
};
pub use size::REFERENCE_DIAMETER;
pub use zone::{BrittleZone, DuctileZone, HighLayer, LowLayer, Sector, ZoneParameters};

use Unit::{Centimetre, Degree, DegreePerRadius, Fraction, Radius};
use greenstick_schema::{ParameterError, Unit, choice, choices, count, number, parameters};
use greenstick_wood::tissue::{Proportions, Zone};

choices! {
    /// What a broken face is made of.
    pub enum SurfaceStyle {
        /// A height field with thorns on it, as published.
        Smooth = "smooth",
        /// Fibre bundles with walls along the grain.
        Fibrous = "fibrous",
    }
}

parameters! {
    /// Everything that decides how a broken face looks.
    pub struct BreakParameters {
        "branch", "heights" {
            /// The diameter that noise is laid out for, in cm as in Table 2. The stem's own size
            /// comes from its mesh: with 1 here the pattern on any stem is that of a branch of 1
            /// cm; with 0 it is laid out in true metres on the stem as it is. A branch made from
            /// nothing has this diameter.
            diameter: f64 = 1.0, number(Centimetre, 0.0, 500.0).symbol("D");
            /// Concentric circles on the section.
            rings: u32 = 48, count(3, 400).symbol("N_ring").stage("layout");
            /// Sectors of the section.
            sectors: u32 = 148, count(10, 1000).symbol("N_sec").stage("layout");
            /// Inclination of the broken face against the section.
            inclination: f64 = 0.0, number(Degree, 0.0, 90.0).symbol("φ");
            /// Direction in which the inclined face rises.
            inclination_direction: f64 = 0.0, number(Degree, 0.0, 360.0);
            /// Which random break of all those with these parameters. Every stem breaks differently with the same seed.
            seed: u64 = 1, count(0, i64::MAX as i128).stage("layout");
        }
        "tissue", "heights" {
            /// Part of the radius that is pith.
            pith_proportion: f64 = Proportions::USUAL.pith, number(Fraction, 0.0, 1.0).symbol("ν_pith");
            /// Part of the radius that is heartwood.
            heartwood_proportion: f64 = Proportions::USUAL.heartwood, number(Fraction, 0.0, 1.0).symbol("ν_heartwood");
            /// Part of the radius that is phloem. What is left is sapwood, and the outermost ring
            /// is bark.
            phloem_proportion: f64 = Proportions::USUAL.phloem, number(Fraction, 0.0, 1.0).symbol("ν_phloem");
        }
        "face", "heights" {
            /// What the face is made of: "smooth" is the height field of the paper, "fibrous" has
            /// bundles with walls along the grain.
            surface: SurfaceStyle = SurfaceStyle::Fibrous, choice(SurfaceStyle::CHOICES).stage("layout");
            /// Part of a thorn's height that is a slender prism; the rest is an irregular pyramid
            /// (section 3.5).
            thorn_shaft: f64 = 0.65, number(Fraction, 0.5, 0.8);
        }
        "fibrous face", "heights" {
            /// How much the counts and heights below, which are those of a stem 4 cm thick, follow the size of the stem: 0
            /// not at all, so that a trunk breaks like a twig seen from near; 1 as wood does, with more slivers in a trunk,
            /// which are shorter against its radius. A thick stem then has up to 1.4 times the rings and sectors.
            size_effect: f64 = 1.0, number(Fraction, 0.0, 1.0);
            /// Width of a sliver, a group of fibre bundles that ended together, along the ring over
            /// its thickness across it, at most: splinters are flat.
            bundle_aspect: f64 = 4.0, number(Unit::One, 1.0, 20.0);
            /// Slabs, the coarsest pieces: bounded by rings and rays.
            slab_count: u32 = 7, count(1, 100);
            /// Slivers, the pieces that slabs split into: groups of fibre bundles.
            sliver_count: u32 = 64, count(1, 2000);
            /// Height by which slabs differ.
            slab_height: f64 = 0.8, number(Radius, 0.0, 20.0);
            /// Height by which the slivers of a slab differ.
            sliver_height: f64 = 0.6, number(Radius, 0.0, 20.0);
            /// Height of the fur of fine fibres on the tips.
            fibre_height: f64 = 0.08, number(Radius, 0.0, 5.0);
            /// Strands of torn fibre on the broken face, along the sides of its splinters and on their edges, and, on pieces that are
            /// moved apart, at the ends of short breaks, too: 0 none, 1 as many as there can be. They are thin meshes of their own
            /// beside the pieces, which files of a single mesh leave out.
            fuzz: f64 = 0.5, number(Fraction, 0.0, 1.0);
            /// Mean angle by which slender splinters lean from the grain, each to a side of its own, as torn wood springs apart: not at
            /// the root, more and more towards the tip, thick ones less. Each half is bent by itself after it was cut, which changes
            /// volumes by some hundredths of a percent; with 0 here and for `splinter_snap` the halves fit exactly. "auto" is 8° where
            /// pieces are moved apart or hang, and 0 where they lie in each other.
            splinter_lean: Option<f64> = None, number(Degree, 0.0, 20.0).auto();
            /// Share of the slender splinters that snapped on their way and hang to one side by the fibres that still hold. Where
            /// there is no room for that, they stay as they are. "auto" is 0.2 where pieces are moved apart or hang, and 0 where they
            /// lie in each other.
            splinter_snap: Option<f64> = None, number(Fraction, 0.0, 1.0).auto();
            /// Height of the steps between neighbouring rings where the wood breaks brittle. The
            /// shear-lag length of the species over the radius is its natural value.
            step_height: f64 = 0.15, number(Radius, 0.0, 20.0);
            /// Depth of the split along the grain between the tension and the compression side.
            split: f64 = 0.0, number(Radius, 0.0, 40.0);
            /// Part of the section, from the compression side, that broke as a blunt shelf.
            compression_shelf: f64 = 0.25, number(Fraction, 0.0, 1.0);
            /// Height of the crumpled steps on that shelf.
            compression_height: f64 = 0.05, number(Radius, 0.0, 5.0);
            /// Height at which the bark broke, against the wood under it: above zero it stands
            /// over, below it is torn back.
            bark_offset: f64 = 0.1, number(Radius, -20.0, 20.0);
            /// Height by which the strips of bark differ: some stand over the wood as flaps, some
            /// are peeled back from it.
            bark_height: f64 = 0.8, number(Radius, 0.0, 20.0);
            /// Strips that the bark tears into around the stem, along its furrows.
            bark_strips: u32 = 13, count(1, 200);
            /// Angle by which the upper piece turns about the bark of the compression side and
            /// hangs on it. The face keeps within the wedge that this opens.
            hang: f64 = 0.0, number(Degree, 0.0, 120.0).stage("heights");
            /// Turn of the splinters about the axis, for breaks by twisting.
            spiral_angle: f64 = 0.0, number(DegreePerRadius, -30.0, 30.0).stage("stem");
        }
    }
    tables {
        /// The pith.
        pith: ZoneParameters = ZoneParameters::of(Zone::Pith);
        /// The heartwood.
        heartwood: ZoneParameters = ZoneParameters::of(Zone::Heartwood);
        /// The sapwood.
        sapwood: ZoneParameters = ZoneParameters::of(Zone::Sapwood);
        /// The phloem.
        phloem: ZoneParameters = ZoneParameters::of(Zone::Phloem);
        /// The bark.
        bark: ZoneParameters = ZoneParameters::of(Zone::Bark);
        /// The high layer.
        high: HighLayer = HighLayer::default();
        /// The low layer.
        low: LowLayer = LowLayer::default();
        /// The ductile fracture zone.
        ductile: DuctileZone = DuctileZone::default();
        /// The brittle fracture zone.
        brittle: BrittleZone = BrittleZone::default();
    }
    check |p| {
        let Proportions {
            pith,
            heartwood,
            phloem,
        } = p.proportions();
        // Proportions such as 0.1 + 0.2 + 0.7 round to a little more than 1.
        if pith + heartwood + phloem <= 1.0 + 1e-12 {
            Ok(())
        } else {
            Err(ParameterError::Conflict(format!(
                "pith {pith}, heartwood {heartwood} and phloem {phloem} are together more than 1, the whole radius"
            )))
        }
    };
}

impl BreakParameters {
    /// The parameters of a tissue.
    pub fn zone(&self, zone: Zone) -> &ZoneParameters {
        match zone {
            Zone::Pith => &self.pith,
            Zone::Heartwood => &self.heartwood,
            Zone::Sapwood => &self.sapwood,
            Zone::Phloem => &self.phloem,
            Zone::Bark => &self.bark,
        }
    }

    /// The parts of the radius each tissue takes.
    pub fn proportions(&self) -> Proportions {
        Proportions {
            pith: self.pith_proportion,
            heartwood: self.heartwood_proportion,
            phloem: self.phloem_proportion,
        }
    }

    /// The diameter in m that noise is laid out for, on a stem of `stem_diameter` m: multiply a
    /// point of the unit section by half of it to come to noise coordinates in m.
    pub fn noise_diameter(&self, stem_diameter: f64) -> f64 {
        if self.diameter > 0.0 {
            self.diameter / 100.0
        } else {
            stem_diameter
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick_schema::{Kind, Parameters, Value};

    #[test]
    fn a_misspelt_key_suggests_the_right_one() {
        let mut p = BreakParameters::default();
        let message = p.set_text("slab_hieght", "1").unwrap_err().to_string();
        let expected = "unknown parameter \"slab_hieght\"; did you mean \"slab_height\"";
        assert!(message.starts_with(expected), "{message}");
        let message = p
            .set_text("sapwod.perlin_amplitude", "1")
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("mean \"sapwood.perlin_amplitude\""),
            "{message}"
        );
        assert_eq!(p, BreakParameters::default());
    }

    #[test]
    fn values_out_of_range_are_refused_with_the_range() {
        let mut p = BreakParameters::default();
        let mut refuse = |key: &str, text: &str| p.set_text(key, text).unwrap_err().to_string();
        assert_eq!(
            refuse("inclination", "91"),
            "inclination is 91, but it must be from 0 to 90 °"
        );
        assert_eq!(
            refuse("rings", "2"),
            "rings is 2, but it must be a whole number from 3 to 400"
        );
        assert!(refuse("rings", "4.5").contains("whole number"));
        assert!(refuse("slab_height", "nan").contains("must be from 0 to 20 radius"));
        assert!(refuse("slab_height", "inf").contains("must be from 0 to 20 radius"));
        assert!(refuse("rings", "-1").contains("whole number"));
        assert!(refuse("surface", "shiny").contains("one of smooth, fibrous"));
        assert!(refuse("low.height", "1").contains("from -20 to 0"));
    }

    #[test]
    fn every_parameter_takes_its_ends_and_nothing_beyond() {
        for info in BreakParameters::table() {
            let mut p = BreakParameters::default();
            let (beyond, ends) = match info.kind {
                Kind::Number { min, max, .. } => (
                    vec![Value::Number(min - 1e-6), Value::Number(max + 1e-6)],
                    vec![Value::Number(min), Value::Number(max)],
                ),
                Kind::Integer { min, max, .. } => (
                    vec![Value::Integer(max + 1), Value::Number(min as f64 + 0.5)],
                    vec![Value::Integer(min), Value::Integer(max)],
                ),
                Kind::Choice { options } => (
                    vec![Value::Text("?".into()), Value::Integer(1)],
                    options.iter().map(|o| Value::Text(o.word.into())).collect(),
                ),
                _ => panic!("{} is of no kind that a broken face has", info.key),
            };
            for value in beyond {
                assert!(
                    p.set(&info.key, &value).is_err(),
                    "{} took {value}",
                    info.key
                );
            }
            for value in ends {
                p.set(&info.key, &value).unwrap();
                let listed = p.list().into_iter().find(|i| i.key == info.key).unwrap();
                assert_eq!(listed.value, value, "{}", info.key);
            }
            assert!(
                !info.doc.is_empty() && !info.group.is_empty(),
                "{}",
                info.key
            );
        }
    }

    #[test]
    fn whole_numbers_may_come_as_real_ones_but_no_others() {
        let mut p = BreakParameters::default();
        p.set("rings", &Value::Number(20.0)).unwrap();
        assert_eq!(p.rings, 20);
        for bad in [20.5, -3.0, f64::NAN, f64::INFINITY] {
            assert!(p.set("rings", &Value::Number(bad)).is_err(), "{bad}");
        }
    }

    #[test]
    fn table_2_is_there_with_its_symbols_and_ranges() {
        let table = BreakParameters::table();
        for (symbol, min, max) in [
            ("D", 0.0, 500.0),
            ("N_ring", 3.0, 400.0),
            ("N_sec", 10.0, 1000.0),
            ("φ", 0.0, 90.0),
            ("ν_pith", 0.0, 1.0),
            ("ν_heartwood", 0.0, 1.0),
            ("ν_phloem", 0.0, 1.0),
            ("λ_phloem", 0.0, 5.0),
            ("β_phloem", 1.0, 10000.0),
            ("λ_sapwood", 0.0, 5.0),
            ("β_sapwood", 1.0, 10000.0),
            ("λ_heartwood", 0.0, 5.0),
            ("β_heartwood", 1.0, 10000.0),
            ("h_high", 0.0, 20.0),
            ("α_high", 0.0, 360.0),
            ("θ_high", 0.0, 360.0),
            ("μ_high", 0.0, 1.0),
            ("h_low", -20.0, 0.0),
            ("α_low", 0.0, 360.0),
            ("θ_low", 0.0, 360.0),
            ("μ_low", 0.0, 1.0),
            ("L_D", 0.0, 40.0),
            ("P_D", 0.0, 1.0),
            ("α_ductile", 0.0, 360.0),
            ("θ_ductile", 0.0, 360.0),
            ("μ_ductile", 0.0, 1.0),
        ] {
            let found: Vec<_> = table.iter().filter(|p| p.symbol == symbol).collect();
            assert_eq!(found.len(), 1, "{symbol}");
            assert_eq!(
                (found[0].min(), found[0].max()),
                (Some(min), Some(max)),
                "{symbol}"
            );
        }
    }

    #[test]
    fn fields_written_directly_are_checked() {
        let mut p = BreakParameters {
            slab_height: f64::NAN,
            ..BreakParameters::default()
        };
        assert!(matches!(p.check(), Err(ParameterError::OutOfRange { .. })));
        p = BreakParameters {
            heartwood_proportion: 0.95,
            ..BreakParameters::default()
        };
        assert!(matches!(p.check(), Err(ParameterError::Conflict(_))));
        p.heartwood_proportion = 0.9;
        p.check().unwrap();
    }
}
