//! Forces of bonds, in two passes. The first computes each bond's forces: those on its vertex x are written in the bond's
//! slot, those on its edge are summed at once, as bonds are sorted by edge. The second gathers for each vertex the forces of
//! its own bonds and of its two edges' bonds. Every sum is taken in one order, whichever thread takes it.

use super::dispatch::for_each_level;
use super::lanes::{Lanes, PaddedPair, PaddedVec3, WIDTH, difference, dot};
use super::level::SimdLevel;
use super::places::Places;
use crate::energy::bond::BondSpring;
use crate::parallel::join;
use crate::rod_bundle::RodBundle;
use std::ops::Range;

/// Bonds of one task, about: few enough for their forces to stay in the second-level cache, enough to make the cost of a
/// task negligible.
const BONDS_PER_TASK: usize = 2048;

/// Marks entries of the table that are no bonds.
const PADDING: u32 = u32::MAX;

/// The first bond and edge of a task.
#[derive(Debug, Clone, Copy)]
struct Task {
    bond: usize,
    edge: u32,
}

/// Eight bonds: whose data are read as one stream.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct BondBatch {
    pub(super) t: [f64; WIDTH],
    /// The distance across the edge and the place along it at rest, m.
    pub(super) rest_opening: [f64; WIDTH],
    pub(super) rest_slip: [f64; WIDTH],
    /// Stiffness against opening, against closing and against slip, N/m.
    pub(super) opening: [f64; WIDTH],
    pub(super) closing: [f64; WIDTH],
    pub(super) slip: [f64; WIDTH],
    pub(super) vertex: [u32; WIDTH],
    /// Ascending.
    pub(super) edge: [u32; WIDTH],
    /// Where in its task a bond's force is written. Forces on one vertex lie together, followed by those on the next, so that
    /// both passes read and write few contiguous streams.
    pub(super) slot: [u32; WIDTH],
    /// One bit for each bond: whether the bond before it has the same edge.
    pub(super) same_edge: u8,
}

impl BondBatch {
    /// Sets the spring of one bond.
    fn set_spring(&mut self, lane: usize, spring: &BondSpring) {
        self.rest_opening[lane] = spring.rest_opening;
        self.rest_slip[lane] = spring.rest_slip;
        self.opening[lane] = spring.opening;
        self.closing[lane] = spring.closing;
        self.slip[lane] = spring.slip;
    }

    const EMPTY: BondBatch = BondBatch {
        t: [0.0; WIDTH],
        rest_opening: [0.0; WIDTH],
        rest_slip: [0.0; WIDTH],
        opening: [0.0; WIDTH],
        closing: [0.0; WIDTH],
        slip: [0.0; WIDTH],
        vertex: [0; WIDTH],
        edge: [0; WIDTH],
        slot: [0; WIDTH],
        same_edge: 0,
    };
}

/// A bundle's bonds sorted by edge, in tasks of whole edges. Each task is padded to whole batches with bonds that have no
/// stiffness and that no vertex gathers.
#[derive(Debug, Clone, Default)]
pub(crate) struct BondTable {
    /// Number of vertices. Every index below is checked against it when the table is built.
    pub(super) vertices: usize,
    /// Number of bonds, with padding.
    count: usize,
    pub(super) batches: Vec<BondBatch>,
    /// Per bond of the bundle: its entry in the table; and per entry its bond, or `PADDING`.
    entry: Vec<u32>,
    bond: Vec<u32>,
    /// Per bond of the bundle: where its force is.
    force_slot: Vec<u32>,
    /// The start of every task, and the end of the last.
    tasks: Vec<Task>,
}

