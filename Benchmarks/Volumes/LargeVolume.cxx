// SPDX-License-Identifier: BSD-3-Clause
#include "Volumes/LargeVolume.h"

#include "Ground/Base/ParallelFor.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <future>
#include <limits>
#include <sstream>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::uint64_t SlabBytes = std::uint64_t{ 32 } << 20;
/// The minimum wavelength of the noise, in new samples.
constexpr double ShortestWave = 3;

/// The root mean square of uniform numbers in [-1, 1) after interpolation by cubic B-splines on
/// three axes: sqrt(1/3 * (151/315)^3).
constexpr double LatticeNoise = 0.1916;

template <typename T>
void Convert(const std::vector<float>& row, T* out)
{
  for (std::size_t i = 0; i < row.size(); ++i)
  {
    if constexpr (std::is_floating_point_v<T>)
    {
      out[i] = row[i];
    }
    else if constexpr (sizeof(T) <= 2)
    {
      // The values are in the type's range and small, so truncation rounds down.
      constexpr float shift = static_cast<float>(std::numeric_limits<T>::min());
      out[i] = static_cast<T>(static_cast<std::int32_t>(row[i] - shift + 0.5F) +
        static_cast<std::int32_t>(std::numeric_limits<T>::min()));
    }
    else
    {
      out[i] = static_cast<T>(std::floor(static_cast<double>(row[i]) + 0.5));
    }
  }
}

/// MetaIO's names of the types.
const char* GetElementType(ValueType type)
{
  constexpr std::array<const char*, 10> names = { "MET_CHAR", "MET_UCHAR", "MET_SHORT",
    "MET_USHORT", "MET_INT", "MET_UINT", "MET_LONG_LONG", "MET_ULONG_LONG", "MET_FLOAT",
    "MET_DOUBLE" };
  return names[static_cast<std::size_t>(type)];
}

Status WriteText(FileSystem& files, const std::string& path, const std::string& text)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto file, files.CreateForWriting(path));
  const Status status = file->Append(text.data(), text.size());
  return status.IsOk() ? file->SyncAndClose() : status;
}

} // namespace

/// Makes the rows of a slice. Each thread has its own.
class LargeVolume::SliceMaker
{
public:
  /// Goes to slice k.
  void SetSlice(const LargeVolume& volume, std::int64_t k)
  {
    if (this->Samplers.empty())
    {
      this->Prepare(volume);
    }
    for (LatticeSampler& sampler : this->Samplers)
    {
      sampler.SetSlice(k);
    }
  }

  /// Row j of the slice: scan + contrast * sum of octaves, clamped and scaled.
  const std::vector<float>& MakeRow(const LargeVolume& volume, std::int64_t j)
  {
    this->Samplers[0].GetRow(j, this->Row.data());
    if (this->Samplers.size() > 2)
    {
      this->AddDetail(j);
    }
    for (float& value : this->Row)
    {
      value =
        volume.Offset + volume.Scale * std::min(volume.Maximum, std::max(volume.Minimum, value));
    }
    return this->Row;
  }

private:
  void Prepare(const LargeVolume& volume)
  {
    const Index3 size = volume.Grid.GetDimensions();
    this->Samplers.emplace_back(volume.Scan, size);
    this->Samplers.emplace_back(volume.Contrast, size);
    for (const Lattice& octave : volume.Octaves)
    {
      this->Samplers.emplace_back(octave, size);
    }
    const auto width = static_cast<std::size_t>(size[0]);
    this->Row.resize(width);
    this->Detail.resize(width);
    this->Part.resize(width);
  }

  void AddDetail(std::int64_t j)
  {
    const std::size_t width = this->Row.size();
    this->Samplers[2].GetRow(j, this->Detail.data());
    for (std::size_t octave = 3; octave < this->Samplers.size(); ++octave)
    {
      this->Samplers[octave].GetRow(j, this->Part.data());
      for (std::size_t i = 0; i < width; ++i)
      {
        this->Detail[i] += this->Part[i];
      }
    }
    this->Samplers[1].GetRow(j, this->Part.data());
    for (std::size_t i = 0; i < width; ++i)
    {
      this->Row[i] += this->Detail[i] * this->Part[i];
    }
  }

  std::vector<LatticeSampler> Samplers; ///< scan, contrast, octaves
  std::vector<float> Row;
  std::vector<float> Detail;
  std::vector<float> Part; ///< a sampler's row
};

