//! Stretch and bending of rods without twist, in two passes over a block of vertices: first the stress of each edge, then the
//! force on each vertex; and the explicit step of those vertices.
//!
//! With a = e₋, b = e₊, D = |ē₋||ē₊| + a·b, τ = 2/D and c = α/l, the bending energy c τ² |a×b|² has the gradients
//! X a − Y b by a and −(Y a − Z b) by b, X = 2cτ² b·b, Z = 2cτ² a·a, Y = 2cτ² a·b + cτ³ |a×b|². X, Y and Z
//! are common to both gradients, which conserves angular momentum to the last bits. One division serves the edge's length
//! and D.

use super::dispatch::for_each_level;
use super::lanes::{Lanes, PaddedVec3, WIDTH, difference, dot, load3};
use super::level::SimdLevel;

/// Vertices of a block: what the kernel holds between its passes fits into the first-level cache.
pub(crate) const BLOCK: usize = 192;
/// Entries read before the first vertex of a block.
pub(crate) const BEFORE: usize = 2;
/// Entries read behind the last vertex of a block, with padding to whole lanes.
pub(crate) const BEHIND: usize = 2 * WIDTH;
/// Entries of a block with all that it reads.
pub(crate) const BLOCK_CAPACITY: usize = (BLOCK + BEFORE + BEHIND).next_multiple_of(WIDTH);

/// Input of the rod kernel: arrays that begin [`BEFORE`] entries before the first vertex and end at least [`BEHIND`] behind
/// the last.
#[derive(Clone, Copy)]
pub(crate) struct RodInput<'a> {
    pub position: [&'a [f64]; 3],
    pub plastic_strain: &'a [f64],
    /// Stiffness, from the vertex before the first on.
    pub stiffness: &'a [Stiffness],
}

/// Stiffness at eight vertices, read as one stream.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Stiffness {
    /// 1/|ē₋|.
    pub inverse_rest: [f64; WIDTH],
    /// k of the edge before; 0 at gaps.
    pub stretch: [f64; WIDTH],
    /// |ē₋||ē₊|.
    pub rest_product: [f64; WIDTH],
    /// α/l; 0 at ends.
    pub bend: [f64; WIDTH],
}

impl Stiffness {
    pub(crate) const ZERO: Stiffness = Stiffness {
        inverse_rest: [1.0; WIDTH],
        stretch: [0.0; WIDTH],
        rest_product: [1.0; WIDTH],
        bend: [0.0; WIDTH],
    };
}

/// Masses of eight vertices and their inverses.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Masses {
    pub mass: [f64; WIDTH],
    pub inverse: [f64; WIDTH],
}

/// Vectors at the vertices of a block, with padding to whole lanes.
pub(crate) type Block = [[f64; BLOCK_CAPACITY]; 3];

/// Results of the first pass. Aligned, because stores across the end of a cache line are slow.
#[repr(align(64))]
pub(crate) struct Passes {
    /// Entry k belongs to the edge before vertex first − 1 + k.
    before: Block,
    /// Entry k belongs to the edge behind vertex first − 1 + k.
    behind: Block,
}

/// Buffers of a task.
#[repr(align(64))]
pub(crate) struct Scratch {
    pub passes: Passes,
    /// Copies of positions and plastic strains near the ends of the arrays.
    pub copies: [[f64; BLOCK_CAPACITY]; 4],
    /// Forces of bonds on the block's vertices.
    pub bond_forces: [PaddedVec3; BLOCK_CAPACITY],
    /// Forces on the block's vertices.
    pub force: Block,
}

impl Scratch {
    pub(crate) const NEW: Scratch = Scratch {
        passes: Passes {
            before: [[0.0; BLOCK_CAPACITY]; 3],
            behind: [[0.0; BLOCK_CAPACITY]; 3],
        },
        copies: [[0.0; BLOCK_CAPACITY]; 4],
        bond_forces: [PaddedVec3([0.0; 4]); BLOCK_CAPACITY],
        force: [[0.0; BLOCK_CAPACITY]; 3],
    };
}

