#!/bin/sh
# Builds target/viewer/viewer.html, the page into which `uvgraft view` embeds avatars. The program contains
# it if it is built with the feature `viewer`:
#
#   scripts/build-viewer.sh && cargo build --release -p uvgraft-cli --features viewer
#
# With --list, it says what it would download, and how many megabytes.
#
# Needs npm, and the first time a network for its packages, whose versions are pinned by
# crates/uvgraft-viewer/package-lock.json. Does nothing if the page is up to date. Without npm or a network
# it reports what is skipped and succeeds; if CI is set, it fails instead.
set -eu

cd "$(dirname "$0")/.."
sources=crates/uvgraft-viewer
folder=target/viewer

skip() {
    echo "build-viewer: $1; \`uvgraft view\` and avatar.html are left out" >&2
    # An outdated page may not match the program.
    rm -f "$folder/viewer.html" "$folder/made-from"
    if [ -n "${CI:-}" ]; then exit 1; fi
    exit 0
}

made_from=$(cksum "$sources"/package-lock.json "$sources"/bundle.mjs "$sources"/page/*)
if [ -s "$folder/viewer.html" ] && [ "$made_from" = "$(cat "$folder/made-from" 2>/dev/null)" ]; then
    exit 0
fi
if [ "${1:-}" = --list ]; then
    # npm downloads nothing where there is none.
    if command -v npm >/dev/null && ! cmp -s "$sources/package-lock.json" "$folder/packages/package-lock.json"; then
        printf '%s\t%s\t%s\n' 10 "npm packages of the viewer for browsers" "$folder"
    fi
    exit 0
fi

command -v node >/dev/null && command -v npm >/dev/null || skip "there is no node or no npm"
mkdir -p "$folder"
temporary=$(mktemp -d "$folder/build.XXXXXX")
trap 'rm -rf "$temporary"' EXIT
trap 'exit 1' HUP INT TERM

# Exactly the versions in this lock file are installed.
packages=$folder/packages
if ! cmp -s "$sources/package-lock.json" "$packages/package-lock.json"; then
    echo "build-viewer: npm packages of the viewer for browsers, 10 MB" >&2
    mkdir "$temporary/packages"
    cp "$sources/package.json" "$sources/package-lock.json" "$temporary/packages/"
    # No install scripts are run: esbuild's binary is a separate package. Without a network, npm's own retries would
    # take two minutes.
    npm ci --prefix "$temporary/packages" --silent --ignore-scripts --no-audit --no-fund \
        --fetch-retries 1 --fetch-retry-mintimeout 1000 --fetch-retry-maxtimeout 5000 >&2 ||
        skip "could not install npm packages (is there a network?)"
    rm -rf "$packages"
    mv "$temporary/packages" "$packages"
fi

node "$sources/bundle.mjs" "$packages/node_modules" "$temporary/viewer.html" >&2
mv "$temporary/viewer.html" "$folder/viewer.html"
printf '%s\n' "$made_from" >"$folder/made-from"
echo "build-viewer: $folder/viewer.html, $(wc -c <"$folder/viewer.html") bytes" >&2
