//! From the places where rods broke to the shape of a face: fracture zones, inclination, layers, thorns and relief
//! (Yang 2019 §3.2 to 3.5).

use super::fans::{self, Held};
use super::places::{Place, quantile, spread};
use super::sheet::Sheet;
use glam::{DMat2, DVec2};
use greenstick_fracture::parameters::{Sector, SurfaceStyle};
use greenstick_wood::tissue::Zone;

/// Fewer breaks tell nothing about a part of the section.
const FEWEST: usize = 3;
/// Fewer breaks tell no plane.
const FEWEST_OF_PLANE: usize = 6;
/// Part of the variance of heights that a plane must account for, else it is left out.
const PLANE_TELLS: f64 = 0.6;
/// What a plane accounts for over what it leaves, for each degree of freedom (the F statistic): few breaks lie near some
/// plane by chance.
const PLANE_SURE: f64 = 10.0;
/// Part of the variance that a layer must account for.
const LAYER_TELLS: f64 = 0.2;
/// A layer's step over its standard error at least: it is the best one of many fans.
const LAYER_SURE: f64 = 4.0;
/// A layer has so many breaks at least, and so has the rest: of many fans some hold a few high ones by chance.
const FEWEST_OF_LAYER: usize = 5;
/// Less than this is no inclination, degrees.
const FLATTEST: f64 = 3.0;
/// A thorn stands out by so many edges of a rod at least ...
const THORN_EDGES: f64 = 2.0;
/// ... and by so many standard deviations of what stands around it.
const THORN_DEVIATIONS: f64 = 3.0;
/// The standard deviation over the median of distances from the median, for a normal distribution.
const NORMAL: f64 = 1.4826;
/// Heights of two neighbours further apart than this many edges are a step: within it they may be one height.
const STEP_EDGES: f64 = 1.5;
/// A face is fibrous where more than this part of neighbours are a step apart.
const FIBROUS: f64 = 0.2;
/// Where a step is higher than this, in radii, a smooth face cannot be told from a fibrous one.
const COARSEST: f64 = 0.5;
/// What the 5th and the 95th hundredth leave out of an even distribution.
const SPREAD_OF_EVEN: f64 = 0.9;

/// The shape of a face.
pub(super) struct Shape {
    pub sheet: Sheet,
    /// Height of the middle layer, radii.
    pub level: f64,
    /// Number of layers.
    pub layers: usize,
    /// Thorns that stand up and those that stand down.
    pub thorns: [usize; 2],
    /// Whether each place carries a thorn.
    pub thorn: Vec<bool>,
    /// Whether the relief is higher than what the edges of rods can tell.
    pub relief: bool,
}

/// What the shape is worked out from.
pub(super) struct Known<'a> {
    pub places: &'a [Place],
    /// All rods of the section: those, then those that are whole.
    pub section: &'a [Place],
    /// Pairs of places whose rods were bonded.
    pub beside: &'a [(usize, usize)],
    /// Length of an edge of a rod, radii.
    pub edge: f64,
    pub seed: u64,
}

impl Shape {
    pub fn of(known: &Known) -> Shape {
        let mut sheet = Sheet::default();
        sheet.face.seed = known.seed;
        let count = known.places.len();
        let mut shape = Shape {
            sheet,
            level: 0.0,
            layers: 1,
            thorns: [0; 2],
            thorn: vec![false; count],
            relief: false,
        };
        let ductile = shape.sides(known);
        let mut heights: Vec<f64> = known.places.iter().map(|p| p.height).collect();
        shape.slope_and_layers(known, &mut heights);
        shape.level = quantile(&weighted(known.places, &heights), 0.5);
        for height in &mut heights {
            *height -= shape.level;
        }
        shape.thorns(known, ductile, &heights);
        shape.crushed(known, &heights);
        shape.relief(known, &heights);
        shape
    }

