#!/usr/bin/env bash
# From a fresh clone on Debian 12 to a first map: installs the packages, builds the two programs, runs dynemo-slam on
# the bundled sample dataset and compares the result with the ground truth. Safe to repeat.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

share/scripts/install-dependencies.sh
cmake --preset release
cmake --build --preset release --target dynemo-slam dynemo-eval

sample=rawlogs/rooms_agents/rooms_agents
run=out/rooms_agents
set -x
build/release/bin/dynemo-slam --entities "${sample}_entities.yaml" --output "$run" "$sample.rawlog"
build/release/bin/dynemo-eval --reference "${sample}_gt_robot.tum" \
  --entities-reference "${sample}_gt_entities.csv" "$run"
