//! Fuzz targets: every reader of files, and kernels against their references.
//!
//! A target is a function of bytes that must end, without a panic, in a time and with memory that
//! suit the bytes. The same targets run in two ways: `cargo fuzz` lets coverage guide the bytes (the
//! binaries are in `fuzz/`), and the tests of this crate mutate the seeds with a seeded generator.

mod differential;
mod exr_seeds;
mod mutation;
mod readers;
mod sealed;
mod seeds;
mod tflite_seed;
mod tiff_seeds;

pub use mutation::Mutator;
pub use sealed::png_resealed;

/// Something to fuzz.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Its name, which is also that of its binary and of its folder of regressions.
    pub name: &'static str,
    /// What is called with the bytes.
    pub run: fn(&[u8]),
    /// Valid files to start from.
    pub seeds: fn() -> Vec<Vec<u8>>,
}

macro_rules! targets {
    ($($module:ident::$name:ident),* $(,)?) => {
        /// All targets.
        pub const TARGETS: &[Target] = &[$(Target {
            name: stringify!($name),
            run: $module::$name,
            seeds: seeds::$name,
        }),*];
    };
}

targets![
    readers::obj,
    readers::ply,
    readers::glb,
    readers::npy,
    readers::npz,
    readers::pickle,
    readers::torch,
    readers::tflite,
    readers::image,
    readers::pair_file,
    readers::map_file,
    readers::vertex_map,
    readers::vertex_list,
    readers::vertex_groups,
    readers::correspondence_table,
    readers::body_model,
    readers::motion,
    readers::networks,
    readers::imports,
    differential::resampling,
    differential::png_round_trip,
];

/// The target of a name.
pub fn target(name: &str) -> Option<Target> {
    TARGETS.iter().find(|target| target.name == name).copied()
}

/// Runs the target of a name, which the binaries of `cargo fuzz` do.
///
/// # Panics
/// If there is none, or the target does.
pub fn run(name: &str, bytes: &[u8]) {
    let target = target(name).unwrap_or_else(|| panic!("no target {name}"));
    (target.run)(bytes);
}
