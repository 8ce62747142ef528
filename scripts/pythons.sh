#!/bin/sh
# Prints the paths of the oldest and the newest CPython here that the package supports, 3.10 and later, each on a line:
# scripts/pythons.sh. It knows those on the path and those of pyenv.
set -eu

interpreters() {
    for python in python3.1[0-9] "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.1[0-9].*/bin/python3; do
        path=$(command -v "$python") || continue
        # Without a stable ABI, free-threaded builds need wheels of their own.
        "$path" -c 'import ssl, sys, venv
if sys.implementation.name == "cpython" and "t" not in sys.abiflags:
    print("%d.%02d" % sys.version_info[:2], sys.executable)' 2>/dev/null || true
    done | sort -u -k1,1 | cut -d' ' -f2
}

found=$(interpreters)
test -n "$found" || { echo "pythons: there is no CPython 3.10 or later" >&2; exit 1; }
echo "$found" | sed -n '1p; $p'
