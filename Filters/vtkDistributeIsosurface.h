// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkDistributeIsosurface
 * @brief   brings an isosurface to the ranks that draw it, compressed
 *
 * The input is the output of a vtkStabbingContour, as it is. Its ranks have whatever blocks are in
 * their stores, spread over the whole volume. The output of this filter is the same surface, dealt
 * out anew: each drawing rank has a part that is compact in space, and all parts have about as many
 * triangles. So each rank draws into a small part of the picture (see vtkMetabufferRenderView).
 *
 * What travels is not triangles but where the isovalues cross the grid, as edge-index records, some
 * bits a vertex. So this filter takes the contour's blocks (CollectContourBlocks), and
 * the contour is not executed. While blocks are under way, those that are there become triangles.
 *
 * The output has the triangles and GlobalIds of the contour, and its point data: isovalues,
 * Normals, interpolated arrays. Points are those of the contour with LOSSLESS, bit by bit, and
 * within MaximumError with BOUNDED and SMALLEST; so are normals within NormalError and arrays
 * within ArrayError. Points on the borders of parts are there once on each side, and equal. A part
 * depends on the number of drawing ranks alone, not on where its blocks came from.
 *
 * Where there is one rank only, nothing travels, and the output is the input.
 *
 * Of the contour's properties, TimeBudget and Progressive are without effect on several ranks: the
 * surface is that of Level, or what MaximumTriangles allows. DropDegenerateTriangles and
 * CloseBoundary are errors, and so is any other input.
 *
 * Field data, of this rank, times in seconds: Rank, Level; ExtractedPoints and ReceivedPoints, of
 * the blocks that it had and that it got (those on shared faces once a block); Triangles that it
 * got; RawBytes of these (points, GlobalIds, normals, arrays, three corners a triangle),
 * EncodedBytes of all blocks that it had, SentBytes to other ranks; Rounds; QuerySeconds until the
 * active blocks are known, EncodeSeconds, which include reading, ChooseSeconds until it is known
 * which block goes where, ExchangeSeconds until all have arrived, DecodeSeconds from then on.
 *
 * Every rank of the controller must execute together. Errors of any rank are reported by all; the
 * output is empty then.
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
    LOSSLESS = 1, ///< every point, bit by bit
    BOUNDED = 2,  ///< every point to within MaximumError
    SMALLEST = 3  ///< of each block the smaller of LOSSLESS and BOUNDED
  };

  enum ProfileType
  {
    DEFAULT = 0, ///< small
    FAST = 1     ///< encoded and decoded about three times as fast, some percent larger
  };

  ///@{
  /**
   * In what form the surface travels. Default LOSSLESS.
   */
  vtkSetClampMacro(Mode, int, LOSSLESS, SMALLEST);
  vtkGetMacro(Mode, int);
  ///@}

  ///@{
  /**
   * BOUNDED and SMALLEST: the most by which a point may move, along its grid edge, in lengths of
   * that edge. Above 0, at most 0.5. Default 0.05.
   */
  vtkSetMacro(MaximumError, double);
  vtkGetMacro(MaximumError, double);
  ///@}

  ///@{
  /**
   * How much time is spent on sending little. Default FAST.
   */
  vtkSetClampMacro(Profile, int, DEFAULT, FAST);
  vtkGetMacro(Profile, int);
  ///@}

  ///@{
  /**
   * The most by which a component of a normal may change, if the contour
   * computes normals. 0 keeps every bit, and makes four times as many bytes. Default 0.01, which
   * changes shades by one of 255 here and there, and by some more at creases as small as a pixel.
   */
  vtkSetClampMacro(NormalError, double, 0, 1);
  vtkGetMacro(NormalError, double);
  ///@}

  ///@{
  /**
   * The most by which a value of an interpolated array may change; 0, the
   * default, keeps every bit.
   */
  vtkSetClampMacro(ArrayError, double, 0, VTK_DOUBLE_MAX);
  vtkGetMacro(ArrayError, double);
  ///@}

  ///@{
  /**
   * The ranks that get a part: the first ones. 0, the default, or more than there are: all.
   */
  vtkSetClampMacro(DrawingRanks, int, 0, VTK_INT_MAX);
  vtkGetMacro(DrawingRanks, int);
  ///@}

  ///@{
  /**
   * Bytes that a rank sends at a time, but for the last block's: what is under way takes as much
   * memory, beside the encoded blocks that a rank had and gets. Default 4 MiB.
   */
  vtkSetClampMacro(RoundBytes, vtkIdType, 1, VTK_ID_MAX);
  vtkGetMacro(RoundBytes, vtkIdType);
  ///@}

  ///@{
  /**
   * Threads to encode and decode with; 0 (the default): this rank's share of the node's cores.
   */
  vtkSetClampMacro(NumberOfThreads, int, 0, 4096);
  vtkGetMacro(NumberOfThreads, int);
  ///@}

  ///@{
  /**
   * The ranks that execute together, the global controller by default, which should be the
   * contour's. Null: this rank alone.
   */
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

  bool TellProgress(double share);

  int Mode;
  double MaximumError;
  int Profile;
  double NormalError;
  double ArrayError;
  int DrawingRanks;
  vtkIdType RoundBytes;
  int NumberOfThreads;
  vtkMultiProcessController* Controller;
};

#endif