/// Edges at eight vertices, their products, D, and the roots and quotients of them.
#[derive(Clone, Copy)]
struct Edges<L> {
    a: [L; 3],
    b: [L; 3],
    aa: L,
    bb: L,
    ab: L,
    /// |a|.
    length: L,
    /// D; 1 where there is no bending.
    denominator: L,
    /// 1/(|a| D).
    inverse: L,
}

#[inline(always)]
unsafe fn edges<L: Lanes>(position: [*const f64; 3], stiffness: &Stiffness, k: usize) -> Edges<L> {
    unsafe {
        let one = L::splat(1.0);
        let (p, q, r) = (
            load3::<L>(position, k - 1),
            load3::<L>(position, k),
            load3::<L>(position, k + 1),
        );
        let (a, b) = (difference(q, p), difference(r, q));
        let (aa, bb, ab) = (
            dot(a, a).add(L::splat(f64::MIN_POSITIVE)),
            dot(b, b),
            dot(a, b),
        );
        let denominator = L::load(stiffness.rest_product.as_ptr())
            .add(ab)
            .where_positive(L::load(stiffness.bend.as_ptr()), one);
        let length = aa.sqrt();
        Edges {
            a,
            b,
            aa,
            bb,
            ab,
            length,
            denominator,
            inverse: one.div(length.mul(denominator)),
        }
    }
}

/// The first pass: vertices from one before the first to one behind the last, each with the edge before it.
#[inline(always)]
unsafe fn stresses<L: Lanes>(input: &RodInput, count: usize, passes: &mut Passes) {
    unsafe {
        let one = L::splat(1.0);
        let position = input.position.map(<[f64]>::as_ptr);
        let groups = (count + 2).div_ceil(WIDTH);
        // Roots and divisions of the next vertices overlap with the stresses of these.
        let mut next = edges::<L>(position, input.stiffness.get_unchecked(0), 1);
        for group in 0..groups {
            let Edges {
                a,
                b,
                aa,
                bb,
                ab,
                length,
                denominator,
                inverse,
            } = next;
            let following = (group + 1).min(groups - 1);
            next = edges::<L>(
                position,
                input.stiffness.get_unchecked(following),
                1 + following * WIDTH,
            );
            let stiffness = input.stiffness.get_unchecked(group);
            let k = group * WIDTH;
            let tau = inverse.add(inverse).mul(length);
            let plastic = one.add(L::load(input.plastic_strain.as_ptr().add(k)));
            let pull = L::load(stiffness.inverse_rest.as_ptr())
                .sub(plastic.mul(inverse.mul(denominator)))
                .mul(L::load(stiffness.stretch.as_ptr()));
            let m = L::load(stiffness.bend.as_ptr()).mul(tau).mul(tau);
            let g = m.add(m);
            let square = aa.mul(bb).sub(ab.mul(ab));
            let x = g.mul(bb).add(pull);
            let y = g.mul(ab).add(m.mul(tau).mul(square));
            let z = g.mul(aa);
            for i in 0..3 {
                x.mul(a[i])
                    .sub(y.mul(b[i]))
                    .store(passes.before[i].as_mut_ptr().add(k));
                y.mul(a[i])
                    .sub(z.mul(b[i]))
                    .store(passes.behind[i].as_mut_ptr().add(k));
            }
        }
    }
}

/// Returns the force on eight vertices from entry k on: that of the edge behind less that of the edge before.
#[inline(always)]
unsafe fn on_vertices<L: Lanes>(passes: &Passes, k: usize) -> [L; 3] {
    unsafe {
        let before = [
            passes.before[0].as_ptr(),
            passes.before[1].as_ptr(),
            passes.before[2].as_ptr(),
        ];
        let behind = [
            passes.behind[0].as_ptr(),
            passes.behind[1].as_ptr(),
            passes.behind[2].as_ptr(),
        ];
        let next = difference(load3::<L>(before, k + 1), load3(behind, k));
        let last = difference(load3::<L>(before, k), load3(behind, k - 1));
        difference(next, last)
    }
}

