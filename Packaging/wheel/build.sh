#!/bin/sh
# Builds the Python wheel on Debian 11, for every Linux with its glibc or a newer one. ./build.sh wheel runs it in a root
# folder of that system. Usage:
#   build.sh
# build/wheel gets the wheel, and keeps what it is made of: sources, which are Debian's, as apt has checked them,
# libraries (those of formats, as archives for shared libraries), licences, and release, our own build. A library that is
# there is not built again. Needs to be root.
set -eu
cd "$(dirname "$0")/../.."
# shellcheck source=/dev/null
[ "$(. /etc/os-release && echo "$VERSION_ID")" = 11 ] || {
  echo "Packaging/wheel/build.sh: this is not Debian 11; use ./build.sh wheel" >&2
  exit 1
}
project=$PWD
folder=$project/build/wheel
tools="g++ cmake ninja-build pkg-config dpkg-dev nasm python3"
tests="python3-venv python3-numpy python3-h5py python3-netcdf4 python3-pydicom python3-tifffile python3-zarr"
linked="libstdc++-10-dev nlohmann-json3-dev libxxhash-dev liblz4-dev libzstd-dev zlib1g-dev liblzma-dev libdeflate-dev
  libaec-dev libsnappy-dev"

printf '\n== Installing packages\n'
# Libraries that read files are those of Debian 12: the versions that our tests run with, and still mended.
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | grep '/debian/*$' | head -n 1)
printf 'deb-src %s bookworm main\n' "$mirror" >/etc/apt/sources.list.d/bookworm-sources.list
apt-get update -q
# shellcheck disable=SC2086
DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $tools $linked $tests
mkdir -p "$folder/sources" "$folder/licences"
for package in $linked; do
  cp "/usr/share/doc/$package/copyright" "$folder/licences/$(dpkg-query -W -f '${source:Package}' "$package")"
done

# source package, options of CMake
build_library() {
  package=$1
  shift
  [ ! -e "$folder/licences/$package" ] || return 0
  printf '\n== %s\n' "$package"
  rm -rf "$folder/sources/$package"
  mkdir -p "$folder/sources/$package/build"
  cd "$folder/sources/$package"
  apt-get source -q "$package"
  mv "$(find . -mindepth 1 -maxdepth 1 -type d ! -name build)" source
  cd build
  cmake -G Ninja ../source \
    -DCMAKE_INSTALL_PREFIX="$folder/libraries" -DCMAKE_INSTALL_LIBDIR:STRING=lib -DCMAKE_PREFIX_PATH="$folder/libraries" \
    -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=OFF -DBUILD_TESTING=OFF -DCMAKE_POSITION_INDEPENDENT_CODE=ON \
    -DCMAKE_C_FLAGS="$flags" -DCMAKE_CXX_FLAGS="$flags" "$@"
  ninja install
  cp ../source/debian/copyright "$folder/licences/$package"
  cd "$project"
}
flags='-ffunction-sections -fdata-sections -fstack-protector-strong -D_FORTIFY_SOURCE=2'
build_library pugixml
build_library c-blosc -DBUILD_SHARED=OFF -DBUILD_TESTS=OFF -DBUILD_FUZZERS=OFF -DBUILD_BENCHMARKS=OFF \
  -DPREFER_EXTERNAL_LZ4=ON -DPREFER_EXTERNAL_ZSTD=ON -DPREFER_EXTERNAL_ZLIB=ON -DDEACTIVATE_SNAPPY=OFF
build_library libjpeg-turbo -DENABLE_SHARED=OFF -DWITH_TURBOJPEG=OFF
# JBIG is under the GPL, and what we read of TIFF has neither LERC nor WebP.
build_library tiff -Dtiff-tools=OFF -Dtiff-tests=OFF -Dtiff-contrib=OFF -Dtiff-docs=OFF -Dcxx=OFF \
  -Djbig=OFF -Dlerc=OFF -Dwebp=OFF
build_library hdf5 -DHDF5_BUILD_TOOLS=OFF -DHDF5_BUILD_UTILS=OFF -DHDF5_BUILD_EXAMPLES=OFF \
  -DHDF5_ENABLE_Z_LIB_SUPPORT=ON -DHDF5_ENABLE_SZIP_SUPPORT=ON -DHDF5_ENABLE_SZIP_ENCODING=ON \
  -DSZIP_LIBRARY=/usr/lib/x86_64-linux-gnu/libsz.a -DSZIP_INCLUDE_DIR=/usr/include
# Files of the web, of HDF4 and of Zarr are not read by it.
build_library netcdf -DENABLE_DAP=OFF -DENABLE_BYTERANGE=OFF -DENABLE_NCZARR=OFF -DENABLE_PLUGINS=OFF \
  -DENABLE_LIBXML2=OFF -DBUILD_UTILITIES=OFF -DENABLE_TESTS=OFF -DENABLE_EXAMPLES=OFF -DENABLE_FILTER_TESTING=OFF
build_library openjpeg2 -DBUILD_CODEC=OFF -DBUILD_STATIC_LIBS=ON
# It has CharLS in it.
build_library gdcm -DGDCM_BUILD_SHARED_LIBS=OFF -DGDCM_BUILD_APPLICATIONS=OFF -DGDCM_BUILD_TESTING=OFF \
  -DGDCM_BUILD_EXAMPLES=OFF -DGDCM_DOCUMENTATION=OFF -DGDCM_USE_SYSTEM_ZLIB=ON -DGDCM_USE_SYSTEM_OPENJPEG=ON

printf '\n== ScalableIsosurface\n'
# What the libraries of formats need; of an archive only what is called is linked.
archives=
for archive in gdcmDICT gdcmIOD gdcmDSED gdcmCommon gdcmjpeg8 gdcmjpeg12 gdcmjpeg16 gdcmcharls gdcmexpat gdcmuuid openjp2 \
  netcdf hdf5_hl hdf5 sz aec jpeg lzma deflate snappy lz4 zstd z; do
  archives="$archives -l:lib$archive.a"
done
PKG_CONFIG_PATH=$folder/libraries/lib/pkgconfig cmake -G Ninja -S . -B "$folder/release" \
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=12 \
  -DISOSURFACE_PARAVIEW=OFF -DISOSURFACE_VTK=OFF -DISOSURFACE_TESTING=OFF -DCMAKE_SKIP_RPATH=ON \
  -DISOSURFACE_HDF5_MODULES=hdf5 -DISOSURFACE_HDF5_IS_AN_ARCHIVE=ON \
  -DCMAKE_PREFIX_PATH="$folder/libraries" -DZLIB_LIBRARY=/usr/lib/x86_64-linux-gnu/libz.a \
  -DCMAKE_CXX_FLAGS='-ffunction-sections -fdata-sections' \
  -DCMAKE_SHARED_LINKER_FLAGS="-static-libstdc++ -static-libgcc -Wl,--as-needed,--gc-sections,-Bsymbolic" \
  -DCMAKE_CXX_STANDARD_LIBRARIES="-L$folder/libraries/lib -Wl,--start-group$archives -Wl,--end-group"
ninja -C "$folder/release" scalable_isosurface IsosurfaceFormatModules
strip "$folder"/release/lib/*.so # the linker's -s leaves out the relocations of functions with clones
rm -f "$folder"/*.whl "$folder"/*.zip
python3 -B Packaging/wheel/make_wheel.py "$folder/release" manylinux_2_31_x86_64 "$folder" "$folder/licences"
python3 -B Testing/Install/check_wheel.py "$folder"/*.whl
Testing/Install/use_wheel.sh "$folder"/*.whl
