// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkStabbingContour
 * @brief   isosurfaces of blocked volumes and image data
 *
 * Input: the output of a vtkBlockedVolumeReader (filters that hand samples on unchanged may stand
 * between, such as vtkPassThrough and vtkPassArrays), a vtkImageData, a vtkRectilinearGrid, or a
 * composite of these. Output: one vtkPolyData a rank, with the triangles, points and normals of
 * vtkFlyingEdges3D, or of vtkRectilinearSynchronizedTemplates (but with degenerate triangles). Cell
 * arrays are averaged to points first, as vtkCellDataToPointData does. Hidden cells and points of a
 * vtkUniformGrid, such as coarse cells under finer grids of a vtkOverlappingAMR, have no surface, as
 * in vtkContourFilter, and no influence on normals.
 *
 * Of a blocked volume only the active blocks are read, through the block cache of the process. For
 * image data the value ranges of blocks, magnitudes (8 bytes a vertex) and averages of cell arrays
 * are kept between isovalues. Normals have no seams where pieces of a grid meet, with or without
 * ghost layers.
 *
 * Point data: GlobalIds, by which the pieces of all ranks fit together, Normals, the isovalue under
 * the name of the contoured array, interpolated arrays. Cell data: IslandId, if asked for. Field
 * data: the cost of the query on this rank, also logged at verbosity 1; see
 * Documentation/reference/isosurfaces.md. All ranks of the controller must execute together; all
 * report the errors of any.
 */

#ifndef vtkStabbingContour_h
#define vtkStabbingContour_h

#include "IsosurfaceFiltersModule.h" // For export macro
#include "vtkContourValues.h"        // For the isovalues
#include "vtkNew.h"                  // For the isovalues
#include "vtkPolyDataAlgorithm.h"
#include "vtkSmartPointer.h" // For the last surface

#include <array>  // For the window
#include <memory> // For the work
#include <string> // For array names
#include <vector> // For array names

namespace isosurface
{
class ContourExecution;
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

  /// Chooses the array, as for any algorithm; but rows of tables are passed over, and the choice made
  /// before stays. ParaView's Python proposes them while a table is the active source.
  using Superclass::SetInputArrayToProcess;
  void SetInputArrayToProcess(
    int index, int port, int connection, int association, const char* name) override;

  ///@{
  /// The isovalues, as in vtkContourFilter.
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
  /// The component of an array that is contoured, or, if it is the number of components, the
  /// magnitude, as in ParaView's menus. Default 0. No effect on arrays of one component.
  vtkSetClampMacro(Component, int, 0, VTK_INT_MAX);
  vtkGetMacro(Component, int);
  ///@}

  ///@{
  /// Whether points carry the normalised negative gradient. Default on.
  vtkSetMacro(ComputeNormals, vtkTypeBool);
  vtkGetMacro(ComputeNormals, vtkTypeBool);
  vtkBooleanMacro(ComputeNormals, vtkTypeBool);
  ///@}

  ///@{
  /// The type of the points, as in vtkContourFilter: SINGLE_PRECISION (float), DOUBLE_PRECISION, or
  /// DEFAULT_PRECISION, the default: double where float has fewer than 16 places between neighbouring
  /// vertices of the grid (of any grid of the input), else float.
  vtkSetClampMacro(OutputPointsPrecision, int, SINGLE_PRECISION, DEFAULT_PRECISION);
  vtkGetMacro(OutputPointsPrecision, int);
  ///@}

  ///@{
  /// Whether points carry their isovalue. Default on.
  vtkSetMacro(ComputeScalars, vtkTypeBool);
  vtkGetMacro(ComputeScalars, vtkTypeBool);
  vtkBooleanMacro(ComputeScalars, vtkTypeBool);
  ///@}

  /// The unit of the isovalues: what the input says of the contoured array (vtkDataArray::UNITS_LABEL),
  /// else "HU" (Hounsfield) if that is the array's name; empty if it is not known. The input must be up
  /// to date.
  const char* GetUnit();

