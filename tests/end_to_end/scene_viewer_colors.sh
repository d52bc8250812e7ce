#!/usr/bin/env bash
# Opens a scene in MRPT's SceneViewer3D, on a display of its own, and prints how many colours its window shows.
# Fails when that is no more than an empty scene has. Usage: scene_viewer_colors.sh FILE.3Dscene [PICTURE.png]
set -euo pipefail

file=$(realpath "$1")
picture=${2:-}
scratch=$(mktemp -d)
pids=()
finish() {
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf "$scratch"
}
trap finish EXIT

Xvfb -displayfd 3 -screen 0 1280x1000x24 3>"$scratch/display" >/dev/null 2>&1 &
pids+=($!)
for _ in {1..300}; do
  [[ -s $scratch/display ]] && break
  sleep 0.1
done
DISPLAY=:$(<"$scratch/display")
export DISPLAY HOME=$scratch LIBGL_ALWAYS_SOFTWARE=1

SceneViewer3D "$file" >"$scratch/viewer.txt" 2>&1 &
viewer=$!
pids+=("$viewer")
for _ in {1..120}; do
  sleep 0.5
  kill -0 "$viewer" 2>/dev/null || { echo "SceneViewer3D has ended"; cat "$scratch/viewer.txt"; exit 1; }
  for window in $(xdotool search --onlyvisible --pid "$viewer" 2>/dev/null); do
    xdotool windowmove "$window" 0 0 windowsize "$window" 1270 990 || true
  done
  # Without the menus and buttons.
  import -window root -crop 1100x850+110+60 +repage "$scratch/view.png" 2>/dev/null || continue
  cmp -s "$scratch/view.png" "$scratch/before.png" || { cp "$scratch/view.png" "$scratch/before.png"; continue; }
  colors=$(identify -format '%k' "$scratch/view.png")
  # An empty scene has some hundred: axes, a grid, smooth lines.
  ((colors > 2000)) || continue
  [[ -z $picture ]] || cp "$scratch/view.png" "$picture"
  echo "$colors"
  exit 0
done
echo "SceneViewer3D shows nothing"
exit 1
