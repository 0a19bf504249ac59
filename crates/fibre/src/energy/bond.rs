//! Bonds between rods: a transverse spring and a shear spring (Sutherland 2012 §3.3.2). Forces are the exact gradients and
//! therefore sum to zero, which the thesis's do not.
//!
//! The thesis measures opening by the length of d = x − c and shear by the angle between d and the edge. A bond that slips far
//! becomes longer without opening, and the more so the nearer the rods are. Here opening is the distance across the edge
//! and slip the way along it: the same for small strains, ½ k_t/d₀ (h − h₀)² and S/d₀² (s − s₀)².

use super::hessian::{ElementHessian, HessianKind};
use super::quadratic::{Jet, hessian_over_vertices};
use crate::rod_bundle::RodBundle;
use crate::state::State;
use glam::DVec3;

/// Returns the edge e = y₁ − y₀ and d = x − c of a bond.
pub(crate) fn vectors(bundle: &RodBundle, state: &State, bond: usize) -> (DVec3, DVec3) {
    let j = bundle.bonds.edge[bond] as usize;
    let (y0, e) = (state.position.get(j), state.edge(j));
    let x = state.position.get(bundle.bonds.vertex[bond] as usize);
    (e, x - (y0 + e * bundle.bonds.t[bond]))
}

/// How far a bond is open, across the other rod's edge, and how far it has slipped along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BondStrain {
    /// The bond's distance from the edge less that at rest, m.
    pub opening: f64,
    /// The way along the edge, m.
    pub slip: f64,
}

/// Stiffness of a bond, N/m, and its geometry at rest, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BondSpring {
    /// Against opening: k_t/d₀.
    pub opening: f64,
    /// Against being closed further than at rest; damage leaves it.
    pub closing: f64,
    /// Against slip: 2 S/d₀².
    pub slip: f64,
    /// Distance across the edge at rest.
    pub rest_opening: f64,
    /// Place along the edge at rest.
    pub rest_slip: f64,
}

impl BondSpring {
    /// Returns the spring of a bond, softened as far as it is damaged.
    pub fn new(bundle: &RodBundle, bond: usize) -> Self {
        BondSpring::intact(bundle, bond).damaged(bundle.bonds.damage[bond])
    }

    /// Returns this intact spring softened by a damage.
    pub fn damaged(self, damage: f64) -> Self {
        BondSpring {
            opening: self.opening * (1.0 - damage),
            slip: self.slip * (1.0 - damage),
            ..self
        }
    }

    /// Returns the spring of a bond without its damage.
    pub fn intact(bundle: &RodBundle, bond: usize) -> Self {
        let b = &bundle.bonds;
        let (distance, cosine) = (b.distance[bond], b.rest_cosine[bond]);
        let across = b.transverse[bond] / distance;
        BondSpring {
            opening: across,
            closing: across,
            slip: 2.0 * b.shear[bond] / (distance * distance),
            rest_opening: distance * (1.0 - cosine * cosine).max(0.0).sqrt(),
            rest_slip: distance * cosine,
        }
    }

    /// Returns the stiffness across the edge at an opening, N/m.
    pub fn across(&self, opening: f64) -> f64 {
        if opening > 0.0 {
            self.opening
        } else {
            self.closing
        }
    }

    /// Returns the strain of a bond whose edge is `e` and whose vector from it is `d`.
    pub fn strain(&self, e: DVec3, d: DVec3) -> BondStrain {
        let along = e.dot(d) / e.length();
        let across = (d.length_squared() - along * along).max(0.0).sqrt();
        BondStrain {
            opening: across - self.rest_opening,
            slip: along - self.rest_slip,
        }
    }

    /// Returns the energies of opening or closing and of slip, J.
    pub fn energy(&self, strain: BondStrain) -> (f64, f64) {
        let BondStrain { opening, slip } = strain;
        (
            0.5 * self.across(opening) * opening * opening,
            0.5 * self.slip * slip * slip,
        )
    }
}

/// Returns the transverse and the shear energy of a bond, J.
pub(crate) fn energy(bundle: &RodBundle, state: &State, bond: usize) -> (f64, f64) {
    let (e, d) = vectors(bundle, state, bond);
    let spring = BondSpring::new(bundle, bond);
    spring.energy(spring.strain(e, d))
}

