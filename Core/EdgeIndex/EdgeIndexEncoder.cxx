// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/EdgeIndexEncoder.h"

#include "Base/ParallelFor.h"
#include "Contour/BrickKernel.h"
#include "EdgeIndex/BlockCoder.h"
#include "EdgeIndex/BlockRecordFormat.h"
#include "EdgeIndex/Quantizer.h"
#include "Volume/ValueKey.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <new>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

// Where the kernel puts a point; see BrickKernelPoints.txx.
template <typename T>
double FindParameter(double isovalue, T from, T to)
{
  double difference = 0;
  if constexpr (std::is_floating_point_v<T>)
  {
    difference = static_cast<double>(static_cast<T>(to - from));
  }
  else if constexpr (sizeof(T) == 8)
  {
    difference = to >= from
      ? static_cast<double>(static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from))
      : -static_cast<double>(static_cast<std::uint64_t>(from) - static_cast<std::uint64_t>(to));
  }
  else
  {
    difference = static_cast<double>(to) - static_cast<double>(from);
  }
  return (isovalue - static_cast<double>(from)) / difference;
}

std::uint32_t FindBin(double parameter, std::uint32_t bins)
{
  if (parameter != parameter)
  {
    return bins;
  }
  const double position = parameter * bins;
  return position <= 0 ? 0 : position >= bins ? bins - 1 : static_cast<std::uint32_t>(position);
}

// The samples of a block as the coders take them. Signs are found by the kernel.
class SampledBlock : public BlockValues
{
public:
  SampledBlock(const SampleView& view, double isovalue, std::uint32_t bins)
    : View(view)
    , Isovalue(isovalue)
    , Bins(bins)
  {
    const Index3 size = view.Box.GetSize();
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      this->Size[axis] = static_cast<int>(size[axis]);
    }
    DispatchValueType(view.Type,
      [this](auto zero)
      {
        using T = decltype(zero);
        this->First = reinterpret_cast<const std::uint8_t*>(this->View.At<T>(this->View.Box.Low));
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
          this->Stride[axis] = this->View.Stride[axis] * static_cast<std::ptrdiff_t>(sizeof(T));
        }
      });
    this->Classify();
  }

  const int* GetSize() const { return this->Size.data(); }
  bool IsCrossed() const { return this->Crossed; }
  void SetDomain(const ValueDomain* domain) { this->Domain = domain; }
  void SetQuantizer(const Quantizer* quantizer) { this->Quantization = quantizer; }

  SignSlice& GetSigns(int z) override { return this->Signs[static_cast<std::size_t>(z)]; }
  void FinishSigns(int) override {}
  bool FinishSlice(int) override { return true; }

  void ExchangeCodes(int y, int z, const SignRow& vertices, std::int64_t* codes) override
  {
    const std::uint8_t* row = this->At(0, y, z);
    if (this->Quantization)
    {
      const SignRow& signs = this->Signs[static_cast<std::size_t>(z)].At(y);
      VisitBits(vertices,
        [&](int x)
        {
          codes[x] =
            this->Quantization->ToCode(this->GetDouble(row + x * this->Stride[0]), signs.Get(x));
        });
      return;
    }
    VisitBits(vertices, [&](int x) { codes[x] = this->Domain->ToCode(row + x * this->Stride[0]); });
  }

  void ExchangeBins(int axis, int y, int z, const SignRow& edges, std::uint32_t* bins) override
  {
    const std::uint8_t* row = this->At(0, y, z);
    VisitBits(edges,
      [&](int x)
      {
        const std::uint8_t* from = row + x * this->Stride[0];
        bins[x] = FindBin(this->FindCrossing(from, axis), this->Bins);
      });
  }

  /// The mean distance of values from the isovalue at relevant vertices; some are looked at.
  double MeasureDistance() const
  {
    double sum = 0;
    std::size_t count = 0;
    this->VisitCrossings(
      [&](const std::uint8_t* from, int axis)
      {
        for (const std::uint8_t* sample :
          { from, from + this->Stride[static_cast<std::size_t>(axis)] })
        {
          const double distance = std::abs(this->GetDouble(sample) - this->Isovalue);
          if (std::isfinite(distance))
          {
            sum += std::min(distance, 1e300);
            ++count;
          }
        }
        return count < 1500;
      });
    return count == 0 ? 0 : sum / static_cast<double>(count);
  }

  bool HasMissingCrossings() const
  {
    if (this->View.Type != ValueType::Float32 && this->View.Type != ValueType::Float64)
    {
      return false;
    }
    bool missing = false;
    this->VisitCrossings(
      [&](const std::uint8_t* from, int axis)
      {
        missing = std::isnan(this->FindCrossing(from, axis));
        return !missing;
      });
    return missing;
  }

