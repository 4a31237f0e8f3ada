// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FetchBudget_h
#define isosurface_FetchBudget_h

#include "Ground/Base/Status.h"

#include <atomic>
#include <cstdint>
#include <string>

namespace isosurface
{

/// What is fetched from addresses by this process from now on, and how much may be. Several threads may use it.
class FetchBudget
{
public:
  /// 0: no limit.
  explicit FetchBudget(std::uint64_t bytes = 0);

  std::uint64_t GetLimit() const { return this->Limit; }
  std::uint64_t CountFetched() const;
  bool IsSpent() const { return this->Limit > 0 && this->CountFetched() >= this->Limit; }
  /// The bytes of the samples that are wanted, once they are known.
  void SetSampleBytes(std::uint64_t bytes) { this->SampleBytes = bytes; }

  /// "412 MB of 1.9 TB fetched, at most 4.3 GB"; "" if nothing is.
  std::string Describe() const;
  /// Of work on `source` that ended since it is spent, when so much was done, from 0 to 1.
  Status MakeError(const std::string& source, double done) const;

private:
  const std::uint64_t Limit;
  const std::uint64_t Before;
  std::atomic<std::uint64_t> SampleBytes = 0;
};

} // namespace isosurface

#endif
