#!/bin/sh
# Tests the Python package: builds it into target/python-venv, checks style, types and stubs, and runs
# pytest. Arguments are passed on to pytest.
#
# scripts/install-venv.sh makes the environment; without one the tests are skipped with a message, or, if
# CI is set, fail.
#
# - UVGRAFT_PYTHON_FEATURES: cargo features of the build, such as simplify,viewer.
# - UVGRAFT_WHEEL: a wheel, which is installed and tested in place of a build.
set -eu
cd "$(dirname "$0")/.."
venv=$PWD/target/python-venv
if [ ! -f "$venv/installed.txt" ]; then
    echo "test-python: there is no $venv; the tests of the Python package are skipped" >&2
    if [ -n "${CI:-}" ]; then exit 1; fi
    exit 0
fi
export VIRTUAL_ENV="$venv"
export PATH="$venv/bin:$PATH"
package=$PWD/bindings/python
folder=$package
if [ -n "${UVGRAFT_WHEEL:-}" ]; then
    pip install --quiet --no-deps --force-reinstall "$UVGRAFT_WHEEL"
    # Not from the folder of the package, whose sources would be imported in place of the wheel.
    folder=$(mktemp -d)
    trap 'rm -rf "$folder"' EXIT
fi
cd "$package"
# The examples have no settings of their own.
checked="--quiet --config pyproject.toml . ../../examples"
# shellcheck disable=SC2086 # several words
ruff format --check $checked || { echo "test-python: run ruff format" >&2; exit 1; }
# shellcheck disable=SC2086 # several words
ruff check $checked
[ -n "${UVGRAFT_WHEEL:-}" ] || maturin develop --quiet --features "${UVGRAFT_PYTHON_FEATURES:-}"
mypy
cd "$folder"
# The compiled part alone: the rest has its types in place.
python -m mypy.stubtest --mypy-config-file "$package/pyproject.toml" uvgraft._uvgraft
python -m pytest --quiet --config-file "$package/pyproject.toml" "$package/tests" "$@"
