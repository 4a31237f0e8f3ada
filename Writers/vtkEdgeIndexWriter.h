// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkEdgeIndexWriter
 * @brief   writes an isosurface as an edge-index file (.eix): a few bits a vertex
 *
 * The input is the output of a vtkStabbingContour, as it is. What is written is not its triangles
 * but where the isovalues cross the grid, so the writer takes the contour's blocks instead, some at
 * a time (CollectContourBlocks): Write() does not make the contour extract anything,
 * and a surface of any size is written within MemoryLimit. Connectivity and GlobalIds are kept
 * exactly, points as Mode tells; interpolated arrays and normals exactly or within a bound. Any
 * other input (a surface that was clipped, say) is an error.
 *
 * All ranks of the controller call Write(), and write one file together, which does not depend on
 * how many they are, nor on the number of threads. It appears in one step when everything is
 * written; if anything fails, on any rank, all ranks report an error and what was there before is
 * left as it was.
 *
 * Surfaces with DropDegenerateTriangles, CloseBoundary or polygons cannot be written.
 */

#ifndef vtkEdgeIndexWriter_h
#define vtkEdgeIndexWriter_h

#include "IsosurfaceWritersModule.h" // For export macro
#include "vtkWriter.h"

class vtkMultiProcessController;

class ISOSURFACEWRITERS_EXPORT vtkEdgeIndexWriter : public vtkWriter
{
public:
  static vtkEdgeIndexWriter* New();
  vtkTypeMacro(vtkEdgeIndexWriter, vtkWriter);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum ModeType
  {
    LOSSLESS = 0,  ///< every point, bit by bit
    BOUNDED = 1,   ///< every point to within MaximumError
    QUANTIZED = 2, ///< values to QuantizationBits
    SMALLEST = 3   ///< of each block the smaller of LOSSLESS and BOUNDED
  };

  enum ProfileType
  {
    DEFAULT = 0, ///< small
    FAST = 1,    ///< written and read about three times as fast, a tenth larger
    COMPACT = 2  ///< smaller by a twentieth to a tenth; takes two to four times as long
  };

  ///@{
  /**
   * The .eix file to write.
   */
  vtkSetFilePathMacro(FileName);
  vtkGetFilePathMacro(FileName);
  ///@}

  ///@{
  /**
   * What is kept of where points lie. Default LOSSLESS.
   */
  vtkSetClampMacro(Mode, int, LOSSLESS, SMALLEST);
  vtkGetMacro(Mode, int);
  ///@}

  ///@{
  /**
   * BOUNDED and SMALLEST: the most by which a point may move, along its grid edge, in lengths of
   * that edge. Above 0, at most 0.5. Default 0.01.
   */
  vtkSetMacro(MaximumError, double);
  vtkGetMacro(MaximumError, double);
  ///@}

  ///@{
  /**
   * QUANTIZED: bits of the samples' values, over the whole range of the array. Default 12.
   */
  vtkSetClampMacro(QuantizationBits, int, 2, 24);
  vtkGetMacro(QuantizationBits, int);
  ///@}

  ///@{
  /**
   * How much time is spent on a small file. Default DEFAULT.
   */
  vtkSetClampMacro(Profile, int, DEFAULT, COMPACT);
  vtkGetMacro(Profile, int);
  ///@}

  ///@{
  /**
   * Whether the arrays that the contour interpolates are written. Default on.
   */
  vtkSetMacro(WriteArrays, bool);
  vtkGetMacro(WriteArrays, bool);
  vtkBooleanMacro(WriteArrays, bool);
  ///@}

  ///@{
  /**
   * The most by which a value of these arrays may change; 0, the default, keeps every bit.
   */
  vtkSetClampMacro(ArrayError, double, 0, VTK_DOUBLE_MAX);
  vtkGetMacro(ArrayError, double);
  ///@}

  ///@{
  /**
   * Whether the contour's normals are written, if it computes any; otherwise vtkEdgeIndexReader
   * makes normals of the triangles. Default off: they take about as much space as all the rest.
   */
  vtkSetMacro(WriteNormals, bool);
  vtkGetMacro(WriteNormals, bool);
  vtkBooleanMacro(WriteNormals, bool);
  ///@}

  ///@{
  /**
   * The most by which a component of a normal may change; 0 keeps every bit. Default 0.005.
   */
  vtkSetClampMacro(NormalError, double, 0, 1);
  vtkGetMacro(NormalError, double);
  ///@}

  ///@{
  /**
   * A coarse surface is in the file as well, of every 2^PreviewLevel-th vertex of the grid, so that
   * it can be looked at before all is read; 0: none. Where blocks are smaller than that (of coarse
   * levels of a volume) it is of a lower level. Default 3, which adds about 2 percent.
   */
  vtkSetClampMacro(PreviewLevel, int, 0, 6);
  vtkGetMacro(PreviewLevel, int);
  ///@}

  ///@{
  /**
   * The MiB of encoded surface that a rank holds before it writes. Beside them it takes a few MiB a
   * thread, and what the input takes: of a blocked volume its CacheSize. Default 256.
   */
  vtkSetClampMacro(MemoryLimit, int, 1, VTK_INT_MAX);
  vtkGetMacro(MemoryLimit, int);
  ///@}

  ///@{
  /**
   * Whether all time steps of the input are written, each to a file of its own: NAME_0.eix,
   * NAME_1.eix and so on, which ParaView opens as one series. Default off: the one that the input
   * is at.
   */
  vtkSetMacro(WriteAllTimeSteps, bool);
  vtkGetMacro(WriteAllTimeSteps, bool);
  vtkBooleanMacro(WriteAllTimeSteps, bool);
  ///@}

  ///@{
  /**
   * Threads to encode with; 0 (the default): this rank's share of the node's cores.
   */
  vtkSetClampMacro(NumberOfThreads, int, 0, 4096);
  vtkGetMacro(NumberOfThreads, int);
  ///@}

  ///@{
  /**
   * The ranks that write together, the global controller by default, which should be the contour's.
   * Null: this rank alone.
   */
  virtual void SetController(vtkMultiProcessController* controller);
  vtkGetObjectMacro(Controller, vtkMultiProcessController);
  ///@}

  /**
   * Writes without updating the input. 1 if all went well.
   */
  int Write() override;

protected:
  vtkEdgeIndexWriter();
  ~vtkEdgeIndexWriter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  void WriteData() override;

private:
  vtkEdgeIndexWriter(const vtkEdgeIndexWriter&) = delete;
  void operator=(const vtkEdgeIndexWriter&) = delete;

  struct Steps; ///< of WriteData

  char* FileName;
  int Mode;
  double MaximumError;
  int QuantizationBits;
  int Profile;
  bool WriteArrays;
  double ArrayError;
  bool WriteNormals;
  double NormalError;
  int PreviewLevel;
  int MemoryLimit;
  bool WriteAllTimeSteps;
  int NumberOfThreads;
  vtkMultiProcessController* Controller;
};

#endif
