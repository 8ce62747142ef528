//! Fuzz targets: every reader of files, and kernels against their references.
//!
//! A target is a function of bytes that must end, without a panic, in a time and with memory that
//! suit the bytes. The bytes are a file, or choices of which a file is built (`structured/`). The same
//! targets run in two ways: `cargo fuzz` lets coverage guide the bytes (the binaries are in `fuzz/`), and
//! the tests of this crate mutate the seeds, or make choices, with a seeded generator.

mod differential;
mod exr_seeds;
mod mutation;
mod oracle;
mod readers;
mod sealed;
mod seeds;
mod structured;
mod tflite_seed;
mod tiff_seeds;

pub use mutation::Mutator;
pub use oracle::highest;
/// Counts the memory of a program that has it as its global allocator. Without it, targets that build
/// files by structure do not see how much memory their readers take.
pub use peak_alloc::PeakAlloc as Allocator;
pub use sealed::png_resealed;
pub use structured::random_choices;

/// Makes a file of choices.
pub type Builder = fn(&[u8]) -> Vec<u8>;

/// Something to fuzz.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Its name, which is also that of its binary and of its folder of regressions.
    pub name: &'static str,
    /// What is called with the bytes.
    pub run: fn(&[u8]),
    /// Valid files, or choices, to start from.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// What makes a file of the bytes, if these are choices.
    pub file: Option<Builder>,
}

macro_rules! targets {
    ($($module:ident::$name:ident),* ; $($structured:ident: $generator:ident),* $(,)?) => {
        /// All targets.
        pub const TARGETS: &[Target] = &[
            $(Target {
                name: stringify!($name),
                run: $module::$name,
                seeds: seeds::$name,
                file: None,
            },)*
            $(Target {
                name: stringify!($structured),
                run: structured::$generator::run,
                seeds: structured::choices,
                file: Some(structured::$generator::file),
            },)*
        ];
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
    differential::png_round_trip;
    structured_gltf: scene,
    structured_vrm0: vrm0,
    structured_vrm1: vrm1,
    structured_vrma: vrma,
    structured_draco: draco,
    structured_ktx2: ktx2,
    structured_npy: npy,
    structured_npz: npz,
    structured_pickle: pickle,
    structured_torch: torch,
    structured_tflite: tflite,
    structured_png: png,
    structured_jpeg: jpeg,
    structured_webp: webp,
    structured_tiff: tiff,
    structured_exr: exr,
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
