//! The cracks of a recipe: planned by species and moisture, opened at the break or at a sawn end, reported.

use crate::breaking::{part_of, volume_scale};
use crate::model::Model;
use crate::prepare::{in_world, laid};
use crate::{Error, Prepared};
use glam::{DVec2, DVec3};
use greenstick_fracture::cracks::{CrackError, CrackPlan, Grooved, plan};
use greenstick_fracture::parameters::{BreakParameters, CrackEnd};
use greenstick_fracture::recipe::Recipe;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Context, Mesh};
use greenstick_wood::stem::{
    CarriedShell, CrossSection, StemError, StemLocation, StemOptions, find_stem,
};

/// Cracks on their way into a stem.
pub(crate) struct Cracks {
    plan: CrackPlan,
    /// Whether they open at a sawn end instead of at the break.
    pub sawn: bool,
    /// What they take away, m³.
    pub volume: f64,
    /// The sawn end that was cracked.
    pub end: Option<SawnEnd>,
    /// Whether the end was sawn straight first.
    sawn_off: bool,
    /// Triangles of other shells that fell with what was sawn off.
    fallen: usize,
    faces: Vec<(&'static str, Grooved)>,
}

impl Cracks {
    /// The cracks that a recipe asks for, if any.
    pub(crate) fn plan(recipe: &Recipe, notes: &mut Vec<String>) -> Result<Option<Self>, Error> {
        if recipe.cracks.is_empty() {
            return Ok(None);
        }
        let shrinkage = recipe.crack_shrinkage()?;
        notes.push(format!(
            "cracks open by a shrinkage of {:.1} % along the rings and {:.1} % across ({})",
            shrinkage.tangential * 100.0,
            shrinkage.radial * 100.0,
            shrinkage.basis
        ));
        let mut asked = recipe.cracks.clone();
        let moved = asked.follow_rings(recipe.face.rings);
        if moved > 0 {
            notes.push(format!(
                "{moved} tangential cracks were brought to the nearest boundary of two of the {} rings",
                recipe.face.rings
            ));
        }
        let plan = plan(
            &asked,
            (shrinkage.tangential, shrinkage.radial),
            recipe.face.seed,
        );
        Ok(Some(Cracks {
            plan,
            sawn: recipe.cracks.settings.end == CrackEnd::Sawn,
            volume: 0.0,
            end: None,
            sawn_off: false,
            fallen: 0,
            faces: Vec::new(),
        }))
    }

    /// Opens the cracks in both faces of a break.
    pub(crate) fn open_break(
        &mut self,
        prepared: &Prepared,
        model: &mut Model,
        p: &BreakParameters,
        material: u32,
    ) -> Result<(), Error> {
        let made = prepared.crack_break(model, p, &self.plan, material)?;
        let scale = volume_scale(&prepared.scene.nodes[prepared.found.node]);
        self.volume = made.void * scale;
        (model.lower, model.upper) = (made.lower, made.upper);
        self.faces = vec![
            ("lower face", made.lower_face),
            ("upper face", made.upper_face),
        ];
        Ok(())
    }

    /// Opens the cracks in the far end of the stem; gives the cracked stem, to be broken at the same place.
    pub(crate) fn open_end(
        &mut self,
        prepared: Prepared,
        p: &BreakParameters,
        material: u32,
        context: &Context,
    ) -> Result<Prepared, Error> {
        let made = match prepared.crack_end(p, &self.plan, true, material) {
            Err(Error::Cut { .. } | Error::Crack(CrackError::NoEnd { .. })) => {
                self.sawn_off = true;
                prepared.saw_and_crack(p, &self.plan, material)?
            }
            made => made?,
        };
        let node = prepared.found.node;
        self.volume = made.void * volume_scale(&prepared.scene.nodes[node]);
        let stem = &prepared.found.stem;
        // A board's pith may lie outside it.
        let height = made.end.at(stem.rings.pith());
        let off = |s: &&CrossSection| (s.length - height).abs();
        let nearest = (stem.sections.iter()).min_by(|a, b| off(a).total_cmp(&off(b)));
        let middle = nearest.map_or(stem.rings.pith(), |s| s.centroid);
        let point = prepared.layers.to_world(middle.extend(made.end.at(middle)));
        let outward = stem.grain.axis().frame(stem.length).tangent;
        let reach = nearest.map_or(stem.radius, |s| {
            let far = |p: &DVec2| p.distance(s.centroid);
            s.contour.iter().map(far).fold(0.0, f64::max)
        });
        let (middle, radius) = (point, reach);
        self.end = Some(SawnEnd {
            middle,
            outward,
            radius,
        });
        // The break stays clear of the cracks, beside which the wood is thin.
        let clear = height - made.face.deepest - CLEAR * stem.radius;
        self.faces = vec![("sawn end", made.face)];
        let fallen = if self.sawn_off {
            fallen(&prepared, height, context)?
        } else {
            Vec::new()
        };
        self.fallen = fallen.iter().map(|shell| shell.triangles.len()).sum();
        let mut prepared = cracked(prepared, made.stem, &fallen);
        let stem = &mut prepared.found.stem;
        stem.usable.1 = stem.usable.1.min(clear);
        Ok(prepared)
    }

