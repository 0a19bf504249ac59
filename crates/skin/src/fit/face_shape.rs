//! From the breaks of rods to the shape of a face: fracture zones, inclination, layers, thorns and relief
//! (Yang 2019 §3.2 to 3.5).

use super::breaks::AddressedBreak;
use super::parameters::FittedParameters;
use super::sector_search::{SectorContents, best_sector};
use super::statistics::{Weighted, quantile, spread};
use super::trend::{HeightSample, Layer, LayerSide, addresses, shelf_line};
use glam::DVec2;
use greenstick_fracture::parameters::{Sector, SurfaceStyle};
use greenstick_wood::tissue::Zone;

/// Fewest breaks that decide a parameter of a part of the section.
const MIN_BREAKS: usize = 3;
/// Part of the variance of heights that a plane must explain.
const MIN_PLANE_EXPLAINED: f64 = 0.6;
/// Least F statistic of a plane: explained over residual variance, each by its degrees of freedom. Few breaks lie near
/// some plane by chance.
const MIN_PLANE_F: f64 = 10.0;
/// Least inclination, degrees.
const MIN_INCLINATION: f64 = 3.0;
/// A thorn stands out by at least so many edges of a rod …
const THORN_EDGES: f64 = 2.0;
/// … and by so many standard deviations of what stands around it.
const THORN_DEVIATIONS: f64 = 3.0;
/// Standard deviation over median absolute deviation of a normal distribution.
const DEVIATION_OF_MEDIAN: f64 = 1.4826;
/// Neighbours whose heights differ by more than this many edges are a step apart: within it they may be at one height.
const STEP_EDGES: f64 = 1.5;
/// Part of neighbours a step apart above which a face is fibrous.
const FIBROUS_STEPS: f64 = 0.2;
/// Height of a step, radii, above which a smooth face cannot be distinguished from a fibrous one.
const MAX_STEP: f64 = 0.5;
/// Spread from the 5th to the 95th percentile over the range of a uniform distribution.
const UNIFORM_SPREAD: f64 = 0.9;

/// What the shape is worked out from.
pub(super) struct Observations<'a> {
    pub breaks: &'a [AddressedBreak],
    /// All rods of the section: the broken ones, then the whole ones.
    pub section: &'a [AddressedBreak],
    /// Pairs of breaks whose rods were bonded.
    pub neighbours: &'a [[usize; 2]],
    /// Mean length of an edge of a rod, radii.
    pub edge: f64,
    pub seed: u64,
}

/// The shape of a face.
pub(super) struct FaceShape {
    pub parameters: FittedParameters,
    /// Height of the middle layer, radii.
    pub level: f64,
    /// Number of layers.
    pub layers: usize,
    /// Number of thorns that stand up and of those that stand down.
    pub thorns: [usize; 2],
    /// Whether each break carries a thorn.
    pub is_thorn: Vec<bool>,
    /// Whether the relief is higher than the edges of rods can resolve.
    pub has_relief: bool,
}

impl FaceShape {
    /// Works out the shape.
    pub fn new(observed: &Observations) -> FaceShape {
        let mut parameters = FittedParameters::default();
        parameters.face.seed = observed.seed;
        let basis = "heights are those of this stem";
        parameters.set("size_effect", 0.0, observed.breaks.len(), basis);
        let mut shape = FaceShape {
            parameters,
            level: 0.0,
            layers: 1,
            thorns: [0; 2],
            is_thorn: vec![false; observed.breaks.len()],
            has_relief: false,
        };
        let ductile = shape.fit_zones(observed);
        let mut heights: Vec<f64> = observed.breaks.iter().map(|b| b.height).collect();
        shape.fit_inclination(observed, &mut heights);
        shape.fit_layers(observed, &mut heights);
        shape.level = quantile(&sample(observed, &heights).weighted(), 0.5);
        for height in &mut heights {
            *height -= shape.level;
        }
        shape.fit_thorns(observed, ductile, &heights);
        shape.fit_compression_steps(observed, &heights);
        shape.fit_relief(observed, &heights);
        shape
    }

