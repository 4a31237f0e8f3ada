// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockCoding_h
#define isosurface_BlockCoding_h

#include "Coding/BlockCoding/AttributeCoder.h"
#include "Coding/BlockCoding/CrossingCoder.h"
#include "Coding/BlockCoding/CrossingIntervals.h"
#include "Coding/BlockCoding/EdgeIndexProfile.h"
#include "Coding/BlockCoding/SignCoder.h"
#include "Coding/BlockCoding/ValueCoder.h"
#include "Coding/BlockCoding/ValueDomain.h"
#include "Coding/EntropyCoding/RangeCoder.h"
#include "Coding/Prediction/SignRows.h"

#include <array>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// All probabilities and weights of a block; they learn while it is coded.
struct BlockModel
{
  explicit BlockModel(EdgeIndexProfile profile)
    : Profile(profile)
    , Signs(profile == EdgeIndexProfile::Small)
    , Values(profile == EdgeIndexProfile::Small)
    , Crossings(profile == EdgeIndexProfile::Small)
  {
  }

  /// Makes the model ready for another block: forgets what was learnt about signs, and about values
  /// if `forValues`, else about crossings.
  void Reset(bool forValues);

  EdgeIndexProfile Profile;
  SignModel Signs;
  ValueModel Values; ///< of the profile small only
  CrossingModel Crossings;
};

/// A model as at the start of each block; made once.
const BlockModel& GetFreshModel(EdgeIndexProfile profile);

/// Gives a block's signs and numbers to an encoder, or takes them from a decoder.
class BlockValues
{
public:
  virtual ~BlockValues() = default;

  /// The signs of slice z, given or to be set. Called once for each slice, in order; the reference
  /// is used until the slice after the next.
  virtual SignSlice& GetSigns(int z) = 0;

  /// Called when the signs of slice z are known.
  virtual void FinishSigns(int z) = 0;

  /// The codes (ValueDomain) of the values at `vertices` of a row: codes[x]. Called before they are
  /// encoded, to set them, or after they were decoded, to take them.
  virtual void ExchangeCodes(int y, int z, const SignRow& vertices, std::int64_t* codes) = 0;

  /// The numbers of the intervals (CrossingIntervals) of the crossed edges along an axis that begin
  /// in a row: bins[x], set or taken likewise.
  virtual void ExchangeBins(int axis, int y, int z, const SignRow& edges, std::uint32_t* bins) = 0;

  /// Called after each slice. Returns whether to continue; if not, CodeBlock returns at once.
  virtual bool FinishSlice(int z) = 0;
};

class BytePlanes;

/// What is coded of a block besides its signs: either values or crossings, and attributes.
struct BlockContent
{
  std::array<int, 3> Size{};           ///< vertices, at most MaximumCodedVertices on each axis
  const ValueDomain* Domain = nullptr; ///< of the values, not owned; null to code crossings
  CrossingIntervals Intervals;         ///< of crossings; not used with values
  bool HasMissing = false;             ///< some crossings are NaN
  /// Not owned; in the profile working signs and numbers go there, and only attributes to the coder.
  BytePlanes* Planes = nullptr;
  std::vector<CodedAttribute> Attributes;
};

/// The two instruction sets that the coders are compiled for.
enum class CoderInstructions
{
  Baseline, ///< of every processor of the platform
  Newest    ///< AVX2, BMI and POPCNT, where this processor has them
};

/**
 * Encodes or decodes a block with a model after BlockModel::Reset. For each slice the signs of the
 * next one come first, since they tell which vertices are relevant and which edges are crossed;
 * then the values or crossings of the slice; then its attributes. Both instruction sets give the
 * same result. Decoding ends whatever the bytes; whether they were whole, RangeDecoder tells.
 */
void CodeBlock(RangeEncoder& coder, BlockModel& model, const BlockContent& content,
  BlockValues& values, CoderInstructions instructions = CoderInstructions::Newest);
void CodeBlock(RangeDecoder& coder, BlockModel& model, const BlockContent& content,
  BlockValues& values, CoderInstructions instructions = CoderInstructions::Newest);

} // namespace isosurface

#endif
