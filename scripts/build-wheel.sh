#!/bin/sh
# Builds the wheel of the Python package with the whole command: scripts/build-wheel.sh target/wheels "flip simplify"
#
# On Linux, Zig compiles and links for glibc 2.28, whatever this machine has, so that the wheel (manylinux_2_28) also runs
# on older machines, such as clusters. Without Zig the wheel is for machines like this one, and if CI is set, that is an error.
set -eu
cd "$(dirname "$0")/.."
wheels=$1
features=$2
venv=$PWD/target/wheel-venv
wanted=bindings/python/requirements-wheel.txt

scripts/install-venv.sh "$venv" "$wanted" "a wheel for other machines needs them"
# Tests have a maturin, too; and Zig may be what is missing.
PATH=$venv/bin:$PATH:$PWD/target/python-venv/bin
command -v maturin >/dev/null || "$venv/bin/pip" install --quiet "$(grep '^maturin' "$wanted")" ||
    { echo "build-wheel: maturin is required, and cannot be installed" >&2; exit 1; }

set -- --profile release --locked --manifest-path bindings/python/Cargo.toml --features "$features" --out "$wheels"
case $(rustc -vV | sed -n 's/^host: //p') in
*-linux-gnu)
    if python3 -m ziglang version >/dev/null 2>&1 || zig version >/dev/null 2>&1; then
        set -- "$@" --zig --compatibility manylinux_2_28
        # Not in the home folder.
        export ZIG_GLOBAL_CACHE_DIR="$PWD/target/zig" CARGO_ZIGBUILD_CACHE_DIR="$PWD/target/zig/build"
    elif [ -n "${CI:-}" ]; then
        echo "build-wheel: Zig is required, and cannot be installed" >&2
        exit 1
    else
        echo "build-wheel: there is no Zig: the wheel is for Linux with $(getconf GNU_LIBC_VERSION) or later" >&2
    fi
    ;;
esac
rm -f "$wheels"/uvgraft-*.whl
exec maturin build "$@"
