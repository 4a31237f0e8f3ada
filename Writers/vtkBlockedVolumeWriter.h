// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBlockedVolumeWriter
 * @brief   writes image data or a rectilinear grid as a blocked volume (.bvol)
 *
 * The grid may be distributed over the ranks of the controller in any pieces, overlapping
 * ones included; every rank calls Write(). All numeric point arrays are written, with any number of
 * components, or only the chosen ones. Cell arrays give a warning; an input with only cell arrays
 * is an error. A disk without room for the samples uncompressed gives a warning before anything is written.
 *
 * Behind a blocked volume whose samples arrive unchanged, the whole volume is written, at full
 * resolution, whatever level the reader gives: of each store all blocks are read, in slabs. So a
 * volume can be written anew with other settings, over its own file, too.
 *
 * A volume may have several time steps: AppendTimeStep adds one to a file, WriteAllTimeSteps writes
 * all that the input has. The file appears in one step at the end. If there is an error on any
 * rank, all ranks report it, and an older file stays unchanged. The file does not depend on the
 * number of ranks, except for the default of NumberOfStores.
 */

#ifndef vtkBlockedVolumeWriter_h
#define vtkBlockedVolumeWriter_h

#include "IsosurfaceWritersModule.h" // For export macro
#include "vtkNew.h"                  // For the selection
#include "vtkWriter.h"

#include <cstddef> // For std::size_t
#include <memory>  // For the session
#include <vector>  // For the time steps

class vtkDataArraySelection;
class vtkImageData;
class vtkMultiProcessController;

class ISOSURFACEWRITERS_EXPORT vtkBlockedVolumeWriter : public vtkWriter
{
public:
  static vtkBlockedVolumeWriter* New();
  vtkTypeMacro(vtkBlockedVolumeWriter, vtkWriter);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum DistributionType
  {
    GREEDY = 0,  ///< distribute blocks with similar value ranges in turn
    RANDOM = 1,  ///< scatter blocks by a seeded hash
    SLAB = 2,    ///< keep neighbours together; not balanced
    BALANCED = 3 ///< give each store an equal number of estimated triangles
  };

  enum CompressionType
  {
    NONE = 0, ///< samples as they are
    LZ4 = 1,  ///< fast
    ZSTD = 2  ///< small
  };

  ///@{
  /**
   * The .bvol file to write. The stores go into the folder .NAME.bvol.stores beside it.
   */
  vtkSetFilePathMacro(FileName);
  vtkGetFilePathMacro(FileName);
  ///@}

  ///@{
  /**
   * Cells along the side of a block: 16, 32 (the default) or 64.
   */
  vtkSetMacro(BlockSize, int);
  vtkGetMacro(BlockSize, int);
  ///@}

  ///@{
  /**
   * How many stores the blocks are distributed over; 0 (the default): the number of ranks.
   */
  vtkSetClampMacro(NumberOfStores, int, 0, 65536);
  vtkGetMacro(NumberOfStores, int);
  ///@}

  ///@{
  /**
   * How many stores have each block, at most NumberOfStores. With 2 or more, a lost or damaged
   * store costs nothing but speed, and `blockvolume --repair` restores it; the files take as many
   * times the space. 0 (the default): 1, or as many as the file that is appended to.
   */
  vtkSetClampMacro(NumberOfReplicas, int, 0, 16);
  vtkGetMacro(NumberOfReplicas, int);
  ///@}

  ///@{
  /**
   * How blocks are distributed over stores. Default GREEDY.
   */
  vtkSetClampMacro(Distribution, int, GREEDY, BALANCED);
  vtkGetMacro(Distribution, int);
  ///@}

  ///@{
  /**
   * The seed of the random distribution.
   */
  vtkSetClampMacro(RandomSeed, int, 0, VTK_INT_MAX);
  vtkGetMacro(RandomSeed, int);
  ///@}

  ///@{
  /**
   * How blocks are compressed, always without loss. Default LZ4, which is read nearly as fast as
   * uncompressed blocks; ZSTD needs the fewest bytes. Blocks that do not shrink are stored
   * uncompressed.
   */
  vtkSetClampMacro(Compression, int, NONE, ZSTD);
  vtkGetMacro(Compression, int);
  ///@}

  ///@{
  /**
   * 1 (fast) to 12 for LZ4, 1 to 19 for ZSTD; 0 (the default) means 1. Any other level is an error
   * when writing.
   */
  vtkSetClampMacro(CompressionLevel, int, 0, 19);
  vtkGetMacro(CompressionLevel, int);
  ///@}

