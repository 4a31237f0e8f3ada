// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkContourSpectrum
 * @brief   the size and the cost of the isosurface at every isovalue, as a table
 *
 * Input: as for vtkStabbingContour. Output: a table with one row for each isovalue: each value of
 * integers with at most 2048 values, else 1024 to 2048 multiples of a power of two. Columns, exact:
 * Isovalue, Triangles, ActiveCells, and ActiveBlocks and Bytes that a query reads; estimated, in
 * world units: Area, and Volume where value >= isovalue. With StoreQuantity also one column for
 * each store, such as "Triangles[0]".
 *
 * The spectrum of a blocked volume is read from its file; that of image data is counted in two
 * passes, and of several images the sum is given; of many samples beside the calling thread, if
 * CountBeside() says so. All ranks of the controller must execute
 * together; the first one gets the table. All report the errors of any.
 *
 * Source: C. Bajaj, V. Pascucci, D. Schikore, "The contour spectrum", IEEE Visualization 1997.
 */

#ifndef vtkContourSpectrum_h
#define vtkContourSpectrum_h

#include "IsosurfaceFiltersModule.h" // For export macro
#include "vtkNew.h"                  // For the tuples
#include "vtkTableAlgorithm.h"

#include <array>  // For the window
#include <memory> // For the work
#include <string> // For the unit

class vtkDoubleArray;
class vtkMultiProcessController;

class ISOSURFACEFILTERS_EXPORT vtkContourSpectrum : public vtkTableAlgorithm
{
public:
  static vtkContourSpectrum* New();
  vtkTypeMacro(vtkContourSpectrum, vtkTableAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The columns, in their order.
  enum Quantity
  {
    TRIANGLES,
    ACTIVE_CELLS,
    ACTIVE_BLOCKS,
    BYTES,
    AREA,
    VOLUME
  };

  /// Chooses the array, as for any algorithm; but rows of tables are passed over, and the choice made
  /// before stays. ParaView's Python proposes them while a table is the active source.
  using Superclass::SetInputArrayToProcess;
  void SetInputArrayToProcess(
    int index, int port, int connection, int association, const char* name) override;

  ///@{
  /// The component of an array that is measured, or, if it is the number of components, the
  /// magnitude. Default 0. No effect on arrays of one component.
  vtkSetClampMacro(Component, int, 0, VTK_INT_MAX);
  vtkGetMacro(Component, int);
  ///@}

  ///@{
  /// The quantity for which each store of a blocked volume gets its own column; -1 (the default):
  /// none.
  vtkSetClampMacro(StoreQuantity, int, -1, VOLUME);
  vtkGetMacro(StoreQuantity, int);
  ///@}

  ///@{
  /// Threads to count with; 0 (the default): this rank's share of the node's cores.
  vtkSetClampMacro(NumberOfThreads, int, 0, 4096);
  vtkGetMacro(NumberOfThreads, int);
  ///@}

  ///@{
  /// The ranks that execute together, the global controller by default. Null: this rank alone.
  virtual void SetController(vtkMultiProcessController* controller);
  vtkGetObjectMacro(Controller, vtkMultiProcessController);
  ///@}

  /// The last table as tuples: isovalue, then the quantities in their order, NaN where they are not
  /// known. For clients that want the numbers without the table. Belongs to this.
  vtkDoubleArray* GetSpectrum();

  ///@{
  /// For windows, which must answer meanwhile. An execution over images of more samples than
  /// CountBeside() says gives an empty table. Then AdvanceCounting() has them counted beside the calling
  /// thread, and waits at most `milliseconds`; several ranks count only while all are in it.
  /// Refinement has the values of Ranks/Query/Refinement.h, as the last call found them. When its
  /// stage is Ready, TakeCounting() lets the next execution give the table. None of these is a
  /// property; all ranks must call them. Default: everything is counted at once.
  void CountBeside(int samplesAtOnce) { this->SamplesAtOnce = samplesAtOnce; }
  void AdvanceCounting(int milliseconds);
  double* GetRefinement() VTK_SIZEHINT(10) { return this->Refinement.data(); }
  void TakeCounting();
  ///@}

  ///@{
  /// An isovalue to begin with: that which divides the samples into the two classes that differ most, as
  /// round as the range allows; the same whatever the number of ranks. NaN on other ranks than the first
  /// one behind a blocked volume, and if there is none. ProposeAlone makes executions find it alone, from
  /// at most some two million samples of images, and give an empty table for these; without it images
  /// have none.
  void ProposeAlone(vtkTypeBool alone);
  vtkGetMacro(Proposal, double);
  ///@}

  /// Of a sample that does not reach through all of its file: the share that the last table is of; else 1.
  vtkGetMacro(Share, double);

  /// As vtkStabbingContour's.
  const char* GetUnit();

protected:
  vtkContourSpectrum();
  ~vtkContourSpectrum() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

private:
  vtkContourSpectrum(const vtkContourSpectrum&) = delete;
  void operator=(const vtkContourSpectrum&) = delete;

  struct Work; ///< what is kept between executions

  int Component = 0;
  int StoreQuantity = -1;
  int NumberOfThreads = 0;
  vtkMultiProcessController* Controller = nullptr;
  vtkNew<vtkDoubleArray> Spectrum;
  int SamplesAtOnce = VTK_INT_MAX;
  std::array<double, 10> Refinement;
  bool ProposesAlone = false;
  double Proposal;
  double Share = 1;
  std::string Unit;
  const std::unique_ptr<Work> Internals;
};

#endif
