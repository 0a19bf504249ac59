//! Bonds, in two passes. The first computes each bond's forces: those on its vertex x are written where the bond is,
//! those on its edge are added up at once, as bonds are sorted by edge. The second gathers for each vertex what its own
//! bonds and its two edges' bonds do to it. Every sum is taken in one order, whoever takes it.

use super::super::both;
use super::lanes::{Lanes, Level, Pair, Row, WIDTH, difference, dot, for_each_level};
use crate::bundle::Bundle;
use std::ops::Range;

/// Bonds of one task, about: few enough for its forces to stay in the second cache, many against what a task costs.
const GRAIN: usize = 2048;

/// Where a task begins.
#[derive(Debug, Clone, Copy)]
struct Task {
    bond: usize,
    edge: u32,
}

/// Eight bonds: all that is read of them in one line through memory.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Eight {
    pub(super) t: [f64; WIDTH],
    pub(super) inverse_distance: [f64; WIDTH],
    pub(super) rest_cosine: [f64; WIDTH],
    pub(super) transverse: [f64; WIDTH],
    /// 2 S.
    pub(super) shear: [f64; WIDTH],
    pub(super) vertex: [u32; WIDTH],
    /// Ascending.
    pub(super) edge: [u32; WIDTH],
    /// Where in its task a bond's force is written: forces on one vertex lie together, and on the next behind it, so
    /// that both passes go through memory in few straight lines.
    pub(super) slot: [u32; WIDTH],
    /// One bit for each bond: whether the bond before is of the same edge.
    pub(super) same: u8,
}

impl Eight {
    const NONE: Eight = Eight {
        t: [0.0; WIDTH],
        inverse_distance: [0.0; WIDTH],
        rest_cosine: [0.0; WIDTH],
        transverse: [0.0; WIDTH],
        shear: [0.0; WIDTH],
        vertex: [0; WIDTH],
        edge: [0; WIDTH],
        slot: [0; WIDTH],
        same: 0,
    };
}

/// A bundle's bonds sorted by edge, in tasks of whole edges. Each task is filled up to whole lanes with bonds without
/// stiffness that nobody gathers.
#[derive(Debug, Clone, Default)]
pub(crate) struct BondTable {
    /// Vertices that there are; every index below is checked against it where the table is made.
    pub(super) vertices: usize,
    /// How many bonds there are, with what fills up tasks.
    count: usize,
    pub(super) eights: Vec<Eight>,
    /// Where the bundle's bonds are, and which is at each place.
    index: Vec<u32>,
    bond: Vec<u32>,
    /// Where the forces of the bundle's bonds are.
    place: Vec<u32>,
    /// First bond and edge of every task, and the ends of the last.
    tasks: Vec<Task>,
}

impl BondTable {
    /// The bonds of a bundle.
    pub(crate) fn new(bundle: &Bundle) -> Self {
        let b = &bundle.bonds;
        let n = bundle.vertices();
        let mut made = BondTable {
            vertices: n,
            place: vec![0; b.len()],
            index: Vec::new(),
            bond: Vec::new(),
            ..BondTable::default()
        };
        let mut before = None;
        for &bond in &b.incidence.held {
            let i = bond as usize;
            let (vertex, edge) = (b.vertex[i], b.edge[i]);
            assert!((vertex as usize) < n && (edge as usize) + 1 < n);
            assert!(before.is_none_or(|e| e <= edge), "sorted by edge");
            let begun = made.tasks.last().map(|t| t.bond);
            if begun.is_none_or(|at| before != Some(edge) && made.count - at >= GRAIN) {
                made.fill_up();
                made.tasks.push(Task {
                    bond: made.count,
                    edge,
                });
            }
            made.place[i] = made.count as u32;
            let l = made.count % WIDTH;
            if l == 0 {
                made.eights.push(Eight::NONE);
            }
            made.count += 1;
            if let Some(eight) = made.eights.last_mut() {
                eight.t[l] = b.t[i];
                eight.inverse_distance[l] = 1.0 / b.distance[i];
                eight.rest_cosine[l] = b.rest_cosine[i];
                eight.transverse[l] = b.transverse[i];
                eight.shear[l] = 2.0 * b.shear[i];
                (eight.vertex[l], eight.edge[l]) = (vertex, edge);
                eight.same |= u8::from(before == Some(edge)) << l;
            }
            before = Some(edge);
        }
        made.index.clone_from(&made.place);
        made.fill_up();
        made.bond = vec![u32::MAX; made.count];
        for (bond, &place) in made.index.iter().enumerate() {
            made.bond[place as usize] = bond as u32;
        }
        made.tasks.push(Task {
            bond: made.count,
            edge: n as u32,
        });
        made.lay_out();
        made
    }

