// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoreVerification_h
#define isosurface_StoreVerification_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/ValueKey.h"
#include "Storage/Record/DecodedBlock.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/BlockStore.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/SourceSamples.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

/**
 * Checks one store of one time step, of the volume or an overview: call Open(), then CheckRun() for
 * every run of blocks, then Finish(), then TakeFaults(). Runs may be checked by several threads at
 * once.
 */
class StoreVerification
{
public:
  /// The references must outlive this object. `source`: the samples, if `place` is a source; if it is
  /// null, samples are not checked.
  StoreVerification(FileSystem& files, const ArrayVariables& variables, const BlockGrid& grid,
    const StoreDescription& description, std::string folder, SamplePlace place,
    std::shared_ptr<SourceSamples> source)
    : Files(files)
    , Variables(variables)
    , Grid(grid)
    , Description(description)
    , Folder(std::move(folder))
    , Place(place)
    , Source(std::move(source))
    , Segments(variables.GetNumberOfStored() * static_cast<std::size_t>(grid.GetNumberOfLevels()))
  {
  }

  /// Opens the files and checks the trees.
  void Open();
  bool IsOpen() const { return this->Directory != nullptr; }
  std::uint64_t GetNumberOfRuns() const;
  void CheckRun(std::uint64_t run);
  /// Checks the store's size and checksum. Counts each of its blocks in `seen`, up to 2; `seen` may
  /// be empty.
  void Finish(std::vector<std::uint8_t>& seen);

  /// In the order of the blocks.
  std::vector<Status> TakeFaults();
  std::uint64_t GetFiles() const { return 2 + this->Variables.GetCount(); }
  std::uint64_t GetBytes() const { return this->Blocks ? this->Blocks->GetSize() : 0; }

private:
  std::string GetTreePath(std::size_t variable) const
  {
    return BlockStore::GetTreePath(this->Folder, this->Variables, variable);
  }
  Status OpenFiles();
  void OpenTree(std::size_t variable);
  /// Reads a tree's intervals into `ranges`, by ordinal.
  Status ReadTree(std::size_t variable, std::vector<KeyRange>& ranges) const;
  Status CheckRecord(std::uint64_t ordinal, std::vector<Status>& faults);
  /// The same if the samples are in the source.
  Status CheckInPlace(
    const BlockDirectoryEntry& entry, std::uint64_t ordinal, std::vector<Status>& faults);
  Status CheckLengths(const BlockDirectoryEntry& entry) const;
  void CheckVariables(const BlockDirectoryEntry& entry, std::uint64_t ordinal,
    const std::uint8_t* record, std::vector<Status>& faults);
  /// The samples of a component; null, and a fault, if they are damaged.
  std::shared_ptr<const DecodedBlock> CheckComponent(const BlockDirectoryEntry& entry,
    std::uint64_t ordinal, std::size_t component, const std::uint8_t* record,
    std::vector<Status>& faults);
  /// Whether the trees have the ranges of the components and magnitudes that are there.
  void CheckRanges(
    const DecodedBlocks& components, std::uint64_t ordinal, std::vector<Status>& faults) const;
  /// The samples of a variable, those of a magnitude if all components are there; else null.
  std::shared_ptr<const DecodedBlock> Find(
    const DecodedBlocks& components, std::size_t variable) const;
  /// Whether the tree has the range of the block's samples.
  void CheckRange(const DecodedBlock& block, std::uint64_t ordinal, std::size_t variable,
    std::vector<Status>& faults) const;
  /// Whether bytes of the file of records, fewer than a page, are zero.
  bool IsZero(std::uint64_t begin, std::uint64_t end) const;
  Status MakeFault(const std::string& reason) const
  {
    return Status(StatusCode::Corrupt, StoreRecords::GetPath(this->Folder) + ": " + reason);
  }

  FileSystem& Files;
  const ArrayVariables& Variables;
  const BlockGrid& Grid;
  const StoreDescription& Description;
  std::string Folder;
  SamplePlace Place;
  std::shared_ptr<SourceSamples> Source;
  std::size_t Segments;

  std::unique_ptr<RandomAccessFile> Blocks;
  std::unique_ptr<BlockDirectory> Directory;
  std::vector<std::vector<KeyRange>> Ranges; ///< per variable and ordinal, from the tree
  std::vector<std::int64_t> Numbers;         ///< per ordinal: the block, or -1
  std::vector<std::uint64_t> Sizes;          ///< per ordinal: bytes of the record and its padding
  std::vector<std::uint64_t> Checksums;      ///< per ordinal and segment
  std::vector<Status> OpenFaults;
  std::vector<std::vector<Status>> RunFaults;
};

} // namespace isosurface

#endif