    /// The ductile zone: the fan that parts what broke in tension from what broke in compression or is whole. And the
    /// shelf, which parts them by a line: what held on is drawn as what broke last.
    fn sides(&mut self, known: &Known) -> Option<Sector> {
        let places = known.section;
        let (count, rods) = (known.places.len(), places.len());
        let tension = places.iter().filter(|p| p.tension).count();
        let sheet = &mut self.sheet;
        if tension == 0 {
            let basis = "nothing broke in tension";
            sheet.put("ductile.angle", 0.0, count, basis);
            sheet.put("compression_shelf", 1.0, count, basis);
            sheet.leave("ductile.direction, ductile.rings", basis);
            return None;
        }
        if tension == rods {
            let basis = "all rods broke in tension";
            sheet.put("ductile.angle", 360.0, count, basis);
            sheet.put("ductile.rings", 1.0, count, basis);
            sheet.put("compression_shelf", 0.0, count, basis);
            sheet.leave("ductile.direction", "what broke in tension is all around");
            return Some(sheet.face.ductile.sector());
        }
        let values: Vec<(f64, f64)> = places
            .iter()
            .map(|p| (p.weight, if p.tension { 1.0 } else { -1.0 }))
            .collect();
        let at = addresses(places);
        let whole: f64 = places.iter().filter(|p| p.tension).map(|p| p.weight).sum();
        // What is told right: tension inside and compression outside.
        let right = |held: &Held| held.sum + 1.0 - whole;
        let fan = fans::best(&at, &values, right)?;
        let told = right(&fans::held(&fan, &at, &values));
        let basis = format!(
            "{tension} rods broke in tension, {} in compression, {} are whole; the fan is right for {:.0} % of their area",
            count - tension,
            rods - count,
            100.0 * told
        );
        sheet.put("ductile.direction", fan.direction, count, &*basis);
        sheet.put("ductile.angle", fan.angle, count, &*basis);
        sheet.put("ductile.rings", fan.rings, count, basis);
        let (sin, cos) = libm::sincos(fan.direction.to_radians());
        let (shelf, told) = shelf(places, DVec2::new(cos, sin));
        let basis = format!(
            "a line across is right for {:.0} % of the area",
            100.0 * told
        );
        sheet.put("compression_shelf", shelf, count, basis);
        Some(sheet.face.ductile.sector())
    }

    /// Takes the inclined plane and the layers off `heights`.
    fn slope_and_layers(&mut self, known: &Known, heights: &mut [f64]) {
        let places = known.places;
        let at = addresses(places);
        let variance = variance(places, heights);
        let first = layer(&at, places, heights, known.edge, 0.0);
        let by_layer = first.as_ref().map_or(0.0, |l| l.tells);
        let mut sloped = false;
        if let Some((tilt, left)) = plane(places, heights) {
            let tells = 1.0 - left / variance.max(f64::MIN_POSITIVE);
            let angle = libm::atan(tilt.length()).to_degrees();
            let free = places.len() as f64 - 3.0;
            let sure = 0.5 * tells * free > PLANE_SURE * (1.0 - tells);
            if sure && tells >= PLANE_TELLS && tells >= by_layer && angle >= FLATTEST {
                let basis = format!("a plane tells {:.0} % of their variance", 100.0 * tells);
                let direction = libm::atan2(tilt.y, tilt.x).to_degrees().rem_euclid(360.0);
                let count = places.len();
                self.sheet.put("inclination", angle, count, &*basis);
                self.sheet
                    .put("inclination_direction", direction, count, basis);
                for (height, place) in heights.iter_mut().zip(places) {
                    *height -= tilt.dot(place.across);
                }
                sloped = true;
            }
        }
        if !sloped {
            self.sheet.leave(
                "inclination, inclination_direction",
                "no plane accounts for the heights better than layers do",
            );
        }
        let mut sign = 0.0;
        for _ in 0..2 {
            let Some(found) = layer(&at, places, heights, known.edge, sign) else {
                break;
            };
            self.put_layer(&found);
            for (height, &(angle, rho)) in heights.iter_mut().zip(&at) {
                if found.fan.contains(angle, rho) {
                    *height -= found.step;
                }
            }
            sign = -found.step.signum();
        }
        let untold = match (self.layers, sign > 0.0) {
            (1, _) => "high.*, low.*",
            (2, true) => "high.*",
            (2, false) => "low.*",
            _ => return,
        };
        self.sheet
            .leave(untold, "no fan stands surely above or below the rest");
    }