    /// Gives each task's bonds their slots, in order of vertex.
    fn lay_out(&mut self) {
        let mut slots = vec![0; self.count];
        for ends in self.tasks.windows(2) {
            let start = ends[0].bond;
            let mut order: Vec<usize> = (start..ends[1].bond).collect();
            order.sort_by_key(|&b| self.eights[b / WIDTH].vertex[b % WIDTH]);
            for (slot, &b) in order.iter().enumerate() {
                slots[b] = slot as u32;
            }
        }
        for (eight, slots) in self.eights.iter_mut().zip(slots.chunks_exact(WIDTH)) {
            eight.slot.copy_from_slice(slots);
        }
        for place in &mut self.place {
            let task = self.tasks.partition_point(|t| t.bond <= *place as usize) - 1;
            *place = self.tasks[task].bond as u32 + slots[*place as usize];
        }
    }

    /// Repeats the last bond without stiffness up to whole lanes.
    fn fill_up(&mut self) {
        let Some(eight) = self.eights.last_mut() else {
            return;
        };
        while !self.count.is_multiple_of(WIDTH) {
            let l = self.count % WIDTH;
            (eight.vertex[l], eight.edge[l]) = (eight.vertex[l - 1], eight.edge[l - 1]);
            eight.t[l] = eight.t[l - 1];
            eight.same |= 1 << l;
            self.count += 1;
        }
    }

    /// How many there are, with what fills up tasks.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Computes all forces: those on bonds' vertices into `force`, of [`BondTable::len`] entries, and for each edge
    /// that has bonds the sums of these and of those on y₁ into `sums`, of which there is one for each vertex.
    pub(crate) fn forces(
        &self,
        level: Level,
        position: &[Row],
        force: &mut [Row],
        sums: &mut [Pair],
    ) {
        assert!(position.len() == self.vertices);
        self.share(force, sums, &|range, first, force, sums| {
            let eights = &self.eights[range];
            // Safety: vertices, edges and the vertices behind edges are below the number of places, edges of the task
            // within its sums, and slots within its bonds: the table was made so, and these are changed nowhere else.
            unsafe { bonds_at(level, position, eights, first, force, sums) }
        });
    }

    /// Calls `work` for each task: with the range of its eights, its first edge, and its part of `force`, one for each
    /// bond, and of `sums`, one for each vertex.
    pub(super) fn share(
        &self,
        force: &mut [Row],
        sums: &mut [Pair],
        work: &(impl Fn(Range<usize>, u32, &mut [Row], &mut [Pair]) + Sync),
    ) {
        assert!(sums.len() == self.vertices && force.len() == self.len());
        // Sums of edges before the first bond's belong to no task.
        let first = self.tasks[0].edge as usize;
        self.share_tasks(0..self.tasks.len() - 1, force, &mut sums[first..], work);
    }

