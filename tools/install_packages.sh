#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs the Debian packages that are missing: what building and running needs; with --video also what the sink
# gst: and config/video-rtp.toml need; with --tests all of that and what the tests need. Does nothing, and needs no rights, when all are there.
set -euo pipefail

packages=(
  g++ cmake ninja-build pkg-config
  libegl-dev libgles-dev libegl1 libgles2 libgl1-mesa-dri # EGL and OpenGL ES through Mesa
  libglm-dev libcli11-dev libtomlplusplus-dev libfmt-dev libspdlog-dev nlohmann-json3-dev
  libzstd-dev libxxhash-dev libpng-dev
  libgdal-dev # the terrain compiler alone
  libpcap-dev # eyepoint-replay alone
)
if [ "${1:-}" = --video ] || [ "${1:-}" = --tests ]; then
  packages+=(libgstreamer1.0-dev gstreamer1.0-plugins-base gstreamer1.0-plugins-good gstreamer1.0-plugins-ugly)
fi
if [ "${1:-}" = --tests ]; then
  packages+=(gstreamer1.0-libav # decodes what the video sink sends
    catch2 libgeographiclib-dev libbenchmark-dev tshark clang libclang-rt-14-dev gdal-bin)
fi

missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q '^install ok installed$' || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

echo "installing: ${missing[*]}" >&2
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "run as root, or install: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
export DEBIAN_FRONTEND=noninteractive
log=$(mktemp)
if ! { "${as_root[@]}" apt-get update && "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
       apt-get install -y --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
  tail -20 "$log" >&2
  echo "apt-get failed; its log is $log" >&2
  exit 1
fi
rm -f "$log"
