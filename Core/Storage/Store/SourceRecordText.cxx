// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/SourceRecordText.h"

#include <nlohmann/json.hpp>

#include <limits>

namespace isosurface
{
namespace
{

constexpr std::int64_t MaximumNumber = std::numeric_limits<std::int64_t>::max();

} // namespace

Json FormatSource(const SourceRecord& record)
{
  return { { "path", record.Path }, { "absolutePath", record.AbsolutePath },
    { "within", record.Within }, { "axes", record.Axes }, { "step", record.Step },
    { "arrays", record.Arrays }, { "chunk", record.Chunk }, { "files", record.State.Files },
    { "bytes", record.State.Bytes }, { "modified", record.State.Modified },
    { "metadata", FormatChecksum(record.Metadata) } };
}

SourceRecord ReadSource(JsonMembers& members)
{
  SourceRecord record;
  record.Path = members.GetString("path");
  record.AbsolutePath = members.GetString("absolutePath");
  record.Within = members.GetString("within");
  record.Axes = members.GetString("axes");
  record.Step = static_cast<std::size_t>(members.GetInteger("step", 0, SourceRecord::MaximumChunk));
  for (const Json& name : members.GetArray("arrays", JsonMembers::AnySize))
  {
    if (!name.is_string())
    {
      members.Fail("arrays", "is not an array of strings");
      return record;
    }
    record.Arrays.push_back(name.get<std::string>());
  }
  const Json& chunk = members.GetArray("chunk", 3);
  for (std::size_t axis = 0; axis < chunk.size(); ++axis)
  {
    const bool isNumber = chunk[axis].is_number_unsigned() &&
      chunk[axis].get<std::uint64_t>() <= static_cast<std::uint64_t>(SourceRecord::MaximumChunk);
    if (!isNumber)
    {
      members.Fail("chunk", "is not an array of numbers of vertices");
      return record;
    }
    record.Chunk[axis] = chunk[axis].get<std::int64_t>();
  }
  record.State.Files = members.GetUnsigned("files");
  record.State.Bytes = members.GetUnsigned("bytes");
  record.State.Modified = members.GetInteger("modified", -MaximumNumber, MaximumNumber);
  record.Metadata = members.GetChecksum("metadata");
  return record;
}

} // namespace isosurface
