// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SourceVolume_h
#define isosurface_SourceVolume_h

#include "Formats/Files/VolumeFile.h"

#include "Ground/Base/FileSystem.h"
#include "Ground/Volume/VolumeOpener.h"

#include <map>
#include <mutex>

namespace isosurface
{

/// A volume in files of another format, without an index: it has one level.
class SourceVolume : public VolumeFile
{
public:
  /// The first time step is opened at once. Errors and cost: OpenForeignVolume, GridPlace::Apply.
  static Result<std::shared_ptr<SourceVolume>> Open(
    const std::string& path, const OpeningChoice& choice);

  const std::string& GetPath() const override { return this->Path; }
  const std::vector<ArrayDescription>& GetArrays() const override { return this->Arrays; }
  const std::vector<std::optional<double>>& GetTimes() const override { return this->Times; }
  int GetNumberOfLevels() const override { return 1; }
  std::string GetLeftOut() const override { return this->LeftOut; }
  LevelDescription Describe(int level) const override;
  /// One thread reads at a time. Memory: 64 MiB, or what the file has to decode at once.
  Status Read(const SampleRequest& request, void* samples, const Progress& progress) override;
  /// Its chunks are decoded by several threads.
  Result<std::unique_ptr<BoxSource>> OpenSource(
    std::size_t timeStep, int threads, std::uint64_t memoryBytes) override;
  SourceFiles GetSourceFiles(std::size_t timeStep) override;
  /// Reads all samples of the time step into blocks in memory, unless they are there. They stay until
  /// those of another time step are read and no caller uses them. OutOfMemory if they take more than a
  /// third of the free memory.
  Result<std::shared_ptr<BlockedVolume>> GetBlocks(
    std::size_t timeStep, const Progress& progress, std::size_t& stepThere) override;
  /// Reads the box alone of a volume at an address, or of one that GetBlocks refuses. The last one stays.
  Result<std::shared_ptr<BlockedVolume>> GetBlocksOf(std::size_t timeStep, const VertexBox& box,
    const Progress& progress, std::size_t& stepThere, Index3& first) override;

private:
  SourceVolume() = default;
  /// Opens the file, which must be as it was when the time step was first opened.
  Result<OpenedVolume> OpenStep(std::size_t timeStep);
  /// Corrupt if the files of a time step that was opened were changed since. Of thousands of files
  /// this is not checked.
  Status CheckUnchanged(std::size_t timeStep);
  /// That of a time step. ReadMutex is held.
  Result<BoxSource*> FindSource(std::size_t timeStep);
  std::uint64_t CountBytes(const VertexBox& box) const;
  /// Whether blocks in memory may take so much.
  static bool Fits(std::uint64_t bytes);
  Result<std::shared_ptr<BlockedVolume>> MakeBlocks(
    std::size_t timeStep, const VertexBox& box, const Progress& progress);

  std::string Path;
  std::string Axes;
  int Threads = 0;
  GridGeometry Grid;
  std::optional<GridLines> Lines;
  std::vector<ArrayDescription> Arrays;
  std::vector<std::optional<double>> Times;
  std::string LeftOut;
  Index3 Chunk{ 1, 1, 1 };

  std::mutex KnownMutex;                    ///< guards Known
  std::map<std::size_t, SourceFiles> Known; ///< of time steps

  std::mutex ReadMutex; ///< guards Source
  std::size_t SourceStep = 0;
  std::unique_ptr<BoxSource> Source; ///< of that time step
  std::mutex BlocksMutex;            ///< guards what follows
  std::map<std::size_t, std::shared_ptr<BlockedVolume>> Blocks;
  struct
  {
    std::size_t Step = 0;
    VertexBox Box;
    std::shared_ptr<BlockedVolume> Volume;
  } Part; ///< of GetBlocksOf
};

} // namespace isosurface

#endif