    fn share_tasks(
        &self,
        tasks: Range<usize>,
        force: &mut [Row],
        sums: &mut [Pair],
        work: &(impl Fn(Range<usize>, u32, &mut [Row], &mut [Pair]) + Sync),
    ) {
        let start = self.tasks[tasks.start];
        if tasks.len() == 1 {
            let end = self.tasks[tasks.end];
            let range = start.bond / WIDTH..end.bond / WIDTH;
            assert!(!range.is_empty() && force.len() == range.len() * WIDTH);
            assert!(sums.len() == (end.edge - start.edge) as usize);
            work(range, start.edge, force, sums);
        } else if tasks.len() > 1 {
            let middle = tasks.start + tasks.len() / 2;
            let cut = self.tasks[middle];
            let (f0, f1) = force.split_at_mut(cut.bond - start.bond);
            let (s0, s1) = sums.split_at_mut((cut.edge - start.edge) as usize);
            both(
                || self.share_tasks(tasks.start..middle, f0, s0, work),
                || self.share_tasks(middle..tasks.end, f1, s1, work),
            );
        }
    }

    /// The bundle's bond at a place of the table; none where it is filled up.
    pub(crate) fn bond(&self, place: usize) -> Option<u32> {
        Some(self.bond[place]).filter(|b| *b != u32::MAX)
    }

    /// Takes the stiffness of bonds `broken` of the bundle that this was made of.
    pub(crate) fn weaken(&mut self, broken: &[u32]) {
        for &bond in broken {
            let place = self.index[bond as usize] as usize;
            let eight = &mut self.eights[place / WIDTH];
            eight.transverse[place % WIDTH] = 0.0;
            eight.shear[place % WIDTH] = 0.0;
        }
    }

    /// What bonds do to the vertices from `first` on, into `out`.
    pub(crate) fn gather(
        &self,
        level: Level,
        bundle: &Bundle,
        force: &[Row],
        sums: &[Pair],
        first: usize,
        out: &mut [Row],
    ) {
        let own = &bundle.bonds.incidence.own;
        gather(level, own, &self.place, force, sums, first, out);
    }
}

/// Eight bonds' vectors e = y₁ − y₀ and d = x − c, their lengths, and one over the lengths' product.
#[derive(Clone, Copy)]
pub(super) struct Vectors<L> {
    pub(super) e: [L; 3],
    pub(super) d: [L; 3],
    t: L,
    pub(super) edge: L,
    pub(super) distance: L,
    pub(super) inverse: L,
}

#[inline(always)]
pub(super) unsafe fn vectors<L: Lanes>(position: *const Row, eight: &Eight) -> Vectors<L> {
    unsafe {
        let (vertex, edge) = (eight.vertex.as_ptr(), eight.edge.as_ptr());
        let t = L::load(eight.t.as_ptr());
        let (x, y0, y1) = (
            L::rows(position, vertex),
            L::rows(position, edge),
            L::rows(position.add(1), edge),
        );
        let (e, s) = (difference(y1, y0), difference(x, y0));
        let d = [
            s[0].sub(e[0].mul(t)),
            s[1].sub(e[1].mul(t)),
            s[2].sub(e[2].mul(t)),
        ];
        let (le, ld) = (dot(e, e).sqrt(), dot(d, d).sqrt());
        Vectors {
            e,
            d,
            t,
            edge: le,
            distance: ld,
            inverse: L::splat(1.0).div(le.mul(ld)),
        }
    }
}

