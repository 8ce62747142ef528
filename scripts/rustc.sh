#!/bin/sh
# The compiler of the workspace's crates where one build serves everything (RUSTC_WORKSPACE_WRAPPER in the Makefile).
#
# A crate's unit tests are another copy of it. Optimising these copies takes minutes and saves seconds, except in the
# core (uvgraft and uvgraft-surface), whose kernels they run.
case " $* " in
*" --crate-name uvgraft_surface "*) ;;
*" --crate-name uvgraft_"*" --test "*)
    set -- "$@" -C opt-level=0
    ;;
esac
exec "$@"
