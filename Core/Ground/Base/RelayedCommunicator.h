// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RelayedCommunicator_h
#define isosurface_RelayedCommunicator_h

#include "Ground/Base/Communicator.h"

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

namespace isosurface
{

/**
 * The ranks as a background thread sees them, where only one thread of the process may communicate
 * (MPI). Each collective of the background threads waits until the threads that may communicate
 * have performed it: they call Serve() now and then, all ranks together. NoMemoryForMessages is thrown
 * in the background threads.
 *
 * Every function but those of Communicator is for the thread that may communicate.
 */
class RelayedCommunicator : public Communicator
{
public:
  /// Collective among the threads that may communicate.
  explicit RelayedCommunicator(Communicator& ranks);

  /**
   * Performs collectives of the background threads by `ranks` for about `seconds`. Returns
   * early when `isEnded()` is true on all ranks; that result is the same on all of them.
   * Collective. If a collective has begun, it ends, however long it takes.
   */
  bool Serve(Communicator& ranks, double seconds, const std::function<bool()>& isEnded);

  /// Makes the background thread's current collective, and every later one, throw
  /// std::runtime_error, since no thread serves it any more. This rank alone.
  void Close();

  int GetRank() const override { return this->Rank; }
  int GetSize() const override { return this->Size; }
  int GetRanksOnNode() override { return this->RanksOnNode; }
  void ReduceMinimum(std::vector<std::uint64_t>& values) override;
  void ReduceMaximum(std::vector<std::uint64_t>& values) override;
  void ReduceSum(std::vector<std::uint64_t>& values) override;
  std::vector<Message> AllGather(const Message& mine) override;
  std::vector<Message> Exchange(std::vector<Message> outgoing) override;

private:
  using Operation = std::function<void(Communicator& ranks)>;

  /// Waits until the other thread has performed it.
  void Relay(const Operation& operation);

  const int Rank;
  const int Size;
  const int RanksOnNode;
  std::mutex Mutex;
  std::condition_variable Changed;
  const Operation* Waiting = nullptr; ///< of the background thread, guarded by the mutex
  bool LacksMemory = false;           ///< whether it ended with NoMemoryForMessages; guarded, too
  bool IsClosed = false;              ///< guarded by the mutex
};

} // namespace isosurface

#endif
