// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Indexing/SampleCollector.h"

#include "Ground/Base/Coding.h"
#include "Ground/Volume/SampleCopy.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace isosurface
{

void SampleCollector::Begin(const OpenedVolume& volume)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Volume = SampledVolume(volume, 0);
  this->Numbers = Lattice{ this->Volume.Box, this->Step }.GetNumbers();
  const auto vertices = static_cast<std::size_t>(this->Numbers.GetNumberOfVertices());
  for (const ValueType type : this->Volume.Types)
  {
    this->Samples.emplace_back(vertices * GetValueSize(type));
  }
  this->IsKnown.resize(vertices);
  this->KnownOfSlice.resize(static_cast<std::size_t>(this->Numbers.High[2]));
}

void SampleCollector::Add(const BoxSamples& slab, const VertexBox& box)
{
  const VertexBox part = Lattice{ box, this->Step }.GetNumbers();
  if (part.IsEmpty() || !slab.Fits(this->Volume.Types, box))
  {
    return;
  }
  const std::lock_guard<std::mutex> lock(this->Mutex);
  VisitRows(part,
    [&](const Index3& number, std::int64_t count)
    {
      const std::size_t first = this->Numbers.FindIndex(number);
      const Index3 vertex{ number[0] * this->Step[0], number[1] * this->Step[1],
        number[2] * this->Step[2] };
      for (std::size_t variable = 0; variable < this->Samples.size(); ++variable)
      {
        const SampleView& view = slab.Arrays[variable];
        const std::size_t size = GetValueSize(view.Type);
        CopySamples(this->Samples[variable].data() + first * size, 1, view.AtBytes(vertex),
          view.Stride[0] * this->Step[0], count, size);
      }
      this->MarkKnown(first, static_cast<std::size_t>(count));
    });
}

void SampleCollector::MarkKnown(std::size_t first, std::size_t count)
{
  const auto whole = static_cast<std::size_t>(this->GetVerticesOfSlice());
  for (std::size_t at = first; at < first + count; ++at)
  {
    this->KnownOfSlice[at / whole] += this->IsKnown[at] ? 0 : 1;
    this->IsKnown[at] = true;
  }
}

Message SampleCollector::Pack(std::int64_t fromSlice) const
{
  Message message;
  const std::lock_guard<std::mutex> lock(this->Mutex);
  const auto begin = this->IsKnown.begin();
  const auto end = this->IsKnown.end();
  for (auto last = begin + fromSlice * this->GetVerticesOfSlice();;)
  {
    const auto first = std::find(last, end, true);
    if (first == end)
    {
      return message;
    }
    last = std::find(first, end, false);
    const auto vertex = static_cast<std::size_t>(first - begin);
    const auto count = static_cast<std::size_t>(last - first);
    AppendLittleEndian<std::uint64_t>(message, vertex);
    AppendLittleEndian<std::uint64_t>(message, count);
    for (std::size_t variable = 0; variable < this->Samples.size(); ++variable)
    {
      const std::size_t size = GetValueSize(this->Volume.Types[variable]);
      const std::uint8_t* samples = this->Samples[variable].data() + vertex * size;
      message.insert(message.end(), samples, samples + count * size);
    }
  }
}

bool SampleCollector::Unpack(const Message& message)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  ByteReader reader(message);
  while (!this->IsKnown.empty() && reader.GetRemaining() > 0)
  {
    const auto vertex = reader.Read<std::uint64_t>();
    const auto count = reader.Read<std::uint64_t>();
    if (vertex > this->IsKnown.size() || count > this->IsKnown.size() - vertex)
    {
      return false;
    }
    for (std::size_t variable = 0; variable < this->Samples.size(); ++variable)
    {
      const std::size_t size = GetValueSize(this->Volume.Types[variable]);
      const std::uint8_t* samples = reader.ReadBytes(count * size);
      if (!samples)
      {
        return false;
      }
      std::copy_n(samples, count * size, this->Samples[variable].data() + vertex * size);
    }
    this->MarkKnown(vertex, count);
  }
  return true;
}

std::int64_t SampleCollector::CountSlices() const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  const std::int64_t whole = this->GetVerticesOfSlice();
  const auto end = std::find_if(this->KnownOfSlice.begin(), this->KnownOfSlice.end(),
    [whole](std::int64_t known) { return known < whole; });
  return end - this->KnownOfSlice.begin();
}

Lattice SampleCollector::FindSlices(std::int64_t slices) const
{
  Lattice lattice{ this->Volume.Box, this->Step };
  lattice.Box.High[2] = std::min(lattice.Box.High[2], slices * this->Step[2]);
  return lattice;
}

double SampleCollector::GetShare(std::int64_t slices) const
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  const std::int64_t all = this->Volume.Box.GetNumberOfVertices();
  return all == 0 ? 0
                  : static_cast<double>(this->FindSlices(slices).Box.GetNumberOfVertices()) /
      static_cast<double>(all);
}

Result<SourceSample> SampleCollector::MakeSample(
  FileSystem& files, const SourceIndex& index, std::int64_t slices) const
{
  Lattice lattice;
  std::vector<std::vector<std::uint8_t>> samples;
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    lattice = this->FindSlices(slices);
    samples = this->Samples;
  }
  if (lattice.Box.IsEmpty())
  {
    return Status(StatusCode::InvalidArgument, index.Source + ": nothing of it has been read yet");
  }
  return MakeSourceSample(files, index, this->Volume, lattice, samples, "first");
}

} // namespace isosurface
