#!/usr/bin/env bash
# What bash offers to complete, asked from the completion as bash would. Arguments: folder of the programs, folder of the
# completions.
set -euo pipefail
export PATH=$1:$PATH
failures=0

# expect WORD... : OFFER...: all offers are among what completing the last word gives.
expect() {
  local words=() offer
  while [[ $1 != : ]]; do
    words+=("$1")
    shift
  done
  shift
  COMP_WORDS=("${words[@]}")
  COMP_CWORD=$((${#words[@]} - 1))
  COMPREPLY=()
  _dynemo
  for offer in "$@"; do
    printf '%s\n' "${COMPREPLY[@]}" | grep -qxF -- "$offer" && continue
    echo "'${words[*]}' does not offer '$offer' but: ${COMPREPLY[*]}"
    failures=$((failures + 1))
  done
}
compopt() { :; } # only inside of a real completion

for program in "$2"/dynemo-*; do
  # shellcheck source=/dev/null
  source "$program"
  complete -p "$(basename "$program")" >/dev/null
  expect "$(basename "$program")" -- : --help --version
done
cd "$(mktemp -d)"
touch some.rawlog
mkdir folder
expect dynemo-slam --se : --setup --set
expect dynemo-slam --setup f : full f-e
expect dynemo-slam --set keyframes.robot_t : keyframes.robot_translation_m=
expect dynemo-slam --output f : folder
expect dynemo-slam some : some.rawlog
expect dynemo-prep t : trim tags
expect dynemo-prep trim --f : --from
expect dynemo-prep trim so : some.rawlog
expect dynemo-batch --slurm : --slurm --slurm-option
expect dynemo-eval --ent : --entities-reference
expect dynemo-eval --reference so : some.rawlog
expect dynemo-simulate --scale m : mini
expect dynemo-simulate --motion-distortion o : on off
expect dynemo-ablation --scale f : full
expect dynemo-ablation --output f : folder
expect dynemo-export --format s : spark-dsg
expect dynemo-export --set cloud.e : cloud.entities=
expect dynemo-export fol : folder
expect dynemo-query w : where
expect dynemo-query diff --j : --json
expect dynemo-query diff fol : folder
expect dynemo-query folder where 1 --set object : object_residence_s=
expect dynemo-query diff folder folder --set '' : min_agreeing= query.object_residence_s=
expect dynemo-prep check --set sensors.lidar.l : sensors.lidar.label=
expect dynemo-batch --set keyframes.robot_t : keyframes.robot_translation_m=
expect dynemo-optimize --initial '' : auto file chordal
expect dynemo-optimize some : some.rawlog
((failures == 0))
