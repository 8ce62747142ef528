#!/usr/bin/env bash
# Looks for undefined behaviour with Miri, or for memory errors with the address sanitizer:
#
#   scripts/test-memory.sh miri | asan
#
# Both need the nightly toolchain; where it or a component is missing, they say so and skip.
set -euo pipefail
cd "$(dirname "$0")/.."

kind="${1:?usage: scripts/test-memory.sh miri|asan}"
skip() {
  echo "test-$kind: skipped, since $1"
  exit 0
}
cargo +nightly --version >/dev/null 2>&1 || skip "there is no nightly toolchain"

case "$kind" in
  miri)
    rustup +nightly component add miri rust-src >/dev/null 2>&1 || skip "nightly has no Miri today"
    # Miri is a thousand times slower: the parts of the core whose tests are small. It has no SIMD of
    # processors, so that kernels run as scalar code, and rounds functions such as powers at random unless
    # told otherwise. The queues of the thread pool (crossbeam-epoch) break the stricter of its two rules
    # on pointers.
    export MIRIFLAGS="-Zmiri-disable-isolation -Zmiri-deterministic-floats -Zmiri-tree-borrows"
    cargo +nightly miri test --locked -p uvgraft-surface -p uvgraft --no-default-features --lib -- \
      bits:: disjoint:: tile:: texture:: color:: piece:: islands:: resample::path resample::plan \
      raster:: matrix:: edges:: map::rows threads:: --skip thousands --skip the_matrix_is --skip a_fan
    ;;
  asan)
    rustup +nightly component add rust-src >/dev/null 2>&1 || skip "nightly has no sources today"
    host="$(rustc -vV | sed -n 's/^host: //p')"
    # Builds of C++ follow these flags. The linker folds equal constants of FLIP into one, which looks
    # like two definitions of one name.
    export RUSTFLAGS="-Zsanitizer=address" ASAN_OPTIONS=detect_leaks=0:detect_odr_violation=0
    # The prefetch of kernels, and the features in C++.
    cargo +nightly test --locked --target "$host" --profile machines --target-dir target/asan \
      -p uvgraft --lib -- resample
    cargo +nightly test --locked --target "$host" --profile machines --target-dir target/asan \
      -p uvgraft-metrics --features flip --lib -- flip
    cargo +nightly test --locked --target "$host" --profile machines --target-dir target/asan \
      -p uvgraft-gltf --features simplify,ktx2 --lib
    ;;
  *) echo "test-memory: $kind must be miri or asan" >&2; exit 2 ;;
esac
