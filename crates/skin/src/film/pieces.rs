//! Pieces through time: which of the pieces that the last frame leaves were one before, and when they parted.

use greenstick_fibre::store::Frame;
use greenstick_geometry::Unions;

/// When a piece parted from all larger ones, s, and the number of the one it was with last.
pub(super) type Parted = Option<(f64, usize)>;

/// Follows pieces, the largest first, each by the first edge of one of its parts of rods.
pub(super) struct Following {
    edges: Vec<u32>,
    /// The largest piece that each was last seen to be one with.
    with: Vec<Option<usize>>,
    /// When it was first seen to be apart.
    since: Vec<Option<f64>>,
}

impl Following {
    pub fn new(edges: Vec<u32>) -> Self {
        Following {
            with: vec![None; edges.len()],
            since: vec![None; edges.len()],
            edges,
        }
    }

    /// Looks at the next frame.
    pub fn see(&mut self, frame: &Frame) {
        let mut unions = Unions::new(frame.parent.len());
        let rod_of = |vertex: u32| frame.rod_offsets.partition_point(|&f| f <= vertex) as u32 - 1;
        for &[v, e] in &frame.bonds {
            unions.join(rod_of(v), rod_of(e));
        }
        // Rods by the vertex of the unbroken bundle that they begin with.
        let starts: Vec<u32> = (frame.rod_offsets[..frame.parent.len()].iter())
            .map(|&v| frame.origin[v as usize])
            .collect();
        let mut first_in = vec![usize::MAX; frame.parent.len()];
        for (piece, &edge) in self.edges.iter().enumerate() {
            let rod = starts.partition_point(|&s| s <= edge).saturating_sub(1);
            let place = &mut first_in[unions.root(rod as u32) as usize];
            if *place == usize::MAX {
                *place = piece;
                if self.since[piece].is_none() {
                    self.since[piece] = Some(frame.time);
                }
            } else {
                self.with[piece] = Some(*place);
                self.since[piece] = None;
            }
        }
    }

    /// What was seen.
    pub fn parted(&self) -> Vec<Parted> {
        let both = self.since.iter().zip(&self.with);
        both.map(|(&since, &with)| since.zip(with)).collect()
    }
}
