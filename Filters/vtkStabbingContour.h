// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkStabbingContour
 * @brief   isosurfaces of blocked volumes and image data
 *
 * The input is the output of a vtkBlockedVolumeReader, a vtkImageData, or a composite of
 * vtkImageData; the output is one vtkPolyData a rank. Triangles, connectivity, points and normals
 * are those of vtkFlyingEdges3D: a sample equal to the isovalue is inside, degenerate triangles are
 * kept.
 *
 * Behind a vtkBlockedVolumeReader the external interval trees are stabbed with the isovalues, and
 * the active blocks are read, through the process' block cache, and contoured one by one; the
 * reader's output is not used. Behind a filter that passes samples on unchanged (vtkPassThrough,
 * vtkPassArrays) the isovalues travel upstream under vtkBlockedVolumeReader::STABBING_REQUEST(),
 * and the reader gives the active blocks. For image data the value ranges of blocks are computed
 * once an array, and kept between isovalues; so are magnitudes, which take 8 bytes a vertex.
 *
 * Point data: GlobalIds, the grid edge that a point lies on: 3 * vertex + axis +
 * n * 3 * numberOfVertices for the n-th isovalue, where vertex is the edge's low end, numbered over
 * the whole grid (x fastest) from 0. Equal ids, on whatever rank, mean bitwise equal points and
 * normals: merging by GlobalIds alone makes the surface watertight. (Where images meet without a
 * ghost layer, normals are of one side only, and differ.) Images of several different grids in one
 * composite have consecutive ranges of ids. With ComputeNormals, Normals; with
 * ComputeScalars, the isovalue under the name of the contoured array.
 *
 * Field data: what the query cost this rank (Rank, TreePagesRead, DirectoryPagesRead, ActiveBlocks,
 * BlocksRead, BytesRead, BlockCacheHits, Triangles, QuerySeconds, ReadSeconds, ExtractSeconds);
 * also a line in the log.
 *
 * Every rank of the controller must execute together. Errors of any rank are reported by all.
 */

#ifndef vtkStabbingContour_h
#define vtkStabbingContour_h

#include "IsosurfaceFiltersModule.h" // For export macro
#include "vtkContourValues.h"        // For the isovalues
#include "vtkNew.h"                  // For the isovalues
#include "vtkPolyDataAlgorithm.h"

#include <memory> // For the index
#include <string> // For array names

namespace isosurface
{
class Status;
struct ContourRequest;
struct QueryCost;
struct Surface;
}

class vtkMultiProcessController;

class ISOSURFACEFILTERS_EXPORT vtkStabbingContour : public vtkPolyDataAlgorithm
{
public:
  static vtkStabbingContour* New();
  vtkTypeMacro(vtkStabbingContour, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The isovalues, as in vtkContourFilter.
   */
  void SetValue(int i, double value) { this->ContourValues->SetValue(i, value); }
  double GetValue(int i) { return this->ContourValues->GetValue(i); }
  void SetNumberOfContours(int number) { this->ContourValues->SetNumberOfContours(number); }
  vtkIdType GetNumberOfContours() { return this->ContourValues->GetNumberOfContours(); }
  void GenerateValues(int number, double rangeStart, double rangeEnd)
  {
    this->ContourValues->GenerateValues(number, rangeStart, rangeEnd);
  }
  ///@}

  ///@{
  /**
   * What is contoured of an array of several components: below their number that component, at
   * their number the magnitude, as in ParaView's menus of components. Default 0. Arrays of one
   * component are contoured whatever this is.
   */
  vtkSetClampMacro(Component, int, 0, VTK_INT_MAX);
  vtkGetMacro(Component, int);
  ///@}

  ///@{
  /**
   * Whether points carry the normalised negative gradient. Default on.
   */
  vtkSetMacro(ComputeNormals, vtkTypeBool);
  vtkGetMacro(ComputeNormals, vtkTypeBool);
  vtkBooleanMacro(ComputeNormals, vtkTypeBool);
  ///@}

  ///@{
  /**
   * Whether points carry their isovalue. Default on.
   */
  vtkSetMacro(ComputeScalars, vtkTypeBool);
  vtkGetMacro(ComputeScalars, vtkTypeBool);
  vtkBooleanMacro(ComputeScalars, vtkTypeBool);
  ///@}

  ///@{
  /**
   * Whether cells are triangles; else one polygon for each loop in which the surface cuts a grid
   * cell. Default on.
   */
  vtkSetMacro(GenerateTriangles, vtkTypeBool);
  vtkGetMacro(GenerateTriangles, vtkTypeBool);
  vtkBooleanMacro(GenerateTriangles, vtkTypeBool);
  ///@}

  ///@{
  /**
   * Threads to extract with; 0 (the default): this rank's share of the node's cores.
   */
  vtkSetClampMacro(NumberOfThreads, int, 0, 4096);
  vtkGetMacro(NumberOfThreads, int);
  ///@}

  ///@{
  /**
   * The ranks that execute together, the global controller by default. Null: this rank alone.
   */
  virtual void SetController(vtkMultiProcessController* controller);
  vtkGetObjectMacro(Controller, vtkMultiProcessController);
  ///@}

  vtkMTimeType GetMTime() override;

protected:
  vtkStabbingContour();
  ~vtkStabbingContour() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

private:
  vtkStabbingContour(const vtkStabbingContour&) = delete;
  void operator=(const vtkStabbingContour&) = delete;

  struct Index; ///< value ranges of the blocks of images, kept between isovalues

  isosurface::Status ExtractFromVolume(vtkInformation* inInfo, vtkInformation* outInfo,
    const isosurface::ContourRequest& request, isosurface::Surface& surface, std::string& arrayName,
    isosurface::QueryCost& cost);
  isosurface::Status ExtractFromImages(vtkInformationVector** input,
    const isosurface::ContourRequest& request, isosurface::Surface& surface, std::string& arrayName,
    isosurface::QueryCost& cost);
  bool TellProgress(double share);
  std::string GetArrayToContour();
  int ChooseThreads();

  vtkNew<vtkContourValues> ContourValues;
  int Component;
  vtkTypeBool ComputeNormals;
  vtkTypeBool ComputeScalars;
  vtkTypeBool GenerateTriangles;
  int NumberOfThreads;
  int RanksOnNode; ///< 0: not known yet
  vtkMultiProcessController* Controller;
  std::unique_ptr<Index> ImageIndex;
};

#endif
