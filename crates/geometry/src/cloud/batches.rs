//! Work on many points in batches, so that the caller can stop it between them.

use crate::{Cancelled, Context};
use rayon::prelude::*;

/// Points in a batch: a few milliseconds of neighbour search on one thread.
const BATCH_SIZE: usize = 1 << 12;

/// Maps all items in parallel, in their order, and reports progress.
///
/// # Errors
/// [`Cancelled`] where the caller asked to stop.
pub(super) fn map_in_batches<T: Sync, R: Send>(
    items: &[T],
    context: &Context,
    map: impl Fn(&T) -> R + Sync,
) -> Result<Vec<R>, Cancelled> {
    let mut mapped = Vec::with_capacity(items.len());
    let threads = rayon::current_num_threads();
    for batch in items.chunks(BATCH_SIZE * threads) {
        context.report(mapped.len() as f64 / items.len() as f64)?;
        mapped.par_extend(batch.par_iter().map(&map));
    }
    Ok(mapped)
}
