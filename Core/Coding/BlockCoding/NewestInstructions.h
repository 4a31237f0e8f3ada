// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_NewestInstructions_h
#define isosurface_NewestInstructions_h

#include "Coding/BlockCoding/BlockCoding.h"

// In a flattened function the coders, which are templates, are compiled for its instructions. Calls
// that the compiler keeps go to functions for every processor, which are right as well. With
// sanitizers, flattened functions would take minutes to compile.
#if defined(__GNUC__) && defined(__x86_64__)
#  if defined(__OPTIMIZE__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#    define ISOSURFACE_NEWEST_CODERS __attribute__((flatten, target("avx2,bmi,bmi2,lzcnt,popcnt")))
#  else
#    define ISOSURFACE_NEWEST_CODERS __attribute__((target("avx2,bmi,bmi2,lzcnt,popcnt")))
#  endif
#endif

namespace isosurface
{

#ifdef ISOSURFACE_NEWEST_CODERS
inline bool HasNewestInstructions()
{
  // Not all compilers can ask for LZCNT, which every processor with AVX2 has.
  static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
    __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
  return has;
}

template <typename Functor>
ISOSURFACE_NEWEST_CODERS void CallWithNewest(const Functor& functor)
{
  functor();
}
#endif

/// Calls a functor, compiled for the instructions if this processor has them.
template <typename Functor>
inline void CallWith(CoderInstructions instructions, const Functor& functor)
{
#ifdef ISOSURFACE_NEWEST_CODERS
  if (instructions == CoderInstructions::Newest && HasNewestInstructions())
  {
    CallWithNewest(functor);
    return;
  }
#else
  static_cast<void>(instructions);
#endif
  functor();
}

} // namespace isosurface

#endif
