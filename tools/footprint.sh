#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What eyepoint-ig weighs by build option, as a table in Markdown: size of the program, shared libraries, time, memory.
#   tools/footprint.sh [TERRAIN.ept]     by default a synthetic one of 1025 x 1025 posts
# Environment: RUNS (9, of the time), SECONDS_TO_FLY (3, before memory is looked at).
set -euo pipefail
[ $# -eq 0 ] || terrain=$(realpath "$1")
cd "$(dirname "$0")/.."
tools/install_packages.sh >&2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
names=()

build() { # NAME PRESET [-DOPTION=...], on top of the preset: keeps the program under the name
  local name=$1 preset=$2
  shift 2
  cmake --preset "$preset" -DEYEPOINT_TESTS=OFF "$@" >/dev/null
  cmake --build --preset "$preset" --parallel "${JOBS:-$(nproc)}" --target eyepoint-ig >"$work/log" || { cat "$work/log"; exit 1; } >&2
  cp "build/$preset/bin/eyepoint-ig" "$work/$name"
  names+=("$name")
}

build default release
build "minimal and PNG" minimal -DEYEPOINT_PNG=ON
build "minimal and streams" minimal -DEYEPOINT_STREAM_SINKS=ON
build minimal minimal
build "minimal, no self-test" minimal -DEYEPOINT_SELFTEST=OFF
if [ -z "${terrain:-}" ]; then
  cmake --build --preset release --parallel "${JOBS:-$(nproc)}" --target eyepoint-terrain >"$work/log" || { cat "$work/log"; exit 1; } >&2
  build/release/bin/eyepoint-terrain synth -o "$work/land.tif" --size 1025 >/dev/null
  build/release/bin/eyepoint-terrain build "$work/land.tif" -o "$work/land.ept" >/dev/null 2>&1
  terrain=$work/land.ept
fi

run() { # NAME [arguments]
  local ig=$work/$1
  shift
  exec "$ig" --terrain "$terrain" --listen 127.0.0.1:0 --set log.level=info "$@" 2>"$work/err"
}

milliseconds() { # NAME: from the start of the process to its end after one frame
  local before=$EPOCHREALTIME
  (run "$1" --frames 1 --sink null)
  echo $(((${EPOCHREALTIME/./} - ${before/./}) / 1000))
}

for _ in $(seq "${RUNS:-9}"); do # in turn, so that all see the same machine
  for name in "${names[@]}"; do milliseconds "$name" >>"$work/ms.$name"; done
done

echo "| Build | Program, stripped | Libraries linked / loaded | Start, one frame, end: median of ${RUNS:-9} | Resident: all / own / files / ring |"
echo "|---|---|---|---|---|"
for name in "${names[@]}"; do
  ig=$work/$name
  strip -o "$work/stripped" "$ig"
  size=$(($(stat -c %s "$work/stripped") / 1024))
  linked=$(readelf -d "$ig" | grep -c NEEDED)
  loaded=$(ldd "$ig" | grep -c '=>')
  median=$(sort -n "$work/ms.$name" | sed -n "$(((${RUNS:-9} + 1) / 2))p")
  rm -f "$work/err"
  (run "$name" --sink "shm:eyepoint-footprint-$$") &
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
  echo "| $name | $size KiB | $linked / $loaded | $median ms | $memory |"
done
