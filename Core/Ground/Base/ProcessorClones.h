// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ProcessorClones_h
#define isosurface_ProcessorClones_h

// Marks a function that is compiled for several processors; the loader chooses one. Not with
// sanitizers, which do not work before the loader has finished.
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && \
  !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
#  define ISOSURFACE_CLONES __attribute__((target_clones("arch=skylake-avx512", "avx2", "default")))
#else
#  define ISOSURFACE_CLONES
#endif

#endif
