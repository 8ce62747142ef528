#!/bin/sh
# Installs a wheel in fresh environments of the oldest and the newest CPython here that it supports, and tries it
# there: scripts/test-wheel.sh target/wheels/uvgraft-*.whl
#
# The newest runs all tests of the package, the oldest those that meet most of the package's own Python. Where
# UVGRAFT_WHEEL_TESTS is `few`, the newest has run them all elsewhere and is left out, and where it is `all`, both run all.
set -eu
cd "$(dirname "$0")/.."
package=$PWD/bindings/python
pythons=$(scripts/pythons.sh)
wheel=$1
test -f "$wheel" || { echo "test-wheel: there is no wheel $wheel" >&2; exit 2; }
few="test_graft.py test_command.py test_file_transfer.py test_progress.py test_notebook.py test_seams.py"

# try PYTHON WHICH: installs the wheel and runs `all` or a `few` of the tests.
try() {
    python=$1
    tests=$package/tests
    peers="imagecodecs opencv-python-headless OpenEXR tifffile trimesh"
    if [ "${UVGRAFT_WHEEL_TESTS:-$2}" = few ]; then
        tests=
        peers=
        for name in $few; do tests="$tests $package/tests/$name"; done
    fi
    echo "test-wheel: $("$python" --version), $wheel"
    fresh=$(mktemp -d)
    trap 'rm -rf "$fresh"' EXIT
    "$python" -m venv "$fresh/venv"
    # shellcheck disable=SC2086 # several packages
    "$fresh/venv/bin/pip" install --quiet "$wheel" pytest hypothesis pillow scipy tqdm $peers
    # Whatever its tests are, this Python must be able to read every file.
    "$fresh/venv/bin/python" -m compileall -q "$fresh"/venv/lib/python*/site-packages/uvgraft
    # Not from the folder of the package, whose sources would be imported in place of the wheel.
    # shellcheck disable=SC2086 # several files
    (cd "$fresh" && venv/bin/python -m pytest --quiet -p no:cacheprovider \
        --config-file "$package/pyproject.toml" $tests)
    "$fresh/venv/bin/uvgraft" --version
    rm -rf "$fresh"
}

oldest=$(echo "$pythons" | head -n 1)
newest=$(echo "$pythons" | tail -n 1)
[ "$oldest" = "$newest" ] || try "$oldest" few
if [ "${UVGRAFT_WHEEL_TESTS:-}" != few ] || [ "$oldest" = "$newest" ]; then
    try "$newest" all
fi
