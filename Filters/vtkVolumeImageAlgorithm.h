// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkVolumeImageAlgorithm
 * @brief   filters that make an image of the samples of a blocked volume
 *
 * Input: a blocked volume (vtkBlockedVolumeReader, vtkInPlaceVolumeReader), of which only the blocks
 * that the image needs are read. First output: an image with the arrays that are chosen in the reader.
 *
 * All ranks of the controller execute together, each for a part of the image, and all must reach all
 * stores. All report the errors of any.
 */

#ifndef vtkVolumeImageAlgorithm_h
#define vtkVolumeImageAlgorithm_h

#include "IsosurfaceFiltersModule.h" // For export macro
#include "vtkDataSetAlgorithm.h"

#include <array>   // For the window
#include <cstddef> // For numbers of arrays
#include <cstdint> // For checksums
#include <memory>  // For the work
#include <string>  // For the text
#include <vector>  // For numbers of arrays

class vtkMultiProcessController;

namespace isosurface
{
class BlockedVolume;
class Status;
struct ImagePlan;
}

class ISOSURFACEFILTERS_EXPORT vtkVolumeImageAlgorithm : public vtkDataSetAlgorithm
{
public:
  vtkTypeMacro(vtkVolumeImageAlgorithm, vtkDataSetAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// What the image is, in words: "2048 x 2048 points, full resolution". Known when the information of the
  /// pipeline is up to date, before samples are read.
  const char* GetShownText() { return this->ShownText.c_str(); }

  ///@{
  /// For a window, as of vtkStabbingContour: while coarse images are allowed, a large image of
  /// something new is coarse, if the filter makes coarse ones, and not final. PrepareRefinement then
  /// reads the exact one beside the calling thread, and waits for it, but not longer than this.
  /// Refinement has the values of Ranks/Query/Refinement.h, as the last call found them. The execution
  /// after Refine gives the exact image. All ranks call these together. DropRefinement stops the reading.
  void AllowCoarse(vtkTypeBool allowed);
  vtkGetMacro(Final, int);
  void Refine();
  void PrepareRefinement(int milliseconds);
  void DropRefinement();
  double* GetRefinement() VTK_SIZEHINT(10) { return this->Refinement.data(); }
  ///@}

  ///@{
  /// The ranks that execute together, the global controller by default. Null: this rank alone.
  virtual void SetController(vtkMultiProcessController* controller);
  vtkGetObjectMacro(Controller, vtkMultiProcessController);
  ///@}

protected:
  vtkVolumeImageAlgorithm();
  ~vtkVolumeImageAlgorithm() override;

  /// A checksum of the filter's properties.
  virtual std::uint64_t SumProperties() = 0;
  /// Plans the image that is made of a volume; `arrays` are those that are read. `isCoarse`: one that is soon
  /// there, if the exact one takes long. Errors: nothing of the volume is wanted.
  virtual isosurface::Status Plan(const isosurface::BlockedVolume& volume,
    const std::vector<std::size_t>& arrays, bool isCoarse, isosurface::ImagePlan& plan) = 0;
  /// Fills the first output, or leaves it empty. Collective. The error, or a stop, is that of all ranks.
  isosurface::Status MakeImage(
    vtkInformation* request, vtkInformation* inInfo, vtkInformationVector* output);

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  /// Collective if the input's volume is made by its first update, as an index in place is.
  int RequestInformation(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestUpdateExtent(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

private:
  vtkVolumeImageAlgorithm(const vtkVolumeImageAlgorithm&) = delete;
  void operator=(const vtkVolumeImageAlgorithm&) = delete;

  struct Work; ///< what is kept between executions

  vtkMultiProcessController* Controller = nullptr;
  std::array<double, 10> Refinement;
  std::string ShownText;
  int Final = 1;
  const std::unique_ptr<Work> Internals;
};

#endif
