// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SoakVolume_h
#define isosurface_SoakVolume_h

#include "TestVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkStabbingContour.h"

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace isosurface
{

/// The kinds of volumes, each with its own type, grid and stores; the last one has time steps.
constexpr int NumberOfSoakVolumes = 5;

/// What a consumer is asked for.
struct SoakQuery
{
  std::size_t Consumer = 0;
  std::size_t Step = 0;
  std::size_t Isovalue = 0;
  int Level = 0;
};

/**
 * A blocked volume on disk, the images it was made of, a reader, and three contours behind it: a plain
 * one, one without normals, and a progressive one.
 */
class SoakVolume
{
public:
  static constexpr std::size_t NumberOfConsumers = 3;
  static constexpr std::size_t NumberOfIsovalues = 5;

  SoakVolume(int kind, const std::string& path);

  /// Writes other samples to the same path, while the reader has it open, and reloads.
  void Replace();
  /// Lets go of the reader and its contours, and makes new ones.
  void Reopen();

  std::size_t GetNumberOfSteps() const { return this->Images.size(); }

  /// Executes a contour. A test fails if its surface is not that of vtkFlyingEdges3D, or if there is
  /// an error. A progressive one is prepared and refined as often as `random` says.
  void Ask(const SoakQuery& query, std::mt19937& random);

private:
  struct Consumer
  {
    vtkNew<vtkStabbingContour> Contour;
    std::unique_ptr<ErrorCounter> Errors;
  };
  struct Pipeline
  {
    vtkNew<vtkBlockedVolumeReader> Reader;
    std::unique_ptr<ErrorCounter> Errors;
    std::array<Consumer, NumberOfConsumers> Consumers;
  };

  void MakeImages();
  void Write();
  double GetIsovalue(std::size_t number) const;
  /// Of the surface that vtkFlyingEdges3D has at a level; computed once.
  std::size_t GetExpectedHash(const SoakQuery& query, int level);
  /// Compares the output of the consumer, at whatever level it is.
  void ExpectSurface(const SoakQuery& query);

  int Kind;
  std::string Path;
  unsigned int Generation = 0;
  std::vector<vtkSmartPointer<vtkImageData>> Images; ///< one a time step
  std::vector<double> Times;
  std::unique_ptr<Pipeline> Pipes;
  std::map<std::array<std::size_t, 4>, std::size_t> Hashes;
};

} // namespace isosurface

#endif
