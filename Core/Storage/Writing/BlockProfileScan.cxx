// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/BlockProfileScan.h"

#include "Ground/Base/ParallelFor.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace isosurface
{
namespace
{

constexpr std::int64_t CubeSize = BlockProfile::CubeSize;
constexpr std::size_t LargestBlock = 64;

/// A profile in a message between ranks.
struct ProfileRecord
{
  std::uint64_t Block = 0;
  BlockProfile Profile;
};

template <typename T>
void ExtendRow(const T* row, std::size_t count, std::ptrdiff_t stride, T* low, T* high)
{
  if (stride == 1) // the compiler vectorises this one
  {
    for (std::size_t i = 0; i < count; ++i)
    {
      // Comparisons with NaN are false, so it changes nothing.
      low[i] = row[i] < low[i] ? row[i] : low[i];
      high[i] = row[i] > high[i] ? row[i] : high[i];
    }
    return;
  }
  for (std::size_t i = 0; i < count; ++i)
  {
    const T value = row[static_cast<std::ptrdiff_t>(i) * stride];
    low[i] = value < low[i] ? value : low[i];
    high[i] = value > high[i] ? value : high[i];
  }
}

} // namespace

BlockProfileScan::BlockProfileScan(const BlockGrid& grid, ValueType type, int threads)
  : Grid(grid)
  , Type(type)
  , Threads(threads)
  , Profiles(static_cast<std::size_t>(grid.GetNumberOfBlocks()))
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    this->CubesPerAxis[axis] = (grid.GetDimensions()[axis] + CubeSize - 1) / CubeSize;
  }
}

std::uint64_t BlockProfileScan::GetBytes(const BlockGrid& grid)
{
  // A profile, one sent and one received, the memory of distributing; and a layer of open cubes.
  const Index3& size = grid.GetDimensions();
  const auto cubes =
    static_cast<std::uint64_t>((size[0] / CubeSize + 1) * (size[1] / CubeSize + 1));
  return static_cast<std::uint64_t>(grid.GetNumberOfBlocks()) * (3 * sizeof(ProfileRecord) + 16) +
    cubes * (sizeof(OpenCube) + 32);
}

VertexBox BlockProfileScan::GetOwnVertices(std::int64_t block) const
{
  VertexBox box = this->Grid.GetVertices(block);
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    box.High[axis] =
      std::min<std::int64_t>(box.High[axis], box.Low[axis] + this->Grid.GetBlockSize());
  }
  return box;
}

VertexBox BlockProfileScan::GetCube(std::uint64_t cube) const
{
  auto rest = static_cast<std::int64_t>(cube);
  VertexBox box;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    box.Low[axis] = rest % this->CubesPerAxis[axis] * CubeSize;
    box.High[axis] = std::min(this->Grid.GetDimensions()[axis], box.Low[axis] + CubeSize);
    rest /= this->CubesPerAxis[axis];
  }
  return box;
}

void BlockProfileScan::Add(const SampleView& samples, const VertexBox& box)
{
  const std::int64_t size = this->Grid.GetBlockSize();
  VertexBox blocks;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    blocks.Low[axis] = box.Low[axis] / size;
    blocks.High[axis] =
      std::min(this->Grid.GetNumberOfBlocksPerAxis()[axis], (box.High[axis] - 1) / size + 1);
  }
  if (box.IsEmpty() || blocks.IsEmpty())
  {
    return;
  }
  const Index3 count = blocks.GetSize();
  std::vector<ThreadState> states(static_cast<std::size_t>(this->Threads));
  ParallelFor(static_cast<std::size_t>(count[1] * count[2]), this->Threads,
    [&](std::size_t index, int thread)
    {
      const auto row = static_cast<std::int64_t>(index);
      for (std::int64_t i = blocks.Low[0]; i < blocks.High[0]; ++i)
      {
        const std::int64_t block = this->Grid.GetBlockIndex(
          { i, blocks.Low[1] + row % count[1], blocks.Low[2] + row / count[1] });
        const VertexBox part = this->GetOwnVertices(block).Intersect(box);
        if (!part.IsEmpty())
        {
          DispatchValueType(this->Type,
            [&](auto zero)
            {
              this->AddBlock<decltype(zero)>(
                samples, block, part, states[static_cast<std::size_t>(thread)]);
            });
        }
      }
    });
  for (const ThreadState& state : states)
  {
    for (const OpenCube& part : state.Open)
    {
      this->AddOpenCube(part);
    }
  }
}

template <typename T>
void BlockProfileScan::AddBlock(
  const SampleView& samples, std::int64_t block, const VertexBox& part, ThreadState& state)
{
  state.Cubes.clear();
  VertexBox row = part;
  for (row.Low[2] = part.Low[2]; row.Low[2] < part.High[2]; row.Low[2] = row.High[2])
  {
    row.High[2] = std::min(part.High[2], (row.Low[2] / CubeSize + 1) * CubeSize);
    for (row.Low[1] = part.Low[1]; row.Low[1] < part.High[1]; row.Low[1] = row.High[1])
    {
      row.High[1] = std::min(part.High[1], (row.Low[1] / CubeSize + 1) * CubeSize);
      this->AddCubeRow<T>(samples, row, state);
    }
  }
  BlockProfile& profile = this->Profiles[static_cast<std::size_t>(block)];
  profile.Add(this->Type, BlockProfile::Make(this->Type, state.Cubes));
}