  ///@{
  /// Whether cells are triangles. If off, one polygon for each loop of the surface in a cell of the
  /// grid. Default on.
  vtkSetMacro(GenerateTriangles, vtkTypeBool);
  vtkGetMacro(GenerateTriangles, vtkTypeBool);
  vtkBooleanMacro(GenerateTriangles, vtkTypeBool);
  ///@}

  ///@{
  /// The level of detail of a blocked volume: 0 (the default) is full resolution, each next level
  /// half of it on every axis. At level l the surface is that of all vertices whose coordinates,
  /// counted from the low corner of the extent, are multiples of 2^l; only what the level needs is
  /// read, and GlobalIds number the vertices of its own grid. A level above the volume's coarsest
  /// gives the coarsest. Image data has only level 0.
  vtkSetClampMacro(Level, int, 0, 64);
  vtkGetMacro(Level, int);
  ///@}

  /// 0, and the coarsest level of the input, as far as its pipeline information is up to date; 0 for
  /// image data.
  int* GetLevelRange() VTK_SIZEHINT(2);

  ///@{
  /// Seconds that the surface of a blocked volume may take; 0, the default: no limit. Chooses the
  /// finest level, not finer than Level, that the slowest rank is expected to extract in time, and
  /// the coarsest if there is none. The prediction is made from the contour spectrum, the active
  /// blocks, the block cache, and the speed of earlier executions. So the same surface may be
  /// coarser the first time, while its blocks are read, and finer later.
  vtkSetClampMacro(TimeBudget, double, 0, VTK_DOUBLE_MAX);
  vtkGetMacro(TimeBudget, double);
  ///@}

  ///@{
  /// Triangles that the surface of a blocked volume may have, on all ranks and for all isovalues
  /// together; 0, the default: no limit. Chooses the finest level, not finer than Level, with at
  /// most MaximumTriangles, and the coarsest if there is none. Field data of a level that was chosen
  /// within a budget: EstimatedTriangles (of all ranks), PredictedSeconds, and LevelLimit, the name
  /// of the budget that forbids the next finer level.
  vtkSetClampMacro(MaximumTriangles, vtkIdType, 0, VTK_ID_MAX);
  vtkGetMacro(MaximumTriangles, vtkIdType);
  ///@}

  ///@{
  /// With Progressive, the first execution after a change gives a coarse surface of a blocked
  /// volume: that of the finest level with at most 1/20 of the triangles at Level, as far as the
  /// spectra of the volume tell. Final says whether the last execution was at Level. If not, Refine
  /// makes the next execution extract a finer level, the next for which other blocks are read:
  ///
  ///   for (contour->Update(); !contour->GetFinal(); contour->Update()) { ...; contour->Refine(); }
  ///
  /// After a change of a property, the volume or the time step, the next surface is coarse again.
  /// Refine has no effect if the surface is final, or if nothing was extracted since the last
  /// change. Surfaces of image data are final (but see AllowCoarse); with a budget the surface is final at the
  /// level that the budget allows. All ranks extract the same level. Default off.
  vtkSetMacro(Progressive, vtkTypeBool);
  vtkGetMacro(Progressive, vtkTypeBool);
  vtkBooleanMacro(Progressive, vtkTypeBool);
  vtkGetMacro(Final, vtkTypeBool);
  void Refine();
  ///@}

  /// While on, the first execution after a change is as if the filter were progressive. Of image data
  /// it gives the surface of every 2^l-th vertex on each axis, the finest one with about 100,000
  /// triangles and at most a million vertices; the exact one if that is as small. Not a property: it
  /// neither modifies the filter nor is it saved. ParaView's window switches it on while it applies
  /// what the user has changed by hand, so scripts and animations never see it.
  void AllowCoarse(vtkTypeBool allowed);

