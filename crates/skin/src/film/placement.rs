//! Where films and stills have the wood. They have y up.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use greenstick_fibre::scene::{Scene as Setting, StemChoice};
use greenstick_geometry::Pose;
use std::f64::consts::FRAC_PI_2;

/// Where films and stills have the wood.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placement {
    /// The pose of the scene's axes in the film's.
    film_from_scene: Pose,
    /// The map from the stem's world, that of the mesh that was simulated, to the film's.
    pub film_from_stem: DAffine3,
}

/// Returns the rotation from z up to y up.
fn upright() -> DQuat {
    DQuat::from_rotation_x(-FRAC_PI_2)
}

impl Placement {
    /// An input that stands as it grew is where its mesh is, turned if that has z up; another stem stands as the scene says, in whose axes
    /// a level stem has those of `level`.
    pub fn as_it_stands(scene: &Setting, scene_from_stem: DAffine3, level: DMat3) -> Self {
        if (scene.stem.kind, scene.stem.inclination) != (StemChoice::Input, None) {
            let level = DQuat::from_mat3(&level).conjugate();
            return Self::turned(upright() * level, scene_from_stem);
        }
        let standing = match scene.stem.up_of_input() == DVec3::Z {
            true => upright(),
            false => DQuat::IDENTITY,
        };
        // Rigid, so that its inverse is.
        let back = scene_from_stem.inverse();
        let rotation = (standing * DQuat::from_mat3(&back.matrix3)).normalize();
        Placement {
            film_from_scene: Pose {
                translation: standing * back.translation,
                rotation,
            },
            film_from_stem: DAffine3::from_quat(standing),
        }
    }

    /// The stem lies along x, as in the scene.
    pub fn along_x(scene_from_stem: DAffine3) -> Self {
        Self::turned(upright(), scene_from_stem)
    }

    /// The scene's axes turned about their origin.
    fn turned(rotation: DQuat, scene_from_stem: DAffine3) -> Self {
        Placement {
            film_from_scene: Pose {
                translation: DVec3::ZERO,
                rotation,
            },
            film_from_stem: DAffine3::from_quat(rotation) * scene_from_stem,
        }
    }

    /// Returns the film's pose of what has this one in the scene.
    pub fn pose(&self, pose: Pose) -> Pose {
        let Pose {
            translation,
            rotation,
        } = self.film_from_scene;
        Pose {
            translation: rotation * pose.translation + translation,
            rotation: (rotation * pose.rotation).normalize(),
        }
    }

    /// Returns the film's point of one in the scene, m.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.film_from_scene.rotation * point + self.film_from_scene.translation
    }

    /// Returns the film's direction of one in the scene.
    pub fn direction(&self, direction: DVec3) -> DVec3 {
        self.film_from_scene.rotation * direction
    }

    /// The map from the scene to the film.
    pub fn map(&self) -> DAffine3 {
        self.film_from_scene.affine()
    }
}
