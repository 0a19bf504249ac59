//! The cracks of a recipe: planned by species and moisture, opened at the break or at a sawn end, reported.

use crate::breaking::volume_scale;
use crate::model::Model;
use crate::{Error, Prepared, prepare};
use glam::DVec3;
use greenstick_fracture::cracks::{CrackError, CrackPlan, Grooved, plan};
use greenstick_fracture::parameters::{BreakParameters, CrackEnd};
use greenstick_fracture::recipe::Recipe;
use greenstick_geometry::Context;
use greenstick_wood::stem::{Place, StemOptions};

/// Cracks on their way into a stem.
pub(crate) struct Cracks {
    plan: CrackPlan,
    /// Whether they open at a sawn end instead of at the break.
    pub sawn: bool,
    /// What they take away, m³.
    pub volume: f64,
    /// Middle of the sawn end (m) and the direction it looks to.
    pub end: Option<(DVec3, DVec3)>,
    /// Whether the end was sawn straight first.
    sawn_off: bool,
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

    /// Opens the cracks in the far end of the stem; gives the cracked stem, found again at the same place.
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
        let middle = stem.rings.pith();
        let point = prepared.layers.to_world(middle.extend(made.end.at(middle)));
        self.end = Some((point, stem.grain.axis().frame(stem.length).tangent));
        self.faces = vec![("sawn end", made.face)];
        let place = Place::Point(stem.grain.axis().frame(stem.place).origin);
        let options = StemOptions {
            kind: Some(stem.kind),
            ..StemOptions::default()
        };
        let mut scene = prepared.scene;
        let mut cracked = made.stem;
        // What else the node holds stays beside the cracked stem.
        let mut ours = vec![false; scene.nodes[node].mesh.triangles.len()];
        prepared
            .found
            .shell
            .iter()
            .for_each(|&t| ours[t as usize] = true);
        let rest = crate::breaking::part_of(
            &scene.nodes[node].mesh,
            (0..ours.len()).filter(|&t| !ours[t]),
        );
        append(&mut cracked, &rest);
        scene.nodes[node].mesh = cracked;
        prepare(scene, &place, &options, context)
    }

    /// What was made of the plan, a sentence each.
    pub(crate) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.sawn_off {
            notes.push(
                "the end is no face that cracks can be cut into: it was sawn off straight first, and what was sawn off is left out"
                    .to_owned(),
            );
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

/// Adds the triangles of `other` to `mesh`; attributes that only one has are filled with zeros.
fn append(mesh: &mut greenstick_geometry::Mesh, other: &greenstick_geometry::Mesh) {
    if other.triangles.is_empty() {
        return;
    }
    let (first, more) = (mesh.positions.len(), other.positions.len());
    mesh.positions.extend(&other.positions);
    mesh.triangles
        .extend(other.triangles.iter().map(|t| t.map(|v| v + first as u32)));
    let triangles = mesh.triangles.len();
    mesh.materials.resize(
        triangles - other.triangles.len(),
        greenstick_geometry::mesh::NO_MATERIAL,
    );
    mesh.materials.extend(&other.materials);
    mesh.materials
        .resize(triangles, greenstick_geometry::mesh::NO_MATERIAL);
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