    /// Fits the ductile zone, the sector that divides best what broke in tension from what broke in compression or is
    /// whole, and the shelf, which divides them by a line: wood that held on is drawn as wood that broke last.
    fn fit_zones(&mut self, observed: &Observations) -> Option<Sector> {
        let section = observed.section;
        let (count, rods) = (observed.breaks.len(), section.len());
        let in_tension = section.iter().filter(|b| b.in_tension).count();
        let fitted = &mut self.parameters;
        if in_tension == 0 {
            let basis = "nothing broke in tension";
            fitted.set("ductile.angle", 0.0, count, basis);
            fitted.set("compression_shelf", 1.0, count, basis);
            fitted.leave("ductile.direction, ductile.rings", basis);
            return None;
        }
        if in_tension == rods {
            let basis = "all rods broke in tension";
            fitted.set("ductile.angle", 360.0, count, basis);
            fitted.set("ductile.rings", 1.0, count, basis);
            fitted.set("compression_shelf", 0.0, count, basis);
            fitted.leave("ductile.direction", "the tension side is all around");
            return Some(fitted.face.ductile.sector());
        }
        let sign = |b: &AddressedBreak| Weighted {
            value: if b.in_tension { 1.0 } else { -1.0 },
            weight: b.weight,
        };
        let values: Vec<Weighted> = section.iter().map(sign).collect();
        let points = addresses(section);
        let tension = section.iter().filter(|b| b.in_tension);
        let tension: f64 = tension.map(|b| b.weight).sum();
        // The part of the area that is classified rightly: tension inside, compression outside.
        let right = |c: &SectorContents| c.sum + 1.0 - tension;
        let sector = best_sector(&points, &values, right)?;
        let basis = format!(
            "{in_tension} rods broke in tension, {} in compression, {} are whole; the sector is right for {:.0} % of their area",
            count - in_tension,
            rods - count,
            100.0 * right(&SectorContents::of(&sector, &points, &values))
        );
        fitted.set("ductile.direction", sector.direction, count, &*basis);
        fitted.set("ductile.angle", sector.angle, count, &*basis);
        fitted.set("ductile.rings", sector.rings, count, basis);
        let (sin, cos) = libm::sincos(sector.direction.to_radians());
        let shelf = shelf_line(section, DVec2::new(cos, sin));
        let basis = format!(
            "a line across is right for {:.0} % of the area",
            100.0 * shelf.right
        );
        fitted.set("compression_shelf", shelf.part, count, basis);
        Some(fitted.face.ductile.sector())
    }

    /// Fits an inclined plane and subtracts it from the heights.
    fn fit_inclination(&mut self, observed: &Observations, heights: &mut [f64]) {
        let breaks = observed.breaks;
        let sample = sample(observed, heights);
        let variance = sample.variance();
        let layer = sample.layer(LayerSide::Either, observed.edge);
        let by_layer = layer.as_ref().map_or(0.0, |l| l.explained);
        if let Some(plane) = sample.plane() {
            let explained = 1.0 - plane.residual / variance.max(f64::MIN_POSITIVE);
            let inclination = libm::atan(plane.slope.length()).to_degrees();
            // A plane has two slopes and a height.
            let residual_freedom = breaks.len() as f64 - 3.0;
            let sure = 0.5 * explained * residual_freedom > MIN_PLANE_F * (1.0 - explained);
            if sure
                && explained >= MIN_PLANE_EXPLAINED
                && explained >= by_layer
                && inclination >= MIN_INCLINATION
            {
                let basis = format!(
                    "a plane explains {:.0} % of the variance",
                    100.0 * explained
                );
                let direction = libm::atan2(plane.slope.y, plane.slope.x);
                let direction = direction.to_degrees().rem_euclid(360.0);
                let (fitted, count) = (&mut self.parameters, breaks.len());
                fitted.set("inclination", inclination, count, &*basis);
                fitted.set("inclination_direction", direction, count, basis);
                for (height, b) in heights.iter_mut().zip(breaks) {
                    *height -= plane.slope.dot(b.across);
                }
                return;
            }
        }
        self.parameters.leave(
            "inclination, inclination_direction",
            "no plane explains the heights better than layers do",
        );
    }

    /// Fits a high and a low layer and subtracts them from the heights.
    fn fit_layers(&mut self, observed: &Observations, heights: &mut [f64]) {
        let points = addresses(observed.breaks);
        let mut side = LayerSide::Either;
        for _ in 0..2 {
            let Some(layer) = sample(observed, heights).layer(side, observed.edge) else {
                break;
            };
            self.set_layer(&layer);
            for (height, point) in heights.iter_mut().zip(&points) {
                if layer.sector.contains(point.angle, point.ring) {
                    *height -= layer.step;
                }
            }
            side = if layer.step > 0.0 {
                LayerSide::Below
            } else {
                LayerSide::Above
            };
        }
        let missing = match (self.layers, side) {
            (1, _) => "high.*, low.*",
            (2, LayerSide::Above) => "high.*",
            (2, _) => "low.*",
            _ => return,
        };
        let why = "no sector stands surely above or below the rest";
        self.parameters.leave(missing, why);
    }

