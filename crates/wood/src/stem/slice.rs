//! The lines in which a plane cuts a shell, chained from the segments in which it cuts triangles.

use glam::DVec3;

/// A connected line in which a plane cuts a shell.
#[derive(Debug, Clone)]
pub(crate) struct SliceLine {
    pub points: Vec<DVec3>,
    /// Numbers of the triangles crossed, in the mesh.
    pub triangles: Vec<u32>,
    pub closed: bool,
}

/// An end of a segment: the edge it lies on, as a key, and where.
#[derive(Debug, Clone, Copy)]
pub(super) struct SegmentEnd {
    pub edge: u64,
    pub at: DVec3,
}

/// The part of the plane within one triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    pub ends: [SegmentEnd; 2],
    /// Number of the triangle in the mesh.
    pub triangle: u32,
}

/// Cuts a triangle by a plane, given its corners' point numbers, positions and heights above the plane. `None` where the
/// triangle does not cross it. A corner in the plane counts as below it.
pub(super) fn cut_triangle(
    numbers: [u32; 3],
    corners: [DVec3; 3],
    heights: [f64; 3],
) -> Option<[SegmentEnd; 2]> {
    let above = heights.map(|h| h > 0.0);
    if above[0] == above[1] && above[1] == above[2] {
        return None;
    }
    let lone =
        (0..3).find(|&k| above[k] != above[(k + 1) % 3] && above[k] != above[(k + 2) % 3])?;
    Some([(lone + 1) % 3, (lone + 2) % 3].map(|other| {
        // From the smaller point number to the larger: both triangles of an edge get the same bits.
        let (a, b) = if numbers[lone] < numbers[other] {
            (lone, other)
        } else {
            (other, lone)
        };
        let (p, q) = (corners[a], corners[b]);
        SegmentEnd {
            edge: (u64::from(numbers[a]) << 32) | u64::from(numbers[b]),
            at: p + (q - p) * (heights[a] / (heights[a] - heights[b])),
        }
    }))
}

/// Joins segments at equal edges into lines: open ones first, then closed ones.
pub(super) fn chain(segments: &[Segment]) -> Vec<SliceLine> {
    const NONE: u32 = u32::MAX;
    let partner = partners(segments);
    let mut used = vec![false; segments.len()];
    let mut lines = Vec::new();
    // Ends are numbered 2 · segment + side.
    let mut follow = |start: usize, used: &mut Vec<bool>| {
        let mut line = SliceLine {
            points: Vec::new(),
            triangles: Vec::new(),
            closed: false,
        };
        let mut end = start;
        loop {
            let (segment, side) = (end / 2, end % 2);
            used[segment] = true;
            line.points.push(segments[segment].ends[side].at);
            line.triangles.push(segments[segment].triangle);
            let next = partner[end ^ 1];
            if next == NONE {
                line.points.push(segments[segment].ends[1 - side].at);
                break;
            }
            end = next as usize;
            if used[end / 2] {
                line.closed = end == start;
                break;
            }
        }
        lines.push(line);
    };
    for (end, &other) in partner.iter().enumerate() {
        if other == NONE && !used[end / 2] {
            follow(end, &mut used);
        }
    }
    for segment in 0..segments.len() {
        if !used[segment] {
            follow(2 * segment, &mut used);
        }
    }
    lines
}

/// For each end of a segment the end that it is joined to. Ends on one edge are joined two by two; one that is left over
/// (`u32::MAX`) is a border of the surface.
fn partners(segments: &[Segment]) -> Vec<u32> {
    let mut ends: Vec<(u64, u32)> = Vec::with_capacity(segments.len() * 2);
    for (i, segment) in segments.iter().enumerate() {
        ends.push((segment.ends[0].edge, 2 * i as u32));
        ends.push((segment.ends[1].edge, 2 * i as u32 + 1));
    }
    ends.sort_unstable();
    let mut partner = vec![u32::MAX; ends.len()];
    let mut i = 0;
    while i + 1 < ends.len() {
        if ends[i].0 == ends[i + 1].0 {
            partner[ends[i].1 as usize] = ends[i + 1].1;
            partner[ends[i + 1].1 as usize] = ends[i].1;
            i += 2;
        } else {
            i += 1;
        }
    }
    partner
}
