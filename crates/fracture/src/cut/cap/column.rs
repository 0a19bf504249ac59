//! The vertices over a node of a stepped surface: one for every distinct height of the facets about it.

/// Most facets about a node whose heights are ranked by counting.
const MAX_COUNTED: usize = 16;

/// The distinct heights over a node, and which of them each facet about it has. Its memory is reused from node to node.
#[derive(Default)]
pub(super) struct HeightColumn {
    /// The distinct heights, ascending; what follows them means nothing.
    ascending: Vec<f64>,
    /// For each facet the number of its height in `ascending`.
    ranks: Vec<u32>,
}

impl HeightColumn {
    /// Ranks the `heights` of the facets about a node. Returns the distinct ones, ascending, and the number among them of
    /// each facet's.
    pub fn rank(
        &mut self,
        heights: impl ExactSizeIterator<Item = f64> + Clone,
    ) -> (&[f64], &[u32]) {
        let facets = heights.len();
        self.ranks.resize(facets, 0);
        self.ascending.resize(MAX_COUNTED.max(facets), 0.0);
        let counted = if facets <= MAX_COUNTED {
            self.rank_by_counting(heights.clone())
        } else {
            None
        };
        let distinct = counted.unwrap_or_else(|| self.rank_by_sorting(heights));
        (&self.ascending[..distinct], &self.ranks)
    }

    /// Ranks at most [`MAX_COUNTED`] heights. `None` where facets that do not follow each other have the same one.
    fn rank_by_counting(&mut self, heights: impl Iterator<Item = f64>) -> Option<usize> {
        // Facets of one cell follow each other and mostly have one height. Where the next begins is not to be predicted, so
        // nothing branches on it.
        let mut runs = [f64::NAN; MAX_COUNTED + 1];
        let mut count = 0;
        for (run, height) in self.ranks.iter_mut().zip(heights) {
            count += usize::from(runs[count] != height);
            runs[count] = height;
            *run = count as u32;
        }
        let runs = &runs[..=count];
        let mut rank_of = [0; MAX_COUNTED + 1];
        let mut sum = 0;
        for (rank, a) in rank_of.iter_mut().zip(runs).skip(1) {
            *rank = runs.iter().map(|b| u32::from(b < a)).sum();
            sum += *rank as usize;
        }
        // Equal ones share a rank and leave out the next.
        if sum != count * count.saturating_sub(1) / 2 {
            return None;
        }
        for (&rank, &height) in rank_of.iter().zip(runs).skip(1) {
            self.ascending[rank as usize] = height;
        }
        for run in &mut self.ranks {
            *run = rank_of[*run as usize];
        }
        Some(count)
    }

    /// Ranks any number of heights.
    fn rank_by_sorting(&mut self, heights: impl Iterator<Item = f64> + Clone) -> usize {
        self.ascending.clear();
        self.ascending.extend(heights.clone());
        self.ascending.sort_unstable_by(f64::total_cmp);
        self.ascending.dedup();
        for (rank, h) in self.ranks.iter_mut().zip(heights) {
            *rank = self.ascending.partition_point(|&c| c < h) as u32;
        }
        self.ascending.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(heights: &[f64], column: &mut HeightColumn) {
        let mut distinct = heights.to_vec();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        let (ascending, ranks) = column.rank(heights.iter().copied());
        assert_eq!(ascending, distinct);
        let found: Vec<f64> = ranks.iter().map(|&r| ascending[r as usize]).collect();
        assert_eq!(found, heights);
    }

    #[test]
    fn every_facet_finds_its_height_among_the_distinct_ones() {
        let mut column = HeightColumn::default();
        check(&[2.0, 2.0, 1.0, 3.0, 3.0], &mut column);
        check(&[0.5], &mut column);
        check(&[], &mut column);
        // Equal ones apart, and more than are counted.
        check(&[2.0, 1.0, 2.0, 0.0], &mut column);
        let many: Vec<f64> = (0..40).map(|i| f64::from(i * 7 % 11)).collect();
        check(&many, &mut column);
        check(&[4.0, -1.0, -1.0], &mut column);
    }
}
