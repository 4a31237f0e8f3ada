// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoreRecovery_h
#define isosurface_StoreRecovery_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Storage/Store/BlockedVolume.h"

#include <string>

namespace isosurface
{

/**
 * Runs a step of a query on all ranks, and once more as long as it fails on a rank and the ranks
 * learn of lost or damaged stores: their blocks are shared anew among the ranks that have replicas.
 * `step` returns this rank's status; it may be collective. `getVolume` is called after `step`; it
 * returns the volume that was read, or null, the same on all ranks. `warning`: names the stores
 * that were found to be lost or damaged, the same on all ranks; else unchanged. Collective, unless
 * the volume has no replicas.
 *
 * Returns this rank's status, which the ranks have agreed on if there are replicas.
 */
template <typename GetVolume, typename Step>
Status RunWithReplicas(
  Communicator& ranks, const GetVolume& getVolume, std::string& warning, const Step& step)
{
  while (true)
  {
    Status mine = step();
    BlockedVolume* volume = getVolume();
    if (!volume || volume->GetHeader().NumberOfReplicas == 1)
    {
      return mine;
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const auto news, volume->ShareStoreFaults(ranks));
    if (!news.Warning.empty())
    {
      warning += (warning.empty() ? "" : "; ") + news.Warning;
    }
    Status all = ranks.Agree(mine);
    if (all.IsOk() || all.GetCode() == StatusCode::Aborted || !news.IsNew)
    {
      return all;
    }
  }
}

} // namespace isosurface

#endif
