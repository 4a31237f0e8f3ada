// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/EdgeIndexDecoder.h"

#include "Coding/BlockCoding/BlockCoding.h"
#include "Coding/BlockCoding/BytePlanes.h"
#include "Coding/BlockCoding/Quantizer.h"
#include "Coding/EdgeIndex/PointAttributes.h"
#include "Coding/EdgeIndex/SampledBlock.h"
#include "Ground/Volume/SampleCopy.h"
#include "Ground/Volume/ValueKey.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

namespace isosurface
{
namespace
{

// A value outside and a value inside. Without a value inside there is no surface.
template <typename T>
std::array<T, 2> FindSideValues(double isovalue)
{
  const auto threshold = FindThreshold<T>(isovalue);
  if constexpr (std::is_floating_point_v<T>)
  {
    return { std::numeric_limits<T>::quiet_NaN(),
      threshold.value_or(std::numeric_limits<T>::quiet_NaN()) };
  }
  else
  {
    const T inside = threshold.value_or(std::numeric_limits<T>::min());
    const bool lowest = inside == std::numeric_limits<T>::min();
    return { lowest ? inside : static_cast<T>(inside - 1), inside };
  }
}

// The memory of a decoded block. Samples are x fastest, without gaps.
struct DecodedMemory
{
  explicit DecodedMemory(PointAttributes attributes)
    : Attributes(std::move(attributes))
  {
  }
  PointAttributes Attributes;
  Buffer<std::uint8_t> Samples;
  std::array<Buffer<float>, 3> Crossings;
  CrossingView View;
};

// Takes signs and numbers from a decoder.
class DecodedBlock : public BlockValues
{
public:
  DecodedBlock(const EdgeIndexHeader& header, const EdgeIndexRecord& record, DecodedMemory& memory)
    : Isovalue(header.Isovalues[record.Block.Isovalue])
    , Intervals(header.GetIntervals())
    , Type(header.GetDecodedType())
    , Memory(memory)
  {
    const Index3 size = record.Block.Vertices.GetSize();
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      this->Size[axis] = static_cast<int>(size[axis]);
    }
    const auto vertices = static_cast<std::size_t>(record.Block.Vertices.GetNumberOfVertices());
    this->ValueSize = GetValueSize(this->Type);
    memory.Samples = Buffer<std::uint8_t>(vertices * this->ValueSize);
    const bool isOfValues = record.Block.Coding == CodedGeometry::Values;
    const bool isRounded = header.Settings.Mode == EdgeIndexMode::Smallest && header.RoundsFaces;
    if (!isOfValues || isRounded)
    {
      memory.View.IsOfFaces = isOfValues;
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        memory.Crossings[axis] = Buffer<float>(vertices);
        memory.View.First[axis] = memory.Crossings[axis].GetData();
      }
      memory.View.Box = record.Block.Vertices;
    }
  }

  const std::array<int, 3>& GetSize() const { return this->Size; }
  /// Whether all decoded values lie on the side of the isovalue that their signs say.
  bool HasRightSides() const { return this->RightSides; }
  void SetDomain(const ValueDomain* domain) { this->Domain = domain; }
  void SetQuantizer(const Quantizer* quantizer) { this->Quantization = quantizer; }
  void SetDecoder(const RangeDecoder* decoder) { this->Decoder = decoder; }

  SignSlice& GetSigns(int z) override
  {
    SignSlice& slice = this->Signs[static_cast<std::size_t>(z % 3)];
    slice = SignSlice();
    return slice;
  }

  void FinishSigns(int z) override
  {
    const SignSlice& slice = this->Signs[static_cast<std::size_t>(z % 3)];
    DispatchValueType(this->Type,
      [&](auto zero)
      {
        using T = decltype(zero);
        const std::array<T, 2> sides = FindSideValues<T>(this->Isovalue);
        T* row = reinterpret_cast<T*>(this->At(0, z));
        for (int y = 0; y < this->Size[1]; ++y, row += this->Size[0])
        {
          this->FillRow(slice.At(y), sides, row);
        }
      });
  }

