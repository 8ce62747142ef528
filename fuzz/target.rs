//! Runs the target that the environment variable `UVGRAFT_FUZZ_TARGET` names.

#![no_main]

use std::sync::LazyLock;

/// Targets that build files by structure see how much memory their readers take.
#[global_allocator]
static ALLOCATOR: uvgraft_fuzz::Allocator = uvgraft_fuzz::Allocator;

static TARGET: LazyLock<uvgraft_fuzz::Target> = LazyLock::new(|| {
    let name = std::env::var("UVGRAFT_FUZZ_TARGET").expect("UVGRAFT_FUZZ_TARGET must name a target");
    uvgraft_fuzz::target(&name).expect("UVGRAFT_FUZZ_TARGET must name a target")
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (TARGET.run)(bytes));
