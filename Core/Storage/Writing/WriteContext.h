// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_WriteContext_h
#define isosurface_WriteContext_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

namespace isosurface
{

/// What all steps of one write share. Each step does what this rank can do alone, and is followed
/// by AgreeOn(), so that no rank enters a collective operation that another one has given up.
class WriteContext
{
public:
  /// The references must outlive this object.
  WriteContext(
    Communicator& ranks, FileSystem& files, std::string path, const BlockedVolumeSettings& settings)
    : Ranks(ranks)
    , Files(files)
    , Path(std::move(path))
    , Settings(settings)
    , Rank(static_cast<std::size_t>(ranks.GetRank()))
    , Size(static_cast<std::size_t>(ranks.GetSize()))
  {
  }

  /// Collective. Returns the same error on all ranks if any rank has one.
  Status AgreeOn(const Status& mine) const
  {
    const Status all = this->Ranks.Agree(mine);
    return all.GetCode() == StatusCode::Aborted ? this->MakeAborted() : all;
  }

  /// Runs a step of this rank alone. A shortage of memory or threads is an error like others.
  template <typename Step>
  Status Attempt(Step&& step) const
  {
    return isosurface::Attempt(this->Path + ": cannot be written here", step);
  }

  /// An InvalidArgument that says why the path cannot be written.
  Status MakeRefusal(const std::string& reason) const
  {
    return Status(StatusCode::InvalidArgument, this->Path + ": cannot be written: " + reason);
  }
  Status MakeAborted() const
  {
    return Status(StatusCode::Aborted, this->Path + ": writing was aborted");
  }
  /// Whether this rank writes a store.
  bool IsMine(std::uint32_t store) const { return store % this->Size == this->Rank; }

  Communicator& Ranks;
  FileSystem& Files;
  std::string Path;
  BlockedVolumeSettings Settings;
  std::size_t Rank;
  std::size_t Size;
};

} // namespace isosurface

#endif
