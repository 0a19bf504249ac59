//! Shapes of bodies, and distances from them. Distances are those of `parry3d-f64`, whose vectors belong to another release
//! of glam and are therefore passed as arrays.

use super::error::BodyError;
use glam::{DMat3, DQuat, DVec3};
use parry3d_f64::math::{Pose as ParryPose, Rotation, Vector};
use parry3d_f64::query;
use parry3d_f64::shape::{SharedShape, TriMeshFlags};
use serde::{Deserialize, Serialize};

/// The shape of a body, in its own coordinates (m).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A half-space whose surface passes through the origin.
    HalfSpace {
        /// Normal out of the body; any length above 0.
        normal: DVec3,
    },
    /// A box about the origin.
    Box {
        /// Half of its sides, m.
        half: DVec3,
    },
    /// A ball about the origin.
    Sphere {
        /// Radius, m.
        radius: f64,
    },
    /// A cylinder with round ends about the origin, along y.
    Capsule {
        /// Half the length between the centres of its ends, m.
        half_length: f64,
        /// Radius, m.
        radius: f64,
    },
    /// A cylinder about the origin, along y.
    Cylinder {
        /// Half its length, m.
        half_length: f64,
        /// Radius, m.
        radius: f64,
    },
    /// The convex hull of points.
    Hull {
        /// The points, m.
        points: Vec<DVec3>,
    },
    /// A closed triangle mesh whose triangles are counter-clockwise seen from outside.
    Mesh {
        /// Vertices, m.
        points: Vec<DVec3>,
        /// Triangles.
        triangles: Vec<[u32; 3]>,
    },
}

/// The surface of a shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Vertices, m.
    pub points: Vec<DVec3>,
    /// Triangles, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Mass, centre and inertia of a shape of some density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Inertia {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the shape's coordinates, m.
    pub centre: DVec3,
    /// Inverse of the inertia about the centre, 1/(kg m²), along the shape's axes.
    pub inverse: DMat3,
    /// The inertia itself, kg m².
    pub tensor: DMat3,
}

/// A shape prepared for queries.
#[derive(Clone)]
pub(super) struct Solid {
    shared: SharedShape,
    /// Corners of its bounding box; infinite for a half-space.
    pub low: DVec3,
    pub high: DVec3,
}

pub(super) fn to_parry(v: DVec3) -> Vector {
    Vector::from_array(v.to_array())
}

pub(super) fn from_parry(v: Vector) -> DVec3 {
    DVec3::from_array(v.to_array())
}

pub(super) fn pose(position: DVec3, rotation: DQuat) -> ParryPose {
    let rotation = Rotation::from_array(rotation.to_array());
    ParryPose::from_parts(to_parry(position), rotation)
}

/// The closest points of two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ClosestPoints {
    /// The point midway between them, m.
    pub point: DVec3,
    /// Unit direction from the first to the second.
    pub normal: DVec3,
    /// Depth of the overlap, m; negative for a gap.
    pub depth: f64,
}

