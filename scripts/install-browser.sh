#!/bin/sh
# Installs what the browser tests need beyond the repository:
#
#   Chromium                     with Debian's apt-get, if missing; UVGRAFT_CHROMIUM names another
#   target/browser/node_modules  playwright-core, gltf-validator, three, @pixiv/three-vrm and
#                                @gltf-transform/cli from npm
#
# Does nothing if both exist. If something cannot be installed, it reports what is skipped and succeeds; if
# CI is set, it fails instead.
set -eu

cd "$(dirname "$0")/.."
packages=crates/uvgraft-tests/browser
folder=target/browser

skip() {
    echo "install-browser: $1" >&2
    echo "install-browser: skipped, so tests in a browser are skipped too" >&2
    if [ -n "${CI:-}" ]; then exit 1; fi
    exit 0
}

have_chromium() {
    [ -n "${UVGRAFT_CHROMIUM:-}" ] || command -v chromium || command -v chromium-browser ||
        command -v google-chrome
}

apt() {
    DEBIAN_FRONTEND=noninteractive $as_root apt-get --quiet --quiet "$@" >&2
}

if ! have_chromium >/dev/null; then
    command -v apt-get >/dev/null || skip "there is no Chromium, and no apt-get to install it with"
    as_root=
    if [ "$(id -u)" != 0 ]; then
        as_root="sudo -n --preserve-env=DEBIAN_FRONTEND"
        sudo -n true 2>/dev/null || skip "there is no Chromium; try: sudo apt-get install chromium"
    fi
    echo "install-browser: Debian's chromium, about 100 MB" >&2
    # A page needs a font, and Chromium only recommends one.
    wanted="chromium fonts-dejavu-core"
    # shellcheck disable=SC2086
    apt install --no-install-recommends --yes $wanted 2>/dev/null ||
        { apt update && apt install --no-install-recommends --yes $wanted; } ||
        skip "could not install chromium"
fi

command -v node >/dev/null && command -v npm >/dev/null || skip "there is no node or no npm"
# Exactly the versions in this lock file are installed.
if cmp -s "$packages/package-lock.json" "$folder/package-lock.json"; then exit 0; fi

mkdir -p target
temporary=$(mktemp -d target/browser.XXXXXX)
trap 'rm -rf "$temporary"' EXIT
trap 'exit 1' HUP INT TERM
cp "$packages/package.json" "$packages/package-lock.json" "$temporary/"
echo "install-browser: npm packages, 130 MB" >&2
npm ci --prefix "$temporary" --silent --ignore-scripts --no-audit --no-fund >&2 ||
    skip "could not install npm packages"
rm -rf "$folder"
mv "$temporary" "$folder"
