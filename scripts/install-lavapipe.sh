#!/bin/sh
# Installs what tests on a graphics processor need where there is none: Mesa's lavapipe, a Vulkan driver that
# runs on the CPU, with Debian's apt-get.
#
# Does nothing if there is any Vulkan driver. If it cannot be installed, it reports what is skipped and
# succeeds; if CI is set, it fails instead.
set -eu

skip() {
    echo "install-lavapipe: $1" >&2
    echo "install-lavapipe: skipped, so tests on a graphics processor are skipped too" >&2
    if [ -n "${CI:-}" ]; then exit 1; fi
    exit 0
}

have_driver() {
    for folder in /usr/share/vulkan/icd.d /etc/vulkan/icd.d /usr/local/share/vulkan/icd.d; do
        for file in "$folder"/*.json; do
            if [ -e "$file" ]; then return 0; fi
        done
    done
    return 1
}

have_loader() {
    ldconfig -p 2>/dev/null | grep --quiet 'libvulkan\.so\.1' || [ -e /usr/lib/libvulkan.so.1 ]
}

apt() {
    DEBIAN_FRONTEND=noninteractive $as_root apt-get --quiet --quiet "$@" >&2
}

# Drivers are files for Linux; other systems bring theirs.
if [ "$(uname)" != Linux ]; then exit 0; fi
if have_driver && have_loader; then exit 0; fi
command -v apt-get >/dev/null || skip "there is no Vulkan driver, and no apt-get to install lavapipe with"
as_root=
if [ "$(id -u)" != 0 ]; then
    as_root="sudo -n --preserve-env=DEBIAN_FRONTEND"
    sudo -n true 2>/dev/null || skip "there is no Vulkan driver; try: sudo apt-get install mesa-vulkan-drivers"
fi
echo "install-lavapipe: Debian's mesa-vulkan-drivers and libvulkan1, about 60 MB" >&2
wanted="mesa-vulkan-drivers libvulkan1"
# shellcheck disable=SC2086
apt install --no-install-recommends --yes $wanted 2>/dev/null ||
    { apt update && apt install --no-install-recommends --yes $wanted; } ||
    skip "could not install lavapipe"
