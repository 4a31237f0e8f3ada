// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockModel_h
#define isosurface_BlockModel_h

#include "Coding/BlockCoding/CrossingCoder.h"
#include "Coding/BlockCoding/EdgeIndexProfile.h"
#include "Coding/BlockCoding/SignCoder.h"
#include "Coding/BlockCoding/ValueCoder.h"

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

} // namespace isosurface

#endif