/// Cubes that are neighbours along x, in a block.
template <typename T>
void BlockProfileScan::AddCubeRow(
  const SampleView& samples, const VertexBox& row, ThreadState& state) const
{
  using Limits = std::numeric_limits<T>;
  std::array<T, LargestBlock> low;
  std::array<T, LargestBlock> high;
  const auto width = static_cast<std::size_t>(row.GetSize()[0]);
  std::fill_n(low.begin(), width, Limits::max());
  std::fill_n(high.begin(), width, Limits::lowest());
  for (std::int64_t k = row.Low[2]; k < row.High[2]; ++k)
  {
    for (std::int64_t j = row.Low[1]; j < row.High[1]; ++j)
    {
      ExtendRow(
        samples.At<T>({ row.Low[0], j, k }), width, samples.Stride[0], low.data(), high.data());
    }
  }
  VertexBox cube = row;
  for (cube.Low[0] = row.Low[0]; cube.Low[0] < row.High[0]; cube.Low[0] = cube.High[0])
  {
    cube.High[0] = std::min(row.High[0], (cube.Low[0] / CubeSize + 1) * CubeSize);
    const auto begin = static_cast<std::ptrdiff_t>(cube.Low[0] - row.Low[0]);
    const auto end = static_cast<std::ptrdiff_t>(cube.High[0] - row.Low[0]);
    const T least = *std::min_element(low.begin() + begin, low.begin() + end);
    const T most = *std::max_element(high.begin() + begin, high.begin() + end);
    SampleSpan span;
    // Without any number, the minimum is above the maximum.
    if (least <= most)
    {
      span.Low = static_cast<double>(std::max(least, Limits::lowest()));
      span.High = static_cast<double>(std::min(most, Limits::max()));
    }
    this->AddSpan(cube, span, state);
  }
}

void BlockProfileScan::AddSpan(
  const VertexBox& part, const SampleSpan& span, ThreadState& state) const
{
  const auto cube = static_cast<std::uint64_t>(part.Low[0] / CubeSize +
    this->CubesPerAxis[0] *
      (part.Low[1] / CubeSize + this->CubesPerAxis[1] * (part.Low[2] / CubeSize)));
  if (part == this->GetCube(cube))
  {
    state.Cubes.push_back(span);
  }
  else
  {
    state.Open.push_back({ cube, part.GetNumberOfVertices(), span });
  }
}

void BlockProfileScan::AddOpenCube(const OpenCube& part)
{
  OpenCube& open = this->Open[part.Cube];
  open.Cube = part.Cube;
  open.Vertices += part.Vertices;
  open.Span.Add(part.Span);
  const VertexBox box = this->GetCube(part.Cube);
  if (open.Vertices == box.GetNumberOfVertices())
  {
    const std::int64_t size = this->Grid.GetBlockSize();
    const std::int64_t block =
      this->Grid.GetBlockIndex({ box.Low[0] / size, box.Low[1] / size, box.Low[2] / size });
    this->Profiles[static_cast<std::size_t>(block)].Add(
      this->Type, BlockProfile::Make(this->Type, { open.Span }));
    this->Open.erase(part.Cube);
  }
}

Message BlockProfileScan::Pack() const
{
  std::uint64_t records = 0;
  for (const BlockProfile& profile : this->Profiles)
  {
    records += profile.IsEmpty() ? 0 : 1;
  }
  Message message(
    sizeof(records) + records * sizeof(ProfileRecord) + this->Open.size() * sizeof(OpenCube));
  std::uint8_t* to = message.data();
  const auto append = [&to](const auto& value)
  {
    std::memcpy(to, &value, sizeof(value));
    to += sizeof(value);
  };
  append(records);
  for (std::size_t block = 0; block < this->Profiles.size(); ++block)
  {
    if (!this->Profiles[block].IsEmpty())
    {
      append(ProfileRecord{ block, this->Profiles[block] });
    }
  }
  for (const auto& open : this->Open)
  {
    append(open.second);
  }
  return message;
}

void BlockProfileScan::Unpack(const Message& message)
{
  const std::uint8_t* from = message.data();
  const auto take = [&from](auto value)
  {
    std::memcpy(&value, from, sizeof(value));
    from += sizeof(value);
    return value;
  };
  for (auto records = take(std::uint64_t{}); records > 0; --records)
  {
    const ProfileRecord record = take(ProfileRecord{});
    this->Profiles[static_cast<std::size_t>(record.Block)].Add(this->Type, record.Profile);
  }
  while (from < message.data() + message.size())
  {
    this->AddOpenCube(take(OpenCube{}));
  }
}

Status BlockProfileScan::Reduce(Communicator& communicator, const std::string& path)
{
  Message own;
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(communicator, path,
    [&]
    {
      own = this->Pack();
      return Status::Ok();
    }));
  const std::vector<Message> messages = communicator.AllGather(own);
  return AttemptOnAll(communicator, path,
    [&]
    {
      for (std::size_t rank = 0; rank < messages.size(); ++rank)
      {
        if (rank != static_cast<std::size_t>(communicator.GetRank()))
        {
          this->Unpack(messages[rank]);
        }
      }
      return Status::Ok();
    });
}

} // namespace isosurface
