// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Indexing/SourceSample.h"

#include "Ground/Base/Communicator.h"
#include "Ground/Base/MemoryFileSystem.h"
#include "Ground/Volume/MemorySource.h"
#include "Ground/Volume/SampleCopy.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <cmath>

namespace isosurface
{
namespace
{

/// For writing the volume of a sample, and for what is written.
constexpr std::uint64_t WriteBytes = std::uint64_t{ 1 } << 30;

/// The grid of a lattice's vertices.
GridGeometry MakeGrid(const GridGeometry& from, const Lattice& lattice)
{
  GridGeometry grid = from;
  const VertexBox numbers = lattice.GetNumbers();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double first =
      static_cast<double>(from.Extent[2 * axis] + numbers.Low[axis] * lattice.Step[axis]);
    for (std::size_t row = 0; row < 3; ++row)
    {
      grid.Origin[row] += from.Direction[3 * row + axis] * from.Spacing[axis] * first;
    }
    grid.Extent[2 * axis] = 0;
    grid.Extent[2 * axis + 1] = numbers.GetSize()[axis] - 1;
    grid.Spacing[axis] *= static_cast<double>(lattice.Step[axis]);
  }
  return grid;
}

GridLines MakeLines(const GridLines& from, const Lattice& lattice)
{
  GridLines lines;
  const VertexBox numbers = lattice.GetNumbers();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    for (std::int64_t number = numbers.Low[axis]; number < numbers.High[axis]; ++number)
    {
      lines.Coordinates[axis].push_back(from.At(axis, number * lattice.Step[axis]));
    }
  }
  return lines;
}

/// A blocked volume and the files in memory that have it.
struct VolumeInMemory
{
  VolumeInMemory(FileSystem& files, const std::string& path)
    : Files(files, path, WriteBytes)
  {
  }

  MemoryFileSystem Files;
  std::shared_ptr<BlockedVolume> Volume; ///< goes before its files
};

std::string Describe(const Index3& step, double share, int level, const std::string& part)
{
  std::string text =
    level > 0 ? "level " + std::to_string(level) + " of the file, whose samples are averages" : "";
  if (step != Index3{ 1, 1, 1 })
  {
    text += (text.empty() ? "one of " : ", one of ") + std::to_string(step[0]) + " x " +
      std::to_string(step[1]) + " x " + std::to_string(step[2]) + " samples";
  }
  if (share < 1)
  {
    text += (text.empty() ? "" : ", ") + ("the " + part) + " " +
      std::to_string(static_cast<int>(std::ceil(100 * share))) + " %";
  }
  return text.empty() ? "all samples" : text;
}

} // namespace

SampledVolume::SampledVolume(const OpenedVolume& volume, std::size_t step)
  : Grid(volume.Grid)
  , Lines(volume.Lines)
  , Arrays(volume.Arrays)
  , Types(ArrayVariables(volume.Arrays).GetStoredTypes())
  , Box(volume.Source->GetBox())
  , Level(volume.Level)
  , Step(step)
  , Time(step < volume.Times.size() ? std::make_optional(volume.Times[step]) : std::nullopt)
{
}

Result<SourceSample> MakeSourceSample(FileSystem& files, const SourceIndex& index,
  const SampledVolume& of, const Lattice& lattice,
  const std::vector<std::vector<std::uint8_t>>& samples, const std::string& part)
{
  VolumePiece piece;
  piece.Box = { { 0, 0, 0 }, lattice.GetNumbers().GetSize() };
  for (std::size_t variable = 0; variable < of.Types.size(); ++variable)
  {
    piece.Arrays.push_back(MakeSampleView(of.Types[variable], piece.Box, samples[variable].data()));
  }
  BlockedVolumeSettings settings;
  settings.NumberOfStores = 1;
  settings.Distribution = DistributionMethod::Slab;
  settings.MemoryLimit = WriteBytes;
  settings.Time = of.Time;
  if (of.Lines)
  {
    settings.Lines = MakeLines(*of.Lines, lattice);
  }
  GridGeometry grid = of.Grid;
  ISOSURFACE_RETURN_IF_ERROR(index.Place.Apply(index.Source, of.Lines.has_value(), grid));
  const std::string path = index.Path + "-sample";
  const auto memory = std::make_shared<VolumeInMemory>(files, path);
  SerialCommunicator alone;
  ISOSURFACE_RETURN_IF_ERROR(BlockedVolumeWriter(alone, memory->Files)
                               .Write(path, MakeGrid(grid, lattice), of.Arrays, piece, settings)
                               .GetStatus());
  ISOSURFACE_ASSIGN_OR_RETURN(memory->Volume, BlockedVolume::Open(path, memory->Files));
  SourceSample sample;
  sample.Volume = std::shared_ptr<BlockedVolume>(memory, memory->Volume.get());
  sample.WholeStep = lattice.Step;
  sample.Step = of.Step;
  sample.Level = of.Level;
  sample.Vertices = piece.Box.GetNumberOfVertices();
  sample.Share = static_cast<double>(lattice.Box.GetNumberOfVertices()) /
    static_cast<double>(of.Box.GetNumberOfVertices());
  sample.IsWhole = of.Level == 0 && lattice.Step == Index3{ 1, 1, 1 } && lattice.Box == of.Box;
  sample.Text = Describe(lattice.Step, sample.Share, of.Level, part);
  return sample;
}

} // namespace isosurface
