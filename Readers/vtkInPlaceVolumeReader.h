// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkInPlaceVolumeReader
 * @brief   reads files of other formats as volumes in place, which it indexes first
 *
 * The first update indexes the source: it writes a blocked volume (.bvol) beside it, or into
 * IndexFolder, without the samples at full resolution, which stay in the source. (Of a gzip stream,
 * which can only be read in order, it has the samples.) From then on the reader is a
 * vtkBlockedVolumeReader of that index, which opens at once. If the source has changed since, the
 * next update after a modification indexes it anew.
 *
 * ParaView's window does not wait for the index (AllowCoarse): the reader shows a sample of the
 * file, and writes the index beside the calling thread. The times of the file are those of its header,
 * before there is an index, too.
 *
 * Indexing is collective: all ranks of the controller update together. It reports progress and
 * stops when the reader is told to abort; then an older index stays as it was, and the output is
 * empty. Errors name file and reason, on every rank. A .bvol that is not an index of the source is
 * never replaced.
 */

#ifndef vtkInPlaceVolumeReader_h
#define vtkInPlaceVolumeReader_h

#include "IsosurfaceReadersModule.h" // For export macro
#include "vtkBlockedVolumeReader.h"

#include <array>    // For the window
#include <cstddef>  // For time steps
#include <memory>   // For the index that grows
#include <optional> // For the window
#include <string>   // For the paths

namespace isosurface
{
class Communicator;
class FetchBudget;
class GrowingIndex;
struct Sight;
struct SourceIndex;
class Status;
enum class RefinementStage;
}

class vtkStringArray;

class ISOSURFACEREADERS_EXPORT vtkInPlaceVolumeReader : public vtkBlockedVolumeReader
{
public:
  static vtkInPlaceVolumeReader* New();
  vtkTypeMacro(vtkInPlaceVolumeReader, vtkBlockedVolumeReader);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * A file or a folder of a format in Formats/Opener/VolumeFormat.cxx, or a file of metadata in a folder of
   * Zarr or N5. FileName is that of the index, set by the update.
   */
  vtkSetFilePathMacro(SourceName);
  vtkGetFilePathMacro(SourceName);
  ///@}

  /**
   * Whether a file or a folder has a volume that can be indexed. Also true of a damaged one, of which
   * the update tells what is wrong. Cost: reading headers.
   */
  static int CanReadFile(const char* fileName);

  ///@{
  /**
   * The dataset within the source; a series of DICOM also by its UID. Empty or "automatic": as the source
   * says, which has to name one (OME-Zarr, VTKHDF) or have only one.
   */
  vtkSetStringMacro(Dataset);
  vtkGetStringMacro(Dataset);
  ///@}

  ///@{
  /**
   * What the samples of a raw file are: XxYxZ,TYPE[,big-endian][,header-bytes=N], as in
   * "512x512x300,uint16". Empty: what the file's name says, NAME_XxYxZ_TYPE.raw.
   */
  vtkSetStringMacro(RawSamples);
  vtkGetStringMacro(RawSamples);
  ///@}

  /**
   * Whether the source is a raw file.
   */
  int GetIsRaw();

  /**
   * "automatic", the datasets of the source and the chosen one. Owned by the reader. Cost: reading metadata.
   */
  vtkStringArray* GetDatasets();

  ///@{
  /**
   * What the axes of the dataset are, the slowest first, of the letters x y z t c. Empty: as the
   * source says.
   */
  vtkSetStringMacro(Axes);
  vtkGetStringMacro(Axes);
  ///@}

  ///@{
  /**
   * The folder of the index. Empty: that of the source.
   */
  vtkSetFilePathMacro(IndexFolder);
  vtkGetFilePathMacro(IndexFolder);
  ///@}

  ///@{
  /**
   * Mebibytes that indexing may take on each rank. Default 1024.
   */
  vtkSetClampMacro(IndexMemory, int, 1, VTK_INT_MAX);
  vtkGetMacro(IndexMemory, int);
  ///@}

  ///@{
  /**
   * A box of the world, x0 x1 y0 y1 z0 z1: only the part of the source that has it is read, which is whole chunks.
   * All of it if a minimum is above its maximum, which is the default.
   */
  vtkSetVector6Macro(FetchRegion, double);
  vtkGetVector6Macro(FetchRegion, double);
  ///@}