    fn put_layer(&mut self, found: &Layer) {
        let names = if found.step > 0.0 {
            ["high.height", "high.direction", "high.angle", "high.rings"]
        } else {
            ["low.height", "low.direction", "low.angle", "low.rings"]
        };
        let fan = &found.fan;
        let values = [found.step, fan.direction, fan.angle, fan.rings];
        let basis = format!("a layer tells {:.0} % of the variance", 100.0 * found.tells);
        for (name, value) in names.into_iter().zip(values) {
            self.sheet.put(name, value, found.count, &*basis);
        }
        self.layers += 1;
    }

    /// Thorns in and out of the ductile zone: what stands far out of the rest.
    fn thorns(&mut self, known: &Known, ductile: Option<Sector>, heights: &[f64]) {
        let inside = |p: &Place| ductile.is_some_and(|fan| fan.contains(p.angle, p.rho));
        let zones = [
            (true, "ductile.thorn_length", "ductile.thorn_probability"),
            (false, "brittle.thorn_length", "brittle.thorn_probability"),
        ];
        for (zone, length, probability) in zones {
            let members: Vec<usize> = (0..known.places.len())
                .filter(|&i| inside(&known.places[i]) == zone)
                .collect();
            let count = members.len();
            if count < FEWEST {
                let keys = if zone {
                    "ductile.thorn_length, ductile.thorn_probability"
                } else {
                    "brittle.thorn_length, brittle.thorn_probability"
                };
                self.sheet
                    .leave(keys, format!("only {count} rods broke in the zone"));
                continue;
            }
            let of = |value: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
                let weight = |i: usize| known.places[i].weight;
                members.iter().map(|&i| (value(i), weight(i))).collect()
            };
            let middle = quantile(&of(&|i| heights[i]), 0.5);
            let off = quantile(&of(&|i| (heights[i] - middle).abs()), 0.5);
            let least = (THORN_EDGES * known.edge).max(THORN_DEVIATIONS * NORMAL * off);
            let (mut area, mut all, mut longest, mut found) = (0.0, 0.0, 0.0_f64, 0);
            for &i in &members {
                let (out, weight) = (heights[i] - middle, known.places[i].weight);
                all += weight;
                if out.abs() > least {
                    area += weight;
                    longest = longest.max(out.abs());
                    found += 1;
                    self.thorn[i] = true;
                    self.thorns[usize::from(out < 0.0)] += 1;
                }
            }
            let basis = format!(
                "{found} of {count} stand out by more than {least:.2} radii, {:.0} % of the zone's area",
                100.0 * area / all
            );
            self.sheet.put(length, longest, count, &*basis);
            self.sheet.put(probability, area / all, count, basis);
        }
    }

    /// Steps of what was crushed.
    fn crushed(&mut self, known: &Known, heights: &[f64]) {
        let pressed = known
            .places
            .iter()
            .zip(heights)
            .zip(&self.thorn)
            .filter(|((p, _), thorn)| !p.tension && !**thorn)
            .map(|((p, &h), _)| (h, p.weight));
        let pressed: Vec<(f64, f64)> = pressed.collect();
        let height = spread(&pressed) / SPREAD_OF_EVEN;
        if pressed.len() < FEWEST {
            let why = format!("only {} rods broke in compression", pressed.len());
            self.sheet.leave("compression_height", why);
        } else if height <= STEP_EDGES * known.edge {
            let why = "their steps are lower than what the edges of rods can tell";
            self.sheet.leave("compression_height", why);
        } else {
            let basis = "from the 5th to the 95th hundredth of what broke in compression";
            self.sheet
                .put("compression_height", height, pressed.len(), basis);
        }
    }

    /// What the face is made of, and how high its relief is, before it is matched to the run's.
    fn relief(&mut self, known: &Known, heights: &[f64]) {
        let plain: Vec<usize> = (0..heights.len()).filter(|&i| !self.thorn[i]).collect();
        let pairs: Vec<f64> = known
            .beside
            .iter()
            .filter(|(a, b)| !self.thorn[*a] && !self.thorn[*b])
            .map(|&(a, b)| (heights[a] - heights[b]).abs())
            .collect();
        if pairs.is_empty() {
            self.sheet.leave(
                "surface, slab_height, sliver_height",
                "no two neighbours broke",
            );
            return;
        }
        let steps = pairs.iter().filter(|&&d| d > STEP_EDGES * known.edge);
        let steps = steps.count() as f64 / pairs.len() as f64;
        let coarse = STEP_EDGES * known.edge > COARSEST;
        if coarse {
            let why = "the edges of rods are too long to tell a smooth face from a fibrous one";
            self.sheet.leave("surface", why);
        }
        let fibrous = coarse || steps > FIBROUS;
        self.sheet.face.surface = if fibrous {
            SurfaceStyle::Fibrous
        } else {
            SurfaceStyle::Smooth
        };
        let all: Vec<(f64, f64)> = plain
            .iter()
            .map(|&i| (heights[i], known.places[i].weight))
            .collect();
        self.relief = spread(&all) > known.edge;
        if fibrous {
            self.torn(known, heights, &plain);
        } else {
            self.rough(known, heights, &plain);
        }
    }

    /// Slabs are what neighbours have in common, slivers are how they differ.
    fn torn(&mut self, known: &Known, heights: &[f64], plain: &[usize]) {
        let mut sum: Vec<(f64, f64)> = heights
            .iter()
            .zip(known.places)
            .map(|(h, p)| (h * p.weight, p.weight))
            .collect();
        for &(a, b) in known.beside {
            if self.thorn[a] || self.thorn[b] {
                continue;
            }
            for (to, from) in [(a, b), (b, a)] {
                let weight = known.places[from].weight;
                sum[to].0 += heights[from] * weight;
                sum[to].1 += weight;
            }
        }
        let shared = |i: usize| sum[i].0 / sum[i].1;
        let weight = |i: usize| known.places[i].weight;
        let slabs: Vec<_> = plain.iter().map(|&i| (shared(i), weight(i))).collect();
        let slivers: Vec<_> = plain
            .iter()
            .map(|&i| (heights[i] - shared(i), weight(i)))
            .collect();
        let count = plain.len();
        self.sheet.put(
            "slab_height",
            spread(&slabs),
            count,
            "what neighbours share",
        );
        self.sheet.put(
            "sliver_height",
            spread(&slivers),
            count,
            "how neighbours differ",
        );
    }

    /// Noise of each tissue: the spread of its heights, less that of the edges.
    fn rough(&mut self, known: &Known, heights: &[f64], plain: &[usize]) {
        const KEYS: [&str; 5] = [
            "pith.perlin_amplitude",
            "heartwood.perlin_amplitude",
            "sapwood.perlin_amplitude",
            "phloem.perlin_amplitude",
            "bark.perlin_amplitude",
        ];
        if !self.relief {
            self.sheet.leave(
                "*.perlin_amplitude",
                "the relief is lower than what the edges of rods can tell",
            );
            return;
        }
        for zone in Zone::ALL {
            let of = plain.iter().filter(|&&i| known.places[i].zone == zone);
            let of: Vec<(f64, f64)> = of.map(|&i| (heights[i], known.places[i].weight)).collect();
            let key = KEYS[usize::from(zone.code())];
            if of.len() < FEWEST {
                self.sheet
                    .leave(key, format!("only {} rods broke in that tissue", of.len()));
                continue;
            }
            let basis = format!("spread of the heights in the {zone}");
            self.sheet.put(key, spread(&of), of.len(), basis);
        }
    }
}