    /// What was made of the plan, a sentence each.
    pub(crate) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.sawn_off {
            let mut note = "the end is no face that cracks can be cut into: it was sawn off straight first, and what was \
                            sawn off is left out"
                .to_owned();
            if self.fallen > 0 {
                note += &format!(", with {} triangles of what hangs on it", self.fallen);
            }
            notes.push(note);
        }
        for (name, face) in &self.faces {
            notes.push(format!(
                "{name}: {} cracks, the widest {:.2} mm, the deepest {:.1} mm",
                face.cracks,
                face.widest * 1e3,
                face.deepest * 1e3
            ));
            let left = face.outside + face.undrawn + face.closed;
            if left > 0 {
                notes.push(format!("{name}: {left} cracks were left out: closed, outside the wood, or too fine to draw"));
            }
            if face.limited > 0 {
                notes.push(format!(
                    "{name}: cracks were made shallower at {} places to stay in the stem",
                    face.limited
                ));
            }
        }
        if self.plan.shortened + self.plan.skipped > 0 {
            notes.push(format!(
                "{} cracks were shortened and {} left out so that none cross",
                self.plan.shortened, self.plan.skipped
            ));
        }
        notes
    }
}

/// A cracked end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SawnEnd {
    /// Its middle, m.
    pub middle: DVec3,
    /// The direction it looks to.
    pub outward: DVec3,
    /// Greatest distance of the section's outline from the middle, m.
    pub radius: f64,
}

/// Wood between the ground of the deepest crack of an end and the highest point of a break, in radii.
const CLEAR: f64 = 0.05;

/// What was prepared with `stem` in place of the stem's shell, and without the shells that have `fallen`.
fn cracked(prepared: Prepared, mut stem: Mesh, fallen: &[CarriedShell]) -> Prepared {
    let (mut scene, mut found) = (prepared.scene, prepared.found);
    let node = found.node;
    let count = stem.triangles.len() as u32;
    let mut gone: Vec<Vec<bool>> = (scene.nodes.iter())
        .map(|n| vec![false; n.mesh.triangles.len()])
        .collect();
    let ours = CarriedShell {
        node,
        triangles: std::mem::take(&mut found.shell),
    };
    for CarriedShell { node: i, triangles } in fallen.iter().chain([&ours]) {
        triangles.iter().for_each(|&t| gone[*i][t as usize] = true);
    }
    found.carried.retain(|shell| !fallen.contains(shell));
    for CarriedShell { node: i, triangles } in &mut found.carried {
        // Numbers of the triangles that stay, behind those of the stem.
        let mut next = if *i == node { count } else { 0 };
        let number = |gone: &bool| {
            next += u32::from(!gone);
            next.wrapping_sub(1)
        };
        let numbers: Vec<u32> = gone[*i].iter().map(number).collect();
        triangles.iter_mut().for_each(|t| *t = numbers[*t as usize]);
    }
    let on_limb = |t: &[u32; 3]| {
        let grain = stem.attributes.get("_GRAIN");
        grain.is_some_and(|g| {
            t.iter()
                .all(|&v| g.at(v as usize).iter().any(|x| *x != 0.0))
        })
    };
    found.limb = (0..count)
        .filter(|&t| on_limb(&stem.triangles[t as usize]))
        .collect();
    found.shell = (0..count).collect();
    for (i, gone) in gone.iter().enumerate() {
        let rest = (0..gone.len()).filter(|&t| !gone[t]);
        let mesh = scene.nodes[i].mesh_mut();
        if i == node {
            append(&mut stem, &part_of(mesh, rest));
        } else if gone.contains(&true) {
            *mesh = part_of(mesh, rest);
        }
    }
    scene.nodes[node].mesh = stem.into();
    laid(scene, found, prepared.layers)
}

/// Shells that hang on the stem beyond a saw that cuts at a length along it, m.
fn fallen(prepared: &Prepared, level: f64, context: &Context) -> Result<Vec<CarriedShell>, Error> {
    let meshes = in_world(&prepared.scene);
    let ours = &prepared.found;
    let stem = &ours.stem;
    let options = StemOptions {
        kind: Some(stem.kind),
        ..StemOptions::default()
    };
    // Too near to the end or to other wood no stem is found; nothing hangs on the free wood before the saw.
    let mut back = 0.0;
    while level - back > stem.location {
        let point = stem.grain.axis().frame(level - back).origin;
        match find_stem(&meshes, &StemLocation::Point(point), &options, context) {
            Ok(found) if found.node == ours.node && found.shell.first() == ours.shell.first() => {
                return Ok(found.carried);
            }
            Err(error @ StemError::Cancelled(_)) => return Err(error.into()),
            _ => back += STEP_BACK * stem.radius,
        }
    }
    Ok(Vec::new())
}

/// Step in which the stem is looked for back from the saw, in radii.
const STEP_BACK: f64 = 0.25;

/// Adds the triangles of `other` to `mesh`; attributes that only one has are filled with zeros.
fn append(mesh: &mut Mesh, other: &Mesh) {
    if other.triangles.is_empty() {
        return;
    }
    let (first, more) = (mesh.positions.len(), other.positions.len());
    mesh.positions.extend(&other.positions);
    mesh.triangles
        .extend(other.triangles.iter().map(|t| t.map(|v| v + first as u32)));
    let triangles = mesh.triangles.len();
    mesh.materials
        .resize(triangles - other.triangles.len(), NO_MATERIAL);
    mesh.materials.extend(&other.materials);
    mesh.materials.resize(triangles, NO_MATERIAL);
    for (name, attribute) in &mut mesh.attributes {
        match other
            .attributes
            .get(name)
            .filter(|o| o.width == attribute.width)
        {
            Some(o) => attribute.data.extend(&o.data),
            None => attribute.data.resize((first + more) * attribute.width, 0.0),
        }
    }
}