  void ExchangeCodes(int y, int z, const SignRow& vertices, std::int64_t* codes) override
  {
    std::uint8_t* row = this->At(y, z);
    if (this->Quantization)
    {
      VisitBits(vertices,
        [&](int x)
        {
          const float value = this->Quantization->ToValue(codes[x]);
          std::memcpy(row + static_cast<std::size_t>(x) * sizeof(value), &value, sizeof(value));
        });
      return;
    }
    const SignRow& signs = this->Signs[static_cast<std::size_t>(z % 3)].At(y);
    DispatchValueType(this->Type,
      [&](auto zero)
      {
        using T = decltype(zero);
        T* values = reinterpret_cast<T*>(row);
        VisitBits(vertices, [&](int x) { values[x] = this->Domain->ToValue<T>(codes[x]); });
        if constexpr (std::is_floating_point_v<T> || sizeof(T) == 8)
        {
          // Signs do not bound the codes of these types.
          const T threshold = FindSideValues<T>(this->Isovalue)[1];
          VisitBits(vertices,
            [&](int x)
            { this->RightSides = this->RightSides && (values[x] >= threshold) == signs.Get(x); });
        }
      });
  }

  void ExchangeBins(int axis, int y, int z, const SignRow& edges, std::uint32_t* bins) override
  {
    float* row = this->Memory.Crossings[static_cast<std::size_t>(axis)].GetData() +
      (std::ptrdiff_t(z) * this->Size[1] + y) * this->Size[0];
    VisitBits(edges, [&](int x) { row[x] = this->Intervals.GetPlace(bins[x]); });
  }

  bool FinishSlice(int) override { return !this->Decoder->IsExhausted(); }

private:
  std::uint8_t* At(int y, int z)
  {
    return this->Memory.Samples.GetData() +
      static_cast<std::size_t>((std::ptrdiff_t(z) * this->Size[1] + y) * this->Size[0]) *
      this->ValueSize;
  }

  template <typename T>
  void FillRow(const SignRow& signs, const std::array<T, 2>& sides, T* row) const
  {
    const SignRow mask = SignRow::MakeMask(this->Size[0]);
    const bool none = (signs & mask).IsZero();
    if (none || (~signs & mask).IsZero())
    {
      std::fill(row, row + this->Size[0], sides[none ? 0 : 1]);
      return;
    }
    // Run by run of equal signs.
    int begin = 0;
    const auto fill = [&](int end)
    {
      std::fill(row + begin, row + end, sides[signs.Get(begin) ? 1 : 0]);
      begin = end;
    };
    const SignRow starts = (signs ^ signs.ShiftUp()) & mask & ~SignRow::MakeMask(1);
    VisitBits(starts, fill);
    fill(this->Size[0]);
  }

  double Isovalue;
  CrossingIntervals Intervals;
  ValueType Type;
  std::size_t ValueSize = 1;
  DecodedMemory& Memory;
  std::array<int, 3> Size{};
  std::array<SignSlice, 3> Signs;
  const ValueDomain* Domain = nullptr;
  const Quantizer* Quantization = nullptr;
  const RangeDecoder* Decoder = nullptr;
  bool RightSides = true;
};

// The domain of a block's values.
ValueDomain MakeDomain(const EdgeIndexHeader& header, const EdgeIndexRecord& record,
  const std::optional<Quantizer>& quantizer)
{
  // Encoders write no other scales for offsets. Those of a corrupt record would shift too far.
  const int shortScale = std::clamp(record.Scale, -30, 10);
  if (quantizer)
  {
    return quantizer->MakeDomain(shortScale);
  }
  const double isovalue = header.Isovalues[record.Block.Isovalue];
  const ValueDomain domain(header.Type, isovalue, record.Scale);
  return domain.GetKind() == ValueDomain::Kind::Offsets
    ? ValueDomain(header.Type, isovalue, shortScale)
    : domain;
}

