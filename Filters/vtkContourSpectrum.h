// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkContourSpectrum
 * @brief   what the isosurface of every isovalue is and costs, as a table
 *
 * The input is the output of a vtkBlockedVolumeReader, a vtkImageData, or a composite of
 * vtkImageData. The output has a row an isovalue: every value of integers of at most 2048 values,
 * all 8-bit data among them, else 1024 to 2048 multiples of a power of two. Columns:
 *
 * - Isovalue
 * - Triangles, ActiveCells: of the isosurface, exactly; inside is value >= isovalue
 * - ActiveBlocks, Bytes: that a query reads, exactly; of image data, blocks of 32 cells a side in
 *   memory
 * - Area: of the isosurface, Volume: where value >= isovalue; estimates, in world units
 *
 * Behind a vtkBlockedVolumeReader the spectrum that is stored with the volume is read, no samples.
 * With StoreQuantity there is one column more a store, "Triangles[0]", "Triangles[1]", ... if the
 * quantity is Triangles. For image data the spectrum is counted: two passes over the samples, on
 * all ranks and threads. Of images of several grids in one composite it is the sum.
 *
 * Every rank of the controller must execute together; the first one gets the table, as charts in
 * ParaView want it, the others an empty one. Errors of any rank are reported by all.
 *
 * Source: C. Bajaj, V. Pascucci, D. Schikore, "The contour spectrum", IEEE Visualization 1997.
 */

#ifndef vtkContourSpectrum_h
#define vtkContourSpectrum_h

#include "IsosurfaceFiltersModule.h" // For export macro
#include "vtkNew.h"                  // For the tuples
#include "vtkTableAlgorithm.h"

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

  ///@{
  /**
   * Which component of an array of several ones is measured; their number means the magnitude.
   * Default 0. Arrays of one component are measured whatever this is.
   */
  vtkSetClampMacro(Component, int, 0, VTK_INT_MAX);
  vtkGetMacro(Component, int);
  ///@}

  ///@{
  /**
   * The quantity of which each store of a blocked volume gets a column of its own; -1 (the
   * default): none.
   */
  vtkSetClampMacro(StoreQuantity, int, -1, VOLUME);
  vtkGetMacro(StoreQuantity, int);
  ///@}

  ///@{
  /**
   * Threads to count with; 0 (the default): this rank's share of the node's cores.
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

  /**
   * The last table as tuples: isovalue, then the quantities in their order, NaN where they are not
   * known. For clients that want the numbers without the table. Belongs to this.
   */
  vtkDoubleArray* GetSpectrum();

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

  struct Steps; ///< of RequestData

  int Component;
  int StoreQuantity;
  int NumberOfThreads;
  vtkMultiProcessController* Controller;
  vtkNew<vtkDoubleArray> Spectrum;
};

#endif
