//! Following the outline through a face, along its own lines and along the border of the face.

/// Directed edges of the outline on one face as (from, to), sorted.
pub(super) type Chains<'a> = &'a [(u32, u32)];

/// The vertex after `id`.
fn after(chains: Chains, id: u32) -> Option<u32> {
    let i = chains.partition_point(|c| c.0 < id);
    chains.get(i).filter(|c| c.0 == id).map(|c| c.1)
}

/// What [`follow`] finds.
pub(super) struct Traced {
    /// Closed loops.
    pub loops: Vec<Vec<u32>>,
    /// Border vertices that the loops pass.
    pub border: Vec<u32>,
    /// Whether the outline meets the border.
    pub met: bool,
}

/// Follows the outline's chains and, from the end of one to the start of the next, the border (counter-clockwise).
pub(super) fn follow(chains: Chains, border: &[u32]) -> Option<Traced> {
    let mut places: Vec<(u32, usize)> = border.iter().enumerate().map(|(i, &id)| (id, i)).collect();
    places.sort_unstable();
    let place = |id: u32| {
        let i = places.partition_point(|p| p.0 < id);
        places.get(i).filter(|p| p.0 == id).map(|p| p.1)
    };
    let mut ends: Vec<u32> = chains.iter().map(|c| c.1).collect();
    ends.sort_unstable();
    // Starts of chains on the border, as (place, vertex), around it.
    let mut starts: Vec<(usize, u32)> = chains
        .iter()
        .filter(|c| ends.binary_search(&c.0).is_err())
        .filter_map(|c| place(c.0).map(|p| (p, c.0)))
        .collect();
    starts.sort_unstable();
    let mut traced = Traced {
        loops: Vec::new(),
        border: Vec::new(),
        met: !starts.is_empty(),
    };
    let mut used: Vec<bool> = vec![false; starts.len()];
    let mut passed = 0;
    for first in 0..starts.len() {
        if used[first] {
            continue;
        }
        let mut corners = Vec::new();
        let mut current = first;
        loop {
            used[current] = true;
            let mut id = starts[current].1;
            corners.push(id);
            while let Some(next) = after(chains, id) {
                id = next;
                corners.push(id);
                passed += 1;
                if passed > chains.len() {
                    return None;
                }
            }
            let mut i = place(id)?;
            loop {
                i = (i + 1) % border.len();
                if let Ok(n) = starts.binary_search_by_key(&i, |s| s.0) {
                    current = n;
                    break;
                }
                corners.push(border[i]);
                traced.border.push(border[i]);
                if corners.len() > border.len() + chains.len() + 2 {
                    return None;
                }
            }
            if current == first {
                break;
            }
            if used[current] {
                return None;
            }
        }
        traced.loops.push(corners);
    }
    if passed < chains.len() {
        close(chains, &mut traced);
    }
    Some(traced)
}

/// What is left must be closed loops (or chains of another part of this face).
fn close(chains: Chains, traced: &mut Traced) {
    let mut seen: Vec<u32> = traced.loops.iter().flatten().copied().collect();
    seen.sort_unstable();
    for &(first, second) in chains {
        if seen.binary_search(&first).is_ok() {
            continue;
        }
        let mut corners = vec![first];
        let mut id = second;
        while id != first {
            match after(chains, id) {
                Some(next) if corners.len() <= chains.len() => {
                    corners.push(id);
                    id = next;
                }
                _ => {
                    corners.clear();
                    break;
                }
            }
        }
        if !corners.is_empty() {
            seen.extend(&corners);
            seen.sort_unstable();
            traced.loops.push(corners);
        }
    }
}
