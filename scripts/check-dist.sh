#!/usr/bin/env bash
# Builds a release twice, from copies of the sources in other folders, and compares the bytes.
set -euo pipefail
cd "$(dirname "$0")/.."

work="$PWD/target/dist-check"
commit="$(git rev-parse HEAD)"
time="$(git log -1 --format=%ct "$commit")"
rm -rf "$work"
for run in first second; do
  mkdir -p "$work/$run/a-folder-of-the-$run"
  git archive "$commit" | tar -x -C "$work/$run/a-folder-of-the-$run"
  # The page of the viewer comes from npm, which is another matter.
  [ ! -e target/viewer ] || { mkdir -p "$work/$run/a-folder-of-the-$run/target" && \
    cp -r target/viewer "$work/$run/a-folder-of-the-$run/target/"; }
  (
    cd "$work/$run/a-folder-of-the-$run"
    UVGRAFT_COMMIT="$commit" SOURCE_DATE_EPOCH="$time" \
      DIST="$work/$run/dist" scripts/dist.sh >"$work/$run.log" 2>&1
  ) || { tail -20 "$work/$run.log" >&2; exit 1; }
  rm -rf "$work/$run/a-folder-of-the-$run"
done
diff -r "$work/first/dist" "$work/second/dist" && echo "dist: both builds are equal" &&
  cat "$work/second/dist/SHA256SUMS"