impl BondTable {
    /// Builds the table of a bundle's bonds.
    pub(crate) fn new(bundle: &RodBundle) -> Self {
        let b = &bundle.bonds;
        let n = bundle.vertices();
        let mut table = BondTable {
            vertices: n,
            force_slot: vec![0; b.len()],
            entry: Vec::new(),
            bond: Vec::new(),
            ..BondTable::default()
        };
        let mut before = None;
        for &bond in &b.incidence.by_edge {
            let i = bond as usize;
            let (vertex, edge) = (b.vertex[i], b.edge[i]);
            assert!((vertex as usize) < n && (edge as usize) + 1 < n);
            assert!(before.is_none_or(|e| e <= edge), "sorted by edge");
            let begun = table.tasks.last().map(|t| t.bond);
            if begun.is_none_or(|at| before != Some(edge) && table.count - at >= BONDS_PER_TASK) {
                table.pad();
                table.tasks.push(Task {
                    bond: table.count,
                    edge,
                });
            }
            table.force_slot[i] = table.count as u32;
            let l = table.count % WIDTH;
            if l == 0 {
                table.batches.push(BondBatch::EMPTY);
            }
            table.count += 1;
            if let Some(batch) = table.batches.last_mut() {
                batch.t[l] = b.t[i];
                batch.set_spring(l, &BondSpring::new(bundle, i));
                (batch.vertex[l], batch.edge[l]) = (vertex, edge);
                batch.same_edge |= u8::from(before == Some(edge)) << l;
            }
            before = Some(edge);
        }
        table.entry.clone_from(&table.force_slot);
        table.pad();
        table.bond = vec![PADDING; table.count];
        for (bond, &entry) in table.entry.iter().enumerate() {
            table.bond[entry as usize] = bond as u32;
        }
        table.tasks.push(Task {
            bond: table.count,
            edge: n as u32,
        });
        table.assign_slots();
        table
    }

    /// Gives each task's bonds their slots, in order of vertex.
    fn assign_slots(&mut self) {
        let mut slots = vec![0; self.count];
        for ends in self.tasks.windows(2) {
            let start = ends[0].bond;
            let mut order: Vec<usize> = (start..ends[1].bond).collect();
            order.sort_by_key(|&b| self.batches[b / WIDTH].vertex[b % WIDTH]);
            for (slot, &b) in order.iter().enumerate() {
                slots[b] = slot as u32;
            }
        }
        for (batch, slots) in self.batches.iter_mut().zip(slots.chunks_exact(WIDTH)) {
            batch.slot.copy_from_slice(slots);
        }
        for slot in &mut self.force_slot {
            let task = self.tasks.partition_point(|t| t.bond <= *slot as usize) - 1;
            *slot = self.tasks[task].bond as u32 + slots[*slot as usize];
        }
    }

    /// Pads the last batch with copies of its last bond without stiffness.
    fn pad(&mut self) {
        let Some(batch) = self.batches.last_mut() else {
            return;
        };
        while !self.count.is_multiple_of(WIDTH) {
            let l = self.count % WIDTH;
            (batch.vertex[l], batch.edge[l]) = (batch.vertex[l - 1], batch.edge[l - 1]);
            batch.t[l] = batch.t[l - 1];
            batch.same_edge |= 1 << l;
            self.count += 1;
        }
    }

    /// Returns the number of entries, with padding.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Whether there are no bonds.
    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Computes all forces: those on bonds' vertices into `force`, of [`BondTable::len`] entries, and for each edge that has
    /// bonds the sums of these and of those on y₁ into `sums`, which has one entry for each vertex.
    pub(crate) fn forces(
        &self,
        level: SimdLevel,
        places: &Places,
        force: &mut [PaddedVec3],
        sums: &mut [PaddedPair],
    ) {
        self.check_places(places);
        self.for_each_task(force, sums, &|range, first, force, sums| {
            let batches = &self.batches[range];
            // Safety: `BondTable::new` makes vertices, edges and the second vertices of edges less than the number of
            // positions, edges of the task lie within its sums and slots within its bonds; nothing else changes them.
            unsafe { bonds_at(level, places, batches, first, force, sums) }
        });
    }

    /// Checks that there are as many positions and edges as all indices of bonds ask for.
    pub(super) fn check_places(&self, places: &Places) {
        let (positions, edges) = (places.position.len(), places.edge.len());
        assert!(positions == self.vertices && edges == self.vertices);
    }

    /// Calls `work` for each task with the range of its batches, its first edge, and its part of `force`, one entry for each
    /// bond, and of `sums`, one for each vertex.
    pub(super) fn for_each_task(
        &self,
        force: &mut [PaddedVec3],
        sums: &mut [PaddedPair],
        work: &(impl Fn(Range<usize>, u32, &mut [PaddedVec3], &mut [PaddedPair]) + Sync),
    ) {
        assert!(sums.len() == self.vertices && force.len() == self.len());
        // Sums of edges before the first bond's belong to no task.
        let first = self.tasks[0].edge as usize;
        self.split_tasks(0..self.tasks.len() - 1, force, &mut sums[first..], work);
    }

