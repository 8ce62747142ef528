#!/bin/sh
# Installs the programs in which `make test-clients` loads avatars: Debian's Blender (about 500 MB) and
# Godot's server. Does nothing if both exist. If something cannot be installed, it reports that and
# succeeds, and the tests skip; if CI is set, it fails instead.
set -eu

skip() {
    echo "install-clients: $1; tests with it are skipped" >&2
    if [ -n "${CI:-}" ]; then exit 1; fi
    exit 0
}

wanted=
command -v blender >/dev/null || wanted="$wanted blender python3-numpy"
command -v godot3-server >/dev/null || wanted="$wanted godot3-server"
[ -n "$wanted" ] || exit 0
command -v apt-get >/dev/null || skip "there is no apt-get to install$wanted with"
as_root=
if [ "$(id -u)" != 0 ]; then
    as_root="sudo -n --preserve-env=DEBIAN_FRONTEND"
    sudo -n true 2>/dev/null || skip "wanted$wanted; try: sudo apt-get install$wanted"
fi
apt() {
    DEBIAN_FRONTEND=noninteractive $as_root apt-get --quiet --quiet "$@" >&2
}
echo "install-clients: Debian's$wanted" >&2
# shellcheck disable=SC2086
apt install --no-install-recommends --yes $wanted 2>/dev/null ||
    { apt update && apt install --no-install-recommends --yes $wanted; } ||
    skip "could not install$wanted"
