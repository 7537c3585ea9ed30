#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# demo_page.sh DIR VIDEO: writes DIR/index.html, which shows the flight in DIR. Everything is in the page or
# beside it; nothing is fetched.
set -euo pipefail
dir=$1
video=$2
mapfile -t frames < <(find "$dir/frames" -name 'frame_*.png' -printf 'frames/%f\n' | sort)
[ ${#frames[@]} -gt 0 ] || { echo "no frames in $dir/frames" >&2; exit 1; }

{
  cat <<'EOF_HEAD'
<!doctype html>
<html lang="en"><meta charset="utf-8"><title>Eyepoint: a flight</title>
<style>
:root { color-scheme: light dark }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1280px; margin: 2em auto; padding: 0 1em }
img, video { max-width: 100%; height: auto; display: block }
.stills { display: grid; grid-template-columns: repeat(3, 1fr); gap: 8px }
table { border-collapse: collapse } td, th { padding: .2em .8em; text-align: right; border-bottom: 1px solid #8884 }
td:first-child, th:first-child { text-align: left } pre { overflow: auto; border: 1px solid #8884; padding: 1em }
</style>
<h1>Eyepoint: a flight</h1>
EOF_HEAD
  case $video in
    *.mp4) printf '<video controls loop src="%s"></video>\n' "$video" ;;
    *) printf '<p>Video: <a href="%s">%s</a> (raw Y4M; mpv and ffplay show it).</p>\n' "$video" "$video" ;;
  esac
  printf '<h2>Frames</h2><div class="stills">\n'
  count=${#frames[@]}
  for i in 1 2 3 4 5 6; do
    still=${frames[$(((count - 1) * i / 6))]}
    printf '<a href="%s"><img src="%s" alt="%s"></a>\n' "$still" "$still" "$(basename "$still")"
  done
  printf '</div>\n<h2>Image generator</h2>\n<table id="times"></table><p id="facts"></p>\n'
  printf '<details><summary>all statistics (ig.json)</summary><pre id="ig">'
  sed 's/&/\&amp;/g; s/</\&lt;/g' "$dir/ig.json"
  printf '</pre></details>\n<h2>Host</h2>\n<pre id="host">'
  sed 's/&/\&amp;/g; s/</\&lt;/g' "$dir/host.json"
  printf '</pre>\n'
  cat <<'EOF_TAIL'
<script>
const ig = JSON.parse(document.getElementById("ig").textContent)
const columns = ["mean", "p50", "p95", "p99", "p99.9", "max"]
const rows = Object.entries(ig).filter(([key, value]) => key.endsWith("_ms") && value.mean > 0)
document.getElementById("times").innerHTML = "<tr><th>ms</th>" + columns.map(c => `<th>${c}</th>`).join("") + "</tr>" +
  rows.map(([key, value]) => `<tr><td>${key.slice(0, -3).replaceAll("_", " ")}</td>` +
    columns.map(c => `<td>${value[c].toFixed(2)}</td>`).join("") + "</tr>").join("")
document.getElementById("facts").textContent =
  `${ig.frames} frames, ${ig.missed} missed at ${ig.rate_hz} Hz; ${Math.round(ig.triangles.mean)} triangles on average, ` +
  `${ig.triangles.max} at most, budget ${ig.triangles.budget}; tolerance ${ig.tau_px.mean.toFixed(1)} px on average; ` +
  `${ig.packets.accepted} host packets, ${ig.packets.lost} lost; ${ig.graphics.renderer}`
</script>
</html>
EOF_TAIL
} >"$dir/index.html"
