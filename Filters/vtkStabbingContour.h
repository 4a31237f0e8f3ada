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
 * reader's output is not used. Filters that hand samples on unchanged may stand between
 * (vtkPassThrough, vtkPassArrays). For image data the value ranges of blocks are computed once an
 * array, and kept between isovalues; so are magnitudes, which take 8 bytes a vertex.
 *
 * Of a blocked volume with Level l > 0 the surface is that of the volume subsampled by 2^l: of all
 * vertices whose coordinates, counted from the extent's low corner, are multiples of 2^l. Only what
 * this level needs is read. GlobalIds then count the vertices of the subsampled grid, so they fit
 * together within a level, not across levels. Image data have level 0 only.
 *
 * Point data: GlobalIds, the grid edge that a point lies on: 3 * vertex + axis +
 * n * 3 * numberOfVertices for the n-th isovalue, where vertex is the edge's low end, numbered over
 * the whole grid (x fastest) from 0; with CloseBoundary over the grid with a layer more around it.
 * With DropDegenerateTriangles, points on vertices have the ids of these: 3 * numberOfVertices *
 * numberOfIsovalues + vertex + n * numberOfVertices. Equal ids, on whatever rank, mean bitwise
 * equal points, normals and attributes: merging by GlobalIds alone makes the surface watertight.
 * (Where images meet without a ghost layer, normals are of one side only, and differ.) Images of
 * several different grids in one composite have consecutive ranges of ids. With ComputeNormals,
 * Normals; with ComputeScalars, the isovalue under the name of the contoured array; the
 * interpolated arrays.
 *
 * Field data: what the query cost this rank (Rank, TreePagesRead, DirectoryPagesRead, ActiveBlocks,
 * BlocksRead, BytesRead, BlockCacheHits, Triangles, Level, QuerySeconds, ReadSeconds,
 * ExtractSeconds); also a line in the log, at verbosity 1. With a TimeBudget or MaximumTriangles also
 * EstimatedTriangles (of all ranks), PredictedSeconds, and LevelLimit: which of the two forbids the
 * next finer level, if one does.
 *
 * Every rank of the controller must execute together. Errors of any rank are reported by all.
 */

#ifndef vtkStabbingContour_h
#define vtkStabbingContour_h

#include "IsosurfaceFiltersModule.h" // For export macro
#include "vtkContourValues.h"        // For the isovalues
#include "vtkNew.h"                  // For the isovalues
#include "vtkPolyDataAlgorithm.h"

#include <memory> // For the work
#include <string> // For array names
#include <vector> // For array names

namespace isosurface
{
class ContourWork;
}

