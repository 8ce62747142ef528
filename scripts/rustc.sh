#!/bin/sh
# The compiler of the workspace's crates where one build serves everything (RUSTC_WORKSPACE_WRAPPER in the Makefile).
#
# A crate's unit tests are another copy of it, which runs for seconds: optimising that copy as much as the one that
# all other tests use would take minutes.
case " $* " in *" --crate-name uvgraft"*" --test "*)
    set -- "$@" -C opt-level=1
    ;;
esac
exec "$@"
