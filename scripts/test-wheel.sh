#!/bin/sh
# Installs a wheel in fresh environments of the oldest and the newest CPython here that it supports, and
# runs the package's tests and the command there: scripts/test-wheel.sh target/wheels/uvgraft-*.whl
set -eu
cd "$(dirname "$0")/.."
repository=$PWD
wheel=$1
test -f "$wheel" || { echo "test-wheel: there is no wheel $wheel" >&2; exit 2; }

# Interpreters on the path and those of pyenv, from old to new; the wheel supports 3.10 and later.
interpreters() {
    for python in python3.1[0-9] "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.1[0-9].*/bin/python3; do
        path=$(command -v "$python") || continue
        # Without a stable ABI, free-threaded builds need wheels of their own.
        "$path" -c 'import ssl, sys, venv
if sys.implementation.name == "cpython" and "t" not in sys.abiflags:
    print("%d.%02d" % sys.version_info[:2], sys.executable)' 2>/dev/null || true
    done | sort -u -k1,1
}

found=$(interpreters)
test -n "$found" || { echo "test-wheel: there is no CPython 3.10 or later" >&2; exit 1; }
oldest=$(echo "$found" | head -n 1 | cut -d' ' -f2)
newest=$(echo "$found" | tail -n 1 | cut -d' ' -f2)
for python in $(printf '%s\n' "$oldest" "$newest" | uniq); do
    echo "test-wheel: $("$python" --version), $wheel"
    fresh=$(mktemp -d)
    trap 'rm -rf "$fresh"' EXIT
    "$python" -m venv "$fresh/venv"
    "$fresh/venv/bin/pip" install --quiet "$wheel" pytest hypothesis pillow scipy tqdm
    # Not from the folder of the package, whose sources would be imported in place of the wheel.
    (cd "$fresh" && venv/bin/python -m pytest --quiet -p no:cacheprovider \
        --config-file "$repository/bindings/python/pyproject.toml" "$repository/bindings/python/tests")
    "$fresh/venv/bin/uvgraft" --version
    rm -rf "$fresh"
done
