// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoreRecords_h
#define isosurface_StoreRecords_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Storage/Record/DecodedBlock.h"
#include "Storage/Store/BlockDirectory.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/QueryStatistics.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

class SourceSamples;

/// The file `blocks` of a store: its records (BlockRecord.h), by the entries of its directory. The store
/// need not be finished. Safe for any number of threads.
class StoreRecords
{
public:
  static std::string GetPath(const std::string& folder) { return folder + "/blocks"; }

  /// `header`: of the volume. `source`: the samples of a volume in place, else null.
  static Result<std::unique_ptr<StoreRecords>> Open(FileSystem& files, const std::string& folder,
    const BlockedVolumeHeader& header, std::shared_ptr<SourceSamples> source = nullptr);

  /// The bytes of the file, when it was opened or later.
  std::uint64_t GetSize() const { return this->File->GetSize(); }
  const std::string& GetPath() const { return this->File->GetPath(); }
  /// Whether samples are in the volume's source.
  bool AreInSource() const { return this->Source != nullptr; }

  /// Reads the components [first, first + count) of a block up to a level, by one contiguous read,
  /// which at a level above 0 includes the finer levels of all components but the last one; and
  /// decodes them. Corrupt if the record does not fit the entry, or is damaged.
  Result<DecodedBlocks> Read(const BlockDirectoryEntry& entry, std::size_t first, std::size_t count,
    int level, QueryStatistics& statistics) const;

  /// A part of the file.
  struct ByteRange
  {
    std::uint64_t Begin;
    std::uint64_t End;
  };

  /// The bytes of components in a record, up to a level of the last one.
  ByteRange FindRange(
    const BlockDirectoryEntry& entry, std::size_t first, std::size_t count, int level) const;

  /// Starts reading ranges, in ascending order, without waiting. Ranges with nothing but padding
  /// between them are one read.
  void Prefetch(const std::vector<ByteRange>& ranges) const;

private:
  StoreRecords(std::unique_ptr<RandomAccessFile> file, const BlockedVolumeHeader& header,
    std::shared_ptr<SourceSamples> source);
  Status MakeError(StatusCode code, const std::string& reason) const;
  Status CheckLengths(const BlockDirectoryEntry& entry, std::size_t variable, int level) const;
  /// The components [first, first + count), which are in the source.
  Result<DecodedBlocks> Gather(const BlockDirectoryEntry& entry, std::size_t first,
    std::size_t count, QueryStatistics& statistics) const;
  /// `segment`: the stored segments of the levels from the coarsest to `level`.
  Result<std::shared_ptr<const DecodedBlock>> Decode(const BlockDirectoryEntry& entry,
    std::size_t variable, int level, const std::uint8_t* segment) const;

  const std::unique_ptr<RandomAccessFile> File;
  const ArrayVariables Variables;
  const BlockGrid Grid;
  const std::shared_ptr<SourceSamples> Source;
};

} // namespace isosurface

#endif
