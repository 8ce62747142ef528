#!/bin/sh
# Installs the npm packages that the browser tests load avatars with into target/browser/node_modules: playwright-core,
# gltf-validator, three, @pixiv/three-vrm and @gltf-transform/cli. The browser itself comes by `make test-setup`.
#
# Does nothing if they are there. Without npm or a network it reports what is skipped and succeeds; if CI is set, it fails
# instead. With --list, it says what it would download, and how many megabytes.
set -eu

cd "$(dirname "$0")/.."
packages=crates/uvgraft-tests/browser
folder=target/browser

skip() {
    echo "install-browser-packages: $1; tests in a browser are skipped" >&2
    if [ -n "${CI:-}" ]; then exit 1; fi
    exit 0
}

# Exactly the versions in this lock file are installed.
if cmp -s "$packages/package-lock.json" "$folder/package-lock.json"; then exit 0; fi
if [ "${1:-}" = --list ]; then
    if command -v npm >/dev/null; then
        printf '%s\t%s\t%s\n' 50 "npm packages of the browser tests" "$folder"
    fi
    exit 0
fi

command -v node >/dev/null && command -v npm >/dev/null || skip "there is no node or no npm"
mkdir -p target
temporary=$(mktemp -d target/browser.XXXXXX)
trap 'rm -rf "$temporary"' EXIT
trap 'exit 1' HUP INT TERM
cp "$packages/package.json" "$packages/package-lock.json" "$temporary/"
echo "install-browser-packages: 50 MB" >&2
# Without a network, npm's own retries would take two minutes.
npm ci --prefix "$temporary" --silent --ignore-scripts --no-audit --no-fund \
    --fetch-retries 1 --fetch-retry-mintimeout 1000 --fetch-retry-maxtimeout 5000 >&2 ||
    skip "could not install npm packages (is there a network?)"
rm -rf "$folder"
mv "$temporary" "$folder"
