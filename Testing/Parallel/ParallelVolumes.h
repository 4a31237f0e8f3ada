// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ParallelVolumes_h
#define isosurface_ParallelVolumes_h

#include "PieceSource.h"
#include "RankGroup.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include <memory>
#include <string>
#include <vector>

class vtkBlockedVolumeReader;
class vtkStabbingContour;

namespace isosurface
{

/// A scratch folder that all ranks share; collective.
class SharedFolder
{
public:
  explicit SharedFolder(const std::string& name);
  ~SharedFolder();

  std::string GetPath(const std::string& name) const;

private:
  std::string Path;
  std::unique_ptr<ScratchFolder> Folder; ///< on rank 0
};

/// Writes an image from pieces on all ranks; collective.
void WriteFromPieces(
  vtkImageData* image, int layout, const std::string& path, const VolumeSettings& settings);

/// A volume of an image in a shared folder; collective.
struct SharedVolume
{
  SharedVolume(const std::string& name, vtkImageData* image, const VolumeSettings& settings,
    int layout = PieceSource::SUB_EXTENTS);

  const SharedFolder Folder;
  const std::string Path;
};

/// A source of pieces of an image.
vtkSmartPointer<PieceSource> MakeSource(vtkImageData* image, int layout = PieceSource::SUB_EXTENTS);

/// Expects the surface that vtkFlyingEdges3D makes of the whole image in the parts of all ranks;
/// collective.
void ExpectSurfaceOf(vtkPolyData* mine, vtkImageData* image, double isovalue);

/// Brings this rank's part of a surface up to date as a window does after a change by hand: coarse, then
/// finer until it is final; collective.
void ShowByHand(vtkStabbingContour* contour);

/// A reader and a contour behind it, on every rank.
class ContourPipeline
{
public:
  explicit ContourPipeline(const std::string& path);
  ~ContourPipeline();

  /// This rank's part of the isosurfaces; collective. A test fails if there is an error.
  vtkPolyData* Update(const std::vector<double>& isovalues);

  vtkSmartPointer<vtkBlockedVolumeReader> Reader;
  vtkSmartPointer<vtkStabbingContour> Contour;
};

} // namespace isosurface

#endif