    fn set_layer(&mut self, layer: &Layer) {
        let keys = if layer.step > 0.0 {
            ["high.height", "high.direction", "high.angle", "high.rings"]
        } else {
            ["low.height", "low.direction", "low.angle", "low.rings"]
        };
        let sector = &layer.sector;
        let values = [layer.step, sector.direction, sector.angle, sector.rings];
        let explained = 100.0 * layer.explained;
        let basis = format!("a layer explains {explained:.0} % of the variance");
        for (key, value) in keys.into_iter().zip(values) {
            self.parameters.set(key, value, layer.count, &*basis);
        }
        self.layers += 1;
    }

    /// Fits thorns in the ductile zone and outside of it: breaks that stand far out of the others.
    fn fit_thorns(&mut self, observed: &Observations, ductile: Option<Sector>, heights: &[f64]) {
        let breaks = observed.breaks;
        let inside = |b: &AddressedBreak| ductile.is_some_and(|s| s.contains(b.angle, b.ring));
        for is_ductile in [true, false] {
            let zone: Vec<usize> = (0..breaks.len())
                .filter(|&i| inside(&breaks[i]) == is_ductile)
                .collect();
            let count = zone.len();
            if count < MIN_BREAKS {
                let keys = if is_ductile {
                    "ductile.thorn_length, ductile.thorn_probability"
                } else {
                    "brittle.thorn_length, brittle.thorn_probability"
                };
                let why = format!("only {count} rods broke in the zone");
                self.parameters.leave(keys, why);
                continue;
            }
            let median = |value: &dyn Fn(usize) -> f64| {
                let weighted = |&i: &usize| Weighted {
                    value: value(i),
                    weight: breaks[i].weight,
                };
                quantile(&zone.iter().map(weighted).collect::<Vec<_>>(), 0.5)
            };
            let middle = median(&|i| heights[i]);
            let deviation = median(&|i| (heights[i] - middle).abs());
            let least = (THORN_EDGES * observed.edge)
                .max(THORN_DEVIATIONS * DEVIATION_OF_MEDIAN * deviation);
            let (mut thorn_area, mut area, mut longest, mut found) = (0.0, 0.0, 0.0_f64, 0);
            for &i in &zone {
                let (length, weight) = (heights[i] - middle, breaks[i].weight);
                area += weight;
                if length.abs() > least {
                    thorn_area += weight;
                    longest = longest.max(length.abs());
                    found += 1;
                    self.is_thorn[i] = true;
                    self.thorns[usize::from(length < 0.0)] += 1;
                }
            }
            let basis = format!(
                "{found} of {count} stand out by more than {least:.2} radii, {:.0} % of the zone's area",
                100.0 * thorn_area / area
            );
            let [length, probability] = if is_ductile {
                ["ductile.thorn_length", "ductile.thorn_probability"]
            } else {
                ["brittle.thorn_length", "brittle.thorn_probability"]
            };
            let fitted = &mut self.parameters;
            fitted.set(length, longest, count, &*basis);
            fitted.set(probability, thorn_area / area, count, basis);
        }
    }

    /// Fits the steps of wood that was crushed.
    fn fit_compression_steps(&mut self, observed: &Observations, heights: &[f64]) {
        let all = observed.breaks.iter().zip(heights).zip(&self.is_thorn);
        let crushed: Vec<Weighted> = all
            .filter(|((b, _), thorn)| !b.in_tension && !**thorn)
            .map(|((b, &value), _)| Weighted {
                value,
                weight: b.weight,
            })
            .collect();
        let height = spread(&crushed) / UNIFORM_SPREAD;
        let (fitted, key) = (&mut self.parameters, "compression_height");
        if crushed.len() < MIN_BREAKS {
            let why = format!("only {} rods broke in compression", crushed.len());
            fitted.leave(key, why);
        } else if height <= STEP_EDGES * observed.edge {
            let why = "its steps are lower than the edges of rods can resolve";
            fitted.leave(key, why);
        } else {
            let basis = "from the 5th to the 95th percentile of what broke in compression";
            fitted.set(key, height, crushed.len(), basis);
        }
    }

