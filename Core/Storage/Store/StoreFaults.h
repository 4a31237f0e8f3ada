// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_StoreFaults_h
#define isosurface_StoreFaults_h

#include "Ground/Base/Communicator.h"

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace isosurface
{

/// A replica of a store of one time step.
struct StoreReplica
{
  /// In place of a store: the spectra, by which ranks share stores.
  static constexpr std::uint32_t Spectra = 0xffffffff;

  std::uint32_t TimeStep = 0;
  std::uint32_t Overview = 0; ///< StoredLevel::Overview
  std::uint32_t Store = 0;
  std::uint32_t Replica = 0;

  bool operator<(const StoreReplica& other) const
  {
    return std::tie(this->TimeStep, this->Overview, this->Store, this->Replica) <
      std::tie(other.TimeStep, other.Overview, other.Store, other.Replica);
  }
  bool operator==(const StoreReplica& other) const { return !(*this < other || other < *this); }
};

/// What is wrong with a replica.
struct StoreFault
{
  static constexpr std::int64_t Whole = -1;

  StoreReplica Where;
  std::int64_t Ordinal = Whole; ///< the block that cannot be read, or all
  std::string Reason;           ///< the message of the error
};

/// How much is to be expected of a replica; a lower one is tried first.
enum class ReplicaState : std::uint8_t
{
  Sound,
  Damaged, ///< has other blocks that cannot be read
  Lost     ///< cannot be opened, or has not the block
};

/**
 * The replicas of an open volume that turned out to be lost or damaged. What this rank has found
 * decides which replica it reads; only what all ranks know decides how they share the blocks. Any
 * thread may call the functions.
 */
class StoreFaults
{
public:
  /// The maximum number of faults of a message; the others wait for the next one.
  static constexpr std::size_t MaximumOfMessage = 256;

  /// Remembers what this rank has found.
  void Add(StoreFault fault);

  /// What is known of a replica, or of one of its blocks. `isCommon`: by all ranks.
  ReplicaState GetState(
    const StoreReplica& replica, bool isCommon, std::int64_t ordinal = StoreFault::Whole) const;
  /// The replicas of a store that all ranks know to be sound, of `replicas` that there are; else the
  /// best.
  std::vector<std::uint32_t> FindBest(StoreReplica store, std::uint32_t replicas) const;
  /// Whether there is a fault at all, so that most queries need no look at each block.
  bool IsEmpty() const;

  /// The faults that this rank has found, and that are not common yet.
  Message Pack() const;
  /// Makes the faults that the ranks have packed common: the same messages in the same order on all
  /// ranks. Returns the faults that are new, in their order.
  std::vector<StoreFault> Join(const std::vector<Message>& ofRanks);

private:
  using Key = std::pair<StoreReplica, std::int64_t>;
  using Keys = std::set<Key>;
  static ReplicaState FindState(
    const Keys& known, const StoreReplica& replica, std::int64_t ordinal);

  mutable std::mutex Mutex;
  Keys Common;
  Keys Known;                    ///< those, and what this rank has found
  std::vector<StoreFault> Found; ///< not packed yet
};

} // namespace isosurface

#endif