  ///@{
  /**
   * MiB that a rank may use to write a volume larger than memory: each rank reads its share of the
   * input in slabs. 0 (the default): each rank reads its piece at once, and the whole input is in
   * memory.
   *
   * The input must be able to deliver any piece of its whole extent on every rank, without the help
   * of other ranks, as readers of a file that all ranks see do. Its own memory is not counted. An
   * input that always delivers everything is written as well, but is in memory as a whole.
   */
  vtkSetClampMacro(MemoryLimit, int, 0, VTK_INT_MAX);
  vtkGetMacro(MemoryLimit, int);
  ///@}

  ///@{
  /**
   * Whether only those arrays are written that GetPointDataArraySelection() enables. Default off:
   * all of them. A chosen array that the input does not have is an error.
   */
  vtkSetMacro(ChooseArraysToWrite, bool);
  vtkGetMacro(ChooseArraysToWrite, bool);
  vtkBooleanMacro(ChooseArraysToWrite, bool);
  vtkDataArraySelection* GetPointDataArraySelection();
  ///@}

  ///@{
  /**
   * Whether cell arrays are written, too, averaged to points as vtkCellDataToPointData does, unless
   * there is a point array of the name. ChooseArraysToWrite chooses among them as well. Default
   * off.
   */
  vtkSetMacro(WriteCellArrays, bool);
  vtkGetMacro(WriteCellArrays, bool);
  vtkBooleanMacro(WriteCellArrays, bool);
  ///@}

  ///@{
  /**
   * Whether the input is added to an existing file, as another time step; a new file gets it as
   * its first time step. Default off: a file is replaced. The time is that of the input
   * (DATA_TIME_STEP, else UPDATE_TIME_STEP) and must be greater than that of the file's last time
   * step; grid, arrays and settings must be those of the file (NumberOfStores 0, NumberOfReplicas
   * 0: those of the file). Earlier time steps are not touched: readers see them alone, or the new
   * one as well.
   */
  vtkSetMacro(AppendTimeStep, bool);
  vtkGetMacro(AppendTimeStep, bool);
  vtkBooleanMacro(AppendTimeStep, bool);
  ///@}

  ///@{
  /**
   * Whether all time steps of the input (its TIME_STEPS) are written. Default off: the current one.
   * They appear together at the end. With AppendTimeStep they are added to those of the file.
   */
  vtkSetMacro(WriteAllTimeSteps, bool);
  vtkGetMacro(WriteAllTimeSteps, bool);
  vtkBooleanMacro(WriteAllTimeSteps, bool);
  ///@}

  ///@{
  /**
   * The ranks that write together, the global controller by default. Null: this rank alone.
   */
  virtual void SetController(vtkMultiProcessController* controller);
  vtkGetObjectMacro(Controller, vtkMultiProcessController);
  ///@}

  ///@{
  /**
   * The image data to write.
   */
  vtkImageData* GetInput();
  vtkImageData* GetInput(int port);
  ///@}

  vtkMTimeType GetMTime() override;

protected:
  vtkBlockedVolumeWriter();
  ~vtkBlockedVolumeWriter() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  vtkTypeBool ProcessRequest(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  void WriteData() override;

private:
  vtkBlockedVolumeWriter(const vtkBlockedVolumeWriter&) = delete;
  void operator=(const vtkBlockedVolumeWriter&) = delete;

  struct Session; ///< what is written between the first and the last time step

  bool IsLastTimeStep() const;

  char* FileName = nullptr;
  int BlockSize = 32;
  int NumberOfStores = 0;
  int NumberOfReplicas = 0;
  int Distribution = GREEDY;
  int RandomSeed = 0;
  int Compression = LZ4;
  int CompressionLevel = 0;
  int MemoryLimit = 0;
  bool ChooseArraysToWrite = false;
  bool WriteCellArrays = false;
  bool AppendTimeStep = false;
  bool WriteAllTimeSteps = false;
  vtkMultiProcessController* Controller = nullptr;
  vtkNew<vtkDataArraySelection> PointDataArraySelection;
  std::vector<double> TimeSteps; ///< that are to be written; empty for the one that is there
  std::size_t TimeIndex = 0;     ///< into TimeSteps
  std::unique_ptr<Session> Writing;
};

#endif
