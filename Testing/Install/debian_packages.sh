#!/bin/sh
# Makes the Debian packages and installs, uses and removes them on a copy of this machine: a mount namespace
# of its own, in which what is written to / goes to memory. Usage:
#   debian_packages.sh BUILD SOURCE FOLDER CPACK
# BUILD is the build tree, SOURCE this repository, FOLDER for scratch files. Needs to be root; exits with 77
# where the copy cannot be made.
set -eu
build=$1
source=$2
folder=$3
cpack=$4
here=$source/Testing/Install

skip() { # reason
  echo "Skipped: $1"
  exit 77
}

if [ "${5:-}" != inside ]; then
  [ "$(id -u)" -eq 0 ] || skip "only root may install packages, even on a copy of the machine"
  command -v dpkg-shlibdeps >/dev/null || skip "there is no dpkg-shlibdeps (package dpkg-dev)"
  unshare --mount --pid --fork true 2>/dev/null || skip "this machine does not allow a mount namespace"
  rm -rf "$folder"
  mkdir -p "$folder"
  exec unshare --mount --pid --fork "$0" "$1" "$2" "$3" "$4" inside
fi

mount -t tmpfs -o size=1g tmpfs "$folder"
mkdir "$folder/packages" "$folder/upper" "$folder/work" "$folder/root"
mount -t overlay -o "lowerdir=/,upperdir=$folder/upper,workdir=$folder/work" overlay "$folder/root" ||
  skip "this machine does not allow a file system over another one"
root=$folder/root
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
mount --rbind /sys "$root/sys"
for path in "$build" "$source"; do # elsewhere than on the disk of /
  mkdir -p "$root$path"
  mount --bind "$path" "$root$path"
done

(cd "$build" && "$cpack" -G DEB -B "$folder/packages" >"$folder/cpack.log" 2>&1) || {
  cat "$folder/cpack.log"
  exit 1
}
mkdir -p "$root/packages"
mv "$folder"/packages/*.deb "$root/packages"
exec chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
  OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 sh "$here/use_packages.sh" "$build" "$here"
