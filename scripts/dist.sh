#!/usr/bin/env bash
# Builds what a release consists of, in target/dist: `make dist`. The same sources make the same bytes.
#
# - a static program for Linux on x86-64 (musl), without the features that need C++, in an archive
# - a wheel for CPython 3.10 and glibc 2.28 and later, if `make wheel` can make one
# - the list of everything that is in them (CycloneDX), if cargo-cyclonedx is there or can be installed
# - SHA256SUMS
set -euo pipefail
cd "$(dirname "$0")/.."

cargo="${CARGO:-cargo}"
dist="${DIST:-$PWD/target/dist}"
build="${DIST_BUILD:-$PWD/target/dist-build}"
target="$(uname -m)-unknown-linux-musl"
version="$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)"

skip() {
  echo "dist: $1 is left out, since $2"
}

# What depends on the day, the folder or the machine must not be in the bytes.
UVGRAFT_COMMIT="${UVGRAFT_COMMIT:-$(git rev-parse HEAD 2>/dev/null || true)}"
SOURCE_DATE_EPOCH="${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || echo 315532800)}"
export UVGRAFT_COMMIT SOURCE_DATE_EPOCH CARGO_INCREMENTAL=0 LC_ALL=C TZ=UTC
cargo_home="${CARGO_HOME:-$HOME/.cargo}"
remap="--remap-path-prefix=$PWD=uvgraft --remap-path-prefix=$cargo_home=cargo"
remap="$remap --remap-path-prefix=$build=build"

rm -rf "$dist"
mkdir -p "$dist"

if ! command -v rustup >/dev/null || ! rustup target add "$target" >/dev/null 2>&1; then
  skip "the static program" "rustup cannot add the target $target"
else
  scripts/build-viewer.sh
  viewer=()
  [ ! -s target/viewer/viewer.html ] || viewer=(--features viewer)
  RUSTFLAGS="$remap -C target-feature=+crt-static -C strip=symbols" \
    "$cargo" build --release --locked -p uvgraft-cli "${viewer[@]}" --target "$target" --target-dir "$build"
  name="uvgraft-$version-$target"
  mkdir -p "$dist/$name"
  cp "$build/$target/release/uvgraft" README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE LICENSE-OFL "$dist/$name/"
  "$dist/$name/uvgraft" man "$dist/$name/man"
  tar --sort=name --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner --mode=go-w \
    -C "$dist" -cf - "$name" | gzip -9n >"$dist/$name.tar.gz"
  rm -r "${dist:?}/$name"
fi

if ! python3 -c 'import venv' 2>/dev/null; then
  skip "the wheel" "there is no Python with the module venv"
elif RUSTFLAGS="$remap" CARGO_TARGET_DIR="$build" WHEELS="$dist" make --no-print-directory ONE_BUILD= wheel; then
  :
else
  echo "dist: the wheel could not be built" >&2
  exit 1
fi

if ! tools="$(scripts/cargo-tool.sh cargo-cyclonedx install)"; then
  skip "the list of contents" "cargo-cyclonedx is not installed and cannot be"
else
  export PATH="$tools:$PATH"
  "$cargo" cyclonedx --quiet --manifest-path crates/uvgraft-cli/Cargo.toml --format json \
    --spec-version 1.5 --target "$target" --override-filename uvgraft-sbom
  # Each run has a number and a time of its own; and paths of this machine.
  sed -e '/"serialNumber"/d' -e '/"timestamp"/d' -e "s|path+file://$PWD|path+file:///uvgraft|g" \
    -e "s|$PWD|/uvgraft|g" crates/uvgraft-cli/uvgraft-sbom.json >"$dist/uvgraft-$version.cdx.json"
  find crates bindings -name uvgraft-sbom.json -delete
fi

(cd "$dist" && sha256sum -- * >../SHA256SUMS && mv ../SHA256SUMS SHA256SUMS && cat SHA256SUMS)
