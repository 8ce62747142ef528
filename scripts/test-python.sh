#!/bin/sh
# Tests the Python package: builds it into target/python-venv, checks style, types and stubs, and runs
# pytest. Arguments are passed on to pytest.
#
# scripts/install-venv.sh makes the environment; without one the tests are skipped with a message, or, if
# CI is set, fail.
#
# - UVGRAFT_PYTHON_FEATURES: cargo features of the build, such as simplify,viewer.
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
cd bindings/python
ruff format --quiet --check . || { echo "test-python: run ruff format" >&2; exit 1; }
ruff check --quiet .
# In CI, wheels are built too, from the same crates.
maturin develop --quiet ${CI:+--release} --features "${UVGRAFT_PYTHON_FEATURES:-}"
mypy
# The compiled part alone: the rest has its types in place.
python -m mypy.stubtest --mypy-config-file pyproject.toml uvgraft._uvgraft
python -m pytest --quiet "$@"
