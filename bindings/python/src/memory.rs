//! Memory that an allocator keeps although nothing uses it.

use pyo3::prelude::*;

/// Gives freed memory back to the system after work that needs much of it for a moment.
///
/// The allocator of glibc keeps an arena for each thread, and of an arena all below its last block.
pub(crate) fn give_back(py: Python<'_>) {
    py.detach(|| {
        #[cfg(all(target_os = "linux", target_env = "gnu"))]
        #[expect(unsafe_code, reason = "a function of the C library")]
        // SAFETY: may be called by any thread at any time; it locks what it looks at.
        unsafe {
            libc::malloc_trim(0);
        }
    });
}