impl Shape {
    /// Returns the shape's name in messages.
    pub fn name(&self) -> &'static str {
        match self {
            Shape::HalfSpace { .. } => "half-space",
            Shape::Box { .. } => "box",
            Shape::Sphere { .. } => "sphere",
            Shape::Capsule { .. } => "capsule",
            Shape::Cylinder { .. } => "cylinder",
            Shape::Hull { .. } => "hull",
            Shape::Mesh { .. } => "mesh",
        }
    }

    fn sizes(&self) -> Vec<(&'static str, f64)> {
        match self {
            Shape::HalfSpace { normal } => vec![("length of the normal", normal.length())],
            Shape::Box { half } => half.to_array().map(|h| ("half side (m)", h)).to_vec(),
            Shape::Sphere { radius } => vec![("radius (m)", *radius)],
            Shape::Capsule {
                half_length,
                radius,
            }
            | Shape::Cylinder {
                half_length,
                radius,
            } => vec![("half length (m)", *half_length), ("radius (m)", *radius)],
            Shape::Hull { .. } | Shape::Mesh { .. } => Vec::new(),
        }
    }

    /// Returns the surface of a hull or mesh, about the centre of mass where `free`, else about its origin; `None` for other
    /// shapes.
    ///
    /// # Errors
    /// [`BodyError`] where the shape is no solid; it is then that of body `body`.
    pub fn surface(&self, body: usize, free: bool) -> Result<Option<Surface>, BodyError> {
        let (points, triangles) = match self {
            Shape::Mesh { points, triangles } => (points.clone(), triangles.clone()),
            Shape::Hull { points } => {
                let points: Vec<Vector> = points.iter().copied().map(to_parry).collect();
                let hull = parry3d_f64::transformation::try_convex_hull(&points);
                let (points, triangles) = hull.map_err(|e| BodyError::Shape {
                    body,
                    shape: self.name(),
                    problem: e.to_string(),
                })?;
                (points.into_iter().map(from_parry).collect(), triangles)
            }
            _ => return Ok(None),
        };
        let centre = if free {
            self.build(body)?.inertia(1.0).centre
        } else {
            DVec3::ZERO
        };
        let points = points.into_iter().map(|p| p - centre).collect();
        Ok(Some(Surface { points, triangles }))
    }

    /// Prepares the shape for queries.
    pub(super) fn build(&self, body: usize) -> Result<Solid, BodyError> {
        for (what, value) in self.sizes() {
            if !(value > 0.0 && value.is_finite()) {
                return Err(BodyError::Value {
                    body,
                    what,
                    value,
                    right: "above 0 and finite",
                });
            }
        }
        let bad = |problem: String| BodyError::Shape {
            body,
            shape: self.name(),
            problem,
        };
        let shared = match self {
            Shape::HalfSpace { normal } => SharedShape::halfspace(to_parry(normal.normalize())),
            Shape::Box { half } => SharedShape::cuboid(half.x, half.y, half.z),
            Shape::Sphere { radius } => SharedShape::ball(*radius),
            Shape::Capsule {
                half_length,
                radius,
            } => SharedShape::capsule_y(*half_length, *radius),
            Shape::Cylinder {
                half_length,
                radius,
            } => SharedShape::cylinder(*half_length, *radius),
            Shape::Hull { points } => {
                let points = finite(points).map_err(bad)?;
                if flat(&points) {
                    return Err(bad("its points lie in a plane, so it has no volume".into()));
                }
                SharedShape::convex_hull(&points)
                    .ok_or_else(|| bad("its points have no hull with a volume".into()))?
            }
            Shape::Mesh { points, triangles } => {
                let points = finite(points).map_err(bad)?;
                if let Some(t) = triangles
                    .iter()
                    .position(|t| t.iter().any(|&v| v as usize >= points.len()))
                {
                    return Err(bad(format!(
                        "triangle {t} names a vertex that does not exist"
                    )));
                }
                let open = open_edges(triangles);
                if open > 0 {
                    return Err(bad(format!(
                        "{open} of its edges do not lie between exactly two triangles; it must be closed"
                    )));
                }
                let flags = TriMeshFlags::ORIENTED;
                SharedShape::trimesh_with_flags(points, triangles.clone(), flags)
                    .map_err(|e| bad(e.to_string()))?
            }
        };
        let (low, high) = if let Shape::HalfSpace { .. } = self {
            (DVec3::NEG_INFINITY, DVec3::INFINITY)
        } else {
            let bounds = shared.compute_local_aabb();
            (from_parry(bounds.mins), from_parry(bounds.maxs))
        };
        Ok(Solid { shared, low, high })
    }
}