/// Forces of bonds on their vertices into `out`, and their sums for each edge, with those on y₁, into `sums`, whose
/// first entry is of edge `first`.
#[inline(always)]
unsafe fn bonds<L: Lanes>(
    position: &[Row],
    eights: &[Eight],
    first: u32,
    out: &mut [Row],
    sums: &mut [Pair],
) {
    unsafe {
        let one = L::splat(1.0);
        let mut sum = L::splat(0.0);
        let position = position.as_ptr();
        // The next bonds' roots and divisions run while these bonds' forces are made of what is there.
        let mut next = vectors::<L>(position, eights.get_unchecked(0));
        for (i, eight) in eights.iter().enumerate() {
            let now = next;
            let following = (i + 1).min(eights.len() - 1);
            next = vectors::<L>(position, eights.get_unchecked(following));
            let Vectors {
                e, d, t, inverse, ..
            } = now;
            let (ie, id) = (inverse.mul(now.distance), inverse.mul(now.edge));
            let cosine = dot(e, d).mul(inverse);
            let shear = cosine
                .sub(L::load(eight.rest_cosine.as_ptr()))
                .mul(L::load(eight.shear.as_ptr()));
            let pull = now
                .distance
                .mul(L::load(eight.inverse_distance.as_ptr()))
                .sub(one)
                .mul(L::load(eight.transverse.as_ptr()));
            // F = B d − A e on x; turn = C e − A d; the force on y₁ is turn − t F.
            let a = shear.mul(inverse);
            let swing = shear.mul(cosine);
            let b = swing.mul(id).sub(pull).mul(id);
            let c = swing.mul(ie).mul(ie);
            let (mut on_vertex, mut on_end) = ([one; 3], [one; 3]);
            for k in 0..3 {
                on_vertex[k] = d[k].mul(b).sub(e[k].mul(a));
                let turn = e[k].mul(c).sub(d[k].mul(a));
                on_end[k] = turn.sub(on_vertex[k].mul(t));
            }
            let pairs = L::pairs(on_vertex, on_end);
            for (k, pair) in pairs.into_iter().enumerate() {
                sum = sum.kept((eight.same >> k) & 1).add(pair);
                let place = (eight.edge[k] - first) as usize;
                sum.store(sums.as_mut_ptr().add(place).cast());
                pair.store_low(out.as_mut_ptr().add(eight.slot[k] as usize).cast());
            }
        }
    }
}

for_each_level! {
    /// [`bonds`] at a level.
    bonds_at = bonds(position: &[Row], eights: &[Eight], first: u32, out: &mut [Row], sums: &mut [Pair])
}

/// What bonds do to the vertices from `first` on into `out`: `own` has the first entry of each vertex in `place`, and
/// `place` where its bonds' forces are in `force`; `sums` are the edges' sums.
#[inline(always)]
fn gathered(
    own: &[u32],
    place: &[u32],
    force: &[Row],
    sums: &[Pair],
    first: usize,
    out: &mut [Row],
) {
    let mut end = match first.checked_sub(1) {
        Some(j) => last(&sums[j]),
        None => [0.0; 4],
    };
    for (i, out) in out.iter_mut().enumerate() {
        let v = first + i;
        let pair = &sums[v];
        let [a, b, c, d, ..] = pair.0;
        let next = last(pair);
        let on_edge = [a, b, c, d];
        let mut sum = end;
        for ((sum, start), end) in sum.iter_mut().zip(on_edge).zip(next) {
            *sum -= start + end;
        }
        end = next;
        for &p in &place[own[v] as usize..own[v + 1] as usize] {
            let f = &force[p as usize];
            for (sum, f) in sum.iter_mut().zip(f.0) {
                *sum += f;
            }
        }
        out.0 = sum;
    }
}

#[inline(always)]
fn last(pair: &Pair) -> [f64; 4] {
    let [.., a, b, c, d] = pair.0;
    [a, b, c, d]
}

/// The same with registers as wide as a row where there are any: wider ones would not help.
fn gather(
    level: Level,
    own: &[u32],
    place: &[u32],
    force: &[Row],
    sums: &[Pair],
    first: usize,
    out: &mut [Row],
) {
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn wide(
        own: &[u32],
        place: &[u32],
        force: &[Row],
        sums: &[Pair],
        first: usize,
        out: &mut [Row],
    ) {
        gathered(own, place, force, sums, first, out);
    }
    #[cfg(target_arch = "x86_64")]
    if level.min(Level::best()) >= Level::Avx2 {
        // Safety: the processor has AVX2.
        unsafe { wide(own, place, force, sums, first, out) };
        return;
    }
    let _ = level;
    gathered(own, place, force, sums, first, out);
}
