//! Distances from the points of a cloud to their nearest neighbours, searched once for all steps of the cleaning.

use super::KdTree;
use super::batches::map_in_batches;
use crate::{Cancelled, Context};
use glam::DVec3;

/// Neighbours whose mean distance shows outliers.
pub(super) const NEIGHBOURS: usize = 8;
/// Most points whose distances [`spacing`] takes the median of.
const MAX_SAMPLE: usize = 100_000;

/// Points with the distances to their nearest neighbours. Points can be removed; distances are then those to the points
/// that remain.
pub(super) struct NeighbourDistances {
    points: Vec<DVec3>,
    tree: KdTree,
    /// For each point the mean distance to its nearest neighbours, m.
    pub means: Vec<f64>,
    /// For each point the two nearest others, as squared distance and number.
    nearest: Vec<[(f64, u32); 2]>,
    /// Numbers of the points that remain, ascending.
    remaining: Vec<u32>,
    /// For each point whether it remains.
    remains: Vec<bool>,
}

/// Distances from a point to the nearest and the second nearest other, m; infinite where there is none.
#[derive(Clone, Copy)]
struct TwoNearest {
    first: f64,
    second: f64,
}

impl NeighbourDistances {
    /// Searches the neighbours of all points.
    pub fn new(points: &[DVec3], context: &Context) -> Result<Self, Cancelled> {
        let tree = KdTree::try_new(points, context)?;
        let search = |p: &DVec3| {
            let near = tree.nearest(*p, NEIGHBOURS + 1);
            let sum: f64 = near.iter().skip(1).map(|n| n.0.sqrt()).sum();
            let other = |k: usize| near.get(k).copied().unwrap_or((f64::INFINITY, u32::MAX));
            let mean = sum / (near.len().max(2) - 1) as f64;
            (mean, [other(1), other(2)])
        };
        let found = map_in_batches(points, context, search)?;
        let (means, nearest) = found.into_iter().unzip();
        Ok(NeighbourDistances {
            points: points.to_vec(),
            tree,
            means,
            nearest,
            remaining: (0..points.len() as u32).collect(),
            remains: vec![true; points.len()],
        })
    }

    /// Removes all points but these, given by their places among those that remain.
    pub fn retain(&mut self, places: &[u32]) {
        self.remaining = places.iter().map(|&k| self.remaining[k as usize]).collect();
        self.remains.fill(false);
        for &i in &self.remaining {
            self.remains[i as usize] = true;
        }
    }

    /// Distances from a point to the two nearest others that remain.
    fn two_nearest(&self, i: u32) -> TwoNearest {
        let known = self.nearest[i as usize];
        if known
            .iter()
            .all(|n| self.remains.get(n.1 as usize) == Some(&true))
        {
            return TwoNearest {
                first: known[0].0.sqrt(),
                second: known[1].0.sqrt(),
            };
        }
        let mut count = 4 * NEIGHBOURS;
        loop {
            let near = self.tree.nearest(self.points[i as usize], count);
            let mut others = near
                .iter()
                .filter(|n| n.1 != i && self.remains[n.1 as usize]);
            let first = others.next().map(|n| n.0.sqrt());
            let second = others.next().map(|n| n.0.sqrt());
            if second.is_some() || near.len() < count {
                return TwoNearest {
                    first: first.unwrap_or(f64::INFINITY),
                    second: second.unwrap_or(f64::INFINITY),
                };
            }
            count *= 4;
        }
    }

    /// Finds the points that have two others within `spacings` median spacings, by their places among those that remain.
    /// Also returns that radius, m.
    pub fn connected(
        &self,
        spacings: f64,
        context: &Context,
    ) -> Result<(Vec<u32>, f64), Cancelled> {
        let distances = map_in_batches(&self.remaining, context, |&i| self.two_nearest(i))?;
        let radius = spacings * median(distances.iter().map(|d| d.first).collect());
        let connected = (0..distances.len() as u32)
            .filter(|&k| distances[k as usize].second <= radius)
            .collect();
        Ok((connected, radius))
    }

    /// Median distance from a point to the nearest other, m.
    pub fn spacing(&self, context: &Context) -> Result<f64, Cancelled> {
        let nearest = map_in_batches(&self.remaining, context, |&i| self.two_nearest(i).first)?;
        Ok(median(nearest))
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Returns the median distance from a point to the nearest other, m; where there are many points that of a hundred
/// thousand at even steps. Where most points are there twice, the median is that of those which are not; zero where all
/// are.
///
/// # Errors
/// [`Cancelled`] where the caller asked to stop.
pub fn spacing(points: &[DVec3], context: &Context) -> Result<f64, Cancelled> {
    if points.len() < 2 {
        return Ok(0.0);
    }
    let tree = KdTree::try_new(points, context)?;
    let stride = points.len().div_ceil(MAX_SAMPLE);
    let sample: Vec<DVec3> = points.iter().step_by(stride).copied().collect();
    let nearest = |p: &DVec3| tree.nearest(*p, 2)[1].0.sqrt();
    let mut distances = map_in_batches(&sample, context, nearest)?;
    let middle = median(distances.clone());
    if middle > 0.0 {
        return Ok(middle);
    }
    distances.retain(|&d| d > 0.0);
    Ok(median(distances))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_that_are_there_twice_do_not_change_the_spacing() {
        let mut points: Vec<DVec3> = (0..50).map(|i| DVec3::X * f64::from(i) * 0.1).collect();
        let context = Context::default();
        let once = spacing(&points, &context).unwrap();
        points.extend_from_within(..40);
        assert!((spacing(&points, &context).unwrap() - once).abs() < 1e-12);
        assert_eq!(spacing(&[DVec3::ONE; 9], &context).unwrap(), 0.0);
    }
}
