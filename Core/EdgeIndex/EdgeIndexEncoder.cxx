// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/EdgeIndexEncoder.h"

#include "Base/ParallelFor.h"
#include "Contour/BrickKernel.h"
#include "EdgeIndex/BlockCoding.h"
#include "EdgeIndex/BlockRecordFormat.h"
#include "EdgeIndex/PointAttributes.h"
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

  const std::array<int, 3>& GetSize() const { return this->Size; }
  std::uint32_t GetBins() const { return this->Bins; }
  bool IsCrossed() const { return this->Crossed; }
  std::uint64_t CountPoints() const
  {
    std::uint64_t points = 0;
    this->VisitCrossedRows(
      [&points](int, int, const SignRow(&edges)[3])
      {
        for (const SignRow& row : edges)
        {
          points += static_cast<std::uint64_t>(
            __builtin_popcountll(row.Words[0]) + __builtin_popcountll(row.Words[1]));
        }
        return true;
      });
    return points;
  }
  void SetDomain(const ValueDomain* domain) { this->Domain = domain; }
  void SetQuantizer(const Quantizer* quantizer) { this->Quantization = quantizer; }

  /// The point arrays that are coded with the block; none unless set.
  void SetAttributes(
    const std::vector<EdgeIndexAttribute>& attributes, const PointAttributes& tuples)
  {
    for (std::size_t n = 0; n < attributes.size(); ++n)
    {
      this->Attributes.push_back({ attributes[n], tuples.GetEdges()[n],
        this->HasExceptions(attributes[n], tuples.GetEdges()[n]) });
    }
  }
  const std::vector<CodedAttribute>& GetAttributes() const { return this->Attributes; }

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
    DispatchValueType(this->View.Type,
      [&](auto zero)
      {
        using T = decltype(zero);
        VisitBits(vertices,
          [&](int x) {
            codes[x] = this->Domain->ToCode(*reinterpret_cast<const T*>(row + x * this->Stride[0]));
          });
      });
  }

  void ExchangeBins(int axis, int y, int z, const SignRow& edges, std::uint32_t* bins) override
  {
    const std::uint8_t* row = this->At(0, y, z);
    DispatchValueType(this->View.Type,
      [&](auto zero)
      {
        VisitBits(edges,
          [&](int x)
          {
            const std::uint8_t* from = row + x * this->Stride[0];
            bins[x] = FindBin(this->FindTypedCrossing<decltype(zero)>(from, axis), this->Bins);
          });
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
  // Whether some value at a crossed edge has no code.
  bool HasExceptions(const EdgeIndexAttribute& attribute, const AttributeEdges& edges) const
  {
    const AttributeDomain domain(attribute);
    if (attribute.MaximumError == 0)
    {
      return false;
    }
    const auto components = static_cast<std::size_t>(attribute.NumberOfComponents);
    bool found = false;
    this->VisitCrossedRows(
      [&](int y, int z, const SignRow(&rows)[3])
      {
        const std::ptrdiff_t row = (std::ptrdiff_t(z) * this->Size[1] + y) * this->Size[0];
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
          VisitBits(rows[axis],
            [&](int x)
            {
              const std::uint8_t* tuple = edges.First[axis] +
                static_cast<std::size_t>(row + x) * components * domain.GetValueSize();
              for (std::size_t n = 0; n < components; ++n)
              {
                found = found || !domain.HasCode(tuple + n * domain.GetValueSize());
              }
            });
        }
        return !found;
      });
    return found;
  }

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

  template <typename T>
  double FindTypedCrossing(const std::uint8_t* from, int axis) const
  {
    return FindParameter(this->Isovalue, *reinterpret_cast<const T*>(from),
      *reinterpret_cast<const T*>(from + this->Stride[static_cast<std::size_t>(axis)]));
  }
  double FindCrossing(const std::uint8_t* from, int axis) const
  {
    return DispatchValueType(this->View.Type,
      [&](auto zero) { return this->FindTypedCrossing<decltype(zero)>(from, axis); });
  }

  // Calls functor(y, z, crossed edges along each axis) for rows until it returns false.
  template <typename Functor>
  void VisitCrossedRows(const Functor& functor) const
  {
    const SignRow vertices = SignRow::MakeMask(this->Size[0]);
    const SignRow cells = SignRow::MakeMask(this->Size[0] - 1);
    for (int z = 0; z < this->Size[2]; ++z)
    {
      const SignSlice& slice = this->Signs[static_cast<std::size_t>(z)];
      for (int y = 0; y < this->Size[1]; ++y)
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
        if (!functor(y, z, edges))
        {
          return;
        }
      }
    }
  }

  // Calls functor(first sample, axis) for crossed edges until it returns false.
  template <typename Functor>
  void VisitCrossings(const Functor& functor) const
  {
    this->VisitCrossedRows(
      [&](int y, int z, const SignRow(&edges)[3])
      {
        bool goesOn = true;
        for (int axis = 0; axis < 3; ++axis)
        {
          VisitBits(
            edges[axis], [&](int x) { goesOn = goesOn && functor(this->At(x, y, z), axis); });
        }
        return goesOn;
      });
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
  std::vector<CodedAttribute> Attributes;
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
    , Preview(header.MakePreview())
    , Learning(learning)
    , Model(GetFreshModel(header.Settings.Profile != EdgeIndexProfile::Fast))
    , PreviewModel(GetFreshModel(false))
  {
  }

  void EncodeValues(SampledBlock& block, EdgeIndexRecord& record, std::vector<std::uint8_t>& code)
  {
    const double isovalue = this->Header.Isovalues[record.Block.Isovalue];
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
    record.Block.Coding = BlockCoding::Values;
    record.Block.HasMissing = false;
    BlockContent content;
    content.Domain = &*domain;
    content.IsFitted = this->Header.Settings.Profile == EdgeIndexProfile::Compact;
    this->Run(block, record.Block.IsPreview, content, code);
  }

  void EncodeCrossings(
    SampledBlock& block, EdgeIndexRecord& record, std::vector<std::uint8_t>& code)
  {
    record.Block.Coding = BlockCoding::Crossings;
    record.Block.HasMissing = block.HasMissingCrossings();
    BlockContent content;
    content.Bins = block.GetBins();
    content.HasMissing = record.Block.HasMissing;
    this->Run(block, record.Block.IsPreview, content, code);
  }

  /// Appends the record of a block that is crossed.
  void Encode(SampledBlock& block, EdgeIndexMode mode, EdgeIndexRecord& record,
    std::vector<std::uint8_t>& bytes)
  {
    record.Block.NumberOfPoints = block.CountPoints();
    std::vector<std::uint8_t> code;
    if (mode != EdgeIndexMode::Bounded)
    {
      this->EncodeValues(block, record, code);
    }
    if (mode == EdgeIndexMode::Bounded || mode == EdgeIndexMode::Smallest)
    {
      EdgeIndexRecord other = record;
      std::vector<std::uint8_t> otherCode;
      this->EncodeCrossings(block, other, otherCode);
      if (mode == EdgeIndexMode::Bounded || otherCode.size() < code.size())
      {
        record = other;
        code = std::move(otherCode);
      }
    }
    record.Code = code.data();
    record.CodeSize = code.size();
    record.Append(bytes);
  }

  /// The same for what of the block belongs to the preview, if anything does.
  void EncodePreview(
    const SampleView& view, EdgeIndexRecord record, std::vector<std::uint8_t>& bytes)
  {
    const std::int64_t step = std::int64_t{ 1 } << this->Header.PreviewLevel;
    const std::optional<SampleView> coarse = Coarsen(view, step);
    if (!coarse)
    {
      return;
    }
    const double isovalue = this->Preview.Isovalues[record.Block.Isovalue];
    SampledBlock block(*coarse, isovalue, this->Preview.GetNumberOfBins());
    if (block.IsCrossed())
    {
      record.Block.Vertices = coarse->Box;
      record.Block.IsPreview = true;
      this->Encode(block, EdgeIndexMode::Bounded, record, bytes);
    }
  }

  const EdgeIndexHeader Header;
  const EdgeIndexHeader Preview;

private:
  // Every step-th vertex; nothing if the block does not begin at one or has too few for cells.
  static std::optional<SampleView> Coarsen(const SampleView& view, std::int64_t step)
  {
    SampleView coarse = view;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      coarse.Stride[axis] *= static_cast<std::ptrdiff_t>(step);
      coarse.Box.Low[axis] = view.Box.Low[axis] / step;
      coarse.Box.High[axis] = (view.Box.High[axis] - 1) / step + 1;
      if (view.Box.Low[axis] % step != 0 || coarse.Box.High[axis] - coarse.Box.Low[axis] < 2)
      {
        return std::nullopt;
      }
    }
    coarse.Available = coarse.Box;
    DispatchValueType(
      view.Type, [&](auto zero) { coarse.First = view.At<decltype(zero)>(view.Box.Low); });
    return coarse;
  }

  void Run(
    SampledBlock& block, bool isPreview, BlockContent& content, std::vector<std::uint8_t>& code)
  {
    content.Size = block.GetSize();
    content.Attributes = block.GetAttributes();
    BlockModel& model = isPreview ? this->PreviewModel : this->Model;
    model.Reset(content.Domain != nullptr);
    RangeEncoder encoder(code);
    CodeBlock(encoder, this->Learning ? *this->Learning : model, content, block);
    encoder.Finish();
  }

  BlockModel* Learning;
  BlockModel Model;
  BlockModel PreviewModel;
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
  record.Block.Isovalue = isovalue;
  record.Block.Vertices = view.Box;
  record.Block.Lattice = lattice;
  if (header.PreviewLevel > 0)
  {
    this->Worker->EncodePreview(view, record, bytes);
  }
  PointAttributes attributes(header, view.Box);
  if (!header.Attributes.empty())
  {
    ISOSURFACE_RETURN_IF_ERROR(attributes.Interpolate(header, samples, isovalue));
    block.SetAttributes(header.Attributes, attributes);
  }
  this->Worker->Encode(block, header.Settings.Mode, record, bytes);
  return Status::Ok();
}

