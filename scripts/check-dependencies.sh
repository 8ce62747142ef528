#!/usr/bin/env bash
# Checks licences, sources and bans of all dependencies (deny.toml), and advisories where the database
# can be had. cargo-deny is installed in CI (environment variable CI); elsewhere the check is skipped
# without it.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo="${CARGO:-cargo}"
tools="${XDG_CACHE_HOME:-$HOME/.cache}/uvgraft-tools"
export PATH="$tools/bin:$PATH"
if ! command -v cargo-deny >/dev/null && [ -n "${CI:-}" ]; then
  "$cargo" install --locked --quiet --root "$tools" cargo-deny
fi
if ! command -v cargo-deny >/dev/null; then
  echo "lint: licences of dependencies are not checked without cargo-deny (cargo install cargo-deny)"
  exit 0
fi
cargo deny --log-level error --locked check licenses bans sources
# The database is a repository, which not every machine reaches.
if ! timeout 60 cargo deny --log-level error --locked fetch db >/dev/null 2>&1; then
  echo "lint: advisories are not checked, since their database cannot be had"
  exit 0
fi
cargo deny --log-level error --locked --offline check advisories