  ///@{
  /// Extraction beside the calling thread, for a window that must not wait: PrepareRefinement begins
  /// to extract the surface that Refine asks for, or goes on with it, waits for it, at most
  /// `milliseconds`, and returns. The output stays as it is. When all ranks have the
  /// surface, the execution after Refine takes it instead of extracting. A change drops it, at the
  /// latest when the filter executes; DropRefinement at once. All ranks call it together.
  ///
  /// Refinement has the values of Ranks/Query/Refinement.h, as the last call found them. Of a sample the
  /// share is how much of the file is shown exactly.
  ///
  /// AcceptSize allows surfaces that do not fit, until the next change. RefinementMemory: MiB that a
  /// rank has; 0, the default: what is free. Without Progressive, budget and region, the surface of a
  /// blocked volume that needs more is made after a warning.
  void PrepareRefinement(int milliseconds);
  void DropRefinement();
  void AcceptSize();
  double* GetRefinement() VTK_SIZEHINT(10) { return this->Refinement.data(); }
  /// The surface does not depend on it, so it does not modify the filter.
  void SetRefinementMemory(double mebibytes) { this->RefinementMemory = mebibytes; }
  vtkGetMacro(RefinementMemory, double);
  ///@}

  ///@{
  /// Other point arrays, or cell arrays as averages, to interpolate linearly along the grid edges, to
  /// arrays of the same name, of float for integers, as in vtkFlyingEdges3D. Default: none. Of a
  /// blocked volume the active blocks of each are read. An array that the input does not have is an
  /// error. With ComputeScalars, the contoured array is not interpolated: the isovalue has its name.
  void AddInterpolatedArray(const char* name);
  void RemoveAllInterpolatedArrays();
  int GetNumberOfInterpolatedArrays() { return static_cast<int>(this->InterpolatedArrays.size()); }
  const char* GetInterpolatedArray(int index);
  ///@}

  ///@{
  /// Whether points at the same vertex of the grid become one point, and triangles with two corners
  /// there are left out. Such points arise on all edges of a vertex whose sample equals the
  /// isovalue. The surface stays watertight. No effect on polygons. Default off, as in
  /// vtkFlyingEdges3D.
  vtkSetMacro(DropDegenerateTriangles, vtkTypeBool);
  vtkGetMacro(DropDegenerateTriangles, vtkTypeBool);
  vtkBooleanMacro(DropDegenerateTriangles, vtkTypeBool);
  ///@}

  ///@{
  /// Whether caps close the surface where it meets the border of the grid (of the whole extent of
  /// images). Caps lie in the border, and their normals point outwards. Degenerate triangles are always
  /// dropped then. The closed surface bounds what is not below the isovalue; with Inside BELOW what is
  /// below, such as pores: corners run the other way round, and normals point to high values. Of a
  /// blocked volume the blocks at the border that are inside as a whole are read as well (with BELOW,
  /// all at the border). Defaults: off, ABOVE.
  enum Insides
  {
    ABOVE,
    BELOW
  };
  vtkSetMacro(CloseBoundary, vtkTypeBool);
  vtkGetMacro(CloseBoundary, vtkTypeBool);
  vtkBooleanMacro(CloseBoundary, vtkTypeBool);
  vtkSetClampMacro(Inside, int, ABOVE, BELOW);
  vtkGetMacro(Inside, int);
  ///@}

  ///@{
  /// Whether cells of the grid with a corner that is NaN are left out, which leaves holes. If off, NaN
  /// counts as below the isovalue, so that there is a wall, whose points are NaN. Default off, as in
  /// vtkFlyingEdges3D.
  vtkSetMacro(SkipNotANumber, vtkTypeBool);
  vtkGetMacro(SkipNotANumber, vtkTypeBool);
  vtkBooleanMacro(SkipNotANumber, vtkTypeBool);
  /// Another name of it, for scripts of ParaView: a change of this one changes the other.
  void SetSkipNaN(vtkTypeBool skip);
  ///@}

  ///@{
  /// Whether ranks that are ready take blocks of a blocked volume from the shares of others within
  /// the query, so that a rank on a busy node or a slow disk does not keep all waiting. The surface of
  /// all ranks is the same; but which rank has which block may differ from one execution to the next,
  /// and with it each rank's piece and what is in its block cache. No effect where the reader's
  /// LocalStores is on, on images in memory, on pieces other than the ranks' own, without MPI, and on
  /// surfaces that are prepared in the background. Must be the same on all ranks. Default off.
  vtkSetMacro(DynamicBalance, vtkTypeBool);
  vtkGetMacro(DynamicBalance, vtkTypeBool);
  vtkBooleanMacro(DynamicBalance, vtkTypeBool);
  ///@}