namespace
{

// Encodes batches of blocks in parallel, and hands them on in their order.
class BatchEncoding
{
public:
  BatchEncoding(const EdgeIndexHeader& header, BlockSource& source, int threads)
    : Header(header)
    , Source(source)
    , Threads(std::max(1, threads))
    , Encoders(static_cast<std::size_t>(Threads))
  {
  }

  Status Run(
    const std::function<Status(const std::vector<std::uint8_t>&)>& take, const Progress& progress)
  {
    const std::size_t count = this->Source.GetNumberOfBlocks();
    const std::size_t batch = BlocksPerThread * static_cast<std::size_t>(this->Threads);
    std::vector<std::uint8_t> joined;
    for (std::size_t first = 0; first < count; first += batch)
    {
      const std::size_t size = std::min(batch, count - first);
      Progress part;
      if (progress)
      {
        part = [&](double share)
        {
          return progress((static_cast<double>(first) + share * static_cast<double>(size)) /
            static_cast<double>(count));
        };
      }
      ISOSURFACE_RETURN_IF_ERROR(this->EncodeBatch(first, size, part));
      joined.clear();
      for (std::vector<std::uint8_t>& block : this->Blocks)
      {
        joined.insert(joined.end(), block.begin(), block.end());
      }
      ISOSURFACE_RETURN_IF_ERROR(take(joined));
    }
    return Status::Ok();
  }

private:
  static constexpr std::size_t BlocksPerThread = 16;

