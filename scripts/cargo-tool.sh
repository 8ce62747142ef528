#!/usr/bin/env bash
# Prints the folder of a tool for cargo, and installs the tool there if it is missing and may be installed:
#
#   PATH="$(scripts/cargo-tool.sh cargo-fuzz install):$PATH"
#
# Without `install`, a missing tool is not installed; where there is none in the end, it exits with 1.
set -euo pipefail

tool="${1:?usage: scripts/cargo-tool.sh TOOL [install]}"
tools="${XDG_CACHE_HOME:-$HOME/.cache}/uvgraft-tools"
if found="$(PATH="$tools/bin:$PATH" command -v "$tool")"; then
  dirname "$found"
  exit 0
fi
[ "${2:-}" = install ] || exit 1
"${CARGO:-cargo}" install --locked --quiet --root "$tools" "$tool" >&2
echo "$tools/bin"
