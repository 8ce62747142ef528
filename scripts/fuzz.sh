#!/usr/bin/env bash
# Fuzzes each target for a while, guided by coverage and with the address sanitizer: `make fuzz`. By default
# all of them together take an hour.
#
#   SECONDS_EACH=60 TARGETS="obj structured_gltf" scripts/fuzz.sh
set -euo pipefail
cd "$(dirname "$0")/.."

if ! cargo +nightly --version >/dev/null 2>&1; then
  echo "fuzz: skipped, since there is no nightly toolchain (rustup toolchain install nightly)"
  exit 0
fi
if ! command -v c++ >/dev/null; then
  echo "fuzz: skipped, since there is no C++ compiler (c++), which libFuzzer needs"
  exit 0
fi
tools="$(scripts/cargo-tool.sh cargo-fuzz install)" ||
  { echo "fuzz: skipped, since cargo-fuzz could not be installed"; exit 0; }
export PATH="$tools:$PATH"

targets="$(cargo run --quiet --locked -p uvgraft-fuzz --example seeds -- fuzz/corpus)"
seconds="${SECONDS_EACH:-$((3600 / $(wc -w <<<"$targets")))}"
cargo +nightly fuzz build target
found=0
for target in ${TARGETS:-$targets}; do
  # Files built by structure are up to a megabyte and may declare more; the targets check what they take.
  [[ "$target" == structured_* ]] && memory=4096 || memory=1024
  mkdir -p "fuzz/artifacts/$target" "fuzz/corpus/$target"
  # One input under a megabyte must not take a gigabyte, nor ten seconds.
  if UVGRAFT_FUZZ_TARGET="$target" cargo +nightly fuzz run target "fuzz/corpus/$target" -- \
    -max_total_time="$seconds" -max_len=65536 -timeout=10 -rss_limit_mb="$memory" \
    -artifact_prefix="fuzz/artifacts/$target/" >"fuzz/artifacts/$target.log" 2>&1; then
    echo "$target: $(grep -c . <(ls "fuzz/corpus/$target")) inputs of interest," \
      "$(sed -n 's/^Done \([0-9]*\) runs.*/\1/p' "fuzz/artifacts/$target.log") runs"
  else
    echo "$target: a find, in fuzz/artifacts/$target; see fuzz/artifacts/$target.log" >&2
    found=1
  fi
done
exit "$found"
