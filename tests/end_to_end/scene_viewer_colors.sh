#!/usr/bin/env bash
# Opens a scene in MRPT's SceneViewer3D, on a display of its own, and prints how many colours its window shows.
# Fails when that is no more than an empty scene has. Usage: scene_viewer_colors.sh FILE.3Dscene [PICTURE.png]
set -euo pipefail

file=$(realpath "$1")
picture=${2:-}
source "$(dirname "${BASH_SOURCE[0]}")/own_display.sh"
export LIBGL_ALWAYS_SOFTWARE=1

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
