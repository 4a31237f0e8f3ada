#!/bin/sh
# Builds and tests this repository on another release of Debian, in a root folder of its own. Usage:
#   on_debian.sh RELEASE FOLDER example        the README's first command
#   on_debian.sh RELEASE FOLDER test           its second one
#   on_debian.sh RELEASE FOLDER ctest ARGS...  builds all, and runs the tests that ARGS select
#   on_debian.sh RELEASE FOLDER vtk            ./build.sh vtk: beside VTK alone, without ParaView
#   on_debian.sh RELEASE FOLDER run COMMAND... any command, in the folder of the copied repository
# RELEASE is a name (bookworm, trixie, forky). FOLDER gets the root folder, RELEASE or, for VTK alone, RELEASE-vtk
# (4 GiB with all packages), which is kept, so that the next run is quick, and a report. Needs to be root,
# mmdebstrap and Debian's archive keys. The files that git knows are copied as they are now. Packages come
# from where this machine's apt has its own. If CCACHE_DIR is set, ccache works there and keeps its files in
# that folder.
set -eu
usage() {
  sed -n '3,13p' "$0" | sed 's/^# \{0,1\}//'
  exit 2
}
[ $# -ge 3 ] || usage
release=$1
folder=$2
what=$3
shift 3
repository=$(cd "$(dirname "$0")/../.." && pwd)
[ "$(id -u)" -eq 0 ] || {
  echo "on_debian.sh: only root can make a root folder" >&2
  exit 1
}
command -v mmdebstrap >/dev/null || {
  echo "on_debian.sh: there is no mmdebstrap; install the package of this name" >&2
  exit 1
}

mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
name=$release
[ "$what" != vtk ] || name=$release-vtk
root=$folder/$name
if [ ! -e "$root/etc/debian_version" ]; then
  mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | grep '/debian/*$' | head -n 1)
  # A mirror's copy of a release that still changes may be older than its signed lists are valid.
  mmdebstrap --variant=apt --aptopt='Acquire::Check-Valid-Until "false"' --include=ca-certificates,git,mount \
    "$release" "$root" "${mirror:-http://deb.debian.org/debian}"
fi

# The sources, beside the build folders of earlier runs. Files that did not change keep their times; others
# are newer than what was built of them.
mkdir -p "$root/project"
(cd "$repository" && git ls-files -co --exclude-standard -z |
  xargs -0 sh -c 'for file; do [ ! -e "$file" ] || printf "%s\0" "$file"; done' sh |
  tar --null -T - -cf -) >"$folder/sources-$name.tar"
mkdir -p "$root/new"
tar -xf "$folder/sources-$name.tar" -C "$root/new"
rm "$folder/sources-$name.tar"
(cd "$root/project" && find . -path ./build -prune -o -type f -print) | while read -r file; do
  [ -e "$root/new/$file" ] || rm "$root/project/$file"
done
(cd "$root/new" && find . -type f -print) | while read -r file; do
  cmp -s "$root/new/$file" "$root/project/$file" || {
    mkdir -p "$root/project/$(dirname "$file")"
    cp -p "$root/new/$file" "$root/project/$file"
    touch "$root/project/$file"
  }
done
(cd "$root/new" && find . -type l -exec cp -dp --parents {} "$root/project" \;)
rm -rf "$root/new"

case "$what" in
  example | test | vtk) set -- ./build.sh "$what" ;;
  ctest) set -- sh -c './build.sh packages && cmake --preset release && ninja -C build/release &&
    ctest --test-dir build/release --output-on-failure "$@"' sh "$@" ;;
  run) ;;
  *) usage ;;
esac

inside() {
  CCACHE_DIR=${CCACHE_DIR:-} unshare --mount --pid --fork sh -c 'root=$1
    shift
    mount --bind "$root" "$root" # a root that is no mount has no mount namespaces
    mount -t proc proc "$root/proc"
    mount --rbind /sys "$root/sys"
    mount --rbind /dev "$root/dev"
    cp /etc/resolv.conf "$root/etc/resolv.conf" 2>/dev/null || true
    if [ -n "$CCACHE_DIR" ]; then
      mkdir -p "$CCACHE_DIR" "$root/ccache"
      mount --bind "$CCACHE_DIR" "$root/ccache"
      set -- env CCACHE_DIR=/ccache CCACHE_SLOPPINESS=pch_defines,time_macros \
        CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache "$@"
    fi
    exec chroot "$root" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
      OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_btl=^tcp \
      CTEST_PARALLEL_LEVEL=2 \
      sh -c "cd /project && \"\$@\"; exit \$?" sh "$@"' sh "$root" "$@" # no exec: xvfb-run hangs as process 1
}

if [ -n "${CCACHE_DIR:-}" ] && [ ! -e "$root/usr/bin/ccache" ]; then
  (CCACHE_DIR='' && inside sh -c 'apt-get update -q && apt-get install -q -y --no-install-recommends ccache') \
    >"$folder/output-$name.txt" 2>&1
fi
begin=$(date +%s)
result=0
inside "$@" >"$folder/output-$name.txt" 2>&1 || result=$?
{
  echo "$(date -u +%F): $what $* on Debian $(cat "$root/etc/debian_version")"
  inside dpkg-query -W -f '${Package} ${Version}\n' paraview libvtk9-dev python3-pyvista g++ cmake python3 2>/dev/null || true
  echo "Exit status $result after $(($(date +%s) - begin)) s"
  grep -aE 'tests passed|tests failed|\(Failed\)|\(Timeout\)|warning:|error:' "$folder/output-$name.txt" | sort | uniq -c || true
} | tee "$folder/report-$name.txt"
exit $result
