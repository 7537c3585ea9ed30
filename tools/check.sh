#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs, builds and runs every test: the dev build, image generators that leave things out, the dev build under
# sanitizers, what uses threads under the thread sanitizer, the fuzz targets for a short while, and a small outside
# project against the installed package.
#   tools/check.sh          everything
#   tools/check.sh dev      the dev build's tests alone
set -euo pipefail
cd "$(dirname "$0")/.."
tools/install_packages.sh --tests

jobs=${JOBS:-$(nproc)}
# Seconds for each fuzz target.
fuzz_seconds=${FUZZ_SECONDS:-45}

step() { printf '\n== %s\n' "$*"; }

build() { # PRESET [cmake --build arguments]
  local preset=$1
  shift
  step "$preset: build"
  cmake --preset "$preset" >/dev/null
  cmake --build --preset "$preset" --parallel "$jobs" "$@"
}

build dev
step "dev: test"
ctest --preset dev
[ "${1:-}" = dev ] && exit 0

step "options: the smallest image generator, then with one more at a time"
tools/check_options.sh build/dev/bin

# Without the benchmarks and the whole programs, which would take minutes.
build asan --target quick_tests
step "asan: test"
ctest --preset asan -LE slow --parallel "$jobs"

tsan_tests='test_height_query test_out test_paging test_receipts test_replay test_service test_shm_ring test_terrain_compiler'
# shellcheck disable=SC2086 # a list of targets
build tsan --target $tsan_tests
step "tsan: test"
ctest --preset tsan -R "^(${tsan_tests// /|})\$"

build fuzz --target fuzzers
fuzz() { # NAME
  local found
  found=$(mktemp -d)
  "build/fuzz/tests/$1" -max_total_time="$fuzz_seconds" -max_len=3000 -print_final_stats=1 \
    -artifact_prefix="$found/" "$found" "tests/fuzz/corpus/$1" >"$found.log" 2>&1 ||
    { tail -40 "$found.log"; echo "$1 failed; its input is in $found"; return 1; }
  echo "$1: $(sed -n 's/^stat::number_of_executed_units: *//p' "$found.log") executions"
  rm -rf "$found" "$found.log"
}
export -f fuzz
export fuzz_seconds
step "fuzz: each target for $fuzz_seconds s, two at a time"
printf '%s\n' fuzz_cigi33 fuzz_cigi40 fuzz_fgnet fuzz_session fuzz_capture |
  xargs -P 2 -I NAME bash -c 'fuzz NAME'

step "demo: two seconds over a small terrain"
demo=$(mktemp -d)
OUT=$demo WERROR=ON SIZE=1025 SECONDS_TO_FLY=2 PORT=18123 tools/demo.sh
test -s "$demo/index.html"
rm -rf "$demo"

step "package: an outside project finds and links the host interface"
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT
cmake --install build/dev --prefix "$prefix" >/dev/null
cmake -S tests/package -B "$prefix/build" -G Ninja -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
cmake --build "$prefix/build" >/dev/null
"$prefix/build/consumer"
"$prefix/build/frames"

step "all checks passed"
