#!/bin/sh
# Uses the same wheel and the same plugin in one file of Python, byte for byte, in releases of Debian with another ParaView
# and another Python each. Usage:
#   any_paraview.sh BUILD FOLDER WHEEL ZIP [RELEASE...]
# BUILD is a folder with the plugin in C++ and the volumes of its tests (ctest -R MakeVolumes), on Debian 12: what that plugin
# makes is what is expected, and where on_debian.sh has built it, what the one of the release makes: normals and the type of
# cells follow VTK's version. FOLDER gets the root folders of on_debian.sh, and of each release a folder
# RELEASE-any-paraview with screenshots and a report. RELEASE is bullseye (ParaView 5.9), bookworm (5.11), trixie (5.13) or
# forky (6.1); without any: all of them. Needs to be root, and mmdebstrap.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
plugin_tests=$here/../Plugin

# name, what it should print at least, command...
check() {
  name=$1
  begin=$(date +%s)
  shift
  result=passed
  "$@" >"$output/$name.log" 2>&1 || result="FAILED ($output/$name.log)"
  echo "$name: $result in $(($(date +%s) - begin)) s"
  [ "$result" = passed ] || failures=$((failures + 1))
}

# Runs beside a server of two ranks, with which the script connects.
run_with_server() {
  timeout 200 xvfb-run -a -s -noreset mpirun --oversubscribe -n 2 pvserver --server-port=11199 >"$output/pvserver.log" 2>&1 &
  server=$!
  until grep -q Accepting "$output/pvserver.log"; do
    kill -0 $server || return 1
    sleep 1
  done
  timeout 150 "$@" --server 127.0.0.1:11199 || {
    kill $server
    return 1
  }
  wait $server
}

# A library that is cut in the middle: one line, and ParaView lives.
refuses_damaged_library() {
  rm -rf "$output/damaged"
  cp -r "$unpacked" "$output/damaged"
  for library in "$output"/damaged/scalable_isosurface/libscalable_isosurface.so*; do
    truncate -s 100000 "$library"
  done
  echo "from paraview.simple import LoadPlugin; LoadPlugin('$output/damaged/ScalableIsosurface.py'); print('lives')" \
    >"$output/damaged.py"
  $pvbatch "$output/damaged.py" >"$output/damaged.txt" 2>&1
  cat "$output/damaged.txt"
  grep -q '^lives$' "$output/damaged.txt" && [ "$(grep -c 'libscalable_isosurface' "$output/damaged.txt")" = 1 ] &&
    ! grep -q Traceback "$output/damaged.txt"
}

# What official binaries differ in: a Python that has nothing but NumPy, and other libraries that are found first.
is_alone_with_numpy() {
  rm -rf "$output/alone"
  mkdir -p "$output/alone/site" "$output/alone/libraries"
  cp -r "$unpacked/scalable_isosurface" "$output/alone/site"
  ln -s "$(python3 -c 'import numpy, os; print(os.path.dirname(numpy.__file__))')" "$output/alone/site/numpy"
  for library in libhdf5_serial.so.103 libnetcdf.so.18 libtiff.so.5; do # of another version, or of none
    echo "not a library" >"$output/alone/libraries/$library"
  done
  LD_LIBRARY_PATH="$output/alone/libraries" PYTHONPATH='' python3 -S -s -B -c "
import sys
sys.path.append('$output/alone/site')
import scalable_isosurface as package
assert len(package.open('$volumes/wave.bvol').isosurface(157.25).triangles) > 1000"
}

