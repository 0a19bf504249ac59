//! Bending about a natural curvature, and twist, in material frames (Bergou 2010; gradients of its appendix).

use super::hessian::{ElementHessian, MAX_ELEMENT_DOFS};
use crate::material_frame;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use glam::DVec3;

/// Derivatives of a quantity at a vertex with respect to its two edges and their angles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BendTwistGradient {
    /// With respect to e₋.
    pub before: DVec3,
    /// With respect to e₊.
    pub after: DVec3,
    /// With respect to the angle of e₋.
    pub angle_before: f64,
    /// With respect to the angle of e₊.
    pub angle_after: f64,
}

impl BendTwistGradient {
    pub(crate) const ZERO: BendTwistGradient = BendTwistGradient {
        before: DVec3::ZERO,
        after: DVec3::ZERO,
        angle_before: 0.0,
        angle_after: 0.0,
    };
}

/// The strains κ₁, κ₂ and twist m at a vertex, with their derivatives.
struct Strains {
    value: [f64; 3],
    gradient: [BendTwistGradient; 3],
    /// Stiffness of each: 2α/l, 2α/l, 2β/l.
    stiffness: [f64; 3],
    natural: [f64; 3],
}

fn frame(state: &State, edge: usize) -> (DVec3, DVec3) {
    let t = state.tangent.get(edge);
    (
        t,
        material_frame::rotate_director(state.director.get(edge), t, state.angle[edge]),
    )
}

/// The material frame of an edge, which the vertices at both of its ends need.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct EdgeFrame {
    /// Unit tangent and first material director.
    tangent: DVec3,
    director: DVec3,
    /// Length, m.
    length: f64,
}

impl EdgeFrame {
    pub fn new(state: &State, edge: usize) -> Self {
        let (tangent, director) = frame(state, edge);
        EdgeFrame {
            tangent,
            director,
            length: state.edge(edge).length(),
        }
    }
}

fn strains(
    bundle: &RodBundle,
    state: &State,
    i: usize,
    (before, after): (&EdgeFrame, &EdgeFrame),
) -> Strains {
    let (t0, d0, l0) = (before.tangent, before.director, before.length);
    let (t1, d1, l1) = (after.tangent, after.director, after.length);
    let chi = 1.0 + t0.dot(t1);
    let kb = t0.cross(t1) * (2.0 / chi);
    let (e0, e1) = (t0.cross(d0), t1.cross(d1));
    let [k1, k2] = [0.5 * kb.dot(e0 + e1), -0.5 * kb.dot(d0 + d1)];
    let mean = (t0 + t1) / chi;
    let (first, second) = ((d0 + d1) / chi, (e0 + e1) / chi);
    let gradient = [
        BendTwistGradient {
            before: (t1.cross(second) - mean * k1) / l0,
            after: (-t0.cross(second) - mean * k1) / l1,
            angle_before: -0.5 * kb.dot(d0),
            angle_after: -0.5 * kb.dot(d1),
        },
        BendTwistGradient {
            before: (-t1.cross(first) - mean * k2) / l0,
            after: (t0.cross(first) - mean * k2) / l1,
            angle_before: -0.5 * kb.dot(e0),
            angle_after: -0.5 * kb.dot(e1),
        },
        BendTwistGradient {
            before: kb / (2.0 * l0),
            after: kb / (2.0 * l1),
            angle_before: -1.0,
            angle_after: 1.0,
        },
    ];
    let m = state.angle[i] - state.angle[i - 1] + state.reference_twist[i];
    let l = bundle.both_lengths(i);
    let (bend, twist) = (2.0 * bundle.bend[i] / l, 2.0 * bundle.twist[i] / l);
    let natural = [
        bundle.natural_curvature[0][i],
        bundle.natural_curvature[1][i],
        0.0,
    ];
    Strains {
        value: [k1, k2, m],
        gradient,
        stiffness: [bend, bend, twist],
        natural,
    }
}

