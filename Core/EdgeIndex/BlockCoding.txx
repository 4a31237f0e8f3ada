// SPDX-License-Identifier: BSD-3-Clause
// CodeBlock for encoding and for decoding, each compiled by itself, since either takes the compiler
// half a minute.
#ifndef isosurface_BlockCoding_txx
#define isosurface_BlockCoding_txx

#include "EdgeIndex/BlockCoding.h"

// For newer processors, the coders, which are templates, all go into one function. What the
// compiler leaves as a call is compiled for every processor, so it is right in it. With sanitizers,
// such functions would take minutes to compile.
#if defined(__GNUC__) && defined(__x86_64__)
#  if defined(__OPTIMIZE__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#    define ISOSURFACE_NEWEST_CODERS __attribute__((flatten, target("avx2,bmi,bmi2,popcnt")))
#  else
#    define ISOSURFACE_NEWEST_CODERS __attribute__((target("avx2,bmi,bmi2,popcnt")))
#  endif
#endif

namespace isosurface
{
namespace
{

template <BlockScheme Scheme, typename Coder>
inline void CodeContent(
  Coder& output, BlockModel& model, const BlockContent& content, BlockValues& values)
{
  BlockCoder<Coder, Scheme> coder(output, model, content.Size.data());
  for (const CodedAttribute& coded : content.Attributes)
  {
    coder.AddAttribute(coded.Attribute, coded.Edges, coded.HasExceptions);
  }
  if (content.Domain)
  {
    coder.CodeValues(*content.Domain, values);
  }
  else
  {
    coder.CodeCrossings(content.Intervals, content.HasMissing, values);
  }
}

#ifdef ISOSURFACE_NEWEST_CODERS
template <BlockScheme Scheme, typename Coder>
ISOSURFACE_NEWEST_CODERS void CodeWithNewest(
  Coder& coder, BlockModel& model, const BlockContent& content, BlockValues& values)
{
  CodeContent<Scheme>(coder, model, content, values);
}

bool HasNewest()
{
  static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
    __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
  return has;
}
#endif

template <BlockScheme Scheme, typename Coder>
void Code(Coder& coder, BlockModel& model, const BlockContent& content, BlockValues& values,
  CoderInstructions instructions)
{
#ifdef ISOSURFACE_NEWEST_CODERS
  if (instructions == CoderInstructions::Newest && HasNewest())
  {
    CodeWithNewest<Scheme>(coder, model, content, values);
    return;
  }
#else
  static_cast<void>(instructions);
#endif
  CodeContent<Scheme>(coder, model, content, values);
}

template <typename Coder>
void CodeByScheme(Coder& coder, BlockModel& model, const BlockContent& content, BlockValues& values,
  CoderInstructions instructions)
{
  switch (model.Scheme)
  {
    case BlockScheme::Fast:
      Code<BlockScheme::Fast>(coder, model, content, values, instructions);
      break;
    case BlockScheme::Mixed:
      Code<BlockScheme::Mixed>(coder, model, content, values, instructions);
      break;
    case BlockScheme::Fitted:
      if constexpr (!Coder::Encodes)
      {
        Code<BlockScheme::Fitted>(coder, model, content, values, instructions);
      }
      break;
    case BlockScheme::Compact:
      Code<BlockScheme::Compact>(coder, model, content, values, instructions);
      break;
  }
}

} // namespace

} // namespace isosurface

#endif