  ///@{
  /// With UseRegion, only blocks that reach into a box in world coordinates are read and contoured,
  /// as a whole: the surface ends where these blocks end, not at the box (vtkClipPolyData cuts
  /// exactly). RegionPosition is the low corner of the box, RegionLength its lengths along the axes;
  /// its faces count as inside. Defaults: off; the unit cube.
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
  /// Planes with outward normals, such as those of a view: only blocks that reach between them are
  /// read and contoured, in the same way as for a box. Null, the default: no such limit.
  virtual void SetFrustum(vtkPlanes* planes);
  vtkGetObjectMacro(Frustum, vtkPlanes);
  /// The same from what vtkCamera::GetFrustumPlanes() gives: a, b, c, d of six planes; no limit if
  /// all are 0.
  void SetFrustumPlanes(const double planes[24]);
  ///@}

  /// By what islands are large or small: triangles (at level l, 4^l times those that there are, so
  /// that a limit is that of the full resolution), area, or the volume that they enclose.
  enum IslandSizes
  {
    TRIANGLES,
    AREA,
    VOLUME
  };

  ///@{
  /// Which islands of the surface are in the output. An island is a connected part of the surface of
  /// one isovalue, on all ranks together: triangles with a common point are on the same one. Those
  /// smaller than MinimumIslandSize are left out, and of each isovalue all but the MaximumIslands
  /// largest; of the same size, that with the lowest global id comes first. IslandSize says what is
  /// compared; areas and volumes are those of the world. Of the islands that are left,
  /// UseIslandPoint keeps the one nearest to IslandPoint alone. With ComputeIslandIds, cells carry
  /// the place of their island among all, by size, in IslandId; 0 is the largest. Defaults:
  /// TRIANGLES, 0 (no limit), 0 (no limit), off, the origin, off.
  ///
  /// If any of these is set, the field data of the output, the same on all ranks, tells of all
  /// islands, those that are left out included: Islands, KeptIslands, a number for each isovalue;
  /// IslandTriangles, IslandArea and IslandVolume of the 1000 largest; IslandBinSize, IslandBinIslands
  /// and IslandBinTriangles, how many have sizes from one power of two to the next.
  ///
  /// Volumes are those of closed islands: see CloseBoundary. MaximumTriangles and TimeBudget are
  /// about the surface before islands are left out. It is extracted as a whole. Finding islands
  /// takes 4 bytes a point and 64 an island; leaving them out 4 bytes a point more, and the largest
  /// array of the points that are kept.
  vtkSetClampMacro(IslandSize, int, TRIANGLES, VOLUME);
  vtkGetMacro(IslandSize, int);
  vtkSetClampMacro(MinimumIslandSize, double, 0, VTK_DOUBLE_MAX);
  vtkGetMacro(MinimumIslandSize, double);
  vtkSetClampMacro(MaximumIslands, vtkIdType, 0, VTK_ID_MAX);
  vtkGetMacro(MaximumIslands, vtkIdType);
  vtkSetMacro(UseIslandPoint, vtkTypeBool);
  vtkGetMacro(UseIslandPoint, vtkTypeBool);
  vtkBooleanMacro(UseIslandPoint, vtkTypeBool);
  vtkSetVector3Macro(IslandPoint, double);
  vtkGetVector3Macro(IslandPoint, double);
  vtkSetMacro(ComputeIslandIds, vtkTypeBool);
  vtkGetMacro(ComputeIslandIds, vtkTypeBool);
  vtkBooleanMacro(ComputeIslandIds, vtkTypeBool);
  /// Whether any of these is set. What takes the blocks of the surface does not know its islands.
  bool FindsIslands();
  /// What the last execution has kept, for people.
  const char* GetIslandSummary() { return this->IslandSummary.c_str(); }
  ///@}

