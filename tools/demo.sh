#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# From a fresh Debian 12 to a flight: installs what is missing, builds, makes terrain, starts the image
# generator, flies it for ten seconds from a host over UDP, and leaves frames, video, statistics and a page
# that shows them.
#   tools/demo.sh                  synthetic terrain
#   tools/demo.sh DEM [DEM...]     any rasters that GDAL reads
# Environment: OUT (demo/ of the project), RATE (30 Hz), SECONDS_TO_FLY (10), SIZE (synthetic posts a side, 4097),
# PORT (any free one), TERRAIN_OPTIONS (more options for eyepoint-terrain build, e.g. "--voids hole").
set -euo pipefail
source "$(dirname "$0")/inputs.sh"
cd "$(dirname "$0")/.."
root=$PWD
out=$(from_caller "${OUT:-$root/demo}")
rate=${RATE:-30}
seconds=${SECONDS_TO_FLY:-10}
size=${SIZE:-4097}
port=${PORT:-0}
take_sources "$@"
mkdir -p "$out"
exec 9>"$out/.lock"
flock -n 9 || { echo "another demo is writing to $out: wait for it, or give another OUT" >&2; exit 1; }

tools/install_packages.sh
echo "building" >&2
cmake --preset release -DEYEPOINT_TESTS=OFF -DCMAKE_COMPILE_WARNING_AS_ERROR=${WERROR:-OFF} >/dev/null
cmake --build --preset release --parallel "${JOBS:-$(nproc)}" >&2
bin=$root/build/release/bin

# What an earlier demo has left, and nothing else.
rm -f "$out"/{terrain,ig,host}.json "$out"/flight.{y4m,mp4} "$out"/{index.html,ig.log}
if [ -d "$out/frames" ]; then find "$out/frames" -maxdepth 1 -name 'frame_*.png' -delete; fi
if [ ${#sources[@]} -eq 0 ]; then
  [ -f "$out/synthetic-$size.tif" ] || "$bin/eyepoint-terrain" synth -o "$out/synthetic-$size.tif" --size "$size"
  sources=("$out/synthetic-$size.tif")
fi
# shellcheck disable=SC2086 # the options are meant to be split
"$bin/eyepoint-terrain" build "${sources[@]}" -o "$out/terrain.ept" ${TERRAIN_OPTIONS:-}

# Above the middle of the terrain, high enough to clear its summits.
"$bin/eyepoint-terrain" info --json "$out/terrain.ept" >"$out/terrain.json"
field() { sed -n 's/^ *"'"$1"'": *\([-0-9.e+]*\),\{0,1\}$/\1/p' "$out/terrain.json" | head -1; }
orbit=$(awk -v n="$(field north_deg)" -v s="$(field south_deg)" -v w="$(field west_deg)" -v e="$(field east_deg)" \
            -v top="$(field max_height_m)" 'BEGIN {
  extent = (n - s) * 111000
  radius = extent / 12; if (radius > 8000) radius = 8000
  printf "%.6f,%.6f,%.1f,%.1f", (n + s) / 2, (w + e) / 2, top + 0.02 * radius + 100, radius }')

echo "flying $seconds s at $rate Hz round $orbit" >&2
"$bin/eyepoint-ig" --terrain "$out/terrain.ept" --listen "127.0.0.1:$port" --set "view.rate_hz=$rate" \
  --sink "png:$out/frames" --sink "y4m:$out/flight.y4m" --stats "$out/ig.json" 2>"$out/ig.log" 9>&- &
ig=$!
trap 'kill "$ig" 2>/dev/null || true' EXIT
# Only a host that knows it talks to this one: another may have the port.
listening() { sed -n 's/.*listening on 127\.0\.0\.1:\([0-9]*\).*/\1/p' "$out/ig.log"; }
until port=$(listening) && [ -n "$port" ]; do
  kill -0 "$ig" 2>/dev/null || { cat "$out/ig.log" >&2; code=0; wait "$ig" || code=$?; exit "$code"; }
  sleep 0.1
done
"$bin/eyepoint-host" --target "127.0.0.1:$port" --orbit "$orbit" --rate "$rate" --duration "$seconds" --view-pitch -8 \
  --json >"$out/host.json" || { echo "the host reports a failure:" >&2; cat "$out/host.json" >&2; exit 1; }
kill -TERM "$ig"
wait "$ig" || { code=$?; cat "$out/ig.log" >&2; exit "$code"; }
trap - EXIT

video=flight.y4m
if command -v ffmpeg >/dev/null && ffmpeg -v error -y -i "$out/flight.y4m" -pix_fmt yuv420p "$out/flight.mp4"; then
  rm "$out/flight.y4m"
  video=flight.mp4
fi
tools/demo_page.sh "$out" "$video"
echo
where=$(cd "$out" && pwd)
echo "look at    $where/index.html"
echo "frames     $where/frames"
echo "video      $where/$video"
echo "figures    $where/ig.json and $where/host.json"
