#!/bin/sh
# Builds the source package of Debian from a clean tarball in a clean root folder, runs lintian, and runs the
# tests of the packages (autopkgtest) in a second root folder. Usage:
#   source_package.sh RELEASE FOLDER
# RELEASE is a name (bookworm, trixie, forky). FOLDER gets the root folders RELEASE-build and RELEASE-test (6 GiB
# together), which are kept, the packages in RELEASE-packages, and logs. The tarball is what `git archive` makes
# of HEAD. DEB_BUILD_OPTIONS is handed on. Needs to be root, mmdebstrap and Debian's archive keys. Packages come
# from where this machine's apt has its own.
set -eu
[ $# -eq 2 ] || {
  sed -n '2,9p' "$0" | sed 's/^# \{0,1\}//'
  exit 2
}
release=$1
mkdir -p "$2"
folder=$(cd "$2" && pwd)
repository=$(cd "$(dirname "$0")/../.." && pwd)
version=$(sed -n '1s/.*(\(.*\)-.*/\1/p' "$repository/debian/changelog")

make_root() { # name
  [ -e "$folder/$1/etc/debian_version" ] && return 0
  mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | grep '/debian/*$' | head -n 1)
  # Nothing of it must survive a power failure. A mirror's copy of a release that still changes may be older
  # than its signed lists are valid.
  mmdebstrap --variant=buildd --dpkgopt=force-unsafe-io --aptopt='Acquire::Check-Valid-Until "false"' \
    --include=ca-certificates "$release" "$folder/$1" "${mirror:-http://deb.debian.org/debian}"
}

inside() { # root, command
  unshare --mount --pid --fork sh -c 'root=$1
    mount --bind "$root" "$root"
    mount -t proc proc "$root/proc"
    mount --rbind /sys "$root/sys"
    mount --rbind /dev "$root/dev"
    cp /etc/resolv.conf "$root/etc/resolv.conf" 2>/dev/null || true
    exec chroot "$root" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
      DEBIAN_FRONTEND=noninteractive DEB_BUILD_OPTIONS="$3" sh -c "$2; exit \$?"' \
    sh "$folder/$1" "$2" "${DEB_BUILD_OPTIONS:-parallel=2 nocheck}"
}

make_root "$release-build"
source=$folder/$release-build/source
rm -rf "$source"
mkdir "$source"
git -C "$repository" archive --prefix="scalable-isosurface-$version/" HEAD |
  gzip >"$source/scalable-isosurface_$version.orig.tar.gz"
tar -C "$source" -xf "$source/scalable-isosurface_$version.orig.tar.gz"
inside "$release-build" "set -e
  cd /source/scalable-isosurface-$version
  apt-get update -q
  apt-get build-dep -q -y --no-install-recommends ./
  dpkg-buildpackage -us -uc
  apt-get install -q -y --no-install-recommends lintian" >"$folder/$release-build.log" 2>&1 || {
  tail -n 20 "$folder/$release-build.log"
  exit 1
}
failed=0
inside "$release-build" "cd /source && lintian --allow-root --fail-on error,warning *.changes" \
  >"$folder/$release-lintian.log" 2>&1 || failed=1
cat "$folder/$release-lintian.log"

mkdir -p "$folder/$release-packages"
cp "$source"/*.deb "$source"/*.changes "$source"/*.buildinfo "$source"/*.dsc "$folder/$release-packages"
make_root "$release-test"
rm -rf "$folder/$release-test/source"
mkdir "$folder/$release-test/source"
cp "$source"/*.deb "$source"/*.tar.* "$source"/*.dsc "$folder/$release-test/source"
inside "$release-test" "apt-get update -q && apt-get install -q -y --no-install-recommends autopkgtest dpkg-dev &&
  cd /source && rm -f *-dbgsym_*.deb && autopkgtest *.deb *.dsc -- null" >"$folder/$release-test.log" 2>&1 ||
  failed=1
sed -n '/^autopkgtest .*: @@@@* summary/,$p' "$folder/$release-test.log"
exit $failed
