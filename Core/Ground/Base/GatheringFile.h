// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_GatheringFile_h
#define isosurface_GatheringFile_h

#include "Ground/Base/FileSystem.h"

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

/// A file whose small appends are written together, since each write costs a call of the system.
/// An error of one is returned by a later call, SyncAndClose() at the latest.
class GatheringFile : public WritableFile
{
public:
  /// The maximum number of bytes that wait.
  static constexpr std::size_t Capacity = std::size_t{ 1 } << 18;

  explicit GatheringFile(std::unique_ptr<WritableFile> file)
    : File(std::move(file))
  {
  }

  Status Append(const void* bytes, std::size_t size) override
  {
    if (this->Waiting.size() + size > Capacity)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Flush());
    }
    if (size > Capacity)
    {
      return this->File->Append(bytes, size);
    }
    const auto* begin = static_cast<const std::uint8_t*>(bytes);
    this->Waiting.insert(this->Waiting.end(), begin, begin + size);
    return Status::Ok();
  }
  Status WriteAt(std::uint64_t offset, const void* bytes, std::size_t size) override
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Flush());
    return this->File->WriteAt(offset, bytes, size);
  }
  std::uint64_t GetSize() const override { return this->File->GetSize() + this->Waiting.size(); }
  Status SyncAndClose() override
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Flush());
    return this->File->SyncAndClose();
  }
  const std::string& GetPath() const override { return this->File->GetPath(); }

private:
  Status Flush()
  {
    const Status status = this->File->Append(this->Waiting.data(), this->Waiting.size());
    this->Waiting.clear();
    return status;
  }

  std::unique_ptr<WritableFile> File;
  std::vector<std::uint8_t> Waiting;
};

} // namespace isosurface

#endif
