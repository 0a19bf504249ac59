//! What is worked out of a scene that is drawn, once, so that the pointer finds its place on it at once. A scene that is finished brings
//! it along; of one that is drawn early it is worked out when the pointer first asks, as most are gone before it does.

use super::crack_face::face_heights;
use super::meshes::{Box3, DrawnScene, Survey};
use glam::Vec3;
use rayon::iter::ParallelIterator;
use rayon::slice::ParallelSlice;

/// Triangles in a box: with fewer, boxes take long to look through, with more, what is in them.
const TRIANGLES: usize = 128;
/// Part of its size by which a box is larger than what is in it: a ray along its side is not missed by rounding.
const MARGIN: f32 = 1e-4;

impl DrawnScene {
    /// The boxes of its triangles and the heights of its faces, which are worked out the first time.
    pub fn surveyed(&self) -> &Survey {
        self.survey.get_or_init(|| self.survey_anew())
    }

    fn survey_anew(&self) -> Survey {
        let corners = self.indices.par_chunks(3 * TRIANGLES);
        let of = |corners: &[u32]| {
            let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            let points = corners
                .iter()
                .map(|&i| Vec3::from_array(self.vertices[i as usize].position));
            let (low, high) = points.fold(start, |(a, b), p| (a.min(p), b.max(p)));
            let margin = Vec3::splat(MARGIN * (high - low).max_element());
            [(low - margin).to_array(), (high + margin).to_array()]
        };
        let faces = (0..self.breaks.len()).map(|number| face_heights(self, number));
        Survey {
            boxes: corners.map(of).collect(),
            faces: faces.collect(),
        }
    }

    /// The corners of the triangles that a ray (origin and direction) may meet, in their order.
    pub fn along(&self, (origin, direction): (Vec3, Vec3)) -> impl Iterator<Item = &[u32; 3]> {
        let chunks = self.indices.chunks(3 * TRIANGLES);
        let near = (chunks.zip(&self.surveyed().boxes))
            .filter(move |(_, around)| meets(around, origin, direction.recip()));
        near.flat_map(|(corners, _)| corners.as_chunks::<3>().0)
    }
}

/// Whether a ray, with the reciprocals of its direction, meets a box.
fn meets(of: &Box3, origin: Vec3, reciprocal: Vec3) -> bool {
    let [a, b] = of.map(|p| (Vec3::from_array(p) - origin) * reciprocal);
    // Along a side of the box 0 · ∞ is no number, which the least and the greatest pass over.
    let (low, high) = (a.min(b), a.max(b));
    let near = low.to_array().into_iter().fold(0.0, f32::max);
    let far = high.to_array().into_iter().fold(f32::INFINITY, f32::min);
    near <= far
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::pick::pick;
    use greenstick::geometry::{Node, Scene};
    use greenstick::wood::primitive::cylinder;
    use std::sync::OnceLock;

    #[test]
    fn what_is_picked_is_the_same_with_boxes_and_without() {
        let at = glam::DAffine3::IDENTITY;
        let scene = Scene {
            nodes: vec![Node::new("a", at, cylinder(0.02, 0.3, 512))],
            ..Scene::default()
        };
        let surveyed = DrawnScene::unbroken(&scene);
        let boxes = surveyed.surveyed().boxes.len();
        assert!(boxes > 8);
        // In boxes that hold everything every triangle is looked at.
        let mut plain = surveyed.clone();
        plain.survey = OnceLock::from(Survey {
            boxes: vec![[[-9.0; 3], [9.0; 3]]; boxes],
            faces: Vec::new(),
        });
        let mut met = 0;
        for k in 0..400 {
            let turn = |n: f32| {
                Vec3::new(
                    (k as f32 * n).sin(),
                    (k as f32 * n * 1.3).cos(),
                    (k as f32 * n * 0.7).sin(),
                )
            };
            // Every fourth ray runs along an axis.
            let direction = match k % 4 {
                0 => Vec3::AXES[k / 4 % 3],
                _ => turn(0.37).normalize(),
            };
            let ray = (turn(0.11) * 0.02 - direction, direction);
            let found = pick(&plain, ray, None);
            assert_eq!(found, pick(&surveyed, ray, None), "{ray:?}");
            met += usize::from(found.is_some());
        }
        assert!(met > 200, "{met}");
    }
}