fn finite(points: &[DVec3]) -> Result<Vec<Vector>, String> {
    if points.len() < 4 {
        return Err(format!("it has {} points; it needs 4", points.len()));
    }
    match points.iter().position(|p| !p.is_finite()) {
        Some(i) => Err(format!("point {i} is {}; it must be finite", points[i])),
        None => Ok(points.iter().copied().map(to_parry).collect()),
    }
}

/// Whether all points lie in one plane, up to rounding.
fn flat(points: &[Vector]) -> bool {
    let first = from_parry(points[0]);
    let arms: Vec<DVec3> = points.iter().map(|p| from_parry(*p) - first).collect();
    let longest = |by: &dyn Fn(DVec3) -> f64| arms.iter().copied().map(by).fold(0.0, f64::max);
    let size = longest(&|a| a.length());
    let Some(&along) = arms.iter().max_by(|a, b| a.length().total_cmp(&b.length())) else {
        return true;
    };
    let Some(&side) = arms
        .iter()
        .max_by(|a, b| a.cross(along).length().total_cmp(&b.cross(along).length()))
    else {
        return true;
    };
    let normal = along.cross(side).normalize_or_zero();
    longest(&|a| a.dot(normal).abs()) <= 1e-9 * size
}

/// Returns the number of edges that do not lie between two triangles in opposite directions.
fn open_edges(triangles: &[[u32; 3]]) -> usize {
    let mut edges: Vec<(u32, u32)> = triangles
        .iter()
        .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
        .collect();
    edges.sort_unstable();
    let twice = edges.windows(2).filter(|p| p[0] == p[1]).count();
    let lonely = edges
        .iter()
        .filter(|(a, b)| edges.binary_search(&(*b, *a)).is_err());
    twice + lonely.count()
}

impl Solid {
    /// Returns the signed distance (m, negative inside) of a point from the surface and the unit direction out of it, in the
    /// shape's coordinates; `None` where the direction is undefined.
    pub fn distance(&self, p: DVec3) -> Option<(f64, DVec3)> {
        let near = self.shared.project_local_point(to_parry(p), false);
        let away = p - from_parry(near.point);
        let distance = away.length();
        let normal = away.try_normalize()?;
        Some(if near.is_inside {
            (-distance, -normal)
        } else {
            (distance, normal)
        })
    }

    /// Whether `p` is within `reach` (m) of the bounding box.
    pub fn is_near(&self, p: DVec3, reach: f64) -> bool {
        (p - self.low).min_element() >= -reach && (self.high - p).min_element() >= -reach
    }

    /// Returns the largest distance of its points from `centre`, m; infinite for a half-space.
    pub fn extent(&self, centre: DVec3) -> f64 {
        (self.high - centre).max(centre - self.low).length()
    }

    /// Returns mass and inertia at a density (kg/m³).
    pub fn inertia(&self, density: f64) -> Inertia {
        let m = self.shared.mass_properties(density);
        let from = |m: parry3d_f64::math::Matrix| DMat3::from_cols_array(&m.to_cols_array());
        Inertia {
            mass: m.mass(),
            centre: from_parry(m.local_com),
            inverse: from(m.reconstruct_inverse_inertia_matrix()),
            tensor: from(m.reconstruct_inertia_matrix()),
        }
    }

    /// Returns the closest points of this shape and another, each at its pose, where they are closer than `distance` (m).
    pub(crate) fn closest_points(
        &self,
        pose: &ParryPose,
        other: &Solid,
        other_pose: &ParryPose,
        distance: f64,
    ) -> Option<ClosestPoints> {
        let (one, two) = (&*self.shared, &*other.shared);
        let found = query::contact(pose, one, other_pose, two, distance).ok()??;
        let (a, b) = (from_parry(found.point1), from_parry(found.point2));
        let normal = from_parry(found.normal1);
        (normal.is_finite() && a.is_finite() && b.is_finite()).then_some(ClosestPoints {
            point: 0.5 * (a + b),
            normal,
            depth: -found.dist,
        })
    }
}