class vtkAlgorithmOutput;
class vtkMultiProcessController;
class vtkPlanes;

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
   * The level of detail of a blocked volume: 0 (the default) is full resolution, each next one half
   * of it on every axis. A level above the volume's coarsest gives the coarsest.
   */
  vtkSetClampMacro(Level, int, 0, 64);
  vtkGetMacro(Level, int);
  ///@}

  ///@{
  /**
   * Seconds that the surface of a blocked volume may take; 0, the default, as many as it takes. The
   * finest level from Level on is chosen that the slowest rank will have ready in time, as far as
   * the contour spectrum, the active blocks and the block cache, and how fast earlier executions
   * were, can tell; the coarsest level if none will be. The same surface may so be coarser the
   * first time, while its blocks are read, and finer later.
   */
  vtkSetClampMacro(TimeBudget, double, 0, VTK_DOUBLE_MAX);
  vtkGetMacro(TimeBudget, double);
  ///@}

  ///@{
  /**
   * Triangles that the surface of a blocked volume may have, on all ranks and for all isovalues
   * together; 0, the default, as many as there are. The finest level from Level on is chosen that
   * keeps to it; the coarsest if none does.
   */
  vtkSetClampMacro(MaximumTriangles, vtkIdType, 0, VTK_ID_MAX);
  vtkGetMacro(MaximumTriangles, vtkIdType);
  ///@}

  ///@{
  /**
   * With Progressive, the first execution after a change gives a coarse surface of a blocked volume
   * soon: that of the finest level with at most 1/20 of the triangles at Level, as far as the
   * volume's spectra tell. Final then tells whether the last execution was at Level. If not, Refine
   * makes the next execution one of a finer level, the next for which other blocks are read:
   *
   *   for (contour->Update(); !contour->GetFinal(); contour->Update()) { ...; contour->Refine(); }
   *
   * A change of a property, the volume or the time step begins anew. Refine without effect: when
   * the surface is final, or nothing was extracted since the last change. Surfaces of other inputs
   * than blocked volumes are final at once. With a budget the surface
   * is final at the level that it allows. All ranks take the same level. Default off.
   */
  vtkSetMacro(Progressive, vtkTypeBool);
  vtkGetMacro(Progressive, vtkTypeBool);
  vtkBooleanMacro(Progressive, vtkTypeBool);
  vtkGetMacro(Final, vtkTypeBool);
  void Refine();
  ///@}

  ///@{
  /**
   * Further point arrays to interpolate linearly along the grid edges, to arrays of the same name,
   * of float for integers, as in vtkFlyingEdges3D. None by default: of a blocked volume
   * each costs the reading of its active blocks. An array that the input does not have is an error.
   * With ComputeScalars, the contoured array stands for the isovalues.
   */
  void AddInterpolatedArray(const char* name);
  void RemoveAllInterpolatedArrays();
  int GetNumberOfInterpolatedArrays();
  const char* GetInterpolatedArray(int index);
  ///@}

  ///@{
  /**
   * Whether points that lie on one vertex of the grid, as those of all its edges do where the
   * sample equals the isovalue, become one point, and triangles with two corners there are left
   * out. The surface stays watertight. Without effect on polygons. Default off, as in
   * vtkFlyingEdges3D.
   */
  vtkSetMacro(DropDegenerateTriangles, vtkTypeBool);
  vtkGetMacro(DropDegenerateTriangles, vtkTypeBool);
  vtkBooleanMacro(DropDegenerateTriangles, vtkTypeBool);
  ///@}

  ///@{
  /**
   * Whether the surface is closed where it meets the border of the grid (of the whole extent of
   * images), by caps that lie in the border and whose normals point outwards; so it bounds what is
   * not below the isovalue. Of a blocked volume the blocks at the border that are above the
   * isovalue as a whole are then read, too. Default off.
   */
  vtkSetMacro(CloseBoundary, vtkTypeBool);
  vtkGetMacro(CloseBoundary, vtkTypeBool);
  vtkBooleanMacro(CloseBoundary, vtkTypeBool);
  ///@}

  ///@{
  /**
   * With UseRegion, only the blocks that reach into a box of the world are read and contoured,
   * whole: the surface ends where these blocks end, not at the box (vtkClipPolyData cuts exactly).
   * The box goes from RegionPosition along the axes by RegionLength; all of it counts as inside,
   * its border too. Defaults: off; the unit cube.
   */
  vtkSetMacro(UseRegion, vtkTypeBool);
  vtkGetMacro(UseRegion, vtkTypeBool);
  vtkBooleanMacro(UseRegion, vtkTypeBool);
  vtkSetVector3Macro(RegionPosition, double);
  vtkGetVector3Macro(RegionPosition, double);
  vtkSetVector3Macro(RegionLength, double);
  vtkGetVector3Macro(RegionLength, double);
  /// Both, from the bounds of the box.
  void SetRegionBounds(const double bounds[6]);
  ///@}

  ///@{
  /**
   * Planes, normals outwards, between which blocks are read and contoured, in the same way and in
   * addition to a box: those of the view, say. Null, the default: no such limit.
   */
  virtual void SetFrustum(vtkPlanes* planes);
  vtkGetObjectMacro(Frustum, vtkPlanes);
  /// The same from what vtkCamera::GetFrustumPlanes() gives: a, b, c, d of six planes; no limit if
  /// all are 0.
  void SetFrustumPlanes(const double planes[24]);
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

  /**
   * The vtkStabbingContour whose output arrives at a connection unchanged: its producer, or what
   * is in front of filters that hand everything on (vtkPassThrough, and the vtkPVPostFilter that
   * ParaView puts behind every filter). Null if there is none.
   */
  static vtkStabbingContour* FindBehind(vtkAlgorithmOutput* connection);

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

  friend class isosurface::ContourWork;

  /// Asks the input for what a piece of the output needs; until ReleaseInput, which is called when
  /// the input is up to date.
  void AskInput(vtkInformation* inInfo, int piece, int pieces);
  void ReleaseInput(vtkInformation* inInfo);

  vtkNew<vtkContourValues> ContourValues;
  int Component;
  vtkTypeBool ComputeNormals;
  vtkTypeBool ComputeScalars;
  vtkTypeBool GenerateTriangles;
  int Level;
  double TimeBudget;
  vtkIdType MaximumTriangles;
  vtkTypeBool Progressive;
  vtkTypeBool Final;
  std::vector<std::string> InterpolatedArrays;
  vtkTypeBool DropDegenerateTriangles;
  vtkTypeBool CloseBoundary;
  vtkTypeBool UseRegion;
  double RegionPosition[3];
  double RegionLength[3];
  vtkPlanes* Frustum;
  int NumberOfThreads;
  vtkMultiProcessController* Controller;
  std::unique_ptr<isosurface::ContourWork> Work;
};

#endif
