#!/usr/bin/env bash
# Fuzzes formats, one after the other, until each has had so much processor time in all its runs so far:
#
#   tests/fuzz/run.sh MINUTES FORMAT...     # "all": every format there is
#
# Each run begins with what earlier ones learned (build/fuzz/runs/FORMAT). What seems found is tried
# again alone, with 20 s of processor time: what fails then too is kept in found/, the rest was a busy
# machine's. Fails where anything is in found/.
set -euo pipefail
cd "$(dirname "$0")/../.."
minutes=$1
shift
[ "$*" = all ] && set -- nifti nrrd mha obj stl ply vtp dicom rtstruct mcap push pacs
bin=$PWD/build/fuzz/bin
seeds=$PWD/build/fuzz/seeds
slice_s=300
TIMEFORMAT="%U %S"
"$bin/fuzz_seeds" "$seeds" >/dev/null

fuzz() {
  local format=$1 runs=$PWD/build/fuzz/runs/$1 largest=4096
  case $format in mcap) largest=32768 ;; esac
  mkdir -p "$runs/corpus" "$runs/found"
  local spent
  spent=$(cat "$runs/cpu_s" 2>/dev/null || echo 0)
  while awk "BEGIN { exit !($spent < 60 * $minutes) }"; do
    # -timeout is of wall time: long enough for a busy machine, what it finds is judged below.
    { time "$bin/fuzz_$format" -fork=1 -ignore_crashes=1 -ignore_timeouts=1 -ignore_ooms=1 \
      -max_total_time=$slice_s -max_len=$largest -timeout=120 -rss_limit_mb=2048 -close_fd_mask=1 \
      -dict="tests/fuzz/dictionaries/$format.dict" -artifact_prefix="$runs/" \
      "$runs/corpus" "$seeds/$format" >>"$runs/log" 2>&1; } 2>"$runs/time" || true # 77: something was found
    spent=$(awk "{ printf \"%.0f\", $spent + \$1 + \$2 }" "$runs/time")
    echo "$spent" >"$runs/cpu_s"
  done
  local artifact
  for artifact in "$runs"/{crash,timeout,oom,slow-unit,leak}-*; do
    [ -e "$artifact" ] || continue
    if (ulimit -t 20 && "$bin/fuzz_$format" -timeout=0 -rss_limit_mb=2048 "$artifact" >/dev/null 2>&1); then
      rm "$artifact"
    else
      mv "$artifact" "$runs/found/"
    fi
  done
  echo "$format: $spent s of processor time, $(find "$runs/corpus" -type f | wc -l) inputs in its corpus," \
    "$(find "$runs/found" -type f | wc -l) found"
}

for format; do fuzz "$format"; done
[ -z "$(find build/fuzz/runs/*/found -type f 2>/dev/null)" ]