Result<LargeVolume> LargeVolume::Open(
  FileSystem& files, const RawVolume& scan, const LargeVolumeSettings& settings)
{
  const Index3 size = scan.Grid.GetDimensions();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    if (size[axis] < 2 || settings.Dimensions[axis] < 2 ||
      settings.Dimensions[axis] > std::numeric_limits<std::int32_t>::max())
    {
      return Status(StatusCode::InvalidArgument,
        "The volume and the scan need at least two samples along each axis.");
    }
  }
  LargeVolume volume;
  volume.Type = settings.Type;
  volume.Grid = scan.Grid;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    volume.Grid.Extent[2 * axis] = 0;
    volume.Grid.Extent[2 * axis + 1] = settings.Dimensions[axis] - 1;
    volume.Grid.Spacing[axis] *=
      static_cast<double>(size[axis] - 1) / static_cast<double>(settings.Dimensions[axis] - 1);
  }
  ISOSURFACE_RETURN_IF_ERROR(volume.ReadScan(files, scan));
  volume.MeasureContrast();
  volume.AddOctaves(settings);
  volume.ChooseScale(scan.Type);
  return volume;
}

Status LargeVolume::ReadScan(FileSystem& files, const RawVolume& scan)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto source, scan.Open(files));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto slab, source->Read(source->GetBox()));
  const SampleView& view = slab.Arrays[0];
  this->Scan.Size = view.Box.GetSize();
  this->Scan.IsInterpolating = true;
  this->Scan.Values.reserve(static_cast<std::size_t>(view.Box.GetNumberOfVertices()));
  DispatchValueType(view.Type,
    [&](auto zero)
    {
      for (std::int64_t k = 0; k < this->Scan.Size[2]; ++k)
      {
        for (std::int64_t j = 0; j < this->Scan.Size[1]; ++j)
        {
          for (std::int64_t i = 0; i < this->Scan.Size[0]; ++i)
          {
            const auto value = static_cast<float>(*view.At<decltype(zero)>({ i, j, k }));
            this->Scan.Values.push_back(std::isfinite(value) ? value : 0.0F);
          }
        }
      }
    });
  const auto ends = std::minmax_element(this->Scan.Values.begin(), this->Scan.Values.end());
  this->Minimum = *ends.first;
  this->Maximum = *ends.second;
  return Status::Ok();
}

/// The contrast of a sample: the range of the sample and its neighbours on the axes.
void LargeVolume::MeasureContrast()
{
  const Index3& size = this->Scan.Size;
  this->Contrast.Size = size;
  this->Contrast.Values.reserve(this->Scan.Values.size());
  const std::vector<float>& values = this->Scan.Values;
  const Index3 stride = { 1, size[0], size[0] * size[1] };
  Index3 at{};
  for (at[2] = 0; at[2] < size[2]; ++at[2])
  {
    for (at[1] = 0; at[1] < size[1]; ++at[1])
    {
      for (at[0] = 0; at[0] < size[0]; ++at[0])
      {
        const std::int64_t index = at[0] + at[1] * stride[1] + at[2] * stride[2];
        float low = values[static_cast<std::size_t>(index)];
        float high = low;
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
          for (const std::int64_t step : { -1, 1 })
          {
            if (at[axis] + step >= 0 && at[axis] + step < size[axis])
            {
              const float value = values[static_cast<std::size_t>(index + step * stride[axis])];
              low = std::min(low, value);
              high = std::max(high, value);
            }
          }
        }
        this->Contrast.Values.push_back(high - low);
      }
    }
  }
}

void LargeVolume::AddOctaves(const LargeVolumeSettings& settings)
{
  // The contrast is that of two distances between samples.
  this->Contrast.Amplitude = static_cast<float>(settings.Detail / 2);
  const Index3 dimensions = this->Grid.GetDimensions();
  double amplitude = 1 / LatticeNoise;
  for (std::int64_t fold = 1;; fold *= 2, amplitude /= 2)
  {
    Lattice octave;
    octave.Seed = settings.Seed + static_cast<std::uint64_t>(fold) * 0x9E3779B97F4A7C15u;
    octave.Amplitude = static_cast<float>(amplitude);
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      octave.Size[axis] = fold * (this->Scan.Size[axis] - 1) + 1;
      if (static_cast<double>(dimensions[axis] - 1) <
        ShortestWave / 2 * static_cast<double>(octave.Size[axis] - 1))
      {
        return;
      }
    }
    this->Octaves.push_back(std::move(octave));
  }
}

