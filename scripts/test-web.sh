#!/usr/bin/env bash
# Compiles the requests of avatars and photographs for WebAssembly, and has the tests of the command compare what they make
# under Node with what they make here. Arguments are for cargo.
#
# Where something is missing, it says what, and skips. In CI (environment variable CI), it fails instead.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo="${CARGO:-cargo}"
target=wasm32-unknown-unknown

skip() {
  echo "test-web: skipped, since $1"
  [ -z "${CI:-}" ] || exit 1
  exit 0
}

command -v node >/dev/null || skip "there is no node (Debian: nodejs)"
if ! rustup target list --installed 2>/dev/null | grep -qx "$target"; then
  rustup target add "$target" >/dev/null 2>&1 || skip "rustup cannot add the target $target"
fi
"$cargo" build --locked --target "$target" --profile machines -p uvgraft-assembly --example web --no-default-features
module="${CARGO_TARGET_DIR:-target}/$target/machines/examples/web.wasm"
UVGRAFT_WEB_MODULE="$(realpath "$module")" "$cargo" test --locked "$@" --test main -- web::
