#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes the published reports: the synthetic terrain, with the scaling part, and real terrain where there is some.
# Leaves OUT/NAME/report.html, .json, .csv and .md, and prints the tables.
#   tools/publish_reports.sh                  synthetic, and Scotland where ../shared/data has it
#   tools/publish_reports.sh DEM [DEM...]     synthetic, and these rasters as one terrain
# Environment: OUT (reports), SIZE (synthetic posts a side, 4097), SCALING (posts a side of the terrains that
# scaling is measured with), METHODS, BUDGETS, FRAMES, REPORT_OPTIONS (more options for eyepoint-report, such as
# --resume).
# Ends with 1 where the engine broke its bound.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${OUT:-reports}
size=${SIZE:-4097}
sources=()
for source in "$@"; do
  [ -e "$source" ] || source=$OLDPWD/$source
  sources+=("$source")
done
scotland=../shared/data/gb_scotland_8193_dm.vrt
if [ ${#sources[@]} -eq 0 ] && [ -e "$scotland" ]; then
  sources=("$scotland")
fi

tools/install_packages.sh
cmake --preset release -DEYEPOINT_TESTS=OFF -DCMAKE_COMPILE_WARNING_AS_ERROR=OFF >/dev/null
cmake --build --preset release --parallel "${JOBS:-$(nproc)}" --target eyepoint-terrain eyepoint-report >&2
bin=build/release/bin
mkdir -p "$out"

failed=0
report() { # NAME [more options]
  local name=$1
  shift
  # shellcheck disable=SC2086 # the options are meant to be split
  "$bin/eyepoint-report" --terrain "$out/$name.ept" -o "$out/$name" --methods "${METHODS:-hybrid,bintree,geomip}" \
    --budgets "${BUDGETS:-4000,8000,14000,24000,48000}" --frames "${FRAMES:-300}" "$@" ${REPORT_OPTIONS:-} || failed=1
  if [ -f "$out/$name/report.md" ]; then cat "$out/$name/report.md"; fi
}

if [ ! -f "$out/synthetic.ept" ]; then
  "$bin/eyepoint-terrain" synth -o "$out/synthetic.tif" --size "$size"
  "$bin/eyepoint-terrain" build "$out/synthetic.tif" -o "$out/synthetic.ept"
fi
report synthetic --scaling "${SCALING:-1025,2049,4097,8193}"
if [ ${#sources[@]} -gt 0 ]; then
  name=$(basename "${sources[0]}" | sed 's/\.[^.]*$//')
  [ -f "$out/$name.ept" ] || "$bin/eyepoint-terrain" build "${sources[@]}" -o "$out/$name.ept"
  report "$name"
fi
exit "$failed"
