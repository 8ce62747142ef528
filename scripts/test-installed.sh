#!/bin/sh
# Installs the wheel of target/wheels beside a Python's own packages and runs tests with both:
# scripts/test-installed.sh venv/bin/python tests/test_torch.py
set -eu
cd "$(dirname "$0")/.."
python=$(command -v "$1")
case $python in /*) ;; *) python=$PWD/$python ;; esac
shift
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$python" -m pip install --quiet --no-deps --target "$folder/site" target/wheels/uvgraft-*.whl
"$python" -c 'import pytest' 2>/dev/null ||
    "$python" -m pip install --quiet --target "$folder/site" pytest
# Not from the folder of the package, whose sources would be imported in place of the wheel.
package=$PWD/bindings/python
cd "$folder"
for test in "$@"; do
    set -- "$@" "$package/$test"
    shift
done
PYTHONPATH="$folder/site" "$python" -m pytest --quiet -p no:cacheprovider \
    --config-file "$package/pyproject.toml" "$@"
