#!/bin/sh
# Packs the build tree as debian/ says, and installs, uses and removes the packages on a copy of this machine: a
# mount namespace of its own, in which what is written to / goes to memory. Usage:
#   debian_packages.sh BUILD SOURCE FOLDER
# BUILD is the build tree, SOURCE this repository, FOLDER for scratch files. Needs to be root; exits with 77
# where the copy cannot be made.
set -eu
build=$1
source=$2
folder=$3
here=$source/Testing/Install

skip() { # reason
  echo "Skipped: $1"
  exit 77
}

if [ "${4:-}" != inside ]; then
  [ "$(id -u)" -eq 0 ] || skip "only root may install packages, even on a copy of the machine"
  { command -v dh && command -v dh_python3; } >/dev/null || skip "there is no debhelper (packages debhelper, dh-python)"
  unshare --mount --pid --fork true 2>/dev/null || skip "this machine does not allow a mount namespace"
  rm -rf "$folder"
  mkdir -p "$folder"
  exec unshare --mount --pid --fork "$0" "$1" "$2" "$3" inside
fi

mount -t tmpfs -o size=1g tmpfs "$folder"
mkdir "$folder/upper" "$folder/work" "$folder/root"
mount -t overlay -o "lowerdir=/,upperdir=$folder/upper,workdir=$folder/work" overlay "$folder/root" ||
  skip "this machine does not allow a file system over another one"
root=$folder/root
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
mount -t tmpfs tmpfs "$root/dev/shm" # jobs of MPI name memory there by numbers of processes, which are this namespace's
mount --rbind /sys "$root/sys"
for path in "$build" "$source"; do # elsewhere than on the disk of /
  mkdir -p "$root$path"
  mount --bind "$path" "$root$path"
done

mkdir "$folder/source" "$root/packages"
cp -r "$source/debian" "$source"/*.md "$source/CITATION.cff" "$source/Documentation" "$source/Examples" "$folder/source"
(cd "$folder/source" && PATH=/usr/sbin:/usr/bin:/sbin:/bin ISOSURFACE_BUILD=$build ISOSURFACE_PACKAGES=$root/packages \
  ISOSURFACE_DEB_OPTIONS=-Znone DEB_RULES_REQUIRES_ROOT=no debian/rules binary >"$folder/log" 2>&1) || {
  cat "$folder/log"
  exit 1
}
exec chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
  OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 sh "$here/use_packages.sh" "$build" "$here"