private:
  const std::uint8_t* At(int x, int y, int z) const
  {
    return this->First + x * this->Stride[0] + y * this->Stride[1] + z * this->Stride[2];
  }

  double GetDouble(const std::uint8_t* sample) const
  {
    return DispatchValueType(this->View.Type,
      [sample](auto zero)
      { return static_cast<double>(*reinterpret_cast<const decltype(zero)*>(sample)); });
  }

  double FindCrossing(const std::uint8_t* from, int axis) const
  {
    return DispatchValueType(this->View.Type,
      [&](auto zero)
      {
        using T = decltype(zero);
        return FindParameter(this->Isovalue, *reinterpret_cast<const T*>(from),
          *reinterpret_cast<const T*>(from + this->Stride[static_cast<std::size_t>(axis)]));
      });
  }

  // Calls functor(first sample, axis) for crossed edges until it returns false.
  template <typename Functor>
  void VisitCrossings(const Functor& functor) const
  {
    bool goesOn = true;
    const SignRow vertices = SignRow::MakeMask(this->Size[0]);
    const SignRow cells = SignRow::MakeMask(this->Size[0] - 1);
    for (int z = 0; z < this->Size[2] && goesOn; ++z)
    {
      const SignSlice& slice = this->Signs[static_cast<std::size_t>(z)];
      for (int y = 0; y < this->Size[1] && goesOn; ++y)
      {
        const SignRow& row = slice.At(y);
        SignRow edges[3] = { (row ^ row.ShiftDown()) & cells, SignRow(), SignRow() };
        if (y + 1 < this->Size[1])
        {
          edges[1] = (row ^ slice.At(y + 1)) & vertices;
        }
        if (z + 1 < this->Size[2])
        {
          edges[2] = (row ^ this->Signs[static_cast<std::size_t>(z + 1)].At(y)) & vertices;
        }
        for (int axis = 0; axis < 3; ++axis)
        {
          VisitBits(
            edges[axis], [&](int x) { goesOn = goesOn && functor(this->At(x, y, z), axis); });
        }
      }
    }
  }

  void Classify();
  void ClassifyColumns(int begin, const void* threshold);

  const SampleView& View;
  double Isovalue;
  std::uint32_t Bins;
  std::array<int, 3> Size{};
  const std::uint8_t* First = nullptr;
  std::array<std::ptrdiff_t, 3> Stride{}; ///< in bytes
  const ValueDomain* Domain = nullptr;
  const Quantizer* Quantization = nullptr;
  std::array<SignSlice, MaximumCodedVertices> Signs;
  bool Crossed = false;
};

void SampledBlock::Classify()
{
  DispatchValueType(this->View.Type,
    [this](auto zero)
    {
      using T = decltype(zero);
      if (const auto threshold = FindThreshold<T>(this->Isovalue))
      {
        for (int begin = 0; begin < this->Size[0]; begin += 32)
        {
          this->ClassifyColumns(begin, &*threshold);
        }
      }
    });
  const SignRow full = SignRow::MakeMask(this->Size[0]);
  SignRow any;
  SignRow all = full;
  for (int z = 0; z < this->Size[2]; ++z)
  {
    for (int y = 0; y < this->Size[1]; ++y)
    {
      any = any | this->Signs[static_cast<std::size_t>(z)].At(y);
      all = all & this->Signs[static_cast<std::size_t>(z)].At(y);
    }
  }
  this->Crossed = !any.IsZero() && !(all ^ full).IsZero();
}

void SampledBlock::ClassifyColumns(int begin, const void* threshold)
{
  BrickSamples samples{};
  const int columns = std::min(32, this->Size[0] - begin);
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    samples.Stride[axis] = this->View.Stride[axis];
    samples.Size[axis] = this->Size[axis];
  }
  samples.Size[0] = columns;
  samples.Size[2] = 1;
  std::array<std::uint64_t, MaximumCodedVertices> inside;
  for (int z = 0; z < this->Size[2]; ++z)
  {
    samples.First = this->At(begin, 0, z);
    GetBrickKernels().ClassifyRows(this->View.Type, samples, threshold, inside.data());
    SignSlice& slice = this->Signs[static_cast<std::size_t>(z)];
    for (int y = 0; y < this->Size[1]; ++y)
    {
      const auto bit = static_cast<unsigned>(begin + SignRow::Margin);
      const std::uint64_t bits = inside[static_cast<std::size_t>(y)];
      slice.At(y).Words[bit / 64] |= bits << (bit % 64);
      if (bit % 64 > 32 && bit / 64 == 0)
      {
        slice.At(y).Words[1] |= bits >> (64 - bit % 64);
      }
    }
  }
}

} // namespace

