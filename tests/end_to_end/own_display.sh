# To be sourced: a display of its own, a scratch folder, both gone at the end, and of every program in pids.
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
export DISPLAY HOME=$scratch
