// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/BlockCoding.h"

// The coders are templates that all go into one function; for newer processors into a second one.
// What the compiler leaves as a call is compiled for every processor, so it is right in both. With
// sanitizers, such functions would take minutes to compile.
#if defined(__OPTIMIZE__) && defined(__GNUC__) && !defined(__clang__) && \
  !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#  define ISOSURFACE_CODERS __attribute__((flatten))
#else
#  define ISOSURFACE_CODERS
#endif
#if defined(__GNUC__) && defined(__x86_64__)
#  define ISOSURFACE_NEWEST_CODERS ISOSURFACE_CODERS __attribute__((target("avx2,bmi,bmi2,popcnt")))
#endif

namespace isosurface
{
namespace
{

template <bool Mixed, bool Fitted, typename Coder>
inline void CodeContent(
  Coder& output, BlockModel& model, const BlockContent& content, BlockValues& values)
{
  BlockCoder<Coder, Mixed, Fitted> coder(output, model, content.Size.data());
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
    coder.CodeCrossings(content.Bins, content.HasMissing, values);
  }
}

template <bool Mixed, bool Fitted, typename Coder>
ISOSURFACE_CODERS void CodeWithBaseline(
  Coder& coder, BlockModel& model, const BlockContent& content, BlockValues& values)
{
  CodeContent<Mixed, Fitted>(coder, model, content, values);
}

#ifdef ISOSURFACE_NEWEST_CODERS
template <bool Mixed, bool Fitted, typename Coder>
ISOSURFACE_NEWEST_CODERS void CodeWithNewest(
  Coder& coder, BlockModel& model, const BlockContent& content, BlockValues& values)
{
  CodeContent<Mixed, Fitted>(coder, model, content, values);
}

bool HasNewest()
{
  static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
    __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
  return has;
}
#endif

template <bool Mixed, bool Fitted, typename Coder>
void Code(Coder& coder, BlockModel& model, const BlockContent& content, BlockValues& values,
  CoderInstructions instructions)
{
#ifdef ISOSURFACE_NEWEST_CODERS
  if (instructions == CoderInstructions::Newest && HasNewest())
  {
    CodeWithNewest<Mixed, Fitted>(coder, model, content, values);
    return;
  }
#else
  static_cast<void>(instructions);
#endif
  CodeWithBaseline<Mixed, Fitted>(coder, model, content, values);
}

template <typename Coder>
void CodeByProfile(Coder& coder, BlockModel& model, const BlockContent& content,
  BlockValues& values, CoderInstructions instructions)
{
  if (!model.IsMixed)
  {
    Code<false, false>(coder, model, content, values, instructions);
  }
  else if (content.IsFitted && content.Domain)
  {
    Code<true, true>(coder, model, content, values, instructions);
  }
  else
  {
    Code<true, false>(coder, model, content, values, instructions);
  }
}

} // namespace

void CodeBlock(RangeEncoder& coder, BlockModel& model, const BlockContent& content,
  BlockValues& values, CoderInstructions instructions)
{
  CodeByProfile(coder, model, content, values, instructions);
}

void CodeBlock(RangeDecoder& coder, BlockModel& model, const BlockContent& content,
  BlockValues& values, CoderInstructions instructions)
{
  CodeByProfile(coder, model, content, values, instructions);
}

} // namespace isosurface