class EdgeIndexEncoder::Work
{
public:
  Work(const EdgeIndexHeader& header, BlockModel* learning)
    : Header(header)
    , Learning(learning)
    , Mixed(header.Settings.Profile == EdgeIndexProfile::Default)
    , Fresh(Mixed)
    , Model(Mixed)
  {
  }

  void EncodeValues(SampledBlock& block, EdgeIndexRecord& record, std::vector<std::uint8_t>& code)
  {
    const double isovalue = this->Header.Isovalues[record.Isovalue];
    const double distance = block.MeasureDistance();
    std::optional<Quantizer> quantizer;
    std::optional<ValueDomain> domain;
    if (this->Header.Settings.Mode == EdgeIndexMode::Quantized)
    {
      quantizer.emplace(this->Header.Settings, isovalue);
      record.Scale = std::clamp(ChooseScale(distance / quantizer->GetStep()), -30, 10);
      domain.emplace(quantizer->MakeDomain(record.Scale));
    }
    else
    {
      domain.emplace(this->Header.Type, isovalue, 0);
      record.Scale = ChooseScale(distance);
      if (domain->GetKind() == ValueDomain::Kind::Offsets)
      {
        record.Scale = std::clamp(record.Scale, -30, 10);
      }
      domain.emplace(this->Header.Type, isovalue, record.Scale);
    }
    block.SetQuantizer(quantizer ? &*quantizer : nullptr);
    block.SetDomain(&*domain);
    record.Coding = BlockCoding::Values;
    record.HasMissing = false;
    this->Run(block, code, [&](auto& coder) { coder.CodeValues(*domain, block); });
  }

  void EncodeCrossings(
    SampledBlock& block, EdgeIndexRecord& record, std::vector<std::uint8_t>& code)
  {
    record.Coding = BlockCoding::Crossings;
    record.HasMissing = block.HasMissingCrossings();
    this->Run(block, code,
      [&](auto& coder)
      { coder.CodeCrossings(this->Header.GetNumberOfBins(), record.HasMissing, block); });
  }

  const EdgeIndexHeader Header;

private:
  template <typename Functor>
  void Run(SampledBlock& block, std::vector<std::uint8_t>& code, const Functor& functor)
  {
    if (!this->Learning)
    {
      this->Model = this->Fresh;
    }
    BlockModel& model = this->Learning ? *this->Learning : this->Model;
    RangeEncoder encoder(code);
    if (this->Mixed)
    {
      BlockCoder<RangeEncoder, true> coder(encoder, model, block.GetSize());
      functor(coder);
    }
    else
    {
      BlockCoder<RangeEncoder, false> coder(encoder, model, block.GetSize());
      functor(coder);
    }
    encoder.Finish();
  }

  BlockModel* Learning;
  bool Mixed;
  BlockModel Fresh;
  BlockModel Model;
};

EdgeIndexEncoder::EdgeIndexEncoder(const EdgeIndexHeader& header, BlockModel* learning)
  : Worker(std::make_unique<Work>(header, learning))
{
}

EdgeIndexEncoder::~EdgeIndexEncoder() = default;

