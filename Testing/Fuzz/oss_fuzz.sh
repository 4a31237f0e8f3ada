#!/bin/sh
# Builds the fuzz targets in the way of OSS-Fuzz (google.github.io/oss-fuzz/getting-started/new-project-guide):
# compilers, their flags and the engine are what the environment names, and $OUT gets, for each target, the
# program, its corpus, its dictionary and its options; $OUT/lib the libraries that the machine which fuzzes
# may not have. $WORK, if there is one, is where it is built. Without OSS-Fuzz:
#   CC=clang CXX=clang++ \
#     CFLAGS='-O1 -g -fsanitize=address,undefined,fuzzer-no-link -fno-sanitize-recover=undefined' \
#     CXXFLAGS="$CFLAGS" \
#     LIB_FUZZING_ENGINE=-fsanitize=fuzzer OUT=/tmp/fuzzers Testing/Fuzz/oss_fuzz.sh
set -eu
: "${CC:?}" "${CXX:?}" "${CFLAGS:?}" "${CXXFLAGS:?}" "${LIB_FUZZING_ENGINE:?}" "${OUT:?}"
sources=$(cd "$(dirname "$0")/../.." && pwd)
build=${WORK:-$sources/build}/oss-fuzz

# The old kind of run path holds for the libraries of libraries, too.
# shellcheck disable=SC2016
cmake -G Ninja -S "$sources" -B "$build" -DISOSURFACE_PARAVIEW=OFF -DISOSURFACE_VTK=OFF -DISOSURFACE_FUZZING=ON \
  -DISOSURFACE_FUZZING_ENGINE="$LIB_FUZZING_ENGINE" -DCMAKE_BUILD_RPATH='$ORIGIN/lib' \
  -DCMAKE_EXE_LINKER_FLAGS=-Wl,--disable-new-dtags -DCMAKE_SHARED_LINKER_FLAGS=-Wl,--disable-new-dtags \
  -DCMAKE_BUILD_TYPE=None
# Formats whose libraries are missing have no target.
targets=
for corpus in "$sources"/Testing/Fuzz/corpus/*/; do
  target=Fuzz$(basename "$corpus")
  if ninja -C "$build" -t query "$target" >/dev/null 2>&1; then
    targets="$targets $target"
  fi
done
# shellcheck disable=SC2086
ninja -C "$build" $targets

mkdir -p "$OUT/lib"
for target in $targets; do
  cp "$build/bin/$target" "$OUT/"
  rm -f "$OUT/${target}_seed_corpus.zip"
  zip -q -j "$OUT/${target}_seed_corpus.zip" "$sources/Testing/Fuzz/corpus/${target#Fuzz}"/*
  # Headers name sizes, and samples are read if they are few: no input has to be long.
  printf '[libfuzzer]\nmax_len = 65536\ntimeout = 20\nrss_limit_mb = 2560\n' >"$OUT/$target.options"
  if [ -e "$sources/Testing/Fuzz/$target.dict" ]; then
    cp "$sources/Testing/Fuzz/$target.dict" "$OUT/"
  fi
  # Those of the C library are everywhere.
  ldd "$build/bin/$target" | awk '$3 ~ /^\// { print $3 }' | grep -v -E '/(libc|libm|libdl|libpthread|librt)\.so' |
    while read -r library; do
      cp -u -L "$library" "$OUT/lib/"
    done
done
echo "In $OUT:$targets"
