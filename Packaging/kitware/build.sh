#!/bin/sh
# Not run by us: where this project is made, there is no registry of containers. Facts are those of Kitware/paraview-ci-example.
# Builds the plugin in C++ for a ParaView from paraview.org, in Kitware's image with all that it was built with. Usage, in a
# clone of this repository:
#   docker run --rm -v "$PWD:/project" -w /project kitware/paraview_org-plugin-devel:6.0.1 Packaging/kitware/build.sh
#   docker run --rm -v "$PWD:/project" -w /project kitware/paraview_org-plugin-devel:5.13.3 Packaging/kitware/build.sh
# and, as a smoke test, where ParaView was unpacked from its archive of the same version:
#   ParaView-VERSION/bin/pvbatch Examples/main_job.py --plugin build/kitware/install/.../ScalableIsosurface.so
set -eu
# ParaView's CMake package has this path in it.
[ -e /builds/gitlab-kitware-sciviz-ci ] || ln -s /paraview/gitlab-kitware-sciviz-ci/ /builds/gitlab-kitware-sciviz-ci
yum install -y epel-release
yum install -y ninja-build lz4-devel libzstd-devel xxhash-devel zlib-devel json-devel cli11-devel
# C++17 with <filesystem>: 6.0 and newer have gcc-toolset-10; for 5.13, which is built by devtoolset-7, a newer one
# of the same kind uses the system's libstdc++, too.
for toolset in gcc-toolset-10 devtoolset-11 devtoolset-9; do
  [ ! -d "/opt/rh/$toolset" ] || break
done
scl enable "$toolset" -- cmake -S . -B build/kitware -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_PREFIX_PATH=/builds/gitlab-kitware-sciviz-ci/build/install/ -DISOSURFACE_TESTING=OFF \
  -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=12
scl enable "$toolset" -- cmake --build build/kitware
cmake --install build/kitware --prefix "$PWD/build/kitware/install"
find "$PWD/build/kitware/install" -name ScalableIsosurface.so
