#!/usr/bin/env bash
# Runs clippy on libraries without their default features, among them `threads`: once without any features, and
# once with those named, which must leave rayon out.
#
#   scripts/check-libraries.sh "uvgraft uvgraft-image" uvgraft/serde,uvgraft-image/exr [--target TARGET]
#
# One run checks all libraries, and cargo gives a crate the features that any of them asks for. So that a run does not
# hide what a library forgets to ask for, no library may give another one features that it does not have for all.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo="${CARGO:-cargo}"
read -ra libraries <<<"$1"
features=$2
shift 2
export LC_ALL=C

fail() {
  echo "lint: $1" >&2
  exit 1
}

# What libraries depend on, with the features of each.
tree() {
  "$cargo" tree --locked --no-default-features --edges normal --prefix none --format '{p} [{f}]' "$@"
}

together=()
for library in "${libraries[@]}"; do together+=(-p "$library"); done

"$cargo" clippy --locked "${together[@]}" --no-default-features "$@" -- -D warnings
"$cargo" clippy --locked "${together[@]}" --no-default-features --features "$features" "$@" -- -D warnings

if tree "${together[@]}" --features "$features" "$@" | grep '^rayon'; then
  fail "rayon must not be a dependency without the feature threads"
fi
found=$(tree "${together[@]}" "$@")
for library in "${libraries[@]}"; do
  alone=$(tree -p "$library" "$@" | sed -n 's/ (\*)$//; /^uvgraft/p' | sort -u)
  more=$(comm -23 <(echo "$alone") <(echo "$found" | sed 's/ (\*)$//' | sort -u))
  [ -z "$more" ] || fail "$library is checked with other features than it has alone: $more"
done