/// Computes forces on `count` vertices (at most [`BLOCK`]) into `force`, with those in `bond_forces` where there are any.
#[inline(always)]
unsafe fn block_forces<L: Lanes>(
    input: &RodInput,
    bond_forces: &[PaddedVec3],
    count: usize,
    passes: &mut Passes,
    force: &mut Block,
) {
    unsafe {
        stresses::<L>(input, count, passes);
        let mut k = 0;
        while k < count {
            let mut f = on_vertices::<L>(passes, k + 1);
            if !bond_forces.is_empty() {
                let more = L::gather(
                    bond_forces.as_ptr().add(k),
                    [0, 1, 2, 3, 4, 5, 6, 7].as_ptr(),
                );
                f = [f[0].add(more[0]), f[1].add(more[1]), f[2].add(more[2])];
            }
            for (to, f) in force.iter_mut().zip(f) {
                f.store(to.as_mut_ptr().add(k));
            }
            k += WIDTH;
        }
    }
}

for_each_level! {
    /// [`block_forces`] at a level.
    block_forces_at = block_forces(
        input: &RodInput, bond_forces: &[PaddedVec3], count: usize, passes: &mut Passes, force: &mut Block,
    )
}

/// Computes forces on `count` vertices (at most [`BLOCK`]) into `force`: stretch, bending, and those in `bond_forces`, which is
/// empty or long enough for whole lanes.
pub(crate) fn rod_forces(
    level: SimdLevel,
    input: &RodInput,
    bond_forces: &[PaddedVec3],
    count: usize,
    passes: &mut Passes,
    force: &mut Block,
) {
    let need = count + BEFORE + BEHIND;
    let mut arrays = input.position.into_iter().chain([input.plastic_strain]);
    assert!(count <= BLOCK && arrays.all(|a| a.len() >= need));
    assert!(input.stiffness.len() * WIDTH >= count + 2);
    assert!(bond_forces.is_empty() || bond_forces.len() >= count.next_multiple_of(WIDTH));
    // Safety: every array is as long as what is read.
    unsafe { block_forces_at(level, input, bond_forces, count, passes, force) }
}

