#!/usr/bin/env bash
# Lists all tests, one a line and sorted, so that the lists before and after a move of tests can be compared:
#
#   scripts/list-tests.sh [OPTIONS OF CARGO TEST] >before.txt
#
# for example with --features uvgraft-cli/viewer,uvgraft-tests/viewer. It builds all test programs and asks them; tests
# in Python come from pytest, in target/python-venv, where `make test-python` has installed the package. Names do not
# depend on which program a test is in, nor on line numbers:
#
#   uvgraft-io src::pair_file::tests::a_name       a unit test
#   uvgraft-image tests::png_rows::a_name          of tests/png_rows.rs, a program or a module of tests/main.rs
#   uvgraft-io doc::src/obj.rs - read              an example in documentation
#   python tests/test_graft.py::test_name          pytest's
set -euo pipefail
cd "$(dirname "$0")/.."
export LC_ALL=C
cargo="${CARGO:-cargo}"

# programs: the package, kind, name and path of each, from cargo's messages.
programs() {
  "$cargo" test --locked --workspace --tests --no-run --quiet --message-format json "$@" | sed -En \
    's/.*"package_id":"[^"]*[/#]([a-z-]+)[#@][^"]*".*"target":\{"kind":\["([a-z]+)"[^}]*"name":"([^"]*)".*"profile":\{[^}]*"test":true.*"executable":"([^"]*)".*/\1 \2 \3 \4/p'
}

rust() {
  local package kind name path prefix
  programs "$@" | while read -r package kind name path; do
    case $kind in
      lib) prefix=src:: ;;
      bin) prefix=bin:: ;;
      test) prefix=tests::$name:: ;;
      *) continue ;;
    esac
    # Its modules are the files beside it.
    if [ "$kind-$name" = test-main ]; then prefix=tests::; fi
    "$path" --list --format terse </dev/null | sed -n "s/: test\$//; t found; d; :found; s/^/$package $prefix/p"
  done
}

docs() {
  "$cargo" test --locked --workspace --doc --quiet "$@" -- --list --format terse |
    sed -En 's/^crates\/([a-z-]+)\/(.*): test$/\1 doc::\2/; T; s/ ?\(line [0-9]+\)//; p'
}

python() {
  if ! [ -x target/python-venv/bin/pytest ]; then
    echo "list-tests: tests in Python are left out, since there is no target/python-venv" >&2
    return
  fi
  (cd bindings/python && ../../target/python-venv/bin/pytest --collect-only --quiet -p no:cacheprovider tests) |
    sed -n '/::/s/^/python /p'
}

{ rust "$@"; docs "$@"; python; } | sort
