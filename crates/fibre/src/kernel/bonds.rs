//! Bonds, in two passes. The first computes each bond's forces: those on its vertex x are written where the bond is,
//! those on its edge are added up at once, as bonds are sorted by edge. The second gathers for each vertex what its own
//! bonds and its two edges' bonds do to it. Every sum is taken in one order, whoever takes it.
#![allow(unsafe_code)]

use super::both;
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

/// A bundle's bonds sorted by edge, in tasks of whole edges. Each task is filled up to whole lanes with bonds without
/// stiffness that nobody gathers.
#[derive(Debug, Clone, Default)]
pub(crate) struct BondTable {
    /// Vertices that there are; every index below is checked against it where the table is made.
    vertices: usize,
    vertex: Vec<u32>,
    /// Ascending.
    edge: Vec<u32>,
    /// One bit for each bond: whether the bond before is of the same edge. One byte for [`WIDTH`] bonds.
    same: Vec<u8>,
    /// Where in its task a bond's force is written: forces on one vertex lie together, and on the next behind it, so
    /// that both passes go through memory in few straight lines.
    slot: Vec<u32>,
    t: Vec<f64>,
    inverse_distance: Vec<f64>,
    rest_cosine: Vec<f64>,
    transverse: Vec<f64>,
    /// 2 S.
    shear: Vec<f64>,
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
            ..BondTable::default()
        };
        let held = &b.incidence.held;
        for (k, &bond) in held.iter().enumerate() {
            let i = bond as usize;
            let (vertex, edge) = (b.vertex[i], b.edge[i]);
            assert!((vertex as usize) < n && (edge as usize) + 1 < n);
            let before = made.edge.last().copied();
            assert!(before.is_none_or(|e| e <= edge), "sorted by edge");
            let begun = made.tasks.last().map_or(0, |t| t.bond);
            if k == 0 || (before != Some(edge) && made.edge.len() - begun >= GRAIN) {
                made.fill_up();
                made.tasks.push(Task {
                    bond: made.edge.len(),
                    edge,
                });
            }
            made.place[i] = made.edge.len() as u32;
            let stiffness = [b.transverse[i], 2.0 * b.shear[i]];
            made.push(
                vertex,
                edge,
                before == Some(edge),
                b.t[i],
                b.distance[i],
                b.rest_cosine[i],
                stiffness,
            );
        }
        made.fill_up();
        made.tasks.push(Task {
            bond: made.edge.len(),
            edge: n as u32,
        });
        made.lay_out();
        made
    }

    #[allow(clippy::too_many_arguments)]
    fn push(
        &mut self,
        vertex: u32,
        edge: u32,
        same: bool,
        t: f64,
        distance: f64,
        rest_cosine: f64,
        [transverse, shear]: [f64; 2],
    ) {
        let bit = self.edge.len() % WIDTH;
        if bit == 0 {
            self.same.push(0);
        }
        if let Some(byte) = self.same.last_mut() {
            *byte |= u8::from(same) << bit;
        }
        self.vertex.push(vertex);
        self.edge.push(edge);
        self.t.push(t);
        self.inverse_distance.push(1.0 / distance);
        self.rest_cosine.push(rest_cosine);
        self.transverse.push(transverse);
        self.shear.push(shear);
    }

    /// Gives each task's bonds their slots, in order of vertex.
    fn lay_out(&mut self) {
        self.slot = vec![0; self.edge.len()];
        for ends in self.tasks.windows(2) {
            let start = ends[0].bond;
            let mut order: Vec<u32> = (start as u32..ends[1].bond as u32).collect();
            order.sort_by_key(|&b| self.vertex[b as usize]);
            for (slot, &b) in order.iter().enumerate() {
                self.slot[b as usize] = slot as u32;
            }
        }
        let mut task = 0;
        let mut ordered: Vec<u32> = (0..self.place.len() as u32).collect();
        ordered.sort_by_key(|&b| self.place[b as usize]);
        for b in ordered {
            let place = &mut self.place[b as usize];
            while self.tasks[task + 1].bond <= *place as usize {
                task += 1;
            }
            *place = self.tasks[task].bond as u32 + self.slot[*place as usize];
        }
    }

    /// Repeats the last bond without stiffness up to whole lanes.
    fn fill_up(&mut self) {
        while !self.edge.len().is_multiple_of(WIDTH) {
            let i = self.edge.len() - 1;
            self.push(
                self.vertex[i],
                self.edge[i],
                true,
                self.t[i],
                1.0,
                0.0,
                [0.0; 2],
            );
        }
    }

    /// How many there are, with what fills up tasks.
    pub(crate) fn len(&self) -> usize {
        self.edge.len()
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.edge.is_empty()
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
        assert!(
            position.len() == self.vertices
                && sums.len() == self.vertices
                && force.len() == self.len()
        );
        let tasks = self.tasks.len() - 1;
        // Sums of edges before the first bond's belong to no task.
        let first = self.tasks[0].edge as usize;
        self.share(level, position, 0..tasks, force, &mut sums[first..]);
    }

    /// Shares out tasks; `force` and `sums` are those of these tasks.
    fn share(
        &self,
        level: Level,
        position: &[Row],
        tasks: Range<usize>,
        force: &mut [Row],
        sums: &mut [Pair],
    ) {
        let start = self.tasks[tasks.start];
        if tasks.len() == 1 {
            self.task(level, position, tasks.start, force, sums);
        } else if tasks.len() > 1 {
            let middle = tasks.start + tasks.len() / 2;
            let cut = self.tasks[middle];
            let (f0, f1) = force.split_at_mut(cut.bond - start.bond);
            let (s0, s1) = sums.split_at_mut((cut.edge - start.edge) as usize);
            both(
                || self.share(level, position, tasks.start..middle, f0, s0),
                || self.share(level, position, middle..tasks.end, f1, s1),
            );
        }
    }

    fn task(
        &self,
        level: Level,
        position: &[Row],
        task: usize,
        force: &mut [Row],
        sums: &mut [Pair],
    ) {
        let (start, end) = (self.tasks[task], self.tasks[task + 1]);
        let range = start.bond..end.bond;
        assert!(force.len() == range.len() && sums.len() == (end.edge - start.edge) as usize);
        let input = BondInput {
            position,
            vertex: &self.vertex[range.clone()],
            edge: &self.edge[range.clone()],
            same: &self.same[start.bond / WIDTH..end.bond / WIDTH],
            slot: &self.slot[range.clone()],
            t: &self.t[range.clone()],
            inverse_distance: &self.inverse_distance[range.clone()],
            rest_cosine: &self.rest_cosine[range.clone()],
            transverse: &self.transverse[range.clone()],
            shear: &self.shear[range],
        };
        // Safety: the arrays are equally long and whole lanes; vertices, edges and the vertices behind edges are below
        // the number of places, edges of the task within its sums, and slots within its bonds, of which there are some: the
        // table was made so, and its fields are
        // changed nowhere else.
        unsafe { bonds_at(level, &input, start.edge, force, sums) }
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

/// What the bond kernel reads. All arrays of bonds are equally long, and their length is a multiple of [`WIDTH`].
struct BondInput<'a> {
    position: &'a [Row],
    vertex: &'a [u32],
    edge: &'a [u32],
    same: &'a [u8],
    slot: &'a [u32],
    t: &'a [f64],
    inverse_distance: &'a [f64],
    rest_cosine: &'a [f64],
    transverse: &'a [f64],
    shear: &'a [f64],
}