/// Returns the forces on x, y₀ and y₁, N.
pub(crate) fn forces(bundle: &RodBundle, state: &State, bond: usize) -> (DVec3, DVec3, DVec3) {
    let (e, d) = vectors(bundle, state, bond);
    let spring = BondSpring::new(bundle, bond);
    let BondStrain { opening, slip } = spring.strain(e, d);
    let (pull, shear) = (spring.across(opening) * opening, spring.slip * slip);
    let length = e.length();
    let direction = e / length;
    let along = direction.dot(d);
    let normal = d - direction * along;
    let across = normal.length();
    let normal = normal / across;
    let on_vertex = -(normal * pull + direction * shear);
    let turn = normal * ((pull * along - shear * across) / length);
    let t = bundle.bonds.t[bond];
    (
        on_vertex,
        on_vertex * (t - 1.0) - turn,
        on_vertex * -t + turn,
    )
}

/// The forces of a bond across and along the edge, N, and their derivatives with respect to opening and slip, N/m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BondTangent {
    pub pull: f64,
    pub shear: f64,
    /// Of the first with respect to opening.
    pub opening: f64,
    /// Of the second with respect to slip.
    pub slip: f64,
    /// Of either with respect to the other.
    pub mixed: f64,
}

impl BondTangent {
    /// Returns that of a spring whose stiffness stays.
    pub fn elastic(spring: &BondSpring, strain: BondStrain) -> Self {
        let (opening, slip) = (spring.across(strain.opening), spring.slip);
        BondTangent {
            pull: opening * strain.opening,
            shear: slip * strain.slip,
            opening,
            slip,
            mixed: 0.0,
        }
    }

    /// Returns this tangent mixed with a part, from 0 to 1, of another at the same forces.
    pub fn mixed_with(&self, other: &BondTangent, part: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * part;
        BondTangent {
            opening: mix(self.opening, other.opening),
            slip: mix(self.slip, other.slip),
            mixed: mix(self.mixed, other.mixed),
            ..*self
        }
    }
}

/// Returns the Hessian over x, y₀ and y₁.
pub(crate) fn hessian(
    bundle: &RodBundle,
    state: &State,
    bond: usize,
    kind: HessianKind,
) -> ElementHessian {
    let (e, d) = vectors(bundle, state, bond);
    let spring = BondSpring::new(bundle, bond);
    let tangent = BondTangent::elastic(&spring, spring.strain(e, d));
    hessian_of_tangent(bundle, state, bond, &tangent, kind)
}

/// Returns the derivatives of the forces on x, y₀ and y₁ of a bond with a tangent.
pub(crate) fn hessian_of_tangent(
    bundle: &RodBundle,
    state: &State,
    bond: usize,
    tangent: &BondTangent,
    kind: HessianKind,
) -> ElementHessian {
    let (e, d) = vectors(bundle, state, bond);
    let (across, along, mixed) = (tangent.opening, tangent.slip, tangent.mixed);
    // The forces, which only the exact Hessian has.
    let exact = f64::from(u8::from(kind == HessianKind::Exact));
    let (pull, shear) = (exact * tangent.pull, exact * tangent.shear);
    // The distance across h = (q − r²/p)^½ and the way along s = r p^(−½).
    let (p, q, r) = (e.length_squared(), d.length_squared(), e.dot(d));
    let h = (q - r * r / p).max(0.0).sqrt();
    let [hp, hq, hr] = [0.5 * r * r / (p * p), 0.5, -r / p].map(|v| v / h);
    let second = |ab: f64, a: f64, b: f64| ab / h - a * b / h;
    let root = 1.0 / p.sqrt();
    let (sp, sr) = (-0.5 * r / p * root, root);
    let jet = Jet {
        value: 0.0,
        p: pull * hp + shear * sp,
        q: pull * hq,
        r: pull * hr + shear * sr,
        pp: across * hp * hp
            + pull * second(-r * r / (p * p * p), hp, hp)
            + along * sp * sp
            + shear * 0.75 * r / (p * p) * root
            + 2.0 * mixed * hp * sp,
        pq: across * hp * hq + pull * second(0.0, hp, hq) + mixed * sp * hq,
        pr: across * hp * hr + pull * second(r / (p * p), hp, hr) + along * sp * sr
            - shear * 0.5 / p * root
            + mixed * (hp * sr + sp * hr),
        qq: across * hq * hq + pull * second(0.0, hq, hq),
        qr: across * hq * hr + pull * second(0.0, hq, hr) + mixed * hq * sr,
        rr: across * hr * hr
            + pull * second(-1.0 / p, hr, hr)
            + along * sr * sr
            + 2.0 * mixed * hr * sr,
    };
    let b = &bundle.bonds;
    let (x, j, t) = (b.vertex[bond] as usize, b.edge[bond] as usize, b.t[bond]);
    hessian_over_vertices(
        [x, j, j + 1],
        [0.0, -1.0, 1.0],
        [1.0, t - 1.0, -t],
        jet.hessians(e, d),
    )
}
