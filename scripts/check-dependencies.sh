#!/usr/bin/env bash
# Checks licences, sources and bans of all dependencies (deny.toml), and advisories where the database
# can be had. cargo-deny is installed in CI (environment variable CI); elsewhere the check is skipped
# without it.
set -euo pipefail
cd "$(dirname "$0")/.."

if ! tools="$(scripts/cargo-tool.sh cargo-deny ${CI:+install})"; then
  # In CI it must be there.
  [ -z "${CI:-}" ] || exit 1
  echo "lint: licences of dependencies are not checked without cargo-deny (cargo install cargo-deny)"
  exit 0
fi
export PATH="$tools:$PATH"
cargo deny --log-level error --locked check licenses bans sources
# The database is a repository, which not every machine reaches.
if ! timeout 60 cargo deny --log-level error --locked fetch db >/dev/null 2>&1; then
  echo "lint: advisories are not checked, since their database cannot be had"
  exit 0
fi
cargo deny --log-level error --locked --offline check advisories
