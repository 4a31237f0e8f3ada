// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Indexing/FetchBudget.h"

#include "Ground/Base/HttpTransfers.h"
#include "Ground/Base/PrintableText.h"

namespace isosurface
{

FetchBudget::FetchBudget(std::uint64_t bytes)
  : Limit(bytes)
  , Before(HttpTransfers::CountFetchedBytes())
{
}

std::uint64_t FetchBudget::CountFetched() const
{
  return HttpTransfers::CountFetchedBytes() - this->Before;
}

std::string FetchBudget::Describe() const
{
  const std::uint64_t fetched = this->CountFetched();
  const std::uint64_t all = this->SampleBytes;
  return fetched == 0 ? std::string()
                      : DescribeBytes(fetched) + (all > 0 ? " of " + DescribeBytes(all) : "") +
      " fetched" + (this->Limit > 0 ? ", at most " + DescribeBytes(this->Limit) : "");
}

Status FetchBudget::MakeError(const std::string& source, double done) const
{
  constexpr double hundred = 100;
  return Status(StatusCode::IoError,
    source + ": the budget of bytes is spent: " + this->Describe() + "; " +
      std::to_string(static_cast<int>(hundred * done)) +
      " % is indexed, and what was fetched is kept: raise the budget to go on, or choose a region");
}

} // namespace isosurface
