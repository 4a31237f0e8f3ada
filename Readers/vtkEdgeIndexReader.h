// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkEdgeIndexReader
 * @brief   reads isosurfaces from edge-index files (.eix)
 *
 * Output: the surface of the vtkStabbingContour that was written, as one vtkPolyData a piece, with
 * the same triangles and GlobalIds, and with points and arrays as exact as the file has them.
 * Merging the pieces by GlobalIds makes the surface watertight. Blocks are distributed over pieces
 * such that all have about equally many points, and decoded by several threads. With Preview, or a
 * region, only the blocks that are needed are read.
 *
 * Of a file that was truncated, or is still being written, the complete blocks are read, with a
 * warning of what is missing. Any other damage is an error on every rank of the controller, which
 * names the file and the reason; the output is empty then.
 *
 * A file knows its time, if its volume did. vtkFileSeriesReader reads several files as a series.
 */

#ifndef vtkEdgeIndexReader_h
#define vtkEdgeIndexReader_h

#include "IsosurfaceReadersModule.h" // For export macro
#include "vtkPolyDataAlgorithm.h"

#include <memory> // For the file

class vtkDoubleArray;
class vtkMultiProcessController;

class ISOSURFACEREADERS_EXPORT vtkEdgeIndexReader : public vtkPolyDataAlgorithm
{
public:
  static vtkEdgeIndexReader* New();
  vtkTypeMacro(vtkEdgeIndexReader, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The .eix file.
   */
  vtkSetFilePathMacro(FileName);
  vtkGetFilePathMacro(FileName);
  ///@}

  /**
   * Whether the file begins as an edge-index file does (of any version).
   */
  static int CanReadFile(const char* fileName);

  /**
   * The isovalues of the file, in the order of its isosurfaces, once UpdateInformation has been called;
   * none if the file cannot be read. The array belongs to the reader.
   */
  vtkDoubleArray* GetContourValues();

  ///@{
  /**
   * Whether to read the coarse surface that the file has in addition to the full one; its GlobalIds
   * are those of its own, coarser grid. A file without one gives a warning, and the full surface.
   * Default off.
   */
  vtkSetMacro(Preview, vtkTypeBool);
  vtkGetMacro(Preview, vtkTypeBool);
  vtkBooleanMacro(Preview, vtkTypeBool);
  ///@}

  ///@{
  /**
   * With UseRegion, only blocks that reach into a box in world coordinates are read, as a whole.
   * RegionPosition is the low corner of the box, RegionLength its lengths along the axes. For a
   * grid whose axes are not those of the world, the box of the grid around it is taken. Defaults:
   * off; the unit cube.
   */
  vtkSetMacro(UseRegion, vtkTypeBool);
  vtkGetMacro(UseRegion, vtkTypeBool);
  vtkBooleanMacro(UseRegion, vtkTypeBool);
  vtkSetVector3Macro(RegionPosition, double);
  vtkGetVector3Macro(RegionPosition, double);
  vtkSetVector3Macro(RegionLength, double);
  vtkGetVector3Macro(RegionLength, double);
  ///@}

  ///@{
  /**
   * Whether points carry their isovalue, under the name of the array that was contoured. Default
   * on.
   */
  vtkSetMacro(ComputeScalars, vtkTypeBool);
  vtkGetMacro(ComputeScalars, vtkTypeBool);
  vtkBooleanMacro(ComputeScalars, vtkTypeBool);
  ///@}

  ///@{
  /**
   * Whether points have normals: those of the file or, if it has none, the mean of the normals of
   * the adjacent triangles, weighted by area. The mean is of the piece alone: at its border it is
   * that of one side. Default on.
   */
  vtkSetMacro(ComputeNormals, vtkTypeBool);
  vtkGetMacro(ComputeNormals, vtkTypeBool);
  vtkBooleanMacro(ComputeNormals, vtkTypeBool);
  ///@}

  ///@{
  /**
   * Threads to decode with; 0 (the default): this rank's share of the node's cores.
   */
  vtkSetClampMacro(NumberOfThreads, int, 0, 4096);
  vtkGetMacro(NumberOfThreads, int);
  ///@}

  ///@{
  /**
   * The ranks that read together, the global controller by default. Null: this rank alone.
   */
  virtual void SetController(vtkMultiProcessController* controller);
  vtkGetObjectMacro(Controller, vtkMultiProcessController);
  ///@}

protected:
  vtkEdgeIndexReader();
  ~vtkEdgeIndexReader() override;

  int RequestInformation(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

private:
  vtkEdgeIndexReader(const vtkEdgeIndexReader&) = delete;
  void operator=(const vtkEdgeIndexReader&) = delete;

  struct Internals; ///< the open file, and the steps of RequestData

  char* FileName = nullptr;
  vtkTypeBool Preview = 0;
  vtkTypeBool UseRegion = 0;
  double RegionPosition[3] = { 0, 0, 0 };
  double RegionLength[3] = { 1, 1, 1 };
  vtkTypeBool ComputeScalars = 1;
  vtkTypeBool ComputeNormals = 1;
  int NumberOfThreads = 0;
  vtkMultiProcessController* Controller = nullptr;
  std::unique_ptr<Internals> Internal;
};

#endif
