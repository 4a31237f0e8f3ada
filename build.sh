#!/bin/sh
# Builds the project on Debian 12, 13 or 14 and runs it. Usage:
#   ./build.sh example   build what the main job needs, run it on two real scans, say where the image is
#   ./build.sh test      build everything and pass all tests (Core with sanitizers, too)
#   ./build.sh sanitizers   build Core alone with sanitizers and pass its tests: a part of "test"
#   ./build.sh package   make Debian packages in build/release: the plugin, the commands, Python, C++
#   ./build.sh vtk       build and test the VTK classes beside VTK alone, on a system without ParaView
#   ./build.sh wheel     make a Python wheel for Linux, and a plugin for any ParaView, in build/wheel (in a root folder of
#                        Debian 11: 3 GB, needs root)
#   ./build.sh packages  only install what is needed, for development too
# The others install what is missing of CMake/debian-packages.txt.
set -eu
cd "$(dirname "$0")"

begin=$(date +%s)
say() { # step
  printf '\n== %s s: %s\n' "$(($(date +%s) - begin))" "$1"
}

# "paraview" or "vtk"; "all", or nothing to leave out those that only development needs
install_packages() {
  release=$(. /etc/os-release && echo "${VERSION_ID:-14}") # Debian's next release has no number yet
  packages=$(awk -v all="${2:-}" -v release="$release" -v beside="$1" \
    '/^# For development alone/ && !all { exit }
     /^#/ { next }
     { for (i = 2; i <= NF; ++i) if (release !~ "^(" $i ")$" && $i != beside) next; print $1 }' \
    CMake/debian-packages.txt)
  missing=
  for package in $packages; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' ||
      missing="$missing $package"
  done
  [ -n "$missing" ] || return 0
  say "Installing packages:$missing"
  as_root=
  [ "$(id -u)" -eq 0 ] || as_root=sudo
  $as_root apt-get update -q
  # shellcheck disable=SC2086
  DEBIAN_FRONTEND=noninteractive $as_root apt-get install -q -y --no-install-recommends $missing
}

configure() { # preset, options
  say "Configuring build/$1"
  cmake --preset "$@"
}

compile() { # preset, targets
  preset=$1
  shift
  sources=$(ninja -C "build/$preset" -n "$@" | grep -c 'Building C') || true
  say "Compiling $sources files in build/$preset"
  ninja -C "build/$preset" "$@"
}

run_tests() { # preset
  say "Running the tests of build/$1"
  ctest --preset "$1" -j 4 # on two cores: windows and ranks wait for each other
}

case "${1:-}" in
  packages)
    install_packages paraview all
    ;;
  example)
    install_packages paraview
    configure release
    compile release ScalableIsosurface blockvolume edgeindex
    say "Running Examples/main_job.py on two ranks: isosurfaces of two scans"
    Examples/run_main_job.sh build/release build/main_job
    say "Done"
    echo "The image:  $PWD/build/main_job/main_job.png"
    echo "The table:  $PWD/build/main_job/main_job.csv"
    echo "The plugin: $(echo "$PWD"/build/release/lib/*/paraview-*/plugins/ScalableIsosurface/ScalableIsosurface.so)"
    ;;
  package)
    install_packages paraview
    configure release
    compile release ScalableIsosurface blockvolume edgeindex IsosurfacePythonHints IsosurfaceManualPages
    say "Making packages"
    ISOSURFACE_BUILD=build/release DEB_RULES_REQUIRES_ROOT=no debian/rules binary
    debian/rules clean ISOSURFACE_BUILD=build/release
    echo "Install them: sudo apt install $PWD/build/release/*.deb"
    ;;
  wheel)
    Testing/Systems/on_debian.sh bullseye "${ISOSURFACE_SYSTEMS:-build/systems}" run Packaging/wheel/build.sh
    mkdir -p build/wheel
    cp "${ISOSURFACE_SYSTEMS:-build/systems}"/bullseye/project/build/wheel/*.whl \
      "${ISOSURFACE_SYSTEMS:-build/systems}"/bullseye/project/build/wheel/*.zip build/wheel
    echo "Install it: pip install $(echo "$PWD"/build/wheel/*.whl)"
    echo "For any ParaView, unzip $(echo "$PWD"/build/wheel/*.zip), and load ScalableIsosurface.py"
    ;;
  vtk)
    if dpkg-query -W -f '${Status}' python3-paraview 2>/dev/null | grep -q 'ok installed'; then
      echo "build.sh: libvtk9-dev would remove ParaView from this system; Testing/Systems/on_debian.sh builds in a folder" >&2
      exit 1
    fi
    install_packages vtk
    configure vtk
    compile vtk
    run_tests vtk
    say "All tests passed"
    ;;
  sanitizers)
    install_packages paraview
    configure asan
    compile asan
    run_tests asan
    say "Passed; of the processors, by this shell and what it ran, each user and system:"
    times
    ;;
  test)
    install_packages paraview
    configure release -DISOSURFACE_CORE_TESTS=OPTIMISED # the sanitizers run the others
    compile release
    # Windows and ranks wait for each other half of the time: compiling takes that time, and no other.
    log=build/sanitizers.log
    say "Compiling Core with sanitizers beside the tests: $log"
    setsid chrt --idle 0 sh -c 'cmake --preset asan && ninja -C build/asan -j 2' > "$log" 2>&1 &
    sanitizers=$!
    trap 'kill -- "-$sanitizers" 2>/dev/null || true' EXIT
    trap 'exit 1' INT TERM
    failed=
    run_tests release || failed=1
    wait "$sanitizers" || cat "$log"
    ./build.sh sanitizers || failed=1
    [ -z "$failed" ] || exit 1
    say "All tests passed; of the processors, by this shell and what it ran, each user and system:"
    times
    ;;
  *)
    sed -n '2,11s/^# \{0,1\}//p' "$0"
    exit 2
    ;;
esac
