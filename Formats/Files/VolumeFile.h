// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeFile_h
#define isosurface_VolumeFile_h

#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/BoxSource.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/GridPlace.h"
#include "Ground/Volume/VertexBox.h"
#include "Storage/Store/SourceRecord.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

class BlockedVolume;

/// What is in a file that can be opened.
enum class FileKind : std::uint8_t
{
  BlockedVolume, ///< a .bvol
  Surface,       ///< an edge-index file, for SurfaceFile
  Source         ///< a volume of another format, or a file that no format reads
};

/// Looks at the name (VolumeName.h) and the first bytes. Error: NotFound if there is no such file or folder.
Result<FileKind> FindFileKind(const std::string& name);

/// How a volume of another format is opened.
struct OpeningChoice
{
  std::string Axes;        ///< VolumeChoice::Axes
  std::string IndexFolder; ///< where its index may be; empty: beside it
  int Threads = 0;         ///< of GetBlocks, as BlockedVolumeSettings::Threads
  GridPlace Place = {};    ///< also of a blocked volume
  /// A box of the world, x0 x1 y0 y1 z0 z1: only the part of another format that has it (FindPart).
  std::optional<std::array<double, 6>> Bounds = {};
  bool HasLocalStores = false; ///< BlockedVolume::SetLocalStores
};

/// One level of a volume.
struct LevelDescription
{
  GridGeometry Grid;
  std::optional<GridLines> Lines; ///< of a rectilinear grid
  Index3 Chunk{ 1, 1, 1 };        ///< the vertices that are best read together, not beyond the grid

  /// The vertices around a box of the world, two or more on each axis that has them; the first ones, if the box is
  /// beside the grid.
  VertexBox FindVerticesAround(
    const std::array<double, 3>& low, const std::array<double, 3>& high) const;
};

/// Samples of an array at every Step-th vertex of a box, which is not empty, from its low corner.
struct SampleRequest
{
  std::size_t Array = 0;
  std::vector<int> Components; ///< in the order of the result; some of the array's
  std::size_t TimeStep = 0;
  int Level = 0;
  VertexBox Box; ///< within the level
  Index3 Step{ 1, 1, 1 };
  int Threads = 1;

  /// Where the chosen component's samples go in a result of tuples, x fastest.
  void* FindPlace(void* samples, std::size_t number, ValueType type) const
  {
    return static_cast<char*>(samples) + number * GetValueSize(type);
  }
};

/**
 * A volume in a file, of which samples are read. All functions may be called by several threads at
 * once. Errors name the file.
 */
class VolumeFile
{
public:
  virtual ~VolumeFile() = default;

  /**
   * Opens a blocked volume, or a file or folder of another format: by its index, if there is one of the
   * file as it is now, else as it is. Errors and cost: BlockedVolume::Open, OpenForeignVolume.
   */
  static Result<std::shared_ptr<VolumeFile>> Open(
    const std::string& name, const OpeningChoice& choice = {});

  virtual const std::string& GetPath() const = 0;
  virtual const std::vector<ArrayDescription>& GetArrays() const = 0;
  /// Of all time steps, of which there is at least one.
  virtual const std::vector<std::optional<double>>& GetTimes() const = 0;
  virtual int GetNumberOfLevels() const = 0;
  /// OpenedVolume::LeftOut, where a file of another format was opened.
  virtual std::string GetLeftOut() const { return {}; }
  virtual LevelDescription Describe(int level) const = 0;

  /// Fills `samples` with tuples of the chosen components. The request must be within the volume.
  virtual Status Read(const SampleRequest& request, void* samples, const Progress& progress) = 0;

  /// The samples of a time step, to write another volume of. Takes at most `memoryBytes` of memory.
  virtual Result<std::unique_ptr<BoxSource>> OpenSource(
    std::size_t timeStep, int threads, std::uint64_t memoryBytes) = 0;

  /// The files that the samples of a time step come from, after OpenSource(). None of a blocked
  /// volume, whose checksums tell a change.
  virtual SourceFiles GetSourceFiles(std::size_t) { return {}; }

  /// The time step in blocks, to be searched for isosurfaces. `stepThere` becomes its number there.
  virtual Result<std::shared_ptr<BlockedVolume>> GetBlocks(
    std::size_t timeStep, const Progress& progress, std::size_t& stepThere) = 0;
  /// Whether GetBlocksOf() reads less than the whole volume.
  virtual bool GivesParts() const { return false; }
  /// The same, perhaps of that part of the volume alone which is a box of vertices, and has blocks that begin at
  /// multiples of their size from the box's corner. `first` becomes the volume's vertex that is the first one there.
  virtual Result<std::shared_ptr<BlockedVolume>> GetBlocksOf(std::size_t timeStep,
    const VertexBox& /*box*/, const Progress& progress, std::size_t& stepThere, Index3& /*first*/)
  {
    return this->GetBlocks(timeStep, progress, stepThere);
  }
};

} // namespace isosurface

#endif
