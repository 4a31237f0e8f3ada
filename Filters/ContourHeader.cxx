// SPDX-License-Identifier: BSD-3-Clause
#include "ContourHeader.h"

#include "NormalRounding.h"

#include "Ground/Base/Coding.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

namespace isosurface
{

namespace
{

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

/// Blocks are encoded with the normals that the contour computes.
void MatchNormals(EdgeIndexHeader& header)
{
  ContourRequest request;
  MatchNormalsOfVTK(request);
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
  Communicator& ranks, const EdgeIndexHeader& mine, bool hasSamples)
{
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(mine.Check()));
  Message message;
  if (hasSamples)
  {
    mine.Append(message);
  }
  Result<EdgeIndexHeader> header = mine;
  for (const Message& other : ranks.AllGather(message))
  {
    if (!other.empty())
    {
      std::size_t used = 0;
      header = EdgeIndexHeader::Parse(other.data(), other.size(), used);
      break;
    }
  }
  if (header.IsOk())
  {
    MatchNormals(*header); // the bytes do not say it
  }
  return header;
}

std::vector<InterpolatedArray> ShareArrays(Communicator& ranks, const ContourBlocks& blocks)
{
  Message mine;
  if (blocks.HasSamples)
  {
    for (const InterpolatedArray& array : blocks.Arrays)
    {
      AppendText(mine, array.Name);
      mine.push_back(static_cast<std::uint8_t>(array.Layout.Type));
      AppendVarint(mine, static_cast<std::uint64_t>(array.Layout.NumberOfComponents));
      AppendVarint(mine, array.ComponentNames.size());
      for (const std::string& name : array.ComponentNames)
      {
        AppendText(mine, name);
      }
    }
  }
  std::vector<InterpolatedArray> arrays;
  for (const Message& message : ranks.AllGather(mine))
  {
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
    if (!arrays.empty())
    {
      break;
    }
  }
  return arrays;
}

} // namespace isosurface