/// Eight bonds' vectors e = y₁ − y₀ and d = x − c, their lengths, and one over the lengths' product.
#[derive(Clone, Copy)]
struct Vectors<L> {
    e: [L; 3],
    d: [L; 3],
    t: L,
    edge: L,
    distance: L,
    inverse: L,
}

#[inline(always)]
unsafe fn vectors<L: Lanes>(input: &BondInput, i: usize) -> Vectors<L> {
    unsafe {
        let position = input.position.as_ptr();
        let (vertex, edge) = (input.vertex.as_ptr().add(i), input.edge.as_ptr().add(i));
        let t = L::load(input.t.as_ptr().add(i));
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
unsafe fn bonds<L: Lanes>(input: &BondInput, first: u32, out: &mut [Row], sums: &mut [Pair]) {
    unsafe {
        let n = out.len();
        let one = L::splat(1.0);
        let mut sum = L::splat(0.0);
        // The next bonds' roots and divisions run while these bonds' forces are made of what is there.
        let mut next = vectors::<L>(input, 0);
        let mut i = 0;
        while i < n {
            let now = next;
            next = vectors::<L>(input, if i + WIDTH < n { i + WIDTH } else { i });
            let Vectors {
                e, d, t, inverse, ..
            } = now;
            let (ie, id) = (inverse.mul(now.distance), inverse.mul(now.edge));
            let cosine = dot(e, d).mul(inverse);
            let shear = cosine
                .sub(L::load(input.rest_cosine.as_ptr().add(i)))
                .mul(L::load(input.shear.as_ptr().add(i)));
            let pull = now
                .distance
                .mul(L::load(input.inverse_distance.as_ptr().add(i)))
                .sub(one)
                .mul(L::load(input.transverse.as_ptr().add(i)));
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
            let same = *input.same.get_unchecked(i / WIDTH);
            for (k, pair) in pairs.into_iter().enumerate() {
                sum = sum.kept((same >> k) & 1).add(pair);
                let place = (*input.edge.get_unchecked(i + k) - first) as usize;
                sum.store(sums.as_mut_ptr().add(place).cast());
                let slot = *input.slot.get_unchecked(i + k) as usize;
                pair.store_low(out.as_mut_ptr().add(slot).cast());
            }
            i += WIDTH;
        }
    }
}

for_each_level! {
    /// [`bonds`] at a level.
    bonds_at = bonds(input: &BondInput, first: u32, out: &mut [Row], sums: &mut [Pair])
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
        let [a, b, c, d, ..] = *pair;
        let next = last(pair);
        let on_edge = [a, b, c, d];
        let mut sum = end;
        for k in 0..4 {
            sum[k] -= on_edge[k] + next[k];
        }
        end = next;
        for &p in &place[own[v] as usize..own[v + 1] as usize] {
            let f = &force[p as usize];
            for k in 0..4 {
                sum[k] += f[k];
            }
        }
        *out = sum;
    }
}

#[inline(always)]
fn last(pair: &Pair) -> Row {
    let [.., a, b, c, d] = *pair;
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
