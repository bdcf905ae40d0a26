#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause

# The paper's studies as a user runs them, short: files whole, an older report replaced, anything
# else left alone.
# Usage: studies_test.sh MORGAGNI DATA_DIR
set -u
morgagni=$1
ct=$2/ct_head_invesalius/promed_ct_0051.nii.gz
if [ ! -f "$ct" ]; then
  echo "SKIPPED: $ct is absent"
  exit 77
fi
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
fail() {
  echo "FAILED: $*"
  exit 1
}

"$morgagni" prepare "$ct" --case "$scratch/head" --vertices 5000 >/dev/null 2>&1 || fail "prepare"
studies() {
  "$morgagni" evaluate studies --case "$scratch/head" --quick --no-opencl --many-poses 1 "$@"
}
studies --out "$scratch/out" 2>"$scratch/log" || fail "studies: $(cat "$scratch/log")"
for file in studies.md studies.json accuracy.svg down_sampling.svg many_poses.svg; do
  [ -s "$scratch/out/$file" ] || fail "$file is missing or empty"
done
grep -q "All data here are simulated" "$scratch/out/studies.md" || fail "the report hides its data"
[ "$(find "$scratch" -maxdepth 1 -name '*.part-*' | wc -l)" = 0 ] || fail "something half-written"

mkdir "$scratch/letters" && echo "dear" >"$scratch/letters/a.txt"
studies --out "$scratch/letters" 2>"$scratch/log" && fail "another folder was replaced"
grep -q "holds no studies" "$scratch/log" || fail "no sentence: $(cat "$scratch/log")"
[ "$(cat "$scratch/letters/a.txt")" = "dear" ] || fail "another folder was touched"
echo "the studies are written whole"
