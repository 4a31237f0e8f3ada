// SPDX-License-Identifier: BSD-3-Clause
#include "ContourHeader.h"

#include "EdgeIndex/CodedNumbers.h"

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
  AppendNumber(message, text.size());
  message.insert(message.end(), text.begin(), text.end());
}

std::string ReadText(NumberReader& reader)
{
  std::string text(std::min<std::uint64_t>(reader.ReadNumber(), reader.GetLeft()), ' ');
  for (char& character : text)
  {
    character = static_cast<char>(reader.ReadByte());
  }
  return text;
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
  const Status status = ranks.Agree(mine.Check());
  if (!status.IsOk())
  {
    return status;
  }
  Message message;
  if (hasSamples)
  {
    mine.Append(message);
  }
  for (const Message& other : ranks.AllGather(message))
  {
    if (!other.empty())
    {
      std::size_t used = 0;
      return EdgeIndexHeader::Parse(other.data(), other.size(), used);
    }
  }
  return mine;
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
      AppendNumber(mine, static_cast<std::uint64_t>(array.Layout.NumberOfComponents));
      AppendNumber(mine, array.ComponentNames.size());
      for (const std::string& name : array.ComponentNames)
      {
        AppendText(mine, name);
      }
    }
  }
  std::vector<InterpolatedArray> arrays;
  for (const Message& message : ranks.AllGather(mine))
  {
    NumberReader reader(message.data(), message.size());
    while (reader.GetLeft() > 0)
    {
      InterpolatedArray& array = arrays.emplace_back();
      array.Name = ReadText(reader);
      array.Layout.Type = static_cast<ValueType>(reader.ReadByte());
      array.Layout.NumberOfComponents = static_cast<int>(reader.ReadNumber());
      for (std::uint64_t left = reader.ReadNumber(); left > 0 && reader.GetLeft() > 0; --left)
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
