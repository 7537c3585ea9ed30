#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes the published reports: the synthetic terrain, and real terrain where there is some, the first of them with
# the scaling part: synthetic terrains, and crops of the terrain itself up to all of it.
# Leaves OUT/NAME/report.html, .json, .csv and .md, and prints the figures as Markdown: machine, settings, what
# was to be shown and whether it was, recommended settings, scaling.
#   tools/publish_reports.sh                  synthetic, and Scotland where ../shared/data has it
#   tools/publish_reports.sh DEM [DEM...]     synthetic, and these rasters as one terrain
#   tools/publish_reports.sh WORLD.ept        synthetic, and this dataset
# Environment: OUT (reports), SIZE (synthetic posts a side, 4097), SCALING (posts a side of the terrains and
# crops that scaling is measured with), METHODS, BUDGETS, ALSO (settings beside METHODS x BUDGETS: bintree without live
# ranges, and the methods without morph, which pop), FRAMES, REPORT_OPTIONS (more options for eyepoint-report,
# such as --resume or --passes 7).
# Settings are compared in turn, so that a busy machine costs certainty and not truth; the frame times
# themselves are those of an otherwise idle machine or they are worth little. The load stands in the figures.
# Ends with 1 where the engine broke a bound or a report could not be made.
set -euo pipefail
source "$(dirname "$0")/inputs.sh"
cd "$(dirname "$0")/.."
out=$(from_caller "${OUT:-$PWD/reports}")
size=${SIZE:-4097}
take_sources "$@"
scotland=../shared/data/gb_scotland_8193_dm.vrt
if [ ${#sources[@]} -eq 0 ] && [ -e "$scotland" ]; then
  sources=("$scotland")
fi

tools/install_packages.sh >&2
cmake --preset release -DEYEPOINT_TESTS=OFF -DCMAKE_COMPILE_WARNING_AS_ERROR=OFF >/dev/null
cmake --build --preset release --parallel "${JOBS:-$(nproc)}" --target eyepoint-terrain eyepoint-report >&2
bin=build/release/bin
mkdir -p "$out"

failed=0
scaling=(--scaling "${SCALING:-1025,2049,4097,8193}")
report() { # NAME DATASET [more options]
  local name=$1 dataset=$2
  shift 2
  rm -f "$out/$name/report.md"
  # shellcheck disable=SC2086 # the options are meant to be split
  "$bin/eyepoint-report" --terrain "$dataset" -o "$out/$name" --methods "${METHODS:-hybrid,bintree,geomip}" \
    --budgets "${BUDGETS:-4000,8000,14000,24000,48000}" \
    --also "${ALSO:-soar-14000,hybrid-nomorph-14000,bintree-nomorph-14000,geomip-nomorph-14000}" \
    --frames "${FRAMES:-300}" "$@" ${REPORT_OPTIONS:-} >&2 ||
    failed=1
  if [ -f "$out/$name/report.md" ]; then cat "$out/$name/report.md"; fi
}

if [ ${#sources[@]} -gt 0 ]; then
  name=$(basename "${sources[0]}" | sed 's/\.[^.]*$//')
  dataset=${sources[0]}
  if [[ $dataset != *.ept ]]; then
    dataset=$out/$name.ept
    "$bin/eyepoint-terrain" build "${sources[@]}" -o "$dataset" >&2
  fi
  report "$name" "$dataset" "${scaling[@]}"
  scaling=()
fi
"$bin/eyepoint-terrain" synth -o "$out/synthetic.tif" --size "$size" >&2
"$bin/eyepoint-terrain" build "$out/synthetic.tif" -o "$out/synthetic.ept" >&2
rm "$out/synthetic.tif"
report synthetic "$out/synthetic.ept" "${scaling[@]}"
exit "$failed"
