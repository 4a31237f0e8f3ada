// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkDistributeIsosurface
 * @brief   gives each rank a compact piece of an isosurface, which ranks send compressed
 *
 * Input: the unchanged output of a vtkStabbingContour. Output: the same surface, as one piece for
 * each drawing rank. Pieces are compact in space, so each rank draws into a small viewport (see
 * vtkMetabufferRenderView), and have about equally many triangles. They depend on the number of
 * drawing ranks alone.
 *
 * Ranks send edge-index records of blocks (ContourExecution::TakeBlocks) and extract those that have
 * arrived; the contour does not execute. Triangles, GlobalIds and isovalues are those of the
 * contour; points, normals and arrays are exact or within bounds, and equal on both sides of a
 * border. On one rank the output is the input. On several ranks TimeBudget and Progressive have no
 * effect; DropDegenerateTriangles, CloseBoundary, ComputeIslandIds and any other input are errors.
 *
 * Field data: the cost on this rank. All ranks of the controller must execute together; all report
 * the errors of any, and the output is empty then.
 */

#ifndef vtkDistributeIsosurface_h
#define vtkDistributeIsosurface_h

#include "IsosurfaceFiltersModule.h" // For export macro
#include "vtkPolyDataAlgorithm.h"

class vtkMultiProcessController;

class ISOSURFACEFILTERS_EXPORT vtkDistributeIsosurface : public vtkPolyDataAlgorithm
{
public:
  static vtkDistributeIsosurface* New();
  vtkTypeMacro(vtkDistributeIsosurface, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum ModeType
  {
    LOSSLESS = 1, ///< every point bit by bit
    BOUNDED = 2,  ///< every point to within MaximumError
    SMALLEST = 3  ///< of each block the smaller of LOSSLESS and BOUNDED
  };

  enum ProfileType
  {
    SMALL = 0,  ///< the fewest bytes
    WORKING = 3 ///< decoded five to seven times as fast, lossless up to a half larger
  };

  ///@{
  /// How exact the points are that arrive. Default LOSSLESS.
  vtkSetClampMacro(Mode, int, LOSSLESS, SMALLEST);
  vtkGetMacro(Mode, int);
  ///@}

  ///@{
  /// BOUNDED and SMALLEST: how far a point may move along its grid edge, in lengths of that edge.
  /// Above 0, at most 0.5. Default 0.05.
  vtkSetMacro(MaximumError, double);
  vtkGetMacro(MaximumError, double);
  ///@}

  ///@{
  /// Speed against bytes. Default WORKING. The numbers 1 and 2, which were profiles in version 1.0,
  /// become WORKING and SMALL, with a warning.
  void SetProfile(int profile);
  vtkGetMacro(Profile, int);
  ///@}

  ///@{
  /// The maximum error of a component of a normal, if the contour computes normals. 0 keeps every
  /// bit, with four times as many bytes. Default 0.01, which changes shades by one of 255 here and
  /// there, and by a little more at creases as small as a pixel.
  vtkSetClampMacro(NormalError, double, 0, 1);
  vtkGetMacro(NormalError, double);
  ///@}

  ///@{
  /// The maximum error of a value of an interpolated array; 0, the default, keeps every bit.
  vtkSetClampMacro(ArrayError, double, 0, VTK_DOUBLE_MAX);
  vtkGetMacro(ArrayError, double);
  ///@}

  ///@{
  /// The number of ranks that get a piece, the first ones. 0, the default, or more than there are:
  /// all.
  vtkSetClampMacro(DrawingRanks, int, 0, VTK_INT_MAX);
  vtkGetMacro(DrawingRanks, int);
  ///@}

  ///@{
  /// Bytes that a rank sends at a time, but for the last block's: what is under way takes as much
  /// memory, besides the encoded blocks that a rank had and gets. Default 4 MiB.
  vtkSetClampMacro(RoundBytes, vtkIdType, 1, VTK_ID_MAX);
  vtkGetMacro(RoundBytes, vtkIdType);
  ///@}

  ///@{
  /// Threads to encode and decode with; 0 (the default): this rank's share of the node's cores.
  vtkSetClampMacro(NumberOfThreads, int, 0, 4096);
  vtkGetMacro(NumberOfThreads, int);
  ///@}

  ///@{
  /// The ranks that execute together, the global controller by default, which should be the
  /// contour's. Null: this rank alone.
  virtual void SetController(vtkMultiProcessController* controller);
  vtkGetObjectMacro(Controller, vtkMultiProcessController);
  ///@}

  /// Whether blocks are taken, and the input is not executed: where there are several ranks.
  bool TakesBlocks() const;

protected:
  vtkDistributeIsosurface();
  ~vtkDistributeIsosurface() override;

  /// A vtkBlockConsumerPipeline.
  vtkExecutive* CreateDefaultExecutive() override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

private:
  vtkDistributeIsosurface(const vtkDistributeIsosurface&) = delete;
  void operator=(const vtkDistributeIsosurface&) = delete;

  struct Steps; ///< of RequestData

  int Mode = LOSSLESS;
  double MaximumError = 0.05;
  int Profile = WORKING;
  double NormalError = 0.01;
  double ArrayError = 0;
  int DrawingRanks = 0;
  vtkIdType RoundBytes = vtkIdType{ 4 } << 20;
  int NumberOfThreads = 0;
  vtkMultiProcessController* Controller = nullptr;
};

#endif
