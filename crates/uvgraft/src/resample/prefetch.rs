//! Asking for memory before it is read. Runs cross the source at any slope, so that processors do not
//! see by themselves what comes next; a row of the target later it is nearby.

/// Rows of the target that what they read is asked for ahead of: as many as take about as long as
/// memory does. Two are a little too late, four not better.
pub(super) const ROWS_AHEAD: i64 = 3;

/// Asks for the value at an index; beyond the slice's ends for nothing.
#[inline(always)]
pub(super) fn prefetch<T>(values: &[T], index: isize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let address = values.as_ptr().wrapping_offset(index).cast();
        #[expect(unsafe_code, reason = "there is no safe name for this instruction")]
        // SAFETY: it is a hint that may name any address, and every x86-64 has it.
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(address);
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (values, index);
}