    fn split_tasks(
        &self,
        tasks: Range<usize>,
        force: &mut [PaddedVec3],
        sums: &mut [PaddedPair],
        work: &(impl Fn(Range<usize>, u32, &mut [PaddedVec3], &mut [PaddedPair]) + Sync),
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
            join(
                || self.split_tasks(tasks.start..middle, f0, s0, work),
                || self.split_tasks(middle..tasks.end, f1, s1, work),
            );
        }
    }

    /// Returns the bundle's bond at an entry of the table; `None` for padding.
    pub(crate) fn bond(&self, entry: usize) -> Option<u32> {
        Some(self.bond[entry]).filter(|b| *b != PADDING)
    }

    /// Returns the entry of one of the bundle's bonds.
    pub(super) fn entry(&self, bond: usize) -> usize {
        self.entry[bond] as usize
    }

    /// Sets the damage of one of the bundle's bonds.
    pub(crate) fn set_damage(&mut self, bundle: &RodBundle, bond: u32, damage: f64) {
        let entry = self.entry[bond as usize] as usize;
        let spring = BondSpring::intact(bundle, bond as usize).damaged(damage);
        self.batches[entry / WIDTH].set_spring(entry % WIDTH, &spring);
    }

    /// Gathers the forces of bonds on the vertices from `first` on into `out`.
    pub(crate) fn gather(
        &self,
        level: SimdLevel,
        bundle: &RodBundle,
        force: &[PaddedVec3],
        sums: &[PaddedPair],
        first: usize,
        out: &mut [PaddedVec3],
    ) {
        let gathering = Gathering {
            offsets: &bundle.bonds.incidence.vertex_offsets,
            slots: &self.force_slot,
            force,
            sums,
        };
        gather(level, &gathering, first, out);
    }
}

/// Eight bonds' vectors e = y₁ − y₀ and d = x − c.
#[derive(Clone, Copy)]
pub(super) struct Vectors<L> {
    pub(super) e: [L; 3],
    pub(super) d: [L; 3],
    t: L,
    /// Components of d along and across the edge.
    pub(super) along: L,
    pub(super) across: L,
    /// One over the edge's length, and over the component across.
    pub(super) by_edge: L,
    pub(super) by_across: L,
}

#[inline(always)]
pub(super) unsafe fn vectors<L: Lanes>(places: &Places, batch: &BondBatch) -> Vectors<L> {
    unsafe {
        let (vertex, edge) = (batch.vertex.as_ptr(), batch.edge.as_ptr());
        let position = places.position.as_ptr();
        let t = L::load(batch.t.as_ptr());
        let (x, y0) = (L::gather(position, vertex), L::gather(position, edge));
        let [ex, ey, ez, by_edge] = L::gather4(places.edge.as_ptr(), edge);
        let (e, s) = ([ex, ey, ez], difference(x, y0));
        let d = [
            s[0].sub(e[0].mul(t)),
            s[1].sub(e[1].mul(t)),
            s[2].sub(e[2].mul(t)),
        ];
        let one = L::splat(1.0);
        let along = dot(e, d).mul(by_edge);
        let across = dot(d, d).sub(along.mul(along)).sqrt();
        Vectors {
            e,
            d,
            t,
            along,
            across,
            by_edge,
            by_across: one.div(across),
        }
    }
}