  Status EncodeBatch(std::size_t first, std::size_t size, const Progress& progress)
  {
    this->Blocks.assign(size, {});
    Status failure;
    std::atomic<bool> failed{ false };
    std::mutex mutex;
    const bool finished = ParallelFor(
      size, this->Threads,
      [&](std::size_t block, int thread)
      {
        if (failed)
        {
          return;
        }
        Status status = this->Encode(
          first + block, this->Encoders[static_cast<std::size_t>(thread)], this->Blocks[block]);
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
    if (failure.IsOk() && !finished)
    {
      return { StatusCode::Aborted, "The encoding was stopped." };
    }
    return failure;
  }

  Status Encode(
    std::size_t block, std::unique_ptr<EdgeIndexEncoder>& encoder, std::vector<std::uint8_t>& bytes)
  {
    if (!encoder)
    {
      encoder = std::make_unique<EdgeIndexEncoder>(this->Header);
    }
    const Result<BlockSamples> samples = this->Source.Acquire(block);
    if (!samples.IsOk())
    {
      return samples.GetStatus();
    }
    for (std::size_t isovalue = 0; isovalue < this->Header.Isovalues.size(); ++isovalue)
    {
      ISOSURFACE_RETURN_IF_ERROR(
        encoder->EncodeBlock(this->Source.GetLatticeCoordinates(block), *samples, isovalue, bytes));
    }
    return Status::Ok();
  }

  const EdgeIndexHeader& Header;
  BlockSource& Source;
  int Threads;
  std::vector<std::unique_ptr<EdgeIndexEncoder>> Encoders;
  std::vector<std::vector<std::uint8_t>> Blocks;
};

} // namespace

Status EncodeBlocks(const EdgeIndexHeader& header, BlockSource& source, int threads,
  const std::function<Status(const std::vector<std::uint8_t>& records)>& take,
  const Progress& progress)
{
  ISOSURFACE_RETURN_IF_ERROR(header.Check());
  try
  {
    return BatchEncoding(header, source, threads).Run(take, progress);
  }
  catch (const std::bad_alloc&)
  {
    return { StatusCode::OutOfMemory, "There is not enough memory to encode the isosurface." };
  }
}

Result<std::vector<std::uint8_t>> EncodeSurface(
  const EdgeIndexHeader& header, BlockSource& source, int threads, const Progress& progress)
{
  std::vector<std::uint8_t> bytes;
  header.Append(bytes);
  const Status status = EncodeBlocks(
    header, source, threads,
    [&bytes](const std::vector<std::uint8_t>& records)
    {
      bytes.insert(bytes.end(), records.begin(), records.end());
      return Status::Ok();
    },
    progress);
  if (!status.IsOk())
  {
    return status;
  }
  return bytes;
}

} // namespace isosurface
