// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBlockedVolumeReader
 * @brief   reads blocked volumes (.bvol): only the blocks that a consumer needs
 *
 * The output is a vtkPartitionedDataSet of vtkImageData. What it holds depends on what is asked for
 * upstream:
 * - STABBING_REQUEST() with isovalues: the blocks that they cross, at the level of detail that the
 *   request names, each an image of its own. Any number of pieces (ranks) reads any number of
 * stores: each piece takes whole stores, or pieces share the blocks of one.
 * - else the whole volume, at the finest level of detail that fits MemoryLimit: one image a piece,
 *   a slab of blocks from whatever stores they are in.
 * A layer of ghost vertices and cells around blocks and slabs is marked by vtkGhostType.
 *
 * A consumer that finds BLOCKED_VOLUME() in its input's information can do without the output and
 * take blocks straight from the volume, as vtkStabbingContour does. It says so by a request with
 * HandleOnly; if there is no output yet, the reader then reads nothing and puts an image of one
 * cell in its place, the box of the volume.
 *
 * Decoded blocks are kept in one cache a process, of CacheSize. Errors name file and reason, on
 * every rank of the controller; the output is empty then.
 */

#ifndef vtkBlockedVolumeReader_h
#define vtkBlockedVolumeReader_h

#include "IsosurfaceReadersModule.h" // For export macro
#include "vtkPartitionedDataSetAlgorithm.h"
#include "vtkSmartPointer.h" // For the handle

#include <string> // For the file name
#include <vector> // For lists of blocks

namespace isosurface
{
class Status;
struct BlockReference;
struct QueryStatistics;
}

class vtkBlockedVolumeHandle;
class vtkDataArraySelection;
class vtkInformationBlockedVolumeKey;
class vtkInformationStabbingRequestKey;
class vtkMultiProcessController;

class ISOSURFACEREADERS_EXPORT vtkBlockedVolumeReader : public vtkPartitionedDataSetAlgorithm
{
public:
  static vtkBlockedVolumeReader* New();
  vtkTypeMacro(vtkBlockedVolumeReader, vtkPartitionedDataSetAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The .bvol file.
   */
  vtkSetFilePathMacro(FileName);
  vtkGetFilePathMacro(FileName);
  ///@}

  /**
   * Whether the file says that it is a blocked volume (of any version).
   */
  static int CanReadFile(const char* fileName);

  ///@{
  /**
   * Mebibytes that the blocks of the output may take on a piece. Default 256.
   */
  vtkSetClampMacro(MemoryLimit, int, 1, VTK_INT_MAX);
  vtkGetMacro(MemoryLimit, int);
  ///@}

  ///@{
  /**
   * Mebibytes of decoded blocks that the process keeps, for all volumes together. Default 1024.
   */
  void SetCacheSize(int mebibytes);
  int GetCacheSize();
  ///@}

  ///@{
  /**
   * The point arrays that the output carries.
   */
  vtkDataArraySelection* GetPointDataArraySelection();
  int GetNumberOfPointArrays();
  const char* GetPointArrayName(int index);
  int GetPointArrayStatus(const char* name);
  void SetPointArrayStatus(const char* name, int status);
  ///@}

  ///@{
  /**
   * The ranks that read together, the global controller by default. Null: this rank alone.
   */
  virtual void SetController(vtkMultiProcessController* controller);
  vtkGetObjectMacro(Controller, vtkMultiProcessController);
  ///@}

  /**
   * The level of detail of the last output: 0 is full resolution, each next one half of it.
   */
  vtkGetMacro(Level, int);

  /**
   * In the output's pipeline information: the blocked volume itself.
   */
  static vtkInformationBlockedVolumeKey* BLOCKED_VOLUME();

  /**
   * Upstream, in the output's pipeline information: the isovalues whose blocks are wanted.
   */
  static vtkInformationStabbingRequestKey* STABBING_REQUEST();

  vtkMTimeType GetMTime() override;

protected:
  vtkBlockedVolumeReader();
  ~vtkBlockedVolumeReader() override;

  int RequestInformation(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

private:
  vtkBlockedVolumeReader(const vtkBlockedVolumeReader&) = delete;
  void operator=(const vtkBlockedVolumeReader&) = delete;

  bool OpenVolume();
  isosurface::Status ReadBlocks(
    vtkInformation* outInfo, int threads, vtkPartitionedDataSet* partitions);
  isosurface::Status ReadSlab(int piece, int pieces, std::size_t step,
    const std::vector<std::size_t>& arrays, int threads, vtkPartitionedDataSet* partitions,
    isosurface::QueryStatistics& statistics);
  isosurface::Status ReadActiveBlocks(const std::vector<isosurface::BlockReference>& blocks,
    std::size_t step, const std::vector<std::size_t>& arrays, int level, int threads,
    vtkPartitionedDataSet* partitions, isosurface::QueryStatistics& statistics);
  bool TellProgress(double share);

  char* FileName;
  int MemoryLimit;
  int Level;
  vtkMultiProcessController* Controller;
  vtkSmartPointer<vtkDataArraySelection> PointDataArraySelection;
  vtkSmartPointer<vtkBlockedVolumeHandle> Handle; ///< of the file that OpenTime tells of
  vtkMTimeType OpenTime;                          ///< our MTime when Handle was opened
  std::string ReportedError;                      ///< what OpenVolume said last, said once
};

#endif
