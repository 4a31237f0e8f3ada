// SPDX-License-Identifier: BSD-3-Clause
#include "ContourHeader.h"

#include "MatchVTK.h"

#include "Ground/Base/Coding.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

namespace isosurface
{

namespace
{

constexpr const char* NotDescribed = "the isosurface cannot be described to all ranks";

void AppendText(Message& message, const std::string& text)
{
  AppendVarint(message, text.size());
  message.insert(message.end(), text.begin(), text.end());
}

std::string ReadText(ByteReader& reader)
{
  const auto size = std::min<std::uint64_t>(reader.ReadVarint(), reader.GetRemaining());
  const std::uint8_t* text = reader.ReadBytes(static_cast<std::size_t>(size));
  return text ? std::string(text, text + size) : std::string();
}

Message PackArrays(const std::vector<InterpolatedArray>& arrays)
{
  Message message;
  for (const InterpolatedArray& array : arrays)
  {
    AppendText(message, array.Name);
    message.push_back(static_cast<std::uint8_t>(array.Layout.Type));
    AppendVarint(message, static_cast<std::uint64_t>(array.Layout.NumberOfComponents));
    AppendVarint(message, array.ComponentNames.size());
    for (const std::string& name : array.ComponentNames)
    {
      AppendText(message, name);
    }
  }
  return message;
}

std::vector<InterpolatedArray> ReadArrays(const Message& message)
{
  std::vector<InterpolatedArray> arrays;
  ByteReader reader(message);
  while (reader.GetRemaining() > 0)
  {
    InterpolatedArray& array = arrays.emplace_back();
    array.Name = ReadText(reader);
    array.Layout.Type = static_cast<ValueType>(reader.Read<std::uint8_t>());
    array.Layout.NumberOfComponents = reader.ReadVarint<int>();
    for (std::uint64_t left = reader.ReadVarint(); left > 0 && reader.GetRemaining() > 0; --left)
    {
      array.ComponentNames.push_back(ReadText(reader));
    }
  }
  return arrays;
}

/// Blocks are encoded with the normals that the contour computes.
void MatchNormals(EdgeIndexHeader& header)
{
  ContourRequest request;
  MatchVTK(request);
  for (EdgeIndexAttribute& attribute : header.Attributes)
  {
    attribute.NormalsRoundedOnce = request.NormalsRoundedOnce;
    attribute.NormalsByDirection = request.NormalsByDirection;
  }
}

} // namespace

EdgeIndexHeader DescribeContourBlocks(
  const ContourBlocks& blocks, double arrayError, double normalError)
{
  EdgeIndexHeader header;
  header.Geometry = blocks.Grid;
  header.Type = blocks.Source->GetValueType();
  header.Isovalues = blocks.Isovalues;
  header.ClosedSides = blocks.ClosedSides;
  header.Array = blocks.ArrayName;
  header.Source = blocks.Origin;
  header.Time = blocks.Time;
  for (const InterpolatedArray& array : blocks.Arrays)
  {
    header.Attributes.push_back({ array.Name, GetInterpolatedType(array.Layout.Type),
      array.Layout.NumberOfComponents, arrayError, false });
  }
  if (blocks.Normals)
  {
    header.Attributes.push_back({ "Normals", ValueType::Float32, 3, normalError, true });
  }
  return header;
}

Result<EdgeIndexHeader> ShareHeader(
  Communicator& ranks, bool hasSamples, const std::function<EdgeIndexHeader()>& describe)
{
  EdgeIndexHeader header;
  Message mine;
  const auto pack = [&]() -> Status
  {
    header = describe();
    header.TakeLosslessIfBoundIsTooFine();
    ISOSURFACE_RETURN_IF_ERROR(header.Check());
    if (hasSamples)
    {
      header.Append(mine);
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotDescribed, pack));
  const std::vector<Message> messages = ranks.AllGather(mine);
  const auto take = [&]() -> Status
  {
    const auto first = std::find_if(
      messages.begin(), messages.end(), [](const Message& message) { return !message.empty(); });
    if (first != messages.end())
    {
      std::size_t used = 0;
      ISOSURFACE_ASSIGN_OR_RETURN(
        header, EdgeIndexHeader::Parse(first->data(), first->size(), used));
    }
    MatchNormals(header); // the bytes do not say it
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotDescribed, take));
  return header;
}

Result<std::vector<InterpolatedArray>> ShareArrays(Communicator& ranks, const ContourBlocks& blocks)
{
  Message mine;
  const auto pack = [&]
  {
    mine = blocks.HasSamples ? PackArrays(blocks.Arrays) : Message();
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotDescribed, pack));
  const std::vector<Message> messages = ranks.AllGather(mine);
  std::vector<InterpolatedArray> arrays;
  const auto take = [&]
  {
    for (std::size_t rank = 0; arrays.empty() && rank < messages.size(); ++rank)
    {
      arrays = ReadArrays(messages[rank]);
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NotDescribed, take));
  return arrays;
}

} // namespace isosurface
