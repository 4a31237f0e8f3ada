// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/BackgroundExtraction.h"

#include <utility>

namespace isosurface
{

BackgroundExtraction::BackgroundExtraction(Communicator& ranks, Extraction extract)
  : Work(ranks, "the isosurface cannot be extracted",
      [this, extract = std::move(extract)](Communicator& all, const Progress& advance)
      { return extract(all, advance, this->Outcome); })
{
}

Status BackgroundExtraction::Take(
  Communicator& ranks, const Progress& advance, ExtractionOutcome& outcome)
{
  ISOSURFACE_RETURN_IF_ERROR(this->Work.Finish(ranks, advance));
  QueryStatistics reading = outcome.Cost.Reading;
  reading.ActiveBlocks = 0;
  reading.Add(this->Outcome.Cost.Reading);
  outcome = std::move(this->Outcome);
  outcome.Cost.Reading = reading;
  return Status::Ok();
}

} // namespace isosurface