/// Input of an explicit step: v ← (v + Δt f/m) k, x ← x + Δt v.
pub(crate) struct StepInput<'a> {
    pub velocity: [&'a [f64]; 3],
    pub position: [&'a [f64]; 3],
    /// External forces; empty for none.
    pub external: [&'a [f64]; 3],
    pub masses: &'a [Masses],
    /// Δt, s.
    pub step: f64,
    /// The factor k of damping.
    pub damping_factor: f64,
}

/// Takes the step of whole lanes, from entry `from` of `force`, and adds eight sums of m v² to `sums`.
#[inline(always)]
unsafe fn steps_of<L: Lanes, const EXTERNAL: bool>(
    input: &StepInput,
    force: &Block,
    from: usize,
    velocity: &mut [&mut [f64]; 3],
    position: &mut [&mut [f64]; 3],
    sums: &mut [f64; WIDTH],
) {
    unsafe {
        let (step, factor) = (L::splat(input.step), L::splat(input.damping_factor));
        let mut sum = L::load(sums.as_ptr());
        let (before, place) = (
            input.velocity.map(<[f64]>::as_ptr),
            input.position.map(<[f64]>::as_ptr),
        );
        let external = input.external.map(<[f64]>::as_ptr);
        let pushed = [force[0].as_ptr(), force[1].as_ptr(), force[2].as_ptr()];
        let mut k = 0;
        while k + WIDTH <= velocity[0].len() {
            let masses = input.masses.get_unchecked(k / WIDTH);
            let push = step.mul(L::load(masses.inverse.as_ptr()));
            let (mut v, mut p) = (load3::<L>(before, k), load3::<L>(place, k));
            let mut f = load3::<L>(pushed, from + k);
            if EXTERNAL {
                let more = load3::<L>(external, k);
                f = [f[0].add(more[0]), f[1].add(more[1]), f[2].add(more[2])];
            }
            for i in 0..3 {
                v[i] = v[i].add(push.mul(f[i])).mul(factor);
                p[i] = p[i].add(step.mul(v[i]));
            }
            sum = sum.add(dot(v, v).mul(L::load(masses.mass.as_ptr())));
            // All reads come before the writes: the arrays lie a multiple of pages apart, where a processor mistakes a read
            // for one of what has just been written.
            for i in 0..3 {
                v[i].store(velocity[i].as_mut_ptr().add(k));
                p[i].store(position[i].as_mut_ptr().add(k));
            }
            k += WIDTH;
        }
        sum.store(sums.as_mut_ptr());
    }
}

#[inline(always)]
unsafe fn steps<L: Lanes>(
    input: &StepInput,
    force: &Block,
    from: usize,
    velocity: &mut [&mut [f64]; 3],
    position: &mut [&mut [f64]; 3],
    sums: &mut [f64; WIDTH],
) {
    unsafe {
        if input.external[0].is_empty() {
            steps_of::<L, false>(input, force, from, velocity, position, sums)
        } else {
            steps_of::<L, true>(input, force, from, velocity, position, sums)
        }
    }
}

for_each_level! {
    /// [`steps`] at a level.
    steps_at = steps(
        input: &StepInput, force: &Block, from: usize, velocity: &mut [&mut [f64]; 3],
        position: &mut [&mut [f64]; 3], sums: &mut [f64; WIDTH],
    )
}

/// Takes the step of a block of vertices, whose arrays are all of one length. Returns its kinetic energy after it.
pub(crate) fn step(
    level: SimdLevel,
    input: &StepInput,
    scratch: &Scratch,
    mut velocity: [&mut [f64]; 3],
    mut position: [&mut [f64]; 3],
) -> f64 {
    let n = velocity[0].len();
    let read = [&input.velocity, &input.position].into_iter().flatten();
    let none = input.external.iter().all(|a| a.is_empty());
    let more = input.external.iter().filter(|_| !none);
    assert!(n <= BLOCK && input.masses.len() * WIDTH >= n);
    assert!(read.chain(more).all(|a| a.len() == n));
    assert!(velocity.iter().chain(&position).all(|a| a.len() == n));
    let mut sums = [0.0; WIDTH];
    // Safety: every array is as long as what is read and written.
    unsafe {
        steps_at(
            level,
            input,
            &scratch.force,
            0,
            &mut velocity,
            &mut position,
            &mut sums,
        )
    }
    let whole = n - n % WIDTH;
    if whole < n {
        // The rest on copies padded with zeros.
        let padded = |a: &[f64]| {
            let mut made = [0.0; WIDTH];
            if !a.is_empty() {
                made[..n - whole].copy_from_slice(&a[whole..]);
            }
            made
        };
        let (v, p) = (input.velocity.map(padded), input.position.map(padded));
        let external = input.external.map(padded);
        let mut made = [[0.0; WIDTH]; 6];
        let [a, b, c, d, e, f] = &mut made;
        let input = StepInput {
            velocity: [&v[0], &v[1], &v[2]],
            position: [&p[0], &p[1], &p[2]],
            external: [0, 1, 2].map(|i| match input.external[i] {
                [] => &[][..],
                _ => &external[i],
            }),
            masses: &input.masses[whole / WIDTH..],
            ..*input
        };
        let (mut new, mut place): ([&mut [f64]; 3], [&mut [f64]; 3]) = ([a, b, c], [d, e, f]);
        // Safety: as above; forces extend beyond a block by more than a lane.
        unsafe {
            steps_at(
                level,
                &input,
                &scratch.force,
                whole,
                &mut new,
                &mut place,
                &mut sums,
            );
        }
        for i in 0..3 {
            velocity[i][whole..].copy_from_slice(&made[i][..n - whole]);
            position[i][whole..].copy_from_slice(&made[3 + i][..n - whole]);
        }
    }
    0.5 * sums.iter().sum::<f64>()
}
