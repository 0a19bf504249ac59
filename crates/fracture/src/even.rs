//! Steps between bundles of brittle wood that run out on the slant.

use crate::ends::EndNode;
use crate::layout::FibreBundle;
use glam::DVec2;
use greenstick_wood::noise;

/// How much of the steps between bundles runs out on the slant where brittle wood broke: least and greatest share, and how often
/// that changes over a radius.
const SLANTED: (f64, f64) = (0.2, 0.85);
const SLANTED_PATCHES: f64 = 3.5;

/// Lets steps between the bundles of brittle wood run out on the slant, here more and there less, so that their edges are no walls
/// along rings and rays. `nodes` have these heights, and `at` returns where a node is, in radii from the pith.
pub(crate) fn even_out(
    heights: &mut [f64],
    nodes: &[EndNode],
    (bundles, at): (&[FibreBundle], &impl Fn(u32) -> DVec2),
    brittle: f64,
    seed: u64,
) {
    let count = nodes.iter().map(|n| n.node as usize + 1).max().unwrap_or(0);
    // Bark tears by itself: each node has a mean of wood and one of bark.
    let mut sums = vec![[(0.0, 0.0); 2]; count];
    let kind = |node: &EndNode| usize::from(bundles[node.cell as usize].bark);
    for (height, node) in heights.iter().zip(nodes) {
        let sum = &mut sums[node.node as usize][kind(node)];
        *sum = (sum.0 + height, sum.1 + 1.0);
    }
    let (least, most) = SLANTED;
    for (height, node) in heights.iter_mut().zip(nodes) {
        let (sum, of) = sums[node.node as usize][kind(node)];
        let patch = noise::gradient_2d(seed + (9 << 40), at(node.node) * SLANTED_PATCHES);
        let share = least + (most - least) * noise::smoothstep(-0.1, 0.35, patch);
        *height += brittle * share * (sum / of - *height);
    }
}
