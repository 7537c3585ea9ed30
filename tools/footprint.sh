#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What the default and the minimal build of eyepoint-ig weigh, as a table: size of the program, shared libraries,
# time, memory.
#   tools/footprint.sh [TERRAIN.ept]     by default a synthetic one of 1025 x 1025 posts
# Environment: RUNS (9, of the time), SECONDS_TO_FLY (3, before memory is looked at).
set -euo pipefail
[ $# -eq 0 ] || terrain=$(realpath "$1")
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for preset in release minimal; do
  cmake --preset "$preset" -DEYEPOINT_TESTS=OFF >/dev/null
  cmake --build --preset "$preset" --parallel "${JOBS:-$(nproc)}" --target eyepoint-ig >"$work/log" || { cat "$work/log"; exit 1; } >&2
done
if [ -z "${terrain:-}" ]; then
  cmake --build --preset release --parallel "${JOBS:-$(nproc)}" --target eyepoint-terrain >"$work/log" || { cat "$work/log"; exit 1; } >&2
  build/release/bin/eyepoint-terrain synth -o "$work/land.tif" --size 1025 >/dev/null
  build/release/bin/eyepoint-terrain build "$work/land.tif" -o "$work/land.ept" >/dev/null 2>&1
  terrain=$work/land.ept
fi

run() { # PRESET [arguments]
  local ig=build/$1/bin/eyepoint-ig
  shift
  exec "$ig" --terrain "$terrain" --listen 127.0.0.1:0 --set log.level=info "$@" 2>"$work/err"
}

milliseconds() { # PRESET: from the start of the process to its end after one frame
  local before=$EPOCHREALTIME
  (run "$1" --frames 1 --sink null)
  echo $(((${EPOCHREALTIME/./} - ${before/./}) / 1000))
}

for _ in $(seq "${RUNS:-9}"); do # in turn, so that both see the same machine
  for preset in release minimal; do milliseconds "$preset" >>"$work/ms.$preset"; done
done

echo "| Build | Program, stripped | Libraries linked / loaded | One frame, from start to end, median of ${RUNS:-9} | Resident: all / own / files / ring |"
echo "|---|---|---|---|---|"
for preset in release minimal; do
  ig=build/$preset/bin/eyepoint-ig
  strip -o "$work/stripped" "$ig"
  size=$(($(stat -c %s "$work/stripped") / 1024))
  linked=$(readelf -d "$ig" | grep -c NEEDED)
  loaded=$(ldd "$ig" | grep -c '=>')
  median=$(sort -n "$work/ms.$preset" | sed -n "$(((${RUNS:-9} + 1) / 2))p")
  rm -f "$work/err"
  (run "$preset" --sink "shm:eyepoint-footprint-$$") &
  pid=$!
  until grep -qs listening "$work/err"; do
    kill -0 "$pid" || { cat "$work/err" >&2; exit 1; }
    sleep 0.1
  done
  sleep "${SECONDS_TO_FLY:-3}"
  mib() { awk -v key="$1:" '$1 == key { printf "%.1f", $2 / 1024 }' "/proc/$pid/status"; }
  memory="$(mib VmRSS) / $(mib RssAnon) / $(mib RssFile) / $(mib RssShmem) MiB"
  kill "$pid"
  wait "$pid"
  [ "$preset" = release ] && name=default || name=minimal
  echo "| $name | $size KiB | $linked / $loaded | $median ms | $memory |"
done
