#!/bin/sh
# A file beside tests/main.rs that is neither a module of it nor named in Cargo.toml would never be compiled, and its
# tests would be missing without a message.
set -eu
cd "$(dirname "$0")/.."
missing=
for main in crates/*/tests/main.rs; do
    folder=${main%/main.rs}
    for file in "$folder"/*.rs; do
        name=$(basename "$file" .rs)
        [ "$name" != main ] || continue
        grep -qx "mod $name;" "$main" || grep -qx "name = \"$name\"" "$folder/../Cargo.toml" || missing="$missing $file"
    done
done
[ -z "$missing" ] || {
    echo "lint: not compiled, since tests/main.rs does not name them:$missing" >&2
    exit 1
}