  ///@{
  /**
   * Mebibytes that indexing may fetch of a source at an address, of all ranks. When they are spent, what is indexed
   * stays, and only an update with a larger budget goes on, as long as the source has the same name. It may be changed
   * while the index grows. A sample does not count. 0, the default: no limit.
   */
  vtkSetClampMacro(FetchBudget, int, 0, VTK_INT_MAX);
  vtkGetMacro(FetchBudget, int);
  ///@}

  /**
   * Where the index is or will be, whether it is up to date, and what was fetched for it, in words.
   */
  const char* GetIndexText();

  /**
   * While on, an execution that finds no index does not wait for one: its output is a sample of the
   * requested time step, of at most 2 million vertices, which takes about a second for a file of
   * any size. The index is written beside the calling thread. Not a property: it neither modifies
   * the reader nor is it saved. ParaView's window switches it on while it applies what the user has
   * changed by hand, so scripts never see it.
   */
  void AllowCoarse(vtkTypeBool allowed);

  ///@{
  /**
   * For a window, while the index is written: AdvanceIndex waits for it, at most `milliseconds`.
   * When all ranks have it, the execution after TakeIndex reads the volume. The same
   * holds for a larger sample, where the first one was of a part of the file: it is of what has been
   * indexed. An error is reported once, and the sample stays. Where there are several ranks, the
   * index is written only while all ranks are in AdvanceIndex, which they call together. An
   * execution that may not be coarse waits for the index.
   *
   * Refinement has the values of Ranks/Query/Refinement.h: the stage that the last call found, the share
   * of the index that is written, and the seconds that it still takes.
   */
  void AdvanceIndex(int milliseconds);
  void TakeIndex();
  /**
   * What a person looks at: a point, a direction, the radius that is seen at the point, and what it widens by with
   * each unit of the distance. The surface of a sample becomes exact there first. Neither a property nor a change: it
   * decides about the order of reading alone.
   */
  void LookAlong(const double sight[8]);
  void StopIndex(); ///< this is no error: the next execution after a modification goes on
  double* GetRefinement() VTK_SIZEHINT(10);
  ///@}

protected:
  vtkInPlaceVolumeReader();
  ~vtkInPlaceVolumeReader() override;

  bool IsPending() override;
  int RequestInformation(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

private:
  vtkInPlaceVolumeReader(const vtkInPlaceVolumeReader&) = delete;
  void operator=(const vtkInPlaceVolumeReader&) = delete;

  struct Steps; ///< of UpdateIndex

  /// Makes the volume to read: the volume in place, or a sample of the file. Collective.
  isosurface::Status UpdateIndex(isosurface::Communicator& ranks, std::size_t step);
  /// The time step of SourceTimes that is asked for: the last one at or before UPDATE_TIME_STEP().
  std::size_t FindStep(vtkInformation* outInfo) const;
  /// Whether a sample is shown that is of another time step.
  bool IsOtherSample(std::size_t step) const;
  /// Tells the index that grows what is looked at.
  void TellSight();
  /// Has the output of the indexed volume read beside the calling thread; whether all ranks have it.
  /// Collective.
  bool PrepareVolume(isosurface::Communicator& ranks, double seconds);

  char* SourceName = nullptr;
  char* Dataset = nullptr;
  char* RawSamples = nullptr;
  char* Axes = nullptr;
  char* IndexFolder = nullptr;
  int IndexMemory = 1024;
  double FetchRegion[6] = { 0, -1, 0, -1, 0, -1 };
  int FetchBudget = 0;
  std::string IndexText;
  std::string ToldText;                              ///< with what was fetched
  std::shared_ptr<isosurface::FetchBudget> Fetching; ///< of the last name
  std::unique_ptr<isosurface::SourceIndex> Found;    ///< the index, and our MTime when it was found
  vtkMTimeType FindTime = 0;
  vtkStringArray* Datasets;
  vtkMTimeType CheckTime = 0; ///< our MTime when the index was found up to date, or a sample read
  vtkMTimeType TellTime = 0;  ///< our MTime when SourceTimes were read
  bool IsStopped = false;     ///< whether the last RequestInformation() was aborted
  bool CoarseAllowed = false;
  isosurface::RefinementStage Stage = {}; ///< of the index
  std::array<double, 10> Refinement = {};
  std::string WindowSource; ///< the source whose window was looked for last
  std::optional<std::array<double, 2>> Window;
  std::unique_ptr<isosurface::Sight> Looked;         ///< null before LookAlong
  std::unique_ptr<isosurface::GrowingIndex> Growing; ///< while a sample is shown
  vtkSmartPointer<vtkBlockedVolumeHandle> Indexed;   ///< the volume, between its end and TakeIndex
};

#endif
