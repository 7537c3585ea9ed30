#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds eyepoint-ig with all sinks to files left out, then without its self-test too, then with one sink more at a
# time, and checks of each: exactly the libraries that it may link, that it flies, that what was left out is refused
# by the name of its option.
#   tools/check_options.sh BIN     BIN: eyepoint-terrain and eyepoint-frames of another build
set -euo pipefail
tools=$(realpath "$1")
cd "$(dirname "$0")/.."
ig=build/minimal/bin/eyepoint-ig
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() { echo "check_options: $*" >&2; exit 1; }

build() { # [-DOPTION=...]: on top of the preset, which takes back what was built before
  cmake --preset minimal "$@" >/dev/null
  cmake --build --preset minimal --parallel "${JOBS:-$(nproc)}" --target eyepoint-ig >"$work/build.log" ||
    { cat "$work/build.log" >&2; fail "does not build with $*"; }
}

links() { # LIBRARY...: these and no others, without their versions
  local expected found
  expected=$(printf '%s\n' "$@" | LC_ALL=C sort | tr '\n' ' ')
  found=$(readelf -d "$ig" | sed -n 's/.*(NEEDED).*\[\(.*\)\.so.*\]/\1/p' | grep -v '^ld-linux' |
          LC_ALL=C sort | tr '\n' ' ')
  [ "$found" = "$expected" ] || fail "links  $found
             but should link  $expected"
}

fly() { # FRAMES [arguments of eyepoint-ig]
  "$ig" --terrain "$work/land.ept" --listen 127.0.0.1:0 --set view.width=320 --set view.height=180 \
    --set log.level=warning --frames "$@"
}

refused() { # OPTION [arguments]
  local option=$1 code=0
  shift
  fly 1 "$@" 2>"$work/said" || code=$?
  if [ "$code" -ne 2 ] || ! grep -q -- "-D$option=ON" "$work/said"; then
    fail "$* ends with $code and says: $(cat "$work/said")"
  fi
}

"$tools/eyepoint-terrain" synth -o "$work/land.tif" --size 257 >/dev/null
"$tools/eyepoint-terrain" build "$work/land.tif" -o "$work/land.ept" >/dev/null 2>&1
least=(libEGL libGLESv2 libc libfmt libgcc_s libm libspdlog libstdc++ libtomlplusplus libxxhash libzstd)

build
links "${least[@]}"
refused EYEPOINT_PNG --sink "png:$work/frames"
refused EYEPOINT_STREAM_SINKS --sink "y4m:$work/v.y4m"
refused EYEPOINT_STREAM_SINKS --sink "raw:$work/v.raw"
refused EYEPOINT_STREAM_SINKS --receipts "$work/receipts.jsonl"
refused EYEPOINT_GSTREAMER --sink "gst:fakesink"
ring=eyepoint-options-$$
fly 200 --sink "shm:$ring" --sink null &
"$tools/eyepoint-frames" "$ring" --frames 5 --wait 30 >"$work/frames.json" || fail "no frames come out of the ring"
wait $! || fail "the flight into a ring fails"
fly 1 --explain --json "$work/explained.json" >"$work/said" || fail "--explain fails: $(cat "$work/said")"
[ -s "$work/explained.json" ] || fail "--explain leaves no JSON"
"$ig" --selftest >"$work/said" || fail "--selftest fails: $(tail -20 "$work/said")"

build -DEYEPOINT_SELFTEST=OFF
links "${least[@]}"
fly 3 --sink null
fly 1 --explain >"$work/said" || fail "--explain fails: $(cat "$work/said")"
refused EYEPOINT_SELFTEST --selftest

build -DEYEPOINT_PNG=ON
links "${least[@]}" libpng16
fly 3 --sink "png:$work/frames"
[ -s "$work/frames/frame_000000.png" ] || fail "no picture"

build -DEYEPOINT_STREAM_SINKS=ON
links "${least[@]}"
fly 3 --sink "raw:$work/v.raw" --receipts "$work/receipts.jsonl"
[ "$(stat -c %s "$work/v.raw")" -eq $((3 * 320 * 180 * 4)) ] || fail "not three frames"
[ "$(wc -l <"$work/receipts.jsonl")" -eq 3 ] || fail "not three receipts"

build -DEYEPOINT_GSTREAMER=ON
links "${least[@]}" libgstreamer-1.0 libgobject-2.0 libglib-2.0
fly 3 --sink "gst:fakesink"
echo "options: each leaves out what it should"
