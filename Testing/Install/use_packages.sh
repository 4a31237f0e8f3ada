#!/bin/sh
# Installs the packages in /packages, uses and removes them, then installs without packages. Only for
# debian_packages.sh: it writes to /usr.   use_packages.sh BUILD HERE
set -eu
build=$1
here=$2

fail() { # message
  echo "FAILED: $1"
  exit 1
}

expect() { # claim, pattern, command...
  claim=$1
  pattern=$2
  shift 2
  said=$("$@" 2>&1) || fail "$claim: $said"
  printf '%s\n' "$said" | grep -q -- "$pattern" || fail "$claim: $said"
  echo "$claim"
}

list_files() {
  find /usr /etc -xdev \( -name __pycache__ -o -name mandb -o -path /etc/ld.so.cache \) -prune -o -print | sort
}

window() { # arguments of paraview
  timeout 600 xvfb-run -a -s "-noreset -screen 0 1400x1000x24" paraview "$@"
}

# ParaView as the distribution has it, or with a list of plugins, whose last line has no end.
conf=$(sed -n 's/^conf="\(.*\)"$/\1/p' "$build/Packaging/postinst")
[ -f "$conf" ] || printf 'plugins/others.xml' >"$conf"
cp "$conf" /before.conf
list_files >/before.txt

expect "The packages can be installed" "Setting up scalable-isosurface " dpkg -i /packages/*.deb
depends=$(dpkg-deb -f /packages/scalable-isosurface_*.deb Depends)
case "$depends" in
  *"paraview (>= "*"paraview (<< "*) echo "They depend on the ParaView that they were built with" ;;
  *) fail "They depend on: $depends" ;;
esac
for package in scalable-isosurface libscalable-isosurface1 scalable-isosurface-tools; do
  ! dpkg-query -W -f '${Depends}' $package | grep -E 'gdcm|hdf5|netcdf' || fail "$package depends on libraries of formats"
done
for library in /usr/lib/*/libIsosurface*.so* /usr/lib/*/paraview-*/plugins/ScalableIsosurface/*.so; do
  ! LC_ALL=C ldd "$library" | grep "not found" || fail "$library misses a library"
  ! readelf -d "$library" | grep "$build" || fail "$library knows where it was built"
done

cd /tmp
expect "The commands are in the path" "^blockvolume [0-9]" blockvolume --version
for page in blockvolume edgeindex edgeindex-info edgeindex-verify edgeindex-decode; do
  [ -s "/usr/share/man/man1/$page.1.gz" ] || fail "There is no manual page of $page"
done
cat >complete.sh <<'X'
. /usr/share/bash-completion/bash_completion
. /usr/share/bash-completion/completions/blockvolume
COMP_WORDS=(blockvolume --compr) COMP_CWORD=1 COMP_LINE="blockvolume --compr" COMP_POINT=19
_scalable_isosurface blockvolume --compr blockvolume
echo "${COMPREPLY[@]}"
X
if [ -f /usr/share/bash-completion/bash_completion ]; then
  expect "Options complete" "^--compression$" bash complete.sh
fi
expect "The package is importable" "vtkStabbingContour" \
  /usr/bin/python3 -c "from scalable_isosurface import vtkStabbingContour; print(vtkStabbingContour())"
expect "It reads files without VTK" "^8 False" /usr/bin/python3 -c "if True:
    import sys, numpy, scalable_isosurface
    samples = numpy.zeros((3, 3, 3), 'float32')
    samples[1, 1, 1] = 1
    volume = scalable_isosurface.create(samples, '/one.bvol')
    print(len(volume.isosurface(0.5).triangles), any(name.startswith('vtk') for name in sys.modules))"
rm -r /one.bvol /.one.bvol.stores
expect "Two ranks of pvbatch find the plugin by its name" "^Triangles: [1-9]" \
  mpiexec --oversubscribe -n 2 pvbatch "$here/plugin_by_name.py"
expect "A server finds the plugin by its name" "^Triangles: [1-9]" pvpython "$here/plugin_by_name.py" --server
expect "The window lists the plugin and does not load it" "^Listed, loaded: 0" \
  window --script="$here/plugin_in_window.py" --exit
expect "Auto Load loads it at the next start" "^Listed, loaded: 1" \
  window --script="$here/plugin_in_window.py" --exit
cmake -S "$here/Core" -B core >/dev/null
expect "C++ programs are built without a path" "^8 triangles" \
  sh -c 'cmake --build core >/dev/null && cd core && ./InstalledCore'

dpkg -r scalable-isosurface-hdf5 scalable-isosurface-dicom >/dev/null
for file in run.h5 climate.nc scan.dcm; do
  : >"$file"
  said=$(blockvolume "$file" out.bvol 2>&1) && fail "$file was read without its module"
  printf '%s\n' "$said" | grep -q "Format.so, which cannot be loaded: .*No such file" || fail "$file: $said"
done
echo "Without the suggested packages, their formats are refused by name"

expect "The packages can be removed" "Removing scalable-isosurface " \
  dpkg -r scalable-isosurface libscalable-isosurface1 scalable-isosurface-tools python3-scalable-isosurface \
  scalable-isosurface-dev scalable-isosurface-doc
list_files >/after.txt
diff /before.txt /after.txt || fail "Files were left or lost"
[ "$(cat "$conf")" = "$(cat /before.conf)" ] || fail "$conf is not what it was: $(cat "$conf")"
echo "Nothing is left of them"

# Without packages: in ParaView's own prefix cmake --install says the same to ParaView.
rm "$conf"
prefix=$(sed -n 's/^ParaView_PREFIX_PATH[^=]*=//p' "$build/CMakeCache.txt")
cmake --install "$build" --prefix "${prefix:-/usr}" >/dev/null
expect "What cmake installs is found by its name" "^Triangles: [1-9]" pvpython "$here/plugin_by_name.py"
