// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeInput_h
#define isosurface_VolumeInput_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

class vtkAlgorithm;
class vtkBlockedVolumeHandle;
class vtkInformation;

namespace isosurface
{

class BlockedVolume;

/// A blocked volume whose samples arrive unchanged at the input of a filter.
class VolumeInput
{
public:
  /// What the information of the filter's input tells. Behind any other source, no volume.
  explicit VolumeInput(vtkInformation* inInfo);

  explicit operator bool() const { return this->Handle != nullptr; }
  vtkBlockedVolumeHandle& GetHandle() const { return *this->Handle; }
  /// Ok if there is no blocked volume at the input, or if it is open.
  Status GetStatus() const;
  /// Whether the input is a volume, which one, at what time step, and how ranks share its blocks:
  /// what all ranks have to agree on before they go the way of volumes or that of images.
  std::vector<CommonValue> MakeCommonValues() const;
  std::shared_ptr<BlockedVolume> GetVolume() const; ///< null if there is none
  std::size_t GetTimeStep() const;                  ///< that the filter asks for

  /// The volume's array of this name, or its first array, the active scalars, if the name is
  /// empty. Errors: NotFound if the volume has no such array, or if a filter between reader and
  /// input leaves it out. The input must be up to date.
  Result<std::size_t> FindArray(const std::string& name, const char* purpose) const;

  /// The variable to contour: of that array a component, or the magnitude, as the menu of ParaView
  /// counts them. Errors: those of FindArray; InvalidArgument if there is no such component.
  Result<std::size_t> FindVariable(const std::string& name, int component) const;

private:
  bool IsLeftOut(const std::string& name) const;

  vtkInformation* Info;
  vtkBlockedVolumeHandle* Handle;
};

/// RequestUpdateExtent of a filter that takes blocks or samples of a blocked volume itself: the reader's own
/// output is not needed, until ReleaseVolume. `ghostLevels`: of images in place of a volume.
void AskVolume(
  vtkAlgorithm& filter, vtkInformation* inInfo, int piece, int pieces, int ghostLevels = 0);
void AskVolume(
  vtkAlgorithm& filter, vtkInformation* inInfo, vtkInformation* outInfo, int ghostLevels = 0);
void ReleaseVolume(vtkAlgorithm& filter, vtkInformation* inInfo);

/// The first step of RequestData of such a filter: whether all ranks have the same volume and the same
/// properties, of which `properties` is a checksum. Collective. Errors: no blocked volume is at the input.
Status AgreeOnVolume(
  vtkAlgorithm& filter, Communicator& ranks, const VolumeInput& input, std::uint64_t properties);

/**
 * Calls `read` after that. Then tells the ranks which stores were lost, and warns of it. Errors: those of
 * `read` on any rank, OutOfMemory among them; Aborted. They are the same on all ranks, and are not
 * reported yet. Collective.
 */
Status ReadVolume(vtkAlgorithm& filter, Communicator& ranks, const VolumeInput& input,
  const std::function<Status()>& read);

} // namespace isosurface

#endif
