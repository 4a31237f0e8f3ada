// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockLayers_h
#define isosurface_BlockLayers_h

#include "Coding/BlockCoding/BlockCoding.h"

#include <memory>

// What is coded of a block, one layer for each kind of number. Layers are compiled one by one, since
// each consists of large templates for both directions, all profiles and both instruction sets.
namespace isosurface
{

/// Codes the signs of a block, slice after slice.
class SignLayer
{
public:
  virtual ~SignLayer() = default;

  /// See SignCoder::CodeSlice.
  virtual void CodeSlice(SignSlice& slice, const SignSlice* below, const SignSlice* below2) = 0;
};

/// Codes the numbers of a slice, whose signs are known. below, above: the slices beside it, null at
/// the ends of the block.
class SliceLayer
{
public:
  virtual ~SliceLayer() = default;
  virtual void CodeSlice(
    int z, const SignSlice& slice, const SignSlice* below, const SignSlice* above) = 0;
};

// All references but `content` and `attribute` must outlive the layer, and so must the domain and
// the tuples that these point to. Coder is RangeEncoder or RangeDecoder.

template <typename Coder>
std::unique_ptr<SignLayer> MakeSignLayer(
  Coder& coder, BlockModel& model, const BlockContent& content, CoderInstructions instructions);

template <typename Coder>
std::unique_ptr<SliceLayer> MakeValueLayer(Coder& coder, BlockModel& model,
  const BlockContent& content, BlockValues& values, CoderInstructions instructions);

template <typename Coder>
std::unique_ptr<SliceLayer> MakeCrossingLayer(Coder& coder, BlockModel& model,
  const BlockContent& content, BlockValues& values, CoderInstructions instructions);

/// Also codes whether the attribute has exceptions, which comes before all slices.
template <typename Coder>
std::unique_ptr<SliceLayer> MakeAttributeLayer(Coder& coder, const BlockContent& content,
  const CodedAttribute& attribute, CoderInstructions instructions);

/// The layers of the profile working, whose signs and numbers are in content.Planes.
template <bool Encodes>
std::unique_ptr<SignLayer> MakePlaneSigns(
  const BlockContent& content, CoderInstructions instructions);
template <bool Encodes>
std::unique_ptr<SliceLayer> MakePlaneNumbers(
  const BlockContent& content, BlockValues& values, CoderInstructions instructions);

} // namespace isosurface

#endif
