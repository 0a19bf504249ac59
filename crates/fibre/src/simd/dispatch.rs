//! Functions compiled for several instruction sets, of which the widest that the processor has is called.

/// Defines `$name`, which calls `$generic` with the widest instructions up to a level, from functions compiled for each.
macro_rules! for_each_level {
    ($(#[$doc:meta])* $name:ident = $generic:ident($($argument:ident: $type:ty),* $(,)?)) => {
        $(#[$doc])*
        ///
        /// # Safety
        /// As for the generic function. The level is limited to the instructions that the processor has.
        unsafe fn $name(level: $crate::simd::level::SimdLevel, $($argument: $type),*) {
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx512f,avx2")]
            unsafe fn wide512($($argument: $type),*) {
                unsafe { $generic::<$crate::simd::x86::Wide512>($($argument),*) }
            }
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2")]
            unsafe fn wide256($($argument: $type),*) {
                unsafe { $generic::<$crate::simd::x86::Wide256>($($argument),*) }
            }
            use $crate::simd::lanes::Scalar;
            use $crate::simd::level::SimdLevel;
            unsafe {
                match level.min(SimdLevel::best()) {
                    #[cfg(target_arch = "x86_64")]
                    SimdLevel::Avx512 => wide512($($argument),*),
                    #[cfg(target_arch = "x86_64")]
                    SimdLevel::Avx2 => wide256($($argument),*),
                    _ => $generic::<Scalar>($($argument),*),
                }
            }
        }
    };
}
pub(crate) use for_each_level;

/// Runs `work` compiled for the widest registers of the processor, for loops that the compiler vectorises by itself. Only
/// what is always inlined takes part, so the closure itself must be marked `#[inline(always)]`.
///
/// The compiler fuses no operations of its own accord, so that the result has the same bits at every level.
#[inline(always)]
pub(crate) fn with_widest_registers<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx2")
        {
            // Safety: the processor has these instructions.
            return unsafe { with_avx512(work) };
        }
        if is_x86_feature_detected!("avx2") {
            // Safety: the processor has these instructions.
            return unsafe { with_avx2(work) };
        }
    }
    work()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2")]
unsafe fn with_avx512<R>(work: impl FnOnce() -> R) -> R {
    work()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn with_avx2<R>(work: impl FnOnce() -> R) -> R {
    work()
}
