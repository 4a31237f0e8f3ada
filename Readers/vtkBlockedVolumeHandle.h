// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBlockedVolumeHandle
 * @brief   gives a consumer the opened blocked volume behind a reader
 *
 * Travels downstream under vtkBlockedVolumeReader::BLOCKED_VOLUME(), so that a filter can take
 * blocks straight from the stores. The handle shares the volume with the reader: it stays valid
 * when the reader opens another file or is deleted. A reader that cannot open its file has a handle
 * all the same, with the error in place of the volume: so every rank knows that its input is a
 * blocked volume, and all go the same way. Internal: not installed, not wrapped.
 */

#ifndef vtkBlockedVolumeHandle_h
#define vtkBlockedVolumeHandle_h

#include "IsosurfaceReadersModule.h" // For export macro
#include "vtkObject.h"

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"

#include <cstddef> // For std::size_t
#include <memory>  // For std::shared_ptr
#include <set>     // For the takers
#include <string>  // For the text
#include <utility> // For std::move
#include <vector>  // For the arrays

class vtkInformation;

namespace isosurface
{
class BlockedVolume;
class FinishedLayers;
}

class ISOSURFACEREADERS_EXPORT vtkBlockedVolumeHandle : public vtkObject
{
public:
  static vtkBlockedVolumeHandle* New();
  vtkTypeMacro(vtkBlockedVolumeHandle, vtkObject);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The volume, or why there is none. SetError drops the volume.
   */
  void SetVolume(std::shared_ptr<isosurface::BlockedVolume> volume);
  void SetError(const isosurface::Status& error);
  const isosurface::Status& GetStatus() const { return this->Error; }
  /**
   * Whether no volume has been opened yet: it may have to be made first.
   */
  bool IsUntried() const { return this->Untried; }
  ///@}

  /**
   * The volume; null if GetStatus() is an error.
   */
  const std::shared_ptr<isosurface::BlockedVolume>& GetVolume() const { return this->Volume; }

  ///@{
  /**
   * The numbers of the volume's arrays that are chosen in the reader.
   */
  void SetArrays(std::vector<std::size_t> arrays) { this->Arrays = std::move(arrays); }
  const std::vector<std::size_t>& GetArrays() const { return this->Arrays; }
  ///@}

  ///@{
  /**
   * If the volume is a sample of a file that is being indexed: how much of it that is, for people, the
   * path of the volume that the file will be, if the sample reaches through all of it, and through which share of it
   * the sample reaches.
   */
  void SetSample(const std::string& text, const std::string& sampled, double share = 1)
  {
    this->SampleText = text;
    this->Sampled = sampled;
    this->SampleShare = share;
  }
  double GetSampleShare() const { return this->SampleShare; }
  const std::string& GetSampleText() const { return this->SampleText; }
  const std::string& GetSampled() const { return this->Sampled; }
  ///@}

  ///@{
  /**
   * The exact part of a file of which the volume is a sample; null if there is none.
   */
  void SetFinished(std::shared_ptr<isosurface::FinishedLayers> finished)
  {
    this->Finished = std::move(finished);
  }
  const std::shared_ptr<isosurface::FinishedLayers>& GetFinished() const { return this->Finished; }
  ///@}

  /**
   * What tells ranks that see different volumes under one path. Without a volume, any value.
   */
  isosurface::CommonValue MakeCommonValue() const;

  /**
   * The time step that pipeline information asks for: the last one at or before UPDATE_TIME_STEP(),
   * the first one if there is none.
   */
  std::size_t FindTimeStep(vtkInformation* pipelineInfo) const;

  ///@{
  /**
   * A consumer that takes blocks through this handle calls BeginTaking in REQUEST_UPDATE_EXTENT and
   * EndTaking in REQUEST_DATA. In between the reader's output is not needed, unless another
   * consumer has asked for it before (AskOutput, called by the reader in REQUEST_UPDATE_EXTENT).
   */
  void BeginTaking(const vtkObject* consumer) { this->Takers.insert(consumer); }
  void EndTaking(const vtkObject* consumer) { this->Takers.erase(consumer); }
  void EndTaking() { this->Takers.clear(); }
  void AskOutput() { this->IsAsked = this->IsAsked || this->Takers.empty(); }
  bool IsOutputNeeded() const { return this->IsAsked || this->Takers.empty(); }
  ///@}

  ///@{
  /**
   * Whether the reader's last output is no more than a box, made while no output was needed.
   */
  void FinishOutput(bool isBox);
  bool IsOutputBox() const { return this->IsBox; }
  ///@}

protected:
  vtkBlockedVolumeHandle();
  ~vtkBlockedVolumeHandle() override;

private:
  vtkBlockedVolumeHandle(const vtkBlockedVolumeHandle&) = delete;
  void operator=(const vtkBlockedVolumeHandle&) = delete;

  std::shared_ptr<isosurface::BlockedVolume> Volume;
  isosurface::Status Error;
  bool Untried = true;
  std::vector<std::size_t> Arrays;
  std::string SampleText;
  std::string Sampled;
  double SampleShare = 1;
  std::shared_ptr<isosurface::FinishedLayers> Finished;
  std::set<const vtkObject*> Takers;
  bool IsAsked = false;
  bool IsBox = false;
};

#endif
