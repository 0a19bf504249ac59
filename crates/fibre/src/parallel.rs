//! Work shared among the threads of the caller's pool. Nothing here starts a thread.

/// Does both, on two threads where the pool has them.
pub(crate) fn join(a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    if rayon::current_num_threads() > 1 {
        rayon::join(a, b);
    } else {
        a();
        b();
    }
}

/// Runs `work` on a thread of the pool, so that the pieces that it is divided into need not each enter the pool from
/// outside, which costs more than a piece.
pub(crate) fn in_pool<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    rayon::join(work, || ()).0
}
