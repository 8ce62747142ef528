#!/usr/bin/env bash
# Checks that the code for other systems compiles, where rustup has their targets: `make check-systems`.
# No C is compiled, so that no linker or headers of these systems are needed. Nothing is run.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo="${CARGO:-cargo}"
for target in x86_64-pc-windows-gnu x86_64-apple-darwin aarch64-apple-darwin; do
  if ! rustup target add "$target" >/dev/null 2>&1; then
    echo "check-systems: $target is skipped, since rustup cannot add it"
    continue
  fi
  "$cargo" check --quiet --locked --target "$target" -p uvgraft-cli --lib --bins
  echo "check-systems: $target compiles"
done
