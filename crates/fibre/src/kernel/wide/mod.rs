//! Loops on wide registers: the one module with unsafe code. What it asks of its callers is checked where it is called
//! from safe code: lengths of arrays, and that the processor has the instructions of a [`Level`].
#![allow(unsafe_code)]

pub mod bands;
pub mod bonds;
pub mod lanes;
pub mod outer;
pub mod own;
pub mod rods;
pub mod slopes;
pub mod watch;
#[cfg(target_arch = "x86_64")]
pub mod x86;
