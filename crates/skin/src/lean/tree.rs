//! The splinters of a broken face as a tree: what stands over a height falls into parts, and every part into smaller ones
//! farther up.
//!
//! This is the join tree of the heights over the cells of the face (Carr, Snoeyink and Axen 2003, *Computing contour trees in
//! all dimensions*). A branch is a splinter: it stands from the height at which it parts from the branch that it grew on up to
//! its tip. Of two that part, the one with the lower tip is the new branch.

use glam::DVec2;
use greenstick_fracture::surface::{FractureSurface, NONE, SectionLayout};

/// Part of the area at its foot below which a splinter counts as much thinner.
const THINNED: f64 = 0.4;

/// A splinter.
#[derive(Debug, Clone)]
pub(super) struct Branch {
    /// The branch that it grew on; [`NONE`] for one that reaches down through the whole section.
    pub parent: u32,
    /// Height at which it parts from it, and its tip.
    pub from: f64,
    pub to: f64,
    /// Areas of the section, m², and the heights below which they are so large, downwards.
    pub areas: Vec<(f64, f64)>,
    /// The way from the middle of what it parts from to its own there, and that middle, m.
    pub aside: DVec2,
    pub middle: DVec2,
}

impl Branch {
    /// Its length, m.
    pub fn length(&self) -> f64 {
        self.to - self.from
    }

    /// Returns the height at which it has become much thinner than at its foot, if it goes on from there for `least` (m).
    fn thinned(&self, least: f64) -> Option<f64> {
        let thin = THINNED * self.foot_area();
        let (at, _) =
            self.areas
                .iter()
                .zip(self.areas.get(1..)?)
                .rev()
                .find_map(|(above, here)| {
                    // Heights are those up to which the section is so large: it gets smaller at the lower one.
                    (above.1 <= thin).then_some(*here)
                })?;
        (at.is_finite() && at > self.from && self.to - at >= least && self.areas[0].0 > at)
            .then_some(at)
    }

    /// Area of its section just above where it parts, m².
    pub fn foot_area(&self) -> f64 {
        self.areas.last().map_or(0.0, |a| a.1)
    }
}

/// The splinters of one side of a face.
#[derive(Debug, Clone, Default)]
pub(super) struct SplinterTree {
    /// As many as there are cells: the branch of each cell's own tip has its number.
    pub branches: Vec<Branch>,
    /// The branches from those that carry others to those that they carry.
    pub order: Vec<u32>,
}

/// A set of cells that hang together above a height.
#[derive(Clone, Copy)]
struct Part {
    branch: u32,
    area: f64,
    /// Sum of the areas' moments, m³.
    moment: DVec2,
}

impl SplinterTree {
    /// Returns the tree of a surface, or with `sign` −1 that of what hangs out of the piece above it. Heights are `sign` times
    /// those of the surface.
    pub fn new(surface: &FractureSurface, sign: f64, cells: usize) -> SplinterTree {
        let layout = surface.layout.as_ref();
        let mut parts: Vec<Part> = (0..cells as u32)
            .map(|branch| Part {
                branch,
                area: 0.0,
                moment: DVec2::ZERO,
            })
            .collect();
        let mut tips = vec![f64::NEG_INFINITY; cells];
        for (f, facet) in layout.facets.iter().enumerate() {
            let [a, b, c] = facet.map(|n| layout.nodes[n as usize]);
            let area = 0.5 * (b - a).perp_dot(c - a).abs();
            let cell = layout.cells[f] as usize;
            parts[cell].area += area;
            parts[cell].moment += (a + b + c) / 3.0 * area;
            for h in surface.heights[f] {
                tips[cell] = tips[cell].max(sign * h);
            }
        }
        let mut links = links(surface, sign);
        links.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut tree = SplinterTree {
            branches: (tips.iter().zip(&parts))
                .map(|(&to, part)| Branch {
                    parent: NONE,
                    from: f64::NEG_INFINITY,
                    to,
                    areas: vec![(to, part.area)],
                    aside: DVec2::ZERO,
                    middle: part.moment / part.area.max(f64::MIN_POSITIVE),
                })
                .collect(),
            order: Vec::with_capacity(cells),
        };
        let mut sets: Vec<u32> = (0..cells as u32).collect();
        for (height, a, b) in links {
            let (a, b) = (find(&mut sets, a), find(&mut sets, b));
            if a == b {
                continue;
            }
            let tip = |set: u32| tree.branches[parts[set as usize].branch as usize].to;
            // Of equal tips the one of the lower number goes on.
            let a_goes_on = tip(a) > tip(b) || (tip(a) == tip(b) && a < b);
            let (on, ends) = if a_goes_on { (a, b) } else { (b, a) };
            let (of_on, of_end) = (parts[on as usize], parts[ends as usize]);
            sets[ends as usize] = on;
            let branch = &mut tree.branches[of_end.branch as usize];
            (branch.parent, branch.from) = (of_on.branch, height);
            let middle = |p: Part| p.moment / p.area.max(f64::MIN_POSITIVE);
            branch.aside = middle(of_end) - middle(of_on);
            branch.middle = middle(of_end);
            tree.order.push(of_end.branch);
            let both = &mut parts[on as usize];
            both.area += of_end.area;
            both.moment += of_end.moment;
            let area = both.area;
            tree.branches[of_on.branch as usize]
                .areas
                .push((height, area));
        }
        let roots = tree
            .branches
            .iter()
            .zip(0..)
            .filter(|(b, _)| b.parent == NONE);
        tree.order
            .extend(roots.map(|(_, number)| number).collect::<Vec<u32>>());
        tree.order.reverse();
        tree
    }