Status EdgeIndexEncoder::EncodeBlock(const Index3& lattice, const BlockSamples& samples,
  std::size_t isovalue, std::vector<std::uint8_t>& bytes)
{
  const EdgeIndexHeader& header = this->Worker->Header;
  const SampleView& view = samples.Scalars;
  const Index3 size = view.Box.GetSize();
  const Index3 dimensions = header.Geometry.GetDimensions();
  bool flat = false;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    if (size[axis] < 1 || size[axis] > MaximumCodedVertices || view.Box.Low[axis] < 0 ||
      view.Box.High[axis] > dimensions[axis])
    {
      return { StatusCode::InvalidArgument,
        "A block to encode must lie within the grid and have at most 64 cells a side." };
    }
    flat = flat || size[axis] == 1;
  }
  if (!view.First || view.Type != header.Type || !(view.Available.Intersect(view.Box) == view.Box))
  {
    return { StatusCode::InvalidArgument,
      "The samples of a block to encode are missing or of another type." };
  }
  if (isovalue >= header.Isovalues.size())
  {
    return { StatusCode::InvalidArgument, "There is no such isovalue in the stream." };
  }
  if (flat)
  {
    return Status::Ok(); // no cells, no surface
  }
  SampledBlock block(view, header.Isovalues[isovalue], header.GetNumberOfBins());
  if (!block.IsCrossed())
  {
    return Status::Ok();
  }
  EdgeIndexRecord record;
  record.Isovalue = isovalue;
  record.Vertices = view.Box;
  record.Lattice = lattice;
  std::vector<std::uint8_t> code;
  const EdgeIndexMode mode = header.Settings.Mode;
  if (mode != EdgeIndexMode::Bounded)
  {
    this->Worker->EncodeValues(block, record, code);
  }
  if (mode == EdgeIndexMode::Bounded || mode == EdgeIndexMode::Smallest)
  {
    EdgeIndexRecord other = record;
    std::vector<std::uint8_t> otherCode;
    this->Worker->EncodeCrossings(block, other, otherCode);
    if (mode == EdgeIndexMode::Bounded || otherCode.size() < code.size())
    {
      record = other;
      code = std::move(otherCode);
    }
  }
  record.Code = code.data();
  record.CodeSize = code.size();
  record.Append(bytes);
  return Status::Ok();
}

namespace
{

// The records of a block, by isovalue.
using BlockBytes = std::vector<std::vector<std::uint8_t>>;

Result<std::vector<std::uint8_t>> EncodeWithinMemory(
  const EdgeIndexHeader& header, BlockSource& source, int threads, const Progress& progress)
{
  ISOSURFACE_RETURN_IF_ERROR(header.Check());
  const std::size_t count = source.GetNumberOfBlocks();
  std::vector<BlockBytes> blocks(count);
  std::vector<std::unique_ptr<EdgeIndexEncoder>> encoders(
    static_cast<std::size_t>(std::max(1, threads)));
  Status failure;
  std::atomic<bool> failed{ false };
  std::mutex mutex;
  const auto encode = [&](std::size_t block, std::unique_ptr<EdgeIndexEncoder>& encoder)
  {
    if (!encoder)
    {
      encoder = std::make_unique<EdgeIndexEncoder>(header);
    }
    const Result<BlockSamples> samples = source.Acquire(block);
    if (!samples.IsOk())
    {
      return samples.GetStatus();
    }
    blocks[block].resize(header.Isovalues.size());
    for (std::size_t isovalue = 0; isovalue < header.Isovalues.size(); ++isovalue)
    {
      ISOSURFACE_RETURN_IF_ERROR(encoder->EncodeBlock(
        source.GetLatticeCoordinates(block), *samples, isovalue, blocks[block][isovalue]));
    }
    return Status::Ok();
  };
  const bool finished = ParallelFor(
    count, threads,
    [&](std::size_t block, int thread)
    {
      if (failed)
      {
        return;
      }
      Status status = encode(block, encoders[static_cast<std::size_t>(thread)]);
      if (!status.IsOk())
      {
        const std::lock_guard<std::mutex> lock(mutex);
        if (!failed.exchange(true))
        {
          failure = std::move(status);
        }
      }
    },
    progress);
  if (!failure.IsOk())
  {
    return failure;
  }
  if (!finished)
  {
    return Status(StatusCode::Aborted, "The encoding was stopped.");
  }
  std::vector<std::uint8_t> bytes;
  header.Append(bytes);
  for (std::size_t isovalue = 0; isovalue < header.Isovalues.size(); ++isovalue)
  {
    for (BlockBytes& block : blocks)
    {
      bytes.insert(bytes.end(), block[isovalue].begin(), block[isovalue].end());
      std::vector<std::uint8_t>().swap(block[isovalue]);
    }
  }
  return bytes;
}

} // namespace

Result<std::vector<std::uint8_t>> EncodeSurface(
  const EdgeIndexHeader& header, BlockSource& source, int threads, const Progress& progress)
{
  try
  {
    return EncodeWithinMemory(header, source, threads, progress);
  }
  catch (const std::bad_alloc&)
  {
    return Status(StatusCode::OutOfMemory, "There is not enough memory to encode the isosurface.");
  }
}

} // namespace isosurface
