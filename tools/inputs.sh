# shellcheck shell=bash
# SPDX-License-Identifier: MIT
# For scripts that are given rasters and an output folder, both meant from where the caller stands. To be sourced
# before the script leaves that folder.
caller=$PWD

from_caller() { # PATH: the same, absolute
  case $1 in /*) echo "$1" ;; *) echo "$caller/$1" ;; esac
}

# FILE...: as the array sources, absolute; ends with 2 where one is not there.
take_sources() {
  local source
  sources=()
  for source in "$@"; do
    source=$(from_caller "$source")
    [ -f "$source" ] || { echo "$source: no such file; check the path" >&2; exit 2; }
    sources+=("$source")
  done
}
