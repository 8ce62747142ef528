#!/bin/sh
# Says what a target of the Makefile goes without and what it will download, before it does anything:
#
#   scripts/preflight.sh demo|test
#
# Each download is stated by the script that makes it (--list), and programs by test-setup.sh. Fails without a Rust
# toolchain that can build the workspace, and, for `test` in CI, if anything is missing.
set -eu

cd "$(dirname "$0")/.."
what=${1:?usage: scripts/preflight.sh demo|test}
cargo=${CARGO:-cargo}

fail() {
    echo "make $what needs the Rust toolchain: $1" >&2
    exit 1
}

if ! command -v "$cargo" >/dev/null; then
    if [ -x "${HOME:-}/.cargo/bin/cargo" ]; then
        fail "cargo is not on the path; run . ~/.cargo/env, and try again"
    fi
    fail "there is no cargo; install it by https://rustup.rs, open a new shell, and try again"
fi
wanted=$(sed -n 's/^rust-version = "1\.\([0-9]*\).*"/\1/p' Cargo.toml)
found=$("$cargo" --version 2>&1) || fail "cargo does not run: $found"
minor=$(echo "$found" | sed -n 's/^cargo 1\.\([0-9]*\).*/\1/p')
if [ -n "$minor" ] && [ "$minor" -lt "$wanted" ]; then
    fail "version 1.$wanted or later, and this is $found; try: rustup update stable"
fi

# crates MEGABYTES ARGUMENT...: whether crates are missing, as cargo would choose them.
crates() {
    megabytes=$1
    shift
    if ! "$cargo" tree --offline --locked --quiet "$@" >/dev/null 2>&1; then
        printf '%s\t%s\t%s\n' "$megabytes" "crates, besides their index" "${CARGO_HOME:-~/.cargo}"
    fi
}

# venv MEGABYTES FOLDER LIST: Python packages.
venv() {
    if ! cmp -s "$3" "$2/installed.txt" && command -v python3 >/dev/null; then
        printf '%s\t%s\t%s\n' "$1" "Python packages of $3" "$2"
    fi
}

case $what in
    demo)
        echo "make demo: the whole workflow on a built-in example; pictures go to uvgraft-demo/"
        missing=$(
            has_npm=$(command -v npm) || echo "no npm: no avatar.html, which shows the avatar in a browser"
            if ! python3 -c 'import ensurepip' 2>/dev/null && ! python3 -m pip --version >/dev/null 2>&1; then
                if [ -n "$has_npm" ] || command -v python3 >/dev/null; then
                    echo "no Python with pip: a picture of the figure takes the place of the photograph"
                else
                    echo "no Python either: no avatar of a photograph"
                fi
            fi
        )
        advice=
        downloads=$(
            crates 16 -p uvgraft-cli --edges normal,build
            scripts/build-viewer.sh --list
            scripts/fetch-test-data.sh --list face-networks photographs
        )
        ;;
    test)
        echo "make test: all tests; nothing is installed outside of this folder"
        status=0
        missing=$(
            scripts/test-setup.sh --missing c++ npm python chromium ${ONE_BUILD:+vulkan blender godot}
        ) || status=1
        advice="make test-setup installs what is missing"
        downloads=$(
            crates 21 --workspace --edges normal,build,dev
            scripts/build-viewer.sh --list
            scripts/install-browser-packages.sh --list
            scripts/fetch-test-data.sh --list
            venv 180 target/python-venv bindings/python/requirements-test.txt
        )
        ;;
    *)
        echo "preflight: the target must be demo or test, got '$what'" >&2
        exit 2
        ;;
esac

if [ -n "$missing" ]; then
    echo "It goes without:"
    echo "$missing" | sed 's/^/    /'
    [ -z "$advice" ] || echo "    ($advice)"
fi
if [ -n "$downloads" ]; then
    echo "It downloads, this once:"
    echo "$downloads" | awk -F '\t' '{ printf "    %4d MB  %s, to %s\n", $1, $2, $3; sum += $1 }
        END { if (NR > 1) printf "    %4d MB  in all\n", sum }'
fi
exit "${status:-0}"
