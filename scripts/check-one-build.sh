#!/usr/bin/env bash
# Checks that the Python package compiles each crate with the features it has in the tests. Where one build serves
# everything, any other feature compiles that crate, and all that is built on it, a second time: minutes, in silence.
#
#   scripts/check-one-build.sh "FEATURES OF THE WORKSPACE" "FEATURES OF THE PACKAGE"
set -euo pipefail
cd "$(dirname "$0")/.."
cargo="${CARGO:-cargo}"
read -ra workspace <<<"$1"
package=$2
export LC_ALL=C

# crates OPTIONS: each crate with its features, in order.
crates() {
  "$cargo" tree --locked --prefix none --format '{p} [{f}]' "$@" | sed 's/ (\*)$//' | sort -u
}

tests=$(crates --workspace "${workspace[@]}" --edges normal,build,dev)
wheel=$(crates -p uvgraft-python --features "$package" --edges normal,build | grep -v '^uvgraft-python ')
twice=$(comm -13 <(echo "$tests") <(echo "$wheel"))
if [ -n "$twice" ]; then
  echo "lint: these crates have other features in the Python package than in the tests, and are compiled twice:" >&2
  echo "$twice" >&2
  exit 1
fi
