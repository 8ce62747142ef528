#!/bin/sh
# Makes a virtual environment with the Python packages of a list:
# scripts/install-venv.sh target/tools-venv requirements.txt ["what happens without them"]
#
# The environment is of python3, or of PYTHON if that is set.
#
# If something cannot be installed, it reports that and succeeds, and the tests that need it skip; if CI
# is set, it fails instead.
set -eu
cd "$(dirname "$0")/.."
venv=$1
wanted=$2
without=${3:-tests with the packages of $wanted are skipped}

skip() {
    echo "install-venv: $1; $without" >&2
    if [ -n "${CI:-}" ]; then exit 1; fi
    exit 0
}

# The list is copied once all of it is installed.
if cmp -s "$wanted" "$venv/installed.txt"; then exit 0; fi
mkdir -p "$(dirname "$venv")"
test -x "$venv/bin/pip" || "${PYTHON:-python3}" -m venv --clear "$venv" ||
    skip "python3 with the venv module is required"
echo "install-venv: the packages of $wanted" >&2
"$venv/bin/pip" install --quiet --requirement "$wanted" || skip "could not install the packages"
cp "$wanted" "$venv/installed.txt"
