//! The vertices over a node of a stepped surface: one for every distinct height of the facets about it.

/// Most heights over a node that are ranked by counting.
const MAX_COUNTED: usize = 16;

/// The distinct heights over a node, and which of them each facet or cell about it has. Its memory is reused from node to node.
#[derive(Default)]
pub(super) struct HeightColumn {
    /// The distinct heights, ascending; what follows them means nothing.
    ascending: Vec<f64>,
    /// For each height given its number in `ascending`.
    ranks: Vec<u32>,
}

impl HeightColumn {
    /// Ranks `heights` over a node. Returns the distinct ones, ascending, and the number among them of each.
    pub fn rank(&mut self, heights: &[f64]) -> (&[f64], &[u32]) {
        self.ranks.resize(heights.len(), 0);
        self.ascending.resize(MAX_COUNTED.max(heights.len()), 0.0);
        // Most nodes have three or four cells about them, for which nothing branches.
        let distinct = match *heights {
            [a] => self.rank_by_counting(&[a]),
            [a, b] => self.rank_by_counting(&[a, b]),
            [a, b, c] => self.rank_by_counting(&[a, b, c]),
            [a, b, c, d] => self.rank_by_counting(&[a, b, c, d]),
            _ if heights.len() <= MAX_COUNTED => self.rank_by_counting(heights),
            _ => self.rank_by_sorting(heights.iter().copied()),
        };
        (&self.ascending[..distinct], &self.ranks)
    }

    /// Ranks at most [`MAX_COUNTED`] heights.
    #[inline(always)]
    fn rank_by_counting(&mut self, heights: &[f64]) -> usize {
        // Of equal ones the first counts. Which are equal is not to be predicted, so nothing branches on it.
        let mut is_first = [0; MAX_COUNTED];
        let mut distinct = 0;
        for (i, a) in heights.iter().enumerate() {
            let known = heights[..i].iter().fold(false, |known, b| known | (a == b));
            is_first[i] = u32::from(!known);
            distinct += usize::from(!known);
        }
        let ranks = self.ranks.iter_mut().zip(heights);
        for (rank, a) in ranks {
            let less = heights.iter().zip(&is_first);
            *rank = less.map(|(b, first)| u32::from(b < a) & first).sum();
            self.ascending[*rank as usize % MAX_COUNTED] = *a;
        }
        distinct
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
        let (ascending, ranks) = column.rank(heights);
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
