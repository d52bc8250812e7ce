#!/usr/bin/env bash
# Installs the packages that cpack made on a Debian 12 that has nothing else, and uses them there as their users would:
#   check_clean_debian.sh PACKAGES_DIR [ROOT]
# ROOT is where the system is made by debootstrap, or a system that was made so before; else a folder that is removed in
# the end. Needs root, debootstrap and a Debian mirror; takes some minutes, most of them apt's.
set -euo pipefail

packages=$(realpath "${1:?usage: check_clean_debian.sh PACKAGES_DIR [ROOT]}")
source=$(realpath "$(dirname "${BASH_SOURCE[0]}")/../..")
if [[ -n ${2:-} ]]; then
  root=$(realpath -m "$2")
else
  root=$(mktemp -d)
  temporary=1
fi
cleanUp() {
  umount "$root/proc" 2>/dev/null || true
  [[ -z ${temporary:-} ]] || rm -rf --one-file-system "$root"
}
trap cleanUp EXIT

step() { echo "== $*"; }
fail() {
  echo "check_clean_debian.sh: $*" >&2
  exit 1
}
inside() { chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 \
  DEBIAN_FRONTEND=noninteractive "$@"; }
installed() { inside dpkg-query -W -f '${db:Status-Abbrev}' "$1" 2>/dev/null | grep -q '^ii'; }

step "a Debian 12 of its own in $root"
[[ -x $root/bin/bash ]] || debootstrap --variant=minbase bookworm "$root"
inside bash -c 'mountpoint -q /proc || mount -t proc proc /proc' 2>/dev/null || true
for package in dynemo-slam libdynemo-dev g++; do
  ! installed "$package" || fail "$package is installed there: this is no clean system"
done
mkdir -p "$root/trial"
cp "$packages"/*.deb "$root/trial/"
cp -r "$source/rawlogs/rooms_agents" "$root/trial/"

step "dynemo-slam"
inside apt-get update -q
inside bash -c 'apt-get install -y -q --no-install-recommends /trial/dynemo-slam_*.deb' >"$root/trial/apt.log"
! installed g++ || fail "the programs' package brings a compiler"
sample=/trial/rooms_agents/rooms_agents
inside dynemo-slam --quiet --setup full --entities "${sample}_entities.yaml" --output /trial/run "$sample.rawlog"
inside dynemo-eval --reference "${sample}_gt_robot.tum" --entities-reference "${sample}_gt_entities.csv" /trial/run |
  sed -n '/Trajectory/,/^$/p'
inside dynemo-query /trial/run moved
inside dynemo-prep check "$sample.rawlog" | tail -1
for format in html gltf ply spark-dsg 3dscene g2o; do
  inside dynemo-export /trial/run --format "$format" --output "/trial/exported.$format"
  [[ -s $root/trial/exported.$format ]] || fail "dynemo-export wrote no $format"
done
inside dynemo-batch "$sample.rawlog" --jobs 1 --work /trial/batch --set 'outputs=[trajectory]' | tail -2

step "manual pages and completion"
programs=$(inside dpkg -L dynemo-slam | sed -n 's|^/usr/bin/||p')
[[ $(wc -w <<<"$programs") -ge 9 ]] || fail "programs: $programs"
for program in $programs; do
  zcat "$root/usr/share/man/man1/$program.1.gz" | grep -q "^\.SH SYNOPSIS" || fail "no manual page of $program"
done
inside bash "/dev/stdin" /usr/bin /usr/share/bash-completion/completions <"$source/tests/install/completion_test.sh"

step "libdynemo-dev, and the example against it"
inside bash -c 'apt-get install -y -q --no-install-recommends /trial/libdynemo-dev_*.deb g++ cmake make' >>"$root/trial/apt.log"
inside cmake -S /usr/share/dynemo/examples/query -B /trial/example -DCMAKE_BUILD_TYPE=Release >"$root/trial/cmake.log"
inside cmake --build /trial/example >>"$root/trial/cmake.log"
inside /trial/example/query_example /trial/run
step "all is well"
