// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Index/ExternalIntervalTreeBuilder.h"

#include "Storage/Index/IntervalSubtreeWriter.h"
#include "Storage/Index/IntervalTreeFormat.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace isosurface
{

ExternalIntervalTreeBuilder::ExternalIntervalTreeBuilder(
  FileSystem& fileSystem, std::string path, std::size_t memoryLimit, std::uint32_t pageSize)
  : Names{ fileSystem, path }
  , Path(std::move(path))
  , MemoryLimit(memoryLimit)
  , PageSize(pageSize)
  , Minimum(std::numeric_limits<ValueKey>::max())
  , Maximum(0)
{
  if (memoryLimit < MinimumMemoryLimit)
  {
    this->FirstError = Status(StatusCode::InvalidArgument,
      this->Path + ": an interval tree cannot be built in " + std::to_string(memoryLimit) +
        " bytes; it takes at least " + std::to_string(MinimumMemoryLimit));
    return;
  }
  this->Sorter = std::make_unique<IntervalSorter>(this->Names,
    IntervalSubtreeWriter::GetSourceBytes(memoryLimit), IntervalSorter::Order::AscendingMinimum);
}

ExternalIntervalTreeBuilder::~ExternalIntervalTreeBuilder() = default;

Status ExternalIntervalTreeBuilder::Add(const KeyInterval& interval)
{
  ISOSURFACE_RETURN_IF_ERROR(this->FirstError);
  Status status = this->Check(interval);
  if (status.IsOk())
  {
    status =
      this->Sorter->Add({ interval.Minimum, interval.Maximum, interval.Payload, /*Group=*/0 });
  }
  if (!status.IsOk())
  {
    this->FirstError = status;
    this->Sorter.reset();
    return status;
  }
  ++this->Count;
  this->Minimum = std::min(this->Minimum, interval.Minimum);
  this->Maximum = std::max(this->Maximum, interval.Maximum);
  return Status::Ok();
}

Status ExternalIntervalTreeBuilder::Finish()
{
  ISOSURFACE_RETURN_IF_ERROR(this->FirstError);
  const std::string temporary = this->Path + ".tmp";
  Status status = this->Write(temporary);
  this->Sorter.reset();
  if (status.IsOk())
  {
    status = this->Names.Files.Rename(temporary, this->Path);
  }
  if (!status.IsOk())
  {
    static_cast<void>(this->Names.Files.RemoveAll(temporary));
    this->FirstError = status;
    return status;
  }
  this->FirstError =
    Status(StatusCode::InvalidArgument, this->Path + ": the interval tree is written already");
  return Status::Ok();
}

Status ExternalIntervalTreeBuilder::Check(const KeyInterval& interval) const
{
  if (interval.Minimum > interval.Maximum)
  {
    return Status(StatusCode::InvalidArgument,
      this->Path + ": interval " + std::to_string(interval.Payload) +
        " has its minimum above its maximum");
  }
  if (this->Count == std::numeric_limits<std::uint32_t>::max())
  {
    return Status(StatusCode::Unsupported, this->Path + ": 2^32 or more intervals");
  }
  return Status::Ok();
}

Status ExternalIntervalTreeBuilder::Write(const std::string& path)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto file,
    PagedFileWriter::Create(this->Names.Files, path, this->PageSize, IntervalTreeFormat::Kind));
  IntervalSubtreeWriter writer(*file, this->Names, this->MemoryLimit);
  ISOSURFACE_ASSIGN_OR_RETURN(auto root, writer.WriteTree(std::move(this->Sorter)));
  IntervalTreeHeader header;
  header.Count = this->Count;
  header.Identity = this->Identity;
  header.Root = root;
  header.Minimum = this->Minimum;
  header.Maximum = this->Maximum;
  ISOSURFACE_RETURN_IF_ERROR(file->Finish(header.Encode()));
  this->Seal = file->GetSeal();
  return Status::Ok();
}

} // namespace isosurface