if [ "$1" = inside ]; then # a root folder
  input=$2
  output=$3
  failures=0
  volumes=$input/volumes
  unpacked=$output/plugin
  { apt-get update -q && DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends paraview \
    python3-paraview python3-numpy python3-venv python3-h5py python3-netcdf4 python3-pydicom python3-tifffile \
    python3-zarr openmpi-bin unzip xvfb xauth libgl1-mesa-dri; } >"$output/packages.log" 2>&1
  (cd "$input" && sha256sum -- *.whl *.zip)
  dpkg-query -W -f '${Package} ${Version}\n' paraview python3 python3-numpy
  rm -rf "$unpacked"
  unzip -q "$input"/*.zip -d "$unpacked"
  unpacked=$(dirname "$(find "$unpacked" -name ScalableIsosurface.py)")
  plugin=$unpacked/ScalableIsosurface.py
  export PYTHONPATH="$input/site"
  pvbatch='xvfb-run -a -s -noreset pvbatch'
  built=$(find "$here/../../build/release/lib" -name ScalableIsosurface.so 2>/dev/null | head -n 1)
  for ranks in 1 3; do
    # LoadPlugin in pvbatch of ParaView 5.9 reaches the first rank alone.
    [ $ranks = 1 ] || [ "$(cut -d . -f 1 /etc/debian_version)" != 11 ] ||
      export PV_PLUGIN_PATH="$(dirname "$plugin")"
    check "surfaces-$ranks" xvfb-run -a -s -noreset python3 -B "$plugin_tests/one_file.py" \
      --plugins "${built:-$input/expected$ranks.json}" "$plugin" --volumes "$volumes" --output "$output/surfaces$ranks" \
      -- mpirun --oversubscribe -n "$ranks" pvbatch
  done
  unset PV_PLUGIN_PATH
  check server run_with_server xvfb-run -a -s -noreset pvpython "$plugin_tests/one_file_server.py" \
    "$plugin" "$volumes" "$input/expected1.json" "$output/server.png"
  for volume in large.zarr slices/0.dcm; do
    folder=$output/$(dirname $volume)-window
    rm -rf "$folder"
    mkdir -p "$folder"
    cp -r "$volumes/$(echo $volume | cut -d / -f 1)" "$folder"
    check "first-contact-$(basename $volume)" env ONE_FILE_PLUGIN="$plugin" ONE_FILE_VOLUME="$folder/$volume" \
      ONE_FILE_OUTPUT="$folder" xvfb-run -a -s -noreset \
      timeout 200 paraview --disable-registry --script="$plugin_tests/one_file_window.py"
  done
  check damaged-library refuses_damaged_library
  check wheel env PYTHONPATH= "$here/../Install/use_wheel.sh" "$input"/*.whl
  check alone-with-numpy is_alone_with_numpy
  exit $failures
fi

[ $# -ge 4 ] || {
  sed -n '2,10p' "$0" | sed 's/^# \{0,1\}//'
  exit 2
}
build=$(cd "$1" && pwd)
mkdir -p "$2"
folder=$(cd "$2" && pwd)
wheel=$(readlink -f "$3")
zip=$(readlink -f "$4")
shift 4
[ $# -gt 0 ] || set -- bullseye bookworm trixie forky

# What every release gets. ParaView 5.11 in Python 3.11 cannot load plugins of Python without the site's line.
input=$folder/any-paraview
rm -rf "$input"
mkdir -p "$input/volumes" "$input/site"
cp "$wheel" "$zip" "$input"
cp -r "$build"/Testing/Plugin/Volumes/wave.[!v]* "$build"/Testing/Plugin/Volumes/series.bvol \
  "$build"/Testing/Plugin/Volumes/.*.bvol.stores "$build"/Testing/Plugin/Volumes/*.vt[im] \
  "$build"/Testing/Plugin/Volumes/pair "$build"/Testing/Plugin/Volumes/large.zarr "$input/volumes"
rm -rf "$input"/volumes/*.mhd.bvol "$input"/volumes/.*.mhd.bvol.stores
"$here/../../Examples/run_main_job.sh" "$build" "$input/volumes/scans" 1 >/dev/null
python3 -B "$here/write_slices.py" "$input/volumes/wave.raw" 82 76 67 "$input/volumes/slices"
echo 'import inspect; inspect.getargspec = inspect.getfullargspec' >"$input/site/sitecustomize.py"
for ranks in 1 3; do
  xvfb-run -a -s -noreset python3 -B "$plugin_tests/one_file.py" --save "$input/expected$ranks.json" \
    --plugins "$(find "$build/lib" -name ScalableIsosurface.so | head -n 1)" \
    --volumes "$input/volumes" --output "$input/output" -- mpirun --oversubscribe -n "$ranks" pvbatch
done
rm -rf "$input/output"

failures=0
for release; do
  "$here/on_debian.sh" "$release" "$folder" run true >/dev/null
  rm -rf "$folder/$release/any-paraview"
  cp -r "$input" "$folder/$release/any-paraview"
  mkdir -p "$folder/$release/any-paraview/output"
  "$here/on_debian.sh" "$release" "$folder" run "./Testing/Systems/$(basename "$0")" inside /any-paraview \
    /any-paraview/output || failures=$((failures + 1))
  rm -rf "$folder/$release-any-paraview"
  cp -r "$folder/$release/any-paraview/output" "$folder/$release-any-paraview"
  cp "$folder/output-$release.txt" "$folder/$release-any-paraview/report.txt"
  cat "$folder/output-$release.txt"
done
exit $failures
