// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/ImageField.h"

#include "Ground/Base/Communicator.h"
#include "Storage/Store/BlockedVolume.h"

#include <utility>

namespace isosurface
{
namespace
{

constexpr const char* NotFilled = "the samples cannot be read";

} // namespace

void ImageField::Ask(std::uint64_t source, SampledBox exact, std::optional<SampledBox> coarse)
{
  if (this->Source != source || !(this->Exact.Box == exact.Box))
  {
    this->DropPrepared();
    this->Source = source;
    this->Exact = std::move(exact);
  }
  this->Coarse = std::move(coarse);
}

std::string ImageField::GetName() const
{
  return this->Exact.Volume ? this->Exact.Volume->GetPath() : "";
}

Status ImageField::Prepare(Communicator&, int)
{
  return Attempt(NotFilled,
    [this]
    {
      this->DropPrepared();
      SerialCommunicator alone;
      this->Work = std::make_unique<CollectiveTask>(alone, NotFilled,
        [this](Communicator&, const Progress& progress)
        { return this->Exact.Fill(this->Levels, progress); });
      return Status::Ok();
    });
}

void ImageField::DropPrepared()
{
  this->Work.reset();
  this->Exact.Values.clear();
}

Status ImageField::Fill(int level, const Progress& progress)
{
  SampledBox& part = this->GetBox(level);
  if (&part == &this->Exact && this->Work)
  {
    SerialCommunicator alone;
    const std::unique_ptr<CollectiveTask> work = std::move(this->Work);
    return work->Finish(alone, progress);
  }
  return part.Fill(this->Levels, progress);
}

} // namespace isosurface
