//! Software prefetching. Runs cross the source at any slope, so hardware prefetchers cannot predict
//! the next reads; but a later row of the target reads near the current one.

/// Prefetch distance in target rows: as many as take about as long as a memory access. Two are
/// slightly too late, four are no better.
pub(super) const ROWS_AHEAD: i64 = 3;

/// Prefetches the value at an index, which may be out of bounds without effect.
#[inline(always)]
pub(super) fn prefetch<T>(values: &[T], index: isize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let address = values.as_ptr().wrapping_offset(index).cast();
        #[expect(unsafe_code, reason = "there is no safe name for this instruction")]
        // SAFETY: a prefetch is a hint that accepts any address, and every x86-64 processor has it.
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(address);
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (values, index);
}