// Returns whether the code ends where its block does.
bool DecodeCode(const EdgeIndexHeader& header, const EdgeIndexRecord& record,
  const PointAttributes& attributes, BlockModel& model, DecodedBlock& block)
{
  BlockContent content;
  content.Size = block.GetSize();
  content.Attributes = attributes.GetCoded();
  std::optional<Quantizer> quantizer;
  std::optional<ValueDomain> domain;
  if (record.Block.Coding == CodedGeometry::Crossings)
  {
    content.Intervals = header.GetIntervals();
    content.HasMissing = record.Block.HasMissing;
  }
  else
  {
    if (header.Settings.Mode == EdgeIndexMode::Quantized)
    {
      quantizer.emplace(
        header.Settings.MakeQuantizer(header.Type, header.Isovalues[record.Block.Isovalue]));
      block.SetQuantizer(&*quantizer);
    }
    domain.emplace(MakeDomain(header, record, quantizer));
    content.Domain = &*domain;
    block.SetDomain(&*domain);
  }
  BytePlanes planes;
  std::size_t begin = 0;
  if (header.Settings.Profile == EdgeIndexProfile::Working)
  {
    begin = planes.Begin(content.Size, record.Code, record.CodeSize);
    if (begin == 0 || (content.Attributes.empty() && begin != record.CodeSize))
    {
      return false;
    }
    content.Planes = &planes;
  }
  RangeDecoder decoder(record.Code + begin, record.CodeSize - begin);
  block.SetDecoder(&decoder);
  model.Reset(content.Domain != nullptr);
  CodeBlock(decoder, model, content, block);
  return !decoder.IsExhausted() && !decoder.HasMore() && (!content.Planes || planes.IsComplete());
}

} // namespace

EdgeIndexBlockDecoder::EdgeIndexBlockDecoder(const EdgeIndexHeader& header)
  : Header(header)
{
}

EdgeIndexBlockDecoder::~EdgeIndexBlockDecoder() = default;

std::unique_ptr<BlockModel> EdgeIndexBlockDecoder::TakeModel()
{
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    if (!this->Models.empty())
    {
      std::unique_ptr<BlockModel> model = std::move(this->Models.back());
      this->Models.pop_back();
      return model;
    }
  }
  return std::make_unique<BlockModel>(GetFreshModel(this->Header.Settings.Profile));
}

Result<BlockSamples> EdgeIndexBlockDecoder::Decode(const EdgeIndexRecord& record)
{
  const auto memory =
    std::make_shared<DecodedMemory>(PointAttributes(this->Header, record.Block.Vertices));
  const auto block = std::make_unique<DecodedBlock>(this->Header, record, *memory);
  std::unique_ptr<BlockModel> model = this->TakeModel();
  const bool isWhole = DecodeCode(this->Header, record, memory->Attributes, *model, *block);
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->Models.push_back(std::move(model));
  }
  if (!isWhole)
  {
    return Status(
      StatusCode::Corrupt, "The code of an edge-index block does not end where its block does.");
  }
  if (!block->HasRightSides())
  {
    return Status(StatusCode::Corrupt,
      "The code of an edge-index block has values on the wrong side of the isovalue.");
  }
  BlockSamples samples;
  samples.Scalars =
    MakeSampleView(this->Header.GetDecodedType(), record.Block.Vertices, memory->Samples.GetData());
  if (memory->View.First[0])
  {
    samples.Crossings = &memory->View;
  }
  if (memory->View.IsOfFaces)
  {
    std::array<float*, 3> crossings;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      crossings[axis] = memory->Crossings[axis].GetData();
    }
    SampledBlock(
      samples.Scalars, this->Header.Isovalues[record.Block.Isovalue], this->Header.GetIntervals())
      .RoundOnFaces(crossings);
  }
  samples.Attributes = memory->Attributes.GetViews(this->Header, record.Block.Vertices);
  samples.Owner = memory;
  ISOSURFACE_RETURN_IF_ERROR(this->TellIslands(record, samples));
  return samples;
}

Status EdgeIndexBlockDecoder::TellIslands(
  const EdgeIndexRecord& record, const BlockSamples& samples)
{
  if (!record.Block.LacksIslands)
  {
    return Status::Ok();
  }
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto islands, FindBlockIslands(this->Header, samples, record.Block.Isovalue));
  if (islands.size() != record.AreKept.size())
  {
    return { StatusCode::Corrupt,
      "The record of an edge-index block tells of " + std::to_string(record.AreKept.size()) +
        " islands, and has " + std::to_string(islands.size()) + "." };
  }
  for (std::size_t island = 0; island < islands.size(); ++island)
  {
    islands[island].IsKept = record.AreKept[island];
  }
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Islands.insert(this->Islands.end(), islands.begin(), islands.end());
  return Status::Ok();
}

} // namespace isosurface
