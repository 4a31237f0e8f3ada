// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CallbackRanks_h
#define isosurface_CallbackRanks_h

#include "Interface/scalable_isosurface.h"

#include "Ground/Base/Communicator.h"

#include <functional>
#include <memory>
#include <vector>

namespace isosurface
{

/// The ranks of a C program. A callback that fails is a std::runtime_error.
class CallbackRanks : public Communicator
{
public:
  /// InvalidArgument if they make no sense. Null: this process alone.
  static Status Check(const si_ranks* ranks);
  /// Ranks that were checked; they are copied.
  static std::unique_ptr<Communicator> Make(const si_ranks* ranks);

  explicit CallbackRanks(const si_ranks& ranks)
    : Given(ranks)
  {
  }

  int GetRank() const override { return this->Given.rank; }
  int GetSize() const override { return this->Given.count; }
  int GetRanksOnNode() override;
  void ReduceMinimum(std::vector<std::uint64_t>& values) override;
  void ReduceMaximum(std::vector<std::uint64_t>& values) override;
  void ReduceSum(std::vector<std::uint64_t>& values) override;
  std::vector<Message> AllGather(const Message& mine) override;
  std::vector<Message> Exchange(std::vector<Message> outgoing) override;

private:
  using Operation = std::uint64_t (*)(std::uint64_t a, std::uint64_t b);

  /// The values of all ranks, which have as many, one rank after the other.
  std::vector<std::uint64_t> Gather(const std::vector<std::uint64_t>& mine);
  void Reduce(std::vector<std::uint64_t>& values, Operation operation);
  /// Allocates memory, of which some rank needs `largest` bytes, the same number on all: on all ranks, or on none.
  void AllocateTogether(std::uint64_t largest, const std::function<void()>& allocate);

  const si_ranks Given;
};

} // namespace isosurface

#endif
