#!/bin/sh
# Builds the book in docs/ into target/book with mdBook, which it installs under target/tools the first
# time (this takes two minutes and a network). Fails if a page is missing; the test `documents` checks links.
set -eu

cd "$(dirname "$0")/.."
version=0.5.4
mdbook=target/tools/bin/mdbook

if [ "$("$mdbook" --version 2>/dev/null)" != "mdbook v$version" ]; then
    "${CARGO:-cargo}" install --quiet --locked --root target/tools --no-default-features \
        --version "$version" mdbook
fi
"$mdbook" build docs
echo "build-book: target/book/index.html"
