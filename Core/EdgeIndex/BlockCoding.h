// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockCoding_h
#define isosurface_BlockCoding_h

#include "EdgeIndex/AttributeCoder.h"
#include "EdgeIndex/BlockCoder.h"
#include "EdgeIndex/RangeCoder.h"
#include "EdgeIndex/ValueDomain.h"

#include <array>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// A point array that is coded with a block.
struct CodedAttribute
{
  EdgeIndexAttribute Attribute;
  AttributeEdges Edges;       ///< tuples that are given, or to be set
  bool HasExceptions = false; ///< when encoding; see AttributeDomain::HasCode
};

/// What of a block is coded.
struct BlockContent
{
  std::array<int, 3> Size{};           ///< vertices
  const ValueDomain* Domain = nullptr; ///< of the values; null to code crossings
  CrossingIntervals Intervals;         ///< of crossings,
  bool HasMissing = false;             ///< and whether some are not numbers
  std::vector<CodedAttribute> Attributes;
};

/// The two sets of instructions that the coders are compiled for.
enum class CoderInstructions
{
  Baseline, ///< of every processor of the platform
  Newest    ///< AVX2, BMI and POPCNT, where this processor has them
};

/**
 * Encodes a block, or decodes it, with a model that is fresh (BlockModel::Reset) and of the
 * scheme: BlockScheme::Fitted can be decoded only. The result is the same with either set of
 * instructions.
 */
void CodeBlock(RangeEncoder& coder, BlockModel& model, const BlockContent& content,
  BlockValues& values, CoderInstructions instructions = CoderInstructions::Newest);
void CodeBlock(RangeDecoder& coder, BlockModel& model, const BlockContent& content,
  BlockValues& values, CoderInstructions instructions = CoderInstructions::Newest);

} // namespace isosurface

#endif