fn addresses(places: &[Place]) -> Vec<fans::Address> {
    places.iter().map(|p| (p.angle, p.rho)).collect()
}

fn weighted(places: &[Place], heights: &[f64]) -> Vec<(f64, f64)> {
    let weights = places.iter().map(|p| p.weight);
    heights.iter().copied().zip(weights).collect()
}

fn mean(places: &[Place], heights: &[f64]) -> f64 {
    weighted(places, heights).iter().map(|(h, w)| h * w).sum()
}

fn variance(places: &[Place], heights: &[f64]) -> f64 {
    let mean = mean(places, heights);
    let all = weighted(places, heights);
    all.iter().map(|(h, w)| (h - mean) * (h - mean) * w).sum()
}

/// The slope (height per radius) of the plane nearest to the heights, and the variance that it leaves.
fn plane(places: &[Place], heights: &[f64]) -> Option<(DVec2, f64)> {
    if places.len() < FEWEST_OF_PLANE {
        return None;
    }
    let middle: DVec2 = places.iter().map(|p| p.across * p.weight).sum();
    let mean = mean(places, heights);
    let (mut square, mut with) = (DMat2::ZERO, DVec2::ZERO);
    for (place, height) in places.iter().zip(heights) {
        let d = place.across - middle;
        square += DMat2::from_cols(d * d.x, d * d.y) * place.weight;
        with += d * ((height - mean) * place.weight);
    }
    let whole = square.x_axis.x + square.y_axis.y;
    if square.determinant() <= 1e-6 * whole * whole {
        return None;
    }
    let tilt = square.inverse() * with;
    let left = places.iter().zip(heights).map(|(place, height)| {
        let off = height - mean - tilt.dot(place.across - middle);
        off * off * place.weight
    });
    Some((tilt, left.sum()))
}