/// Returns the energies of bending α |κ − κ̄|²/l and of twist β m²/l at a vertex, J.
pub(crate) fn energy(bundle: &RodBundle, state: &State, vertex: usize) -> (f64, f64) {
    let kappa = material_frame::curvature(frame(state, vertex - 1), frame(state, vertex));
    let m = state.angle[vertex] - state.angle[vertex - 1] + state.reference_twist[vertex];
    let l = bundle.both_lengths(vertex);
    let off = [0, 1].map(|k| kappa[k] - bundle.natural_curvature[k][vertex]);
    let bend = bundle.bend[vertex] / l * (off[0] * off[0] + off[1] * off[1]);
    (bend, bundle.twist[vertex] / l * m * m)
}

/// Returns the difference of curvature from the natural curvature at a vertex, 1/m.
pub(crate) fn curvature_change(bundle: &RodBundle, state: &State, vertex: usize) -> f64 {
    let kappa = material_frame::curvature(frame(state, vertex - 1), frame(state, vertex));
    let off = [0, 1].map(|k| kappa[k] - bundle.natural_curvature[k][vertex]);
    (off[0] * off[0] + off[1] * off[1]).sqrt() / (0.5 * bundle.both_lengths(vertex))
}

/// Returns the twist at a vertex over its share of the rod's length, rad/m.
pub(crate) fn twist_rate(bundle: &RodBundle, state: &State, vertex: usize) -> f64 {
    let m = state.angle[vertex] - state.angle[vertex - 1] + state.reference_twist[vertex];
    m / (0.5 * bundle.both_lengths(vertex))
}

/// Returns the gradient of the sum of both energies ([`energy`]).
pub(crate) fn gradient(bundle: &RodBundle, state: &State, vertex: usize) -> BendTwistGradient {
    let frames = [vertex - 1, vertex].map(|j| EdgeFrame::new(state, j));
    gradient_between(bundle, state, vertex, (&frames[0], &frames[1]))
}

/// Returns the same from the frames of the edges before and after the vertex.
pub(crate) fn gradient_between(
    bundle: &RodBundle,
    state: &State,
    vertex: usize,
    frames: (&EdgeFrame, &EdgeFrame),
) -> BendTwistGradient {
    let s = strains(bundle, state, vertex, frames);
    let mut sum = BendTwistGradient::ZERO;
    for k in 0..3 {
        let stress = s.stiffness[k] * (s.value[k] - s.natural[k]);
        sum.before += s.gradient[k].before * stress;
        sum.after += s.gradient[k].after * stress;
        sum.angle_before += s.gradient[k].angle_before * stress;
        sum.angle_after += s.gradient[k].angle_after * stress;
    }
    sum
}

/// Returns the Gauss–Newton Hessian over vertices i − 1, i, i + 1 and the angles of edges i − 1, i.
pub(crate) fn hessian(bundle: &RodBundle, state: &State, vertex: usize) -> ElementHessian {
    let frames = [vertex - 1, vertex].map(|j| EdgeFrame::new(state, j));
    let s = strains(bundle, state, vertex, (&frames[0], &frames[1]));
    let mut hessian = ElementHessian {
        count: 11,
        dofs: [0; MAX_ELEMENT_DOFS],
        matrix: [[0.0; MAX_ELEMENT_DOFS]; MAX_ELEMENT_DOFS],
    };
    for k in 0..9 {
        hessian.dofs[k] = (3 * (vertex - 1) + k) as u32;
    }
    let angles = 3 * bundle.vertices() + vertex - 1;
    hessian.dofs[9] = angles as u32;
    hessian.dofs[10] = angles as u32 + 1;
    for k in 0..3 {
        let g = &s.gradient[k];
        let mut row = [0.0; MAX_ELEMENT_DOFS];
        for axis in 0..3 {
            row[axis] = -g.before[axis];
            row[3 + axis] = g.before[axis] - g.after[axis];
            row[6 + axis] = g.after[axis];
        }
        row[9] = g.angle_before;
        row[10] = g.angle_after;
        for u in 0..11 {
            for v in 0..11 {
                hessian.matrix[u][v] += s.stiffness[k] * row[u] * row[v];
            }
        }
    }
    hessian
}
