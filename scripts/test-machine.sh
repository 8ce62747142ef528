#!/usr/bin/env bash
# Runs the tests of the core and of the readers on another kind of machine, where rustup has the
# target and Debian the linker, and QEMU where this machine cannot run it:
#
#   scripts/test-machine.sh i686 | big-endian | aarch64 | wasm
#
# With `web`, it compiles the requests of avatars and photographs for WebAssembly instead, and has the tests of the command
# compare what they make under Node with what they make here; arguments after it are cargo's.
#
# Where something is missing, it says what, and skips. In CI (environment variable CI), it installs
# what is missing first, and fails where it cannot.
set -euo pipefail
cd "$(dirname "$0")/.."

kind="${1:?usage: scripts/test-machine.sh i686|big-endian|aarch64|wasm|web}"
shift
cargo="${CARGO:-cargo}"

skip() {
  echo "test-$kind: skipped, since $1"
  [ -z "${CI:-}" ] || exit 1
  exit 0
}

# The target, the linker, Debian's packages and what runs the tests.
case "$kind" in
  i686)
    target=i686-unknown-linux-gnu tool=i686-linux-gnu-gcc runner=
    packages="gcc-i686-linux-gnu libc6-dev-i386-cross"
    ;;
  big-endian)
    target=s390x-unknown-linux-gnu tool=s390x-linux-gnu-gcc runner=qemu-s390x
    packages="gcc-s390x-linux-gnu libc6-dev-s390x-cross qemu-user"
    ;;
  aarch64)
    target=aarch64-unknown-linux-gnu tool=aarch64-linux-gnu-gcc runner=qemu-aarch64
    packages="gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user"
    ;;
  wasm)
    target=wasm32-wasip1 tool=node runner=scripts/run-wasi.mjs
    packages=nodejs
    ;;
  web)
    target=wasm32-unknown-unknown tool=node runner=
    packages=nodejs
    ;;
  *) echo "test-machine: $kind must be i686, big-endian, aarch64, wasm or web" >&2; exit 2 ;;
esac

if [ "$(uname -s)-$(uname -m)" != Linux-x86_64 ]; then
  skip "this is not Linux on x86-64"
fi
if [ "$kind" = aarch64 ] && [ "$(uname -m)" = aarch64 ]; then
  runner=
fi
if ! command -v "$tool" >/dev/null || { [[ "$runner" = qemu-* ]] && ! command -v "$runner" >/dev/null; }; then
  if [ -n "${CI:-}" ] && command -v apt-get >/dev/null; then
    # shellcheck disable=SC2086 # several packages
    { apt-get update -qq && DEBIAN_FRONTEND=noninteractive \
      apt-get install -y -qq --no-install-recommends $packages >/dev/null; } || true
  fi
  command -v "$tool" >/dev/null || skip "there is no $tool (Debian: $packages)"
  [[ "$runner" != qemu-* ]] || command -v "$runner" >/dev/null || skip "there is no $runner ($packages)"
fi
if ! rustup target list --installed 2>/dev/null | grep -qx "$target"; then
  rustup target add "$target" >/dev/null 2>&1 || skip "rustup cannot add the target $target"
fi

if [ "$kind" = web ]; then
  "$cargo" build --locked --target "$target" --profile machines -p uvgraft-assembly --example web --no-default-features
  module="${CARGO_TARGET_DIR:-target}/$target/machines/examples/web.wasm"
  UVGRAFT_WEB_MODULE="$(realpath "$module")" "$cargo" test --locked "$@" --test main -- web::
  exit
fi
variable="CARGO_TARGET_$(echo "$target" | tr a-z- A-Z_)"
if [ "$kind" = wasm ]; then
  export "${variable}_RUNNER=node --no-warnings $PWD/$runner"
  # Without threads. Examples would use files, and readers temporary ones.
  "$cargo" test --locked --target "$target" --profile machines -p uvgraft-surface -p uvgraft --no-default-features --lib
  exit
fi
export "${variable}_LINKER=$tool"
# Static, so that programs run without the libraries of their own system.
export "${variable}_RUSTFLAGS=-C target-feature=+crt-static"
[ -z "$runner" ] || export "${variable}_RUNNER=$runner"
skip=
if [ "$kind" = big-endian ]; then
  # QEMU 7.2 multiplies two floats to a double (the instruction MDEBR) as if they had the bits of doubles,
  # as the reference of this test does: 0.5 times 0.25 is 7.6e-6.
  skip=normals::kernel::tests::agrees_with_the_reference
  echo "test-$kind: $skip is skipped, since QEMU multiplies wrongly"
fi
# Tests that measure memory or send signals are those of the command, which is not run here.
"$cargo" test --locked --target "$target" --profile machines -p uvgraft-surface -p uvgraft -p uvgraft-files -p uvgraft-image -p uvgraft-io \
  --lib --tests -- \
  ${skip:+--skip "$skip"}
