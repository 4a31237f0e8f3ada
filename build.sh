#!/bin/sh
# Builds the project on Debian 12 and runs it. Usage:
#   ./build.sh example   install what is needed, build, run the main job on two real scans
#   ./build.sh test      install what is needed, build, pass all tests (Core with sanitizers, too)
#   ./build.sh packages  install what is needed
set -eu
cd "$(dirname "$0")"

install_packages() {
  packages=$(grep -v '^#' CMake/debian-packages.txt)
  missing=
  for package in $packages; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' ||
      missing="$missing $package"
  done
  [ -n "$missing" ] || return 0
  echo "Installing:$missing"
  as_root=
  [ "$(id -u)" -eq 0 ] || as_root=sudo
  $as_root apt-get update -q
  # shellcheck disable=SC2086
  DEBIAN_FRONTEND=noninteractive $as_root apt-get install -q -y --no-install-recommends $missing
}

build() { # preset
  cmake --preset "$1"
  cmake --build --preset "$1"
}

case "${1:-}" in
  packages)
    install_packages
    ;;
  example)
    install_packages
    build release
    Examples/run_main_job.sh build/release build/main_job
    echo
    echo "The picture: $PWD/build/main_job/main_job.png"
    echo "The table:   $PWD/build/main_job/main_job.csv"
    ;;
  test)
    install_packages
    build asan
    ctest --preset asan -j 2
    build release
    ctest --preset release -j 2
    ;;
  *)
    sed -n '2,5s/^# \{0,1\}//p' "$0"
    exit 2
    ;;
esac