    /// Divides branches where they have become much thinner than they are at their foot, and what is left is `least` (m) long at
    /// least: what a slab ends in bends by itself. What is divided off below has a number of its own.
    pub fn divide(&mut self, least: f64) {
        let mut order = Vec::with_capacity(self.order.len());
        // For each branch the heights up to which its parts reach, and their numbers.
        let mut parts: Vec<Vec<(f64, u32)>> = vec![Vec::new(); self.branches.len()];
        for number in std::mem::take(&mut self.order) {
            let mut upper = self.branches[number as usize].clone();
            if upper.parent != NONE {
                let of = &parts[upper.parent as usize];
                let carrying = of.iter().find(|(to, _)| upper.from <= *to);
                upper.parent = carrying.map_or(upper.parent, |part| part.1);
            }
            while let Some(at) = upper.thinned(least) {
                let made = self.branches.len() as u32;
                let split = upper.areas.iter().position(|area| area.0 <= at);
                let mut lower = upper.clone();
                lower.areas = upper.areas.split_off(split.unwrap_or(upper.areas.len()));
                lower.to = at;
                (upper.parent, upper.from, upper.aside) = (made, at, DVec2::ZERO);
                parts[number as usize].push((at, made));
                order.push(made);
                self.branches.push(lower);
            }
            self.branches[number as usize] = upper;
            order.push(number);
        }
        self.order = order;
    }

    /// Returns the branch that a cell's wood belongs to at a height.
    pub fn branch_at(&self, cell: u32, height: f64) -> u32 {
        let mut branch = cell;
        loop {
            let b = &self.branches[branch as usize];
            if height > b.from || b.parent == NONE {
                return branch;
            }
            branch = b.parent;
        }
    }
}

/// Which cells hang together, and up to which height: wherever they meet in a point, as pieces may do.
fn links(surface: &FractureSurface, sign: f64) -> Vec<(f64, u32, u32)> {
    let layout: &SectionLayout = surface.layout.as_ref();
    let mut links = Vec::new();
    // About every node, the cells in the order of their heights there.
    let mut around: Vec<(u32, f64, u32)> = Vec::with_capacity(3 * layout.facets.len());
    for (f, facet) in layout.facets.iter().enumerate() {
        for (k, &node) in facet.iter().enumerate() {
            around.push((node, -sign * surface.heights[f][k], layout.cells[f]));
        }
    }
    around.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    for pair in around.windows(2) {
        let [(node, _, cell), (other_node, depth, other)] = [pair[0], pair[1]];
        if node == other_node && cell != other {
            links.push((-depth, cell.min(other), cell.max(other)));
        }
    }
    // Along an edge two cells may meet higher than at its ends: where the higher one changes.
    for edge in &layout.edges {
        let [(f, i), (g, k)] = edge.facets;
        if f == NONE || g == NONE || layout.cells[f as usize] == layout.cells[g as usize] {
            continue;
        }
        let [[a, b], [c, d]] = [surface.side_heights(f, i), surface.side_heights(g, k)]
            .map(|heights| heights.map(|h| sign * h));
        let (first, second) = (a - c, b - d);
        if first * second < 0.0 {
            let height = a + (b - a) * (first / (first - second));
            let [one, other] = [f, g].map(|f| layout.cells[f as usize]);
            links.push((height, one.min(other), one.max(other)));
        }
    }
    links
}

/// Returns the representative of a set, with paths halved.
fn find(sets: &mut [u32], mut at: u32) -> u32 {
    while sets[at as usize] != at {
        let up = sets[sets[at as usize] as usize];
        sets[at as usize] = up;
        at = up;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// Columns of these heights beside each other, each of two facets.
    fn columns(heights: &[f64]) -> FractureSurface {
        let nodes = (0..=heights.len())
            .flat_map(|i| [DVec2::new(i as f64, 0.0), DVec2::new(i as f64, 1.0)])
            .collect();
        let facets = (0..heights.len() as u32).flat_map(|i| {
            let n = 2 * i;
            [[n, n + 2, n + 3], [n, n + 3, n + 1]]
        });
        let cells = (0..2 * heights.len() as u32).map(|f| f / 2).collect();
        FractureSurface {
            layout: Arc::new(SectionLayout::new(nodes, facets.collect(), cells)),
            heights: heights.iter().flat_map(|&h| [[h; 3]; 2]).collect(),
        }
    }

    #[test]
    fn splinters_part_where_the_lowest_column_between_them_ends() {
        let surface = columns(&[5.0, 1.0, 3.0, 2.0, 4.0]);
        let tree = SplinterTree::new(&surface, 1.0, 5);
        let b = &tree.branches;
        assert_eq!(b[0].parent, NONE);
        // The two on the right part at 2, and both from the first at 1.
        assert_eq!((b[4].parent, b[4].from), (0, 1.0));
        assert_eq!((b[2].parent, b[2].from), (4, 2.0));
        // Columns that only lead up to others are branches without a length.
        assert_eq!((b[1].length(), b[3].length()), (0.0, 0.0));
        // Above 1 there are the three on the right.
        assert_eq!(b[4].foot_area(), 3.0);
        assert_eq!(tree.branch_at(3, 1.5), 4);
        assert_eq!(tree.branch_at(2, 2.5), 2);
        assert_eq!(tree.branch_at(2, 0.5), 0);
        let place = |n: u32| tree.order.iter().position(|&o| o == n);
        for (i, branch) in b.iter().enumerate().filter(|(_, b)| b.parent != NONE) {
            assert!(place(branch.parent) < place(i as u32));
        }
        // Upside down there is one pit between two others.
        let tree = SplinterTree::new(&surface, -1.0, 5);
        assert_eq!(tree.branches[1].parent, NONE);
        assert_eq!((tree.branches[3].parent, tree.branches[3].from), (1, -3.0));
    }
}
