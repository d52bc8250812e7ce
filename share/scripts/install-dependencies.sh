#!/usr/bin/env bash
# Installs the Debian 12 packages this project is built from. Safe to repeat: what is installed is left alone.
set -euo pipefail

usage() {
  cat <<EOF
Usage: install-dependencies.sh [--check | --list-libraries]
  --check  install nothing; succeed when every package is installed, else list the missing ones
  --list-libraries  print the packages that a project needs to build against the libraries, and exit
EOF
}

build_tools=(g++ cmake ninja-build ccache help2man)
packaging_tools=(dpkg-dev file doxygen)
libraries=(
  libmrpt-maps-dev # with it: obs, graphs, opengl, poses, math, img, io, system and what these stand on
  libmrpt-slam-dev
  libpcl-dev
  libeigen3-dev
  libopencv-dev # the one package with OpenCVConfig.cmake
  libapriltag-dev
  libembree-dev
  libtbb-dev
  libsuitesparse-dev
  libopenblas-dev
  libboost-dev
  libnanoflann-dev
  zlib1g-dev
  libyaml-cpp-dev
  nlohmann-json3-dev
  libcli11-dev
  libexpected-dev
  librosbag-storage-dev libsensor-msgs-dev libnav-msgs-dev libtf2-msgs-dev # ROS 1 bags
  libegl-mesa0 # renders pictures without a display
  libgl1-mesa-dri
  libjs-three # goes into the web page
)
run_time_tools=(gnuplot-nox) # figures of dynemo-ablation
test_libraries=(libgtest-dev libbenchmark-dev libceres-dev libmrpt-graphslam-dev)
# Programs of others that tests look through; tests that lack theirs are skipped.
test_programs=(
  mrpt-apps xvfb xdotool imagemagick tesseract-ocr tesseract-ocr-eng # RawLogViewer's window
  slurmctld slurmd slurm-client munge # dynemo-batch --slurm
  python3 python3-jsonschema chromium-headless-shell # readers of exported files
)
packages=("${build_tools[@]}" "${packaging_tools[@]}" "${libraries[@]}" "${run_time_tools[@]}" "${test_libraries[@]}"
  "${test_programs[@]}")

fail() {
  echo "install-dependencies.sh: $*" >&2
  exit 1
}

missing_packages() {
  local package
  for package in "${packages[@]}"; do
    [[ $(dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2>/dev/null) == ii* ]] || echo "$package"
  done
}

as_root() {
  if [[ $EUID -eq 0 ]]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    fail "packages are missing and neither root rights nor sudo are available"
  fi
}

check_only=false
case "${1:-}" in
  "") ;;
  --check) check_only=true ;;
  --list-libraries)
    printf '%s\n' "${libraries[@]}"
    exit 0
    ;;
  -h | --help)
    usage
    exit 0
    ;;
  *)
    usage >&2
    exit 2
    ;;
esac

command -v apt-get >/dev/null && command -v dpkg-query >/dev/null ||
  fail "this system has no apt-get; the packages of Debian 12 are needed: ${packages[*]}"

# The Khronos validator for glTF is an npm package; where there is no npm its test is skipped.
install_gltf_validator() {
  command -v npm >/dev/null || return 0
  [[ -d $(npm root -g)/gltf-validator ]] && return 0
  as_root npm install --global --no-fund --no-audit gltf-validator@2.0.0-dev.3.10 ||
    echo "gltf-validator could not be installed: its test will be skipped" >&2
}

$check_only || install_gltf_validator

mapfile -t missing < <(missing_packages)
if [[ ${#missing[@]} -eq 0 ]]; then
  echo "All ${#packages[@]} packages are installed."
  exit 0
fi
echo "Missing packages: ${missing[*]}"
$check_only && exit 1

as_root apt-get update
as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"
