#!/bin/sh
# Checks that the libraries build for wasm32-unknown-unknown, which has no threads, files or clock, and
# 32-bit addresses; arguments are those of scripts/check-libraries.sh.
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

CARGO=$cargo scripts/check-libraries.sh "$@" --target $target
