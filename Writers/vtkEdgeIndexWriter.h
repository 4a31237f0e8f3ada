// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkEdgeIndexWriter
 * @brief   writes an isosurface as an edge-index file (.eix), a few bits a point
 *
 * Input: the unchanged output of a vtkStabbingContour. The file holds where the isovalues cross the
 * grid, instead of triangles. So Write() takes the contour's blocks, some at a time
 * (ContourExecution::TakeBlocks), without executing the contour, and writes a surface of any size within
 * MemoryLimit. Connectivity and GlobalIds are exact, points as Mode says, interpolated arrays and
 * normals exact or within a bound. Any other input is an error, and so are surfaces with
 * DropDegenerateTriangles (but of closed ones), island ids or polygons.
 *
 * If the contour leaves islands out, each rank first makes the triangles of its blocks, to find
 * them: see MakeSurfaceHeader. A closed surface is lossless then, in every mode.
 *
 * All ranks of the controller call Write(), and write one file together. It does not depend on the
 * number of ranks or threads, and appears in one step at the end. If there is an error on any rank,
 * all ranks report it, and an older file stays unchanged.
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
    SMALL = 0,  ///< the fewest bytes
    WORKING = 3 ///< read five to seven times as fast, lossless up to a half larger
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
   * How exact points are. Default LOSSLESS.
   */
  vtkSetClampMacro(Mode, int, LOSSLESS, SMALLEST);
  vtkGetMacro(Mode, int);
  ///@}

  ///@{
  /**
   * BOUNDED and SMALLEST: how far a point may move along its grid edge, in lengths of that edge.
   * Above 0, at most 0.5. Default 0.01.
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
   * Speed against size. Default SMALL. The numbers 1 and 2, which were profiles in version 1.0,
   * become WORKING and SMALL, with a warning.
   */
  void SetProfile(int profile);
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
   * The maximum error of a value of these arrays; 0, the default, keeps every bit.
   */
  vtkSetClampMacro(ArrayError, double, 0, VTK_DOUBLE_MAX);
  vtkGetMacro(ArrayError, double);
  ///@}

  ///@{
  /**
   * Whether the contour's normals are written, if it computes any. Without them vtkEdgeIndexReader
   * computes normals from the triangles. Default off: they take about as much space as everything
   * else.
   */
  vtkSetMacro(WriteNormals, bool);
  vtkGetMacro(WriteNormals, bool);
  vtkBooleanMacro(WriteNormals, bool);
  ///@}

  ///@{
  /**
   * The maximum error of a component of a normal; 0 keeps every bit. Default 0.005.
   */
  vtkSetClampMacro(NormalError, double, 0, 1);
  vtkGetMacro(NormalError, double);
  ///@}

  ///@{
  /**
   * The file also holds a coarse surface, of every 2^PreviewLevel-th vertex of the grid on each
   * axis, to look at before everything is read; 0: none. If blocks are smaller than that, as those
   * of coarse levels are, the level is lower. Default 3, which adds about 2 per cent.
   */
  vtkSetClampMacro(PreviewLevel, int, 0, 6);
  vtkGetMacro(PreviewLevel, int);
  ///@}

  ///@{
  /**
   * MiB of encoded surface that a rank holds before it writes. In addition it takes a few MiB a
   * thread, and the memory of the input: for a blocked volume the CacheSize of the reader. Default
   * 256.
   */
  vtkSetClampMacro(MemoryLimit, int, 1, VTK_INT_MAX);
  vtkGetMacro(MemoryLimit, int);
  ///@}

  ///@{
  /**
   * Whether all time steps of the input are written, each to its own file: NAME_0.eix, NAME_1.eix
   * and so on, which ParaView opens as one series. Default off: the current time step.
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
   * Writes without executing the input. 1 for success.
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

  char* FileName = nullptr;
  int Mode = LOSSLESS;
  double MaximumError = 0.01;
  int QuantizationBits = 12;
  int Profile = SMALL;
  bool WriteArrays = true;
  double ArrayError = 0;
  bool WriteNormals = false;
  double NormalError = 0.005;
  int PreviewLevel = 3;
  int MemoryLimit = 256;
  bool WriteAllTimeSteps = false;
  int NumberOfThreads = 0;
  vtkMultiProcessController* Controller = nullptr;
};

#endif