void LargeVolume::ChooseScale(ValueType scanType)
{
  if (this->Type == scanType || this->Minimum == this->Maximum)
  {
    return;
  }
  const double maximum = DispatchValueType(this->Type,
    [](auto zero)
    {
      using T = decltype(zero);
      return std::is_floating_point_v<T>
        ? 1.0
        : std::min(16777216.0, static_cast<double>(std::numeric_limits<T>::max()));
    });
  this->Scale = static_cast<float>(maximum / (double{ this->Maximum } - double{ this->Minimum }));
  this->Offset = -this->Minimum * this->Scale;
}

void LargeVolume::FillSlices(std::int64_t begin, std::int64_t end, int threads, void* samples) const
{
  const Index3 size = this->Grid.GetDimensions();
  const auto width = static_cast<std::size_t>(size[0]);
  std::vector<SliceMaker> makers(static_cast<std::size_t>(threads));
  ParallelFor(static_cast<std::size_t>(end - begin), threads,
    [&](std::size_t slice, int thread)
    {
      SliceMaker& maker = makers[static_cast<std::size_t>(thread)];
      maker.SetSlice(*this, begin + static_cast<std::int64_t>(slice));
      DispatchValueType(this->Type,
        [&](auto zero)
        {
          auto* out = static_cast<decltype(zero)*>(samples) +
            slice * width * static_cast<std::size_t>(size[1]);
          for (std::int64_t j = 0; j < size[1]; ++j, out += width)
          {
            Convert(maker.MakeRow(*this, j), out);
          }
        });
    });
}

Status LargeVolume::Write(FileSystem& files, const std::string& path, int threads) const
{
  const std::filesystem::path rawPath = std::filesystem::path(path).replace_extension(".raw");
  ISOSURFACE_ASSIGN_OR_RETURN(auto file, files.CreateForWriting(rawPath.string()));
  const Index3 size = this->Grid.GetDimensions();
  const std::uint64_t sliceBytes =
    static_cast<std::uint64_t>(size[0] * size[1]) * GetValueSize(this->Type);
  const auto slices =
    std::max<std::int64_t>(threads, static_cast<std::int64_t>(SlabBytes / sliceBytes));
  std::array<std::vector<std::uint8_t>, 2> slabs;
  std::future<Status> writing;
  Status status;
  std::size_t turn = 0;
  for (std::int64_t k = 0; k < size[2] && status.IsOk(); k += slices, turn = 1 - turn)
  {
    const std::int64_t end = std::min(size[2], k + slices);
    std::vector<std::uint8_t>& slab = slabs[turn];
    slab.resize(static_cast<std::size_t>(end - k) * sliceBytes);
    this->FillSlices(k, end, threads, slab.data());
    if (writing.valid())
    {
      status = writing.get();
    }
    writing = std::async(std::launch::async,
      [&target = *file, &slab] { return target.Append(slab.data(), slab.size()); });
  }
  const Status last = writing.valid() ? writing.get() : Status::Ok();
  status = status.IsOk() ? last : status;
  status = status.IsOk() ? file->SyncAndClose() : status;
  ISOSURFACE_RETURN_IF_ERROR(status);
  return WriteText(files, path, this->MakeHeader(rawPath.filename().string()));
}

std::string LargeVolume::MakeHeader(const std::string& rawName) const
{
  const Index3 size = this->Grid.GetDimensions();
  std::ostringstream header;
  header.precision(17);
  header << "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
         << "CompressedData = False\nTransformMatrix =";
  for (std::size_t column = 0; column < 3; ++column)
  {
    for (std::size_t row = 0; row < 3; ++row)
    {
      header << ' ' << this->Grid.Direction[3 * row + column];
    }
  }
  header << "\nOffset = " << this->Grid.Origin[0] << ' ' << this->Grid.Origin[1] << ' '
         << this->Grid.Origin[2] << "\nElementSpacing = " << this->Grid.Spacing[0] << ' '
         << this->Grid.Spacing[1] << ' ' << this->Grid.Spacing[2] << "\nDimSize = " << size[0]
         << ' ' << size[1] << ' ' << size[2] << "\nElementType = " << GetElementType(this->Type)
         << "\nElementDataFile = " << rawName << "\n";
  return header.str();
}

RawVolume FindDebianScan()
{
  // NIfTI-1: a header of 348 bytes, four bytes that mean "no extension", the samples.
  RawVolume scan;
  scan.Grid.Extent = { 0, 180, 0, 216, 0, 180 };
  scan.Grid.Origin = { -90, -125, -71 };
  scan.Type = ValueType::UInt8;
  scan.ArrayName = "T1";
  scan.IsGzip = true;
  scan.Skip = 352;
  scan.Paths = { "/usr/share/mricron/templates/ch2.nii.gz" };
  return scan;
}

} // namespace isosurface
