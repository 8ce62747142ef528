#!/bin/sh
# Checks that the libraries build for wasm32-unknown-unknown, which has no threads, files or clock, and
# 32-bit addresses: without their default features, alone and with all features that need no C++.
#
# Adds the target with rustup if it is missing. Without rustup or a network it reports that it is skipped
# and succeeds.
set -eu

cd "$(dirname "$0")/.."
target=wasm32-unknown-unknown
cargo=${CARGO:-cargo}

have_target() {
    [ -n "$(find "$(rustc --print target-libdir --target $target)" -name 'libcore-*' 2>/dev/null)" ]
}

skip() {
    echo "check-wasm: skipped, there is no target $target: $1" >&2
    exit 0
}

if ! have_target; then
    command -v rustup >/dev/null || skip "rustup is missing too"
    rustup target add $target >&2 || skip "rustup could not add it"
    have_target || skip "rustup added it to another toolchain"
fi

check() {
    "$cargo" clippy --locked --target $target --no-default-features "$@" -- -D warnings
}

check -p uvgraft
check -p uvgraft --features serde
check -p uvgraft-metrics
check -p uvgraft-metrics --features lpips,serde,ssimulacra2
check -p uvgraft-io
check -p uvgraft-io --features lpips
check -p uvgraft-avatar
check -p uvgraft-gltf
check -p uvgraft-render
check -p uvgraft-figure
check -p uvgraft-pipeline