    /// Fits whether the face is smooth or fibrous, and how high its relief is before it is matched to that of the run.
    fn fit_relief(&mut self, observed: &Observations, heights: &[f64]) {
        let neighbours = observed.neighbours.iter();
        let steps: Vec<f64> = neighbours
            .filter(|[a, b]| !self.is_thorn[*a] && !self.is_thorn[*b])
            .map(|&[a, b]| (heights[a] - heights[b]).abs())
            .collect();
        if steps.is_empty() {
            let keys = "surface, slab_height, sliver_height";
            return self.parameters.leave(keys, "no two neighbours broke");
        }
        let resolved = STEP_EDGES * observed.edge;
        let apart = steps.iter().filter(|&&step| step > resolved).count();
        let coarse = resolved > MAX_STEP;
        if coarse {
            let why =
                "the edges of rods are too long to distinguish a smooth face from a fibrous one";
            self.parameters.leave("surface", why);
        }
        let fibrous = coarse || apart as f64 / steps.len() as f64 > FIBROUS_STEPS;
        self.parameters.face.surface = if fibrous {
            SurfaceStyle::Fibrous
        } else {
            SurfaceStyle::Smooth
        };
        let plain: Vec<usize> = (0..heights.len()).filter(|&i| !self.is_thorn[i]).collect();
        let all: Vec<Weighted> = plain
            .iter()
            .map(|&i| Weighted {
                value: heights[i],
                weight: observed.breaks[i].weight,
            })
            .collect();
        self.has_relief = spread(&all) > observed.edge;
        if fibrous {
            self.fit_fibrous_relief(observed, heights, &plain);
        } else {
            self.fit_smooth_relief(observed, heights, &plain);
        }
    }

    /// Fits slabs, the heights that neighbours share, and slivers, by which they differ.
    fn fit_fibrous_relief(&mut self, observed: &Observations, heights: &[f64], plain: &[usize]) {
        let breaks = observed.breaks;
        // Sums of height times weight and of weight over each break and its neighbours.
        let mut sums: Vec<[f64; 2]> = heights
            .iter()
            .zip(breaks)
            .map(|(h, b)| [h * b.weight, b.weight])
            .collect();
        for &[a, b] in observed.neighbours {
            if self.is_thorn[a] || self.is_thorn[b] {
                continue;
            }
            for (to, from) in [(a, b), (b, a)] {
                let weight = breaks[from].weight;
                sums[to][0] += heights[from] * weight;
                sums[to][1] += weight;
            }
        }
        let shared = |i: usize| sums[i][0] / sums[i][1];
        let spread_of = |value: &dyn Fn(usize) -> f64| {
            let weighted = |&i: &usize| Weighted {
                value: value(i),
                weight: breaks[i].weight,
            };
            spread(&plain.iter().map(weighted).collect::<Vec<_>>())
        };
        let slabs = spread_of(&shared);
        let slivers = spread_of(&|i| heights[i] - shared(i));
        let (fitted, count) = (&mut self.parameters, plain.len());
        fitted.set("slab_height", slabs, count, "what neighbours share");
        fitted.set("sliver_height", slivers, count, "how neighbours differ");
    }

    /// Fits the noise of each tissue: the spread of its heights.
    fn fit_smooth_relief(&mut self, observed: &Observations, heights: &[f64], plain: &[usize]) {
        const KEYS: [&str; 5] = [
            "pith.perlin_amplitude",
            "heartwood.perlin_amplitude",
            "sapwood.perlin_amplitude",
            "phloem.perlin_amplitude",
            "bark.perlin_amplitude",
        ];
        if !self.has_relief {
            let why = "the relief is lower than the edges of rods can resolve";
            return self.parameters.leave("*.perlin_amplitude", why);
        }
        for zone in Zone::ALL {
            let of = plain.iter().filter(|&&i| observed.breaks[i].zone == zone);
            let of: Vec<Weighted> = of
                .map(|&i| Weighted {
                    value: heights[i],
                    weight: observed.breaks[i].weight,
                })
                .collect();
            let key = KEYS[usize::from(zone.code())];
            if of.len() < MIN_BREAKS {
                let why = format!("only {} rods broke in that tissue", of.len());
                self.parameters.leave(key, why);
                continue;
            }
            let basis = format!("spread of the heights in the {zone}");
            self.parameters.set(key, spread(&of), of.len(), basis);
        }
    }
}

fn sample<'a>(observed: &Observations<'a>, heights: &'a [f64]) -> HeightSample<'a> {
    HeightSample {
        breaks: observed.breaks,
        heights,
    }
}
