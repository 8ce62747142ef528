//! Compiles kernels for several SIMD levels and picks one at run time.

/// Runs a kernel with AVX2 if the level has it, else with the baseline of the architecture: SSE2,
/// NEON, 128-bit WebAssembly SIMD, or scalar code. AVX-512 is left out: it gained nothing (bilinear
/// 36.5 to 37.5 ms on one core, Catmull-Rom 56 to 54 ms), and every kernel is compiled for each
/// level, format and filter.
macro_rules! dispatch {
    ($level:expr, $simd:ident => $kernel:expr) => {{
        #[cfg(target_arch = "x86_64")]
        match ($level.as_avx2(), $level.as_sse2()) {
            (Some($simd), _) => {
                $simd.vectorize(
                    #[inline(always)]
                    || $kernel,
                )
            }
            (None, Some($simd)) => {
                $simd.vectorize(
                    #[inline(always)]
                    || $kernel,
                )
            }
            (None, None) => unreachable!("x86-64 has SSE2"),
        }
        #[cfg(not(target_arch = "x86_64"))]
        fearless_simd::dispatch!($level, $simd => $kernel)
    }};
}

pub(crate) use dispatch;

/// The SIMD instructions that kernels use on this machine: `AVX2`, `SSE2`, `NEON`, `WebAssembly SIMD` or
/// `none`. Results do not depend on them.
pub fn simd_level() -> &'static str {
    let level = fearless_simd::Level::new();
    #[cfg(target_arch = "x86_64")]
    let name = if level.as_avx2().is_some() { "AVX2" } else { "SSE2" };
    #[cfg(target_arch = "aarch64")]
    let name = if level.as_neon().is_some() { "NEON" } else { "none" };
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let name = {
        let _ = level;
        if cfg!(all(target_arch = "wasm32", target_feature = "simd128")) {
            "WebAssembly SIMD"
        } else {
            "none"
        }
    };
    name
}
