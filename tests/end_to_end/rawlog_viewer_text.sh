#!/usr/bin/env bash
# Opens a rawlog in MRPT's RawLogViewer, on a display of its own, and prints what its window shows of the classes and
# labels in it, as read by optical character recognition. Usage: rawlog_viewer_text.sh FILE.rawlog
set -euo pipefail

file=$(realpath "$1")
source "$(dirname "${BASH_SOURCE[0]}")/own_display.sh"

# It finds the images only when it is started beside the rawlog.
cd "$(dirname "$file")"
open_viewer() {
  RawLogViewer "$(basename "$file")" >"$scratch/viewer.txt" 2>&1 &
  viewer=$!
  pids+=("$viewer")
}
open_viewer
# On a busy machine the viewer may end when its first dialog is closed while it is still opening.
again=2

# The pane at the lower right of a window of this size.
pane=860x520+405+325
for _ in {1..120}; do
  sleep 0.5
  if ! kill -0 "$viewer" 2>/dev/null; then
    ((again-- > 0)) || { echo "RawLogViewer has ended"; cat "$scratch/viewer.txt"; exit 1; }
    open_viewer
    continue
  fi
  for tip in $(xdotool search --name '^Tip of the Day$' 2>/dev/null); do xdotool windowclose "$tip" || true; done
  for window in $(xdotool search --name '^RawlogViewer - Part' 2>/dev/null); do
    xdotool windowmove "$window" 0 0 windowsize "$window" 1270 990 || true
  done
  import -window root -crop "$pane" +repage -resize 250% "$scratch/pane.png" 2>/dev/null || continue
  # Reading takes long: only what does not change any more, and is no empty pane (which is small as a file).
  cmp -s "$scratch/pane.png" "$scratch/before.png" || { cp "$scratch/pane.png" "$scratch/before.png"; continue; }
  [[ $(stat -c %s "$scratch/pane.png") -gt 30000 ]] || continue
  OMP_THREAD_LIMIT=1 tesseract "$scratch/pane.png" "$scratch/pane" --psm 6 >/dev/null 2>&1
  if grep -q 'Summary of classes' "$scratch/pane.txt"; then
    cat "$scratch/pane.txt"
    exit 0
  fi
done
echo "RawLogViewer shows no summary"
exit 1
