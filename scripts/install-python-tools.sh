#!/bin/sh
# Installs the Python packages that `make test-clients` checks exported maps with, in target/tools-venv.
# If something cannot be installed, it reports that and succeeds, and the tests skip; if CI is set, it
# fails instead.
set -eu
cd "$(dirname "$0")/.."

skip() {
    echo "install-python-tools: $1; tests with it are skipped" >&2
    if [ -n "${CI:-}" ]; then exit 1; fi
    exit 0
}

venv=target/tools-venv
wanted=crates/uvgraft-cli/tests/other_tools/requirements.txt
# The list is copied once all of it is installed.
if cmp -s "$wanted" "$venv/installed.txt"; then exit 0; fi
mkdir -p target
test -x "$venv/bin/pip" || python3 -m venv --clear "$venv" ||
    skip "python3 with the venv module is required"
echo "install-python-tools: the packages of $wanted" >&2
"$venv/bin/pip" install --quiet --requirement "$wanted" || skip "could not install the packages"
cp "$wanted" "$venv/installed.txt"
