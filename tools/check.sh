#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs, builds and runs every test: the dev build, the sanitizers over everything that needs no driver, the
# fuzz targets for a short while, and a small outside project against the installed package.
#   tools/check.sh          everything
#   tools/check.sh dev      the dev build's tests alone
set -euo pipefail
cd "$(dirname "$0")/.."
tools/install_packages.sh --tests

jobs=${JOBS:-$(nproc)}
# Seconds for each fuzz target.
fuzz_seconds=${FUZZ_SECONDS:-20}

step() { printf '\n== %s\n' "$*"; }

build_and_test() { # PRESET [ctest arguments]
  local preset=$1
  shift
  step "$preset: build"
  cmake --preset "$preset" >/dev/null
  cmake --build --preset "$preset" --parallel "$jobs"
  step "$preset: test"
  ctest --preset "$preset" --output-on-failure "$@"
}

build_and_test dev
[ "${1:-}" = dev ] && exit 0

build_and_test asan
build_and_test tsan -L threads

step "fuzz: build"
cmake --preset fuzz >/dev/null
cmake --build --preset fuzz --parallel "$jobs" --target fuzzers
for fuzzer in build/fuzz/fuzz/fuzz_*; do
  [ -x "$fuzzer" ] || continue
  name=$(basename "$fuzzer")
  step "fuzz: $name, $fuzz_seconds s"
  corpus=$(mktemp -d)
  "$fuzzer" -max_total_time="$fuzz_seconds" -print_final_stats=1 -artifact_prefix="$corpus/" \
    "$corpus" "tests/fuzz/corpus/${name#fuzz_}" 2>&1 | tail -8
  rm -rf "$corpus"
done

step "package: an outside project finds and links the host interface"
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT
cmake --install build/dev --prefix "$prefix" >/dev/null
cmake -S tests/package -B "$prefix/build" -G Ninja -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
cmake --build "$prefix/build" >/dev/null
"$prefix/build/consumer"

step "all checks passed"
