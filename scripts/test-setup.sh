#!/bin/sh
# Installs what the tests need from the system, with Debian's apt-get: `make test-setup`.
#
#   scripts/test-setup.sh [--missing] [PROGRAM...]
#
#   c++       a C++ compiler, for FLIP and mesh simplification
#   npm       with Node, for the viewer and the packages of the browser tests
#   python    with venv, for the Python package and for downloads
#   chromium  for tests in a browser; UVGRAFT_CHROMIUM names another one
#   vulkan    Mesa's lavapipe, a Vulkan driver that runs on the CPU, where there is no driver
#   blender   in which `make test-clients` loads avatars
#   godot     likewise
#
# Without PROGRAM, all of them. What is there is left alone. With --missing, it installs nothing and says what is missing and
# what is skipped for it, in a line each; if CI is set and anything is missing, it then fails.
set -eu

missing=
if [ "${1:-}" = --missing ]; then
    missing=yes
    shift
fi
[ $# -gt 0 ] || set -- c++ npm python chromium vulkan blender godot

have_driver() {
    # Drivers are files for Linux; other systems bring theirs.
    [ "$(uname)" = Linux ] || return 0
    { PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null | grep --quiet 'libvulkan\.so\.1'; } || [ -e /usr/lib/libvulkan.so.1 ] || return 1
    for folder in /usr/share/vulkan/icd.d /etc/vulkan/icd.d /usr/local/share/vulkan/icd.d; do
        for file in "$folder"/*.json; do
            if [ -e "$file" ]; then return 0; fi
        done
    done
    return 1
}

have() {
    case $1 in
        c++) command -v c++ ;;
        npm) command -v node && command -v npm ;;
        python) python3 -c 'import ensurepip, venv' 2>/dev/null ;;
        chromium)
            [ -n "${UVGRAFT_CHROMIUM:-}" ] || command -v chromium || command -v chromium-browser ||
                command -v google-chrome
            ;;
        vulkan) have_driver ;;
        blender) command -v blender ;;
        godot) command -v godot3-server ;;
        *)
            echo "test-setup: PROGRAM must be c++, npm, python, chromium, vulkan, blender or godot, got '$1'" >&2
            exit 2
            ;;
    esac >/dev/null
}

# What is skipped without it.
without() {
    case $1 in
        c++) echo "no C++ compiler (c++): tests of FLIP and of mesh simplification are skipped" ;;
        npm) echo "no npm: tests of the viewer and in a browser are skipped" ;;
        python) echo "no Python with venv: tests of the Python package and of downloaded files are skipped" ;;
        chromium) echo "no Chromium: tests in a browser are skipped" ;;
        vulkan) echo "no Vulkan driver: tests on a graphics processor are skipped" ;;
        blender) echo "no Blender: avatars are not loaded in it" ;;
        godot) echo "no Godot (godot3-server): avatars are not loaded in it" ;;
    esac
}

# Debian's packages.
packages() {
    case $1 in
        c++) echo g++ ;;
        npm) echo nodejs npm ;;
        python) echo python3 python3-venv ;;
        # A page needs a font, and Chromium only recommends one.
        chromium) echo chromium fonts-dejavu-core ;;
        vulkan) echo mesa-vulkan-drivers libvulkan1 ;;
        blender) echo blender python3-numpy ;;
        godot) echo godot3-server ;;
    esac
}

absent=
for program in "$@"; do
    have "$program" || absent="$absent $program"
done

if [ -n "$missing" ]; then
    for program in $absent; do without "$program"; done
    if [ -n "$absent" ] && [ -n "${CI:-}" ]; then exit 1; fi
    exit 0
fi

if [ -z "$absent" ]; then
    echo "test-setup: all is there"
    exit 0
fi
wanted=
for program in $absent; do wanted="$wanted $(packages "$program")"; done
if ! command -v apt-get >/dev/null; then
    echo "test-setup: there is no apt-get; install these yourself:$absent" >&2
    exit 1
fi
as_root=
if [ "$(id -u)" != 0 ]; then
    command -v sudo >/dev/null || { echo "test-setup: as root, run: apt-get install$wanted" >&2; exit 1; }
    # Asks for a password where there is somebody to ask.
    as_root="sudo --preserve-env=DEBIAN_FRONTEND"
    [ -t 0 ] || as_root="$as_root --non-interactive"
fi
apt() {
    DEBIAN_FRONTEND=noninteractive $as_root apt-get --quiet --quiet --no-install-recommends --yes "$@" >&2
}
# Bytes to download; fails where apt-get has no list of packages, or an old one.
# shellcheck disable=SC2086 # several packages
bytes() {
    apt-get --quiet --quiet --no-install-recommends --yes --print-uris install $wanted 2>/dev/null |
        awk '{ sum += $3 } END { if (NR == 0) exit 1; print sum }'
}
bytes >/dev/null || apt update || true
echo "test-setup: Debian's$wanted, $(($(bytes || echo 0) / 1000000)) MB" >&2
# shellcheck disable=SC2086 # several packages
apt install $wanted || { apt update && apt install $wanted; } ||
    { echo "test-setup: could not install$wanted" >&2; exit 1; }
