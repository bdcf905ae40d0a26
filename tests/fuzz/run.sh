#!/usr/bin/env bash
# Fuzzes one format for some minutes of wall time: run.sh FORMAT MINUTES. What is found is gone past and
# kept (crash-*, timeout-* in build/fuzz/runs/FORMAT); a later run begins with what this one learned.
set -euo pipefail
cd "$(dirname "$0")/../.."
format=$1
minutes=$2
bin=build/fuzz/bin
runs=build/fuzz/runs/$format
seeds=build/fuzz/seeds
mkdir -p "$runs/corpus" "$seeds"
[ -e "$seeds/$format" ] || "$bin/fuzz_seeds" "$seeds"
largest=4096
[ "$format" = mcap ] && largest=32768
TIMEFORMAT="$format: %R s of wall time, %U s and %S s (system) of CPU time"
time "$bin/fuzz_$format" -fork=1 -ignore_crashes=1 -ignore_timeouts=1 -ignore_ooms=1 \
  -max_total_time=$((minutes * 60)) -max_len=$largest -timeout=20 -rss_limit_mb=2048 -close_fd_mask=1 \
  -dict="tests/fuzz/dictionaries/$format.dict" -artifact_prefix="$runs/" \
  "$runs/corpus" "$seeds/$format" >>"$runs/log" 2>&1 || true  # 77: something was found
find "$runs" -maxdepth 1 -type f ! -name log -printf '%f\n' | sort
