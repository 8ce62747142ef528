#!/bin/sh
# Asks an offline face recogniser how far avatars are from the face in a photograph, and from other faces:
#
#   scripts/recognise.sh PHOTO --avatar VIEW... [--others PICTURE...] [--check]
#
# The first run installs it (130 MB of Python packages) in target/recogniser-venv. Never a part of `make
# test`.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
venv=$root/target/recogniser-venv
wanted=$root/crates/uvgraft-tests/recogniser/requirements.txt

# The list is copied once all of it is installed.
if ! cmp -s "$wanted" "$venv/installed.txt"; then
    mkdir -p "$root/target"
    test -x "$venv/bin/pip" || python3 -m venv --clear "$venv" || {
        echo "recognise: python3 with the venv module is required" >&2
        exit 1
    }
    echo "recognise: installing the packages of $wanted" >&2
    "$venv/bin/pip" install --quiet --requirement "$wanted" || {
        echo "recognise: could not install the packages; is there a network?" >&2
        exit 1
    }
    cp "$wanted" "$venv/installed.txt"
fi
exec "$venv/bin/python" "$root/crates/uvgraft-tests/recogniser/recognise.py" "$@"