/// A fan at a height of its own.
struct Layer {
    fan: Sector,
    /// Over the rest, radii.
    step: f64,
    /// Part of the variance that it accounts for.
    tells: f64,
    /// Breaks in it.
    count: usize,
}

/// The fan that accounts best for the heights, above the rest where `sign` is above 0, below it where it is below 0.
fn layer(
    at: &[fans::Address],
    places: &[Place],
    heights: &[f64],
    edge: f64,
    sign: f64,
) -> Option<Layer> {
    let mean = mean(places, heights);
    let all = variance(places, heights);
    let values: Vec<(f64, f64)> = places
        .iter()
        .zip(heights)
        .map(|(p, h)| (p.weight, h - mean))
        .collect();
    let signs: &[f64] = match sign {
        s if s > 0.0 => &[1.0],
        s if s < 0.0 => &[-1.0],
        _ => &[1.0, -1.0],
    };
    let mut best: Option<(Layer, f64)> = None;
    for &sign in signs {
        let told = |held: &Held| {
            let few = held.count.min(places.len() - held.count) < FEWEST_OF_LAYER;
            if few || held.sum * sign <= 0.0 || held.weight >= 1.0 {
                return 0.0;
            }
            held.sum * held.sum / (held.weight * (1.0 - held.weight)) / all
        };
        let Some(fan) = fans::best(at, &values, told) else {
            continue;
        };
        let held = fans::held(&fan, at, &values);
        let tells = told(&held);
        let part = |inside: bool| -> Vec<(f64, f64)> {
            let kept = at.iter().zip(&values);
            kept.filter(|(a, _)| fan.contains(a.0, a.1) == inside)
                .map(|(_, &(w, h))| (h, w))
                .collect()
        };
        let step = quantile(&part(true), 0.5) - quantile(&part(false), 0.5);
        let (n, m) = (held.count as f64, (places.len() - held.count) as f64);
        let error = ((1.0 - tells).max(0.0) * all * (1.0 / n + 1.0 / m)).sqrt();
        let sure = step * sign > edge.max(LAYER_SURE * error) && tells >= LAYER_TELLS;
        // A high fan and the low rest tell the same: the smaller one is the layer.
        let better = best.as_ref().is_none_or(|(known, weight)| {
            tells > known.tells + 1e-9 || (tells > known.tells - 1e-9 && held.weight < *weight)
        });
        if sure && better {
            let count = held.count;
            best = Some((
                Layer {
                    fan,
                    step,
                    tells,
                    count,
                },
                held.weight,
            ));
        }
    }
    best.map(|(layer, _)| layer)
}

/// The part of the section, from the side opposite to `tension`, that parts best what broke in compression from the
/// rest, and the part of the area that it is right for.
fn shelf(places: &[Place], tension: DVec2) -> (f64, f64) {
    let mut across: Vec<(f64, f64)> = places
        .iter()
        .map(|p| {
            (
                p.shelf.dot(tension),
                if p.tension { -p.weight } else { p.weight },
            )
        })
        .collect();
    across.sort_by(|a, b| a.0.total_cmp(&b.0));
    // With nothing on the shelf what broke in tension is right.
    let mut right: f64 = places.iter().filter(|p| p.tension).map(|p| p.weight).sum();
    let first = across.first().map_or(-1.0, |a| a.0);
    let (mut best, mut at) = (right, 0.5 * (first - 1.0));
    for (i, (place, weight)) in across.iter().enumerate() {
        right += weight;
        if right > best {
            best = right;
            at = 0.5 * (place + across.get(i + 1).map_or(1.0, |next| next.0));
        }
    }
    (0.5 * (at + 1.0), best)
}
