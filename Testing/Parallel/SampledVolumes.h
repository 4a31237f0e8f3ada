// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SampledVolumes_h
#define isosurface_SampledVolumes_h

#include "ParallelVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkVolumeSlice.h"

#include "vtkImageData.h"
#include "vtkSmartPointer.h"

#include <array>
#include <string>

namespace isosurface
{

constexpr Extent SampledExtent = { -4, 60, 3, 35, 0, 49 };

/// Waves of a VTK type on an oblique grid with this extent.
vtkSmartPointer<vtkImageData> MakeSampledImage(int type);

/// A reader whose ranks are all of this program.
vtkSmartPointer<vtkBlockedVolumeReader> OpenOnRanks(const std::string& path);

/// Brings this rank's part up to date; a test fails if there is an error. Collective.
template <typename Filter>
void UpdatePart(Filter* filter)
{
  const ExpectNoErrors errors(filter);
  filter->SetController(GetRanks());
  filter->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
}

/// A slice near the middle of the image, but not where values are halfway between two integers.
vtkSmartPointer<vtkVolumeSlice> MakeSlice(
  vtkBlockedVolumeReader* reader, vtkImageData* image, const std::array<double, 3>& normal);

/// Expects in "density" what vtkProbeFilter finds in the image at the same points. Integers may
/// differ by 1 where the value is halfway between two.
void ExpectStockValues(vtkDataSet* points, vtkImageData* image);

/// Collective: the cells of all parts are those of an image of this extent.
void ExpectWhole(vtkImageData* part, const int* whole);

} // namespace isosurface

#endif