  ///@{
  /// Threads to extract with; 0 (the default): this rank's share of the node's cores.
  vtkSetClampMacro(NumberOfThreads, int, 0, 4096);
  vtkGetMacro(NumberOfThreads, int);
  ///@}

  ///@{
  /// The ranks that execute together, the global controller by default. Null: this rank alone.
  virtual void SetController(vtkMultiProcessController* controller);
  vtkGetObjectMacro(Controller, vtkMultiProcessController);
  ///@}

  vtkMTimeType GetMTime() override;

  /// The vtkStabbingContour whose output arrives at a connection unchanged: its producer, or what
  /// is in front of filters that hand everything on (vtkPassThrough, and the vtkPVPostFilter that
  /// ParaView puts behind every filter). Null if there is none.
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

  friend class isosurface::ContourExecution;

  /// Calls visit(name, value) for the numbers on which all ranks agree.
  template <typename Visit>
  void VisitProperties(const Visit& visit) const
  {
    visit("Component", this->Component);
    visit("ComputeNormals", this->ComputeNormals);
    visit("OutputPointsPrecision", this->OutputPointsPrecision);
    visit("ComputeScalars", this->ComputeScalars);
    visit("GenerateTriangles", this->GenerateTriangles);
    visit("Level", this->Level);
    visit("TimeBudget", this->TimeBudget);
    visit("MaximumTriangles", this->MaximumTriangles);
    visit("Progressive", this->Progressive);
    visit("DropDegenerateTriangles", this->DropDegenerateTriangles);
    visit("CloseBoundary", this->CloseBoundary);
    visit("Inside", this->Inside);
    visit("SkipNotANumber", this->SkipNotANumber);
    visit("DynamicBalance", this->DynamicBalance);
    visit("IslandSize", this->IslandSize);
    visit("MinimumIslandSize", this->MinimumIslandSize);
    visit("MaximumIslands", this->MaximumIslands);
    visit("UseIslandPoint", this->UseIslandPoint);
    visit("ComputeIslandIds", this->ComputeIslandIds);
  }
  /// Asks the input for what a piece of the output needs (AskVolume).
  void AskInput(vtkInformation* inInfo, int piece, int pieces);
  /// Whether an array to contour or to interpolate is one of cells, as far as the input tells.
  bool TakesCells(vtkInformation* inInfo);

  vtkNew<vtkContourValues> ContourValues;
  int Component = 0;
  vtkTypeBool ComputeNormals = 1;
  int OutputPointsPrecision = DEFAULT_PRECISION;
  vtkTypeBool ComputeScalars = 1;
  vtkTypeBool GenerateTriangles = 1;
  int Level = 0;
  int LevelRange[2] = { 0, 0 };
  double TimeBudget = 0;
  vtkIdType MaximumTriangles = 0;
  vtkTypeBool Progressive = 0;
  vtkTypeBool Final = 1;
  std::array<double, 10> Refinement;
  double RefinementMemory = 0;
  std::vector<std::string> InterpolatedArrays;
  vtkTypeBool DropDegenerateTriangles = 0;
  vtkTypeBool CloseBoundary = 0;
  int Inside = ABOVE;
  vtkTypeBool SkipNotANumber = 0;
  vtkTypeBool SkipNaN = 0;
  vtkTypeBool DynamicBalance = 0;
  vtkTypeBool UseRegion = 0;
  double RegionPosition[3] = { 0, 0, 0 };
  double RegionLength[3] = { 1, 1, 1 };
  vtkPlanes* Frustum = nullptr;
  int IslandSize = TRIANGLES;
  double MinimumIslandSize = 0;
  vtkIdType MaximumIslands = 0;
  vtkTypeBool UseIslandPoint = 0;
  double IslandPoint[3] = { 0, 0, 0 };
  vtkTypeBool ComputeIslandIds = 0;
  std::string IslandSummary;
  std::string Unit;
  int NumberOfThreads = 0;
  vtkMultiProcessController* Controller = nullptr;
  std::unique_ptr<isosurface::ContourExecution> Work;
  vtkSmartPointer<vtkPolyData> LastSurface; ///< if the next execution may have it stay
};

#endif
