//! Pieces through time: which of the pieces that the last frame leaves were one before, and when they separated.

use greenstick_fibre::store::Frame;
use greenstick_geometry::Unions;

/// The separation of a piece from all larger ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Separation {
    /// When, s.
    pub time: f64,
    /// Number of the piece that it was last connected to.
    pub from: usize,
}

/// Tracks pieces, the largest first, each by the first edge of one of its parts of rods.
pub(super) struct SeparationTracker {
    edges: Vec<u32>,
    /// The largest piece that each was connected to last.
    last_connected: Vec<Option<usize>>,
    /// Since when each is separate, s.
    separate_since: Vec<Option<f64>>,
}

impl SeparationTracker {
    /// Tracks the pieces with these edges.
    pub fn new(edges: Vec<u32>) -> Self {
        SeparationTracker {
            last_connected: vec![None; edges.len()],
            separate_since: vec![None; edges.len()],
            edges,
        }
    }

    /// Takes the next frame.
    pub fn push_frame(&mut self, frame: &Frame) {
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
            let first = &mut first_in[unions.root(rod as u32) as usize];
            if *first == usize::MAX {
                *first = piece;
                if self.separate_since[piece].is_none() {
                    self.separate_since[piece] = Some(frame.time);
                }
            } else {
                self.last_connected[piece] = Some(*first);
                self.separate_since[piece] = None;
            }
        }
    }

    /// Returns the separation of each piece; `None` for those that were never connected to a larger one, or still are.
    pub fn separations(&self) -> Vec<Option<Separation>> {
        let both = self.separate_since.iter().zip(&self.last_connected);
        both.map(|(&since, &last)| {
            let (time, from) = since.zip(last)?;
            Some(Separation { time, from })
        })
        .collect()
    }
}
