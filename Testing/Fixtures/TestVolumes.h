// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TestVolumes_h
#define isosurface_TestVolumes_h

#include "ScratchFolder.h"
#include "TestImages.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkBlockedVolumeWriter.h"

#include <cstdint>
#include <string>

namespace isosurface
{

/**
 * A ball with a rough surface, from about 0 (far off) to 250 (in its middle), and 0 on the border,
 * so that all isosurfaces are closed. The same for the same arguments on every machine and rank.
 */
vtkSmartPointer<vtkImageData> MakeClosedVolume(const Extent& extent, int type);

/// Gives an image an origin, unequal spacings and axes that are oblique to the world's.
void TurnObliquely(vtkImageData* image);

/// How a volume is cut and spread when it is written.
struct VolumeSettings
{
  int BlockSize = 16;
  int NumberOfStores = 1;
  int Distribution = vtkBlockedVolumeWriter::GREEDY;
  int Compression = vtkBlockedVolumeWriter::LZ4;
  int NumberOfReplicas = 0;
};

/// Lets a writer write its input as a volume; a test fails if that reports an error.
void WriteVolume(
  vtkBlockedVolumeWriter* writer, const std::string& path, const VolumeSettings& settings);

/// Writes an image or a rectilinear grid, on this process alone; a test fails if that reports an
/// error.
void WriteVolume(
  vtkDataObject* input, const std::string& path, const VolumeSettings& settings = {});

/// A volume of a data object in a folder of the running test.
struct ScratchVolume
{
  explicit ScratchVolume(vtkDataObject* input, const VolumeSettings& settings = {});

  const ScratchFolder Folder;
  const std::string Path;
};

vtkSmartPointer<vtkBlockedVolumeReader> MakeReader(const std::string& path);

/// Every 2^level-th vertex of an image, by vtkExtractVOI; as a level of a blocked volume of it.
vtkSmartPointer<vtkImageData> SubsampleImage(vtkImageData* image, int level);

/// What a query must cost: counted from the image alone.
struct ExpectedCost
{
  std::uint64_t ActiveBlocks = 0; ///< blocks with samples on both sides of the isovalue
  std::uint64_t StoredBytes = 0;  ///< samples that those store: all levels, with ghost layers
};
ExpectedCost CountActiveBlocks(vtkImageData* image, int blockSize, double isovalue);

/// The sum of a number that a contour's outputs have in their field data.
std::uint64_t GetCost(vtkPolyData* surface, const char* name);

} // namespace isosurface

#endif