/// Computes forces of bonds on their vertices into `out`, and their sums for each edge, with those on y₁, into `sums`, whose
/// first entry belongs to edge `first`.
#[inline(always)]
unsafe fn bonds<L: Lanes>(
    places: &Places,
    batches: &[BondBatch],
    first: u32,
    out: &mut [PaddedVec3],
    sums: &mut [PaddedPair],
) {
    unsafe {
        let mut sum = L::splat(0.0);
        // Roots and divisions of the next batch overlap with the forces of this one.
        let mut next = vectors::<L>(places, batches.get_unchecked(0));
        for (i, batch) in batches.iter().enumerate() {
            let now = next;
            let following = (i + 1).min(batches.len() - 1);
            next = vectors::<L>(places, batches.get_unchecked(following));
            let Vectors { e, d, t, .. } = now;
            let opening = now.across.sub(L::load(batch.rest_opening.as_ptr()));
            let stiffness = L::load(batch.opening.as_ptr())
                .where_positive(opening, L::load(batch.closing.as_ptr()));
            let pull = opening.mul(stiffness).mul(now.by_across);
            let shear = now
                .along
                .sub(L::load(batch.rest_slip.as_ptr()))
                .mul(L::load(batch.slip.as_ptr()));
            // With the part of d across the edge, n = d − s e/|e|, the force on x is −(pull n + shear e/|e|), turn = C n, and the
            // force on y₁ is turn − t F.
            let on_edge = now.along.mul(now.by_edge);
            let c = pull
                .mul(now.along)
                .sub(shear.mul(now.across).mul(now.by_across))
                .mul(now.by_edge);
            let push = shear.mul(now.by_edge);
            let (mut on_vertex, mut on_end) = ([t; 3], [t; 3]);
            for k in 0..3 {
                let normal = d[k].sub(e[k].mul(on_edge));
                on_vertex[k] = L::splat(0.0).sub(normal.mul(pull).add(e[k].mul(push)));
                on_end[k] = normal.mul(c).sub(on_vertex[k].mul(t));
            }
            let pairs = L::pairs(on_vertex, on_end);
            for (k, pair) in pairs.into_iter().enumerate() {
                sum = sum.keep_if((batch.same_edge >> k) & 1).add(pair);
                let edge = (batch.edge[k] - first) as usize;
                sum.store(sums.as_mut_ptr().add(edge).cast());
                pair.store_low(out.as_mut_ptr().add(batch.slot[k] as usize).cast());
            }
        }
    }
}

for_each_level! {
    /// [`bonds`] at a level.
    bonds_at = bonds(places: &Places, batches: &[BondBatch], first: u32, out: &mut [PaddedVec3], sums: &mut [PaddedPair])
}

/// What the forces on vertices are gathered from.
struct Gathering<'a> {
    /// Per vertex: its first entry in `slots`.
    offsets: &'a [u32],
    /// Per bond, in order of vertex: where its force is.
    slots: &'a [u32],
    /// Forces on bonds' vertices.
    force: &'a [PaddedVec3],
    /// Per edge: the sums of its bonds' forces.
    sums: &'a [PaddedPair],
}

/// Gathers the forces of bonds on the vertices from `first` on into `out`.
#[inline(always)]
fn gather_inlined(from: &Gathering, first: usize, out: &mut [PaddedVec3]) {
    let mut end = match first.checked_sub(1) {
        Some(j) => second_half(&from.sums[j]),
        None => [0.0; 4],
    };
    for (i, out) in out.iter_mut().enumerate() {
        let v = first + i;
        let pair = &from.sums[v];
        let [a, b, c, d, ..] = pair.0;
        let next = second_half(pair);
        let on_edge = [a, b, c, d];
        let mut sum = end;
        for ((sum, start), end) in sum.iter_mut().zip(on_edge).zip(next) {
            *sum -= start + end;
        }
        end = next;
        for &slot in &from.slots[from.offsets[v] as usize..from.offsets[v + 1] as usize] {
            let f = &from.force[slot as usize];
            for (sum, f) in sum.iter_mut().zip(f.0) {
                *sum += f;
            }
        }
        out.0 = sum;
    }
}

#[inline(always)]
fn second_half(pair: &PaddedPair) -> [f64; 4] {
    let [.., a, b, c, d] = pair.0;
    [a, b, c, d]
}

/// Does the same with registers as wide as a padded vector where the processor has them; wider ones would not help.
fn gather(level: SimdLevel, from: &Gathering, first: usize, out: &mut [PaddedVec3]) {
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn gather_avx2(from: &Gathering, first: usize, out: &mut [PaddedVec3]) {
        gather_inlined(from, first, out);
    }
    #[cfg(target_arch = "x86_64")]
    if level.min(SimdLevel::best()) >= SimdLevel::Avx2 {
        // Safety: the processor has AVX2.
        unsafe { gather_avx2(from, first, out) };
        return;
    }
    let _ = level;
    gather_inlined(from, first, out);
}
