// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBlockedVolumeReader
 * @brief   reads blocked volumes (.bvol)
 *
 * The output is a vtkPartitionedDataSet of vtkImageData: the whole volume, at the finest level of
 * detail that fits MemoryLimit. Each piece gets one image, or one rectilinear grid if the volume is
 * on such a grid: a slab of blocks from whatever stores
 * they are in, with a layer of ghost vertices and cells marked by vtkGhostType.
 *
 * Filters of this project, such as vtkStabbingContour, take blocks straight from the stores
 * instead: they find BLOCKED_VOLUME() in their input's information. If only such filters have
 * asked for the output, it is the box of the volume, an image of one cell, and nothing is read.
 *
 * Decoded blocks are kept in one cache a process, of CacheSize. Errors name file and reason, on
 * every rank of the controller; the output is empty then.
 */

#ifndef vtkBlockedVolumeReader_h
#define vtkBlockedVolumeReader_h

#include "IsosurfaceReadersModule.h" // For export macro
#include "vtkDataArraySelection.h"   // For the arrays
#include "vtkPartitionedDataSetAlgorithm.h"
#include "vtkSmartPointer.h" // For the handle

#include <memory> // For what is prepared
#include <string> // For the last error
#include <vector> // For times

class vtkBlockedVolumeHandle;
class vtkInformationBlockedVolumeKey;
class vtkMultiProcessController;

namespace isosurface
{
struct GridGeometry;
struct GridPlace;
class Status;
}

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
   * Whether stores may be on disks that only one rank reaches. Then ranks share whole stores, which
   * is uneven unless the number of ranks divides that of the stores (if there are replicas, parts
   * of the stores that they have replicas of); else they share the active blocks of all stores. No
   * output of the reader itself depends on it. Default off.
   */
  void SetLocalStores(bool local);
  vtkGetMacro(LocalStores, bool);
  vtkBooleanMacro(LocalStores, bool);
  ///@}

  ///@{
  /**
   * Where the samples are, in place of what the file says: their distances on each axis, above 0; the
   * place of the vertex with coordinates (0, 0, 0); the unit of both, as "mm", or "unknown". Numbers are
   * added one by one, three or none. What is not set is the file's, and so are the directions of the axes.
   * Of a rectilinear grid the unit alone can be set.
   */
  void SetSpacing(double x, double y, double z) { this->Change(this->Spacing, {}, { x, y, z }); }
  void AddSpacing(double distance) { this->Change(this->Spacing, this->Spacing, { distance }); }
  void RemoveSpacing() { this->Change(this->Spacing, {}, {}); }
  void SetOrigin(double x, double y, double z) { this->Change(this->Origin, {}, { x, y, z }); }
  void AddOrigin(double coordinate) { this->Change(this->Origin, this->Origin, { coordinate }); }
  void RemoveOrigin() { this->Change(this->Origin, {}, {}); }
  vtkSetStringMacro(LengthUnit);
  vtkGetStringMacro(LengthUnit);
  ///@}

  ///@{
  /**
   * What the file says of them. Known after RequestInformation.
   */
  vtkGetVector3Macro(FoundSpacing, double);
  vtkGetVector3Macro(FoundOrigin, double);
  vtkGetCharFromStdStringMacro(FoundUnit);
  ///@}

  ///@{
  /**
   * The point arrays that the output carries.
   */
  vtkDataArraySelection* GetPointDataArraySelection() { return this->PointDataArraySelection; }
  int GetNumberOfPointArrays() { return this->PointDataArraySelection->GetNumberOfArrays(); }
  const char* GetPointArrayName(int index)
  {
    return this->PointDataArraySelection->GetArrayName(index);
  }
  int GetPointArrayStatus(const char* name)
  {
    return this->PointDataArraySelection->ArrayIsEnabled(name);
  }
  void SetPointArrayStatus(const char* name, int status)
  {
    this->PointDataArraySelection->SetArraySetting(name, status);
  }
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
   * What the last output is, in words: "level 2, 256 x 256 x 275, of 1023 x 1023 x 1097".
   */
  vtkGetCharFromStdStringMacro(ShownText);

  /**
   * In the output's pipeline information: the blocked volume itself.
   */
  static vtkInformationBlockedVolumeKey* BLOCKED_VOLUME();

  vtkMTimeType GetMTime() override;

protected:
  vtkBlockedVolumeReader();
  ~vtkBlockedVolumeReader() override;

  int RequestInformation(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

  /**
   * Whether there is nothing to open before RequestData has been called, of which a subclass makes
   * the file first. Then consumers learn no more than that there will be a volume.
   */
  virtual bool IsPending() { return false; }

  /**
   * Reads the volume of this handle in place of FileName's, from the next execution on; null: no
   * longer. If it is a sample, ShownText is its text.
   */
  void SetStandIn(vtkBlockedVolumeHandle* standIn);

  /**
   * The times of the file while there is nothing to open, or a sample of one of its time steps.
   */
  std::vector<double> SourceTimes;

  ///@{
  /**
   * Reads the last execution's request again, but of the volume of this handle, beside the calling
   * thread. The next execution takes this output if its request is the same. If reading fails, that
   * execution reads, too, and tells the error. Where the last output was a box, nothing is read.
   * Collective. IsOutputPrepared waits for the end, at most `seconds`.
   */
  void PrepareOutput(vtkBlockedVolumeHandle* volume);
  bool IsOutputPrepared(double seconds);
  ///@}

private:
  vtkBlockedVolumeReader(const vtkBlockedVolumeReader&) = delete;
  void operator=(const vtkBlockedVolumeReader&) = delete;

  struct Reading;        ///< the steps of RequestData
  struct PreparedOutput; ///< of the next execution

  friend class vtkInPlaceVolumeReader;
  /// What is set of Spacing, Origin and LengthUnit. Errors name the file `path` and what is wrong with them.
  isosurface::Status MakePlace(const std::string& path, isosurface::GridPlace& place) const;
  void Change(
    std::vector<double>& numbers, std::vector<double> kept, const std::vector<double>& added);
  /// Sets what the file says.
  void TellGrid(const isosurface::GridGeometry& grid);

  bool OpenVolume();
  /// Tells the pipeline about the arrays and times of the open volume.
  void TellVolume(vtkInformation* outInfo);

  char* FileName = nullptr;
  bool LocalStores = false;
  int MemoryLimit = 256;
  int Level = 0;
  std::vector<double> Spacing; ///< empty, or three numbers
  std::vector<double> Origin;
  char* LengthUnit = nullptr;
  double FoundSpacing[3];
  double FoundOrigin[3];
  std::string FoundUnit;
  vtkMultiProcessController* Controller = nullptr;
  vtkSmartPointer<vtkDataArraySelection> PointDataArraySelection;
  /// One for good: of a series of files each in turn is opened, and consumers keep the handle that
  /// they found first, since pipeline information does not reach them when the time changes.
  vtkSmartPointer<vtkBlockedVolumeHandle> Handle;
  vtkMTimeType OpenTime = 0; ///< our MTime when the handle's volume was opened
  bool IsErrorTold = false;  ///< whether OpenVolume has just reported the handle's error
  bool IsToldLate = false;   ///< whether RequestData tells what RequestInformation could not
  std::string ShownText;
  vtkSmartPointer<vtkBlockedVolumeHandle> StandIn;
  std::unique_ptr<PreparedOutput> Prepared; ///< null if nothing is
};

#endif
