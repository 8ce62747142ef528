#!/bin/sh
# Installs the programs that `make test-clients` loads avatars with: Debian's Blender (some 500 MB) and Godot's server.
# Does nothing where both are there. Where something cannot be had it says so and succeeds, and the tests skip; where
# CI is set it fails instead.
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
