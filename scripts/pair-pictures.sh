#!/usr/bin/env bash
# Draws the documents' pictures of pairs, one for each way in which meshes correspond, in docs/src/images/.
set -euo pipefail
cd "$(dirname "$0")/.."
images="$PWD/docs/src/images"
cargo build --quiet --release --locked -p uvgraft-cli
cargo build --quiet --release --locked -p uvgraft-tests --example pair_pictures
uvgraft="$PWD/target/release/uvgraft"
example="$PWD/target/release/examples/pair_pictures"

folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$example" meshes .
"$uvgraft" pair head.obj head_unrolled.obj -o faces.uvpair --preview faces.png
"$uvgraft" pair head.obj body.obj -o topology.uvpair --preview topology.png
"$uvgraft" pair head.obj other_head.obj -o surface.uvpair --preview surface.png
"$uvgraft" map topology.uvpair --size 1024 -o grid.npz
"$uvgraft" pair head.obj body.obj --table grid.npz -o table.uvpair --preview table.png
"$uvgraft" inspect mesh head_in_tiles.obj --preview tiles.png
for name in faces topology surface table tiles; do
  "$example" half $name.png "$images/pair_$name.jpg"
done
