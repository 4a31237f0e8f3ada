// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeReading_h
#define isosurface_VolumeReading_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"

#include <cstdint>
#include <functional>

class vtkAlgorithm;
class vtkInformation;

namespace isosurface
{

class VolumeInput;

/// RequestUpdateExtent of a filter that reads samples of a blocked volume itself: the reader's own
/// output is not needed.
void AskVolume(vtkAlgorithm& filter, vtkInformation* inInfo, vtkInformation* outInfo);

/**
 * The frame of RequestData of such a filter. Calls `read` with this rank's threads once all ranks
 * have the same volume and the same properties, of which `properties` is a checksum. Then tells the
 * ranks which stores were lost, and warns of it. Errors: no blocked volume is at the input; those of
 * `read` on any rank, OutOfMemory among them; Aborted. They are the same on all ranks, and are not
 * reported yet. Collective.
 */
Status ReadVolume(vtkAlgorithm& filter, Communicator& ranks, const VolumeInput& input,
  std::uint64_t properties, const std::function<Status(int threads)>& read);

} // namespace isosurface

#endif
