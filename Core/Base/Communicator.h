// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Communicator_h
#define isosurface_Communicator_h

#include "Base/Status.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace isosurface
{

/// Bytes on their way between ranks.
using Message = std::vector<std::uint8_t>;

/**
 * What the parallel algorithms of Core ask of a group of ranks. Every function is collective: all
 * ranks enter it, in the same order. The VTK wrappers implement it on a vtkMultiProcessController;
 * SerialCommunicator is a group of one.
 */
class Communicator
{
public:
  virtual ~Communicator() = default;

  virtual int GetRank() const = 0;
  virtual int GetSize() const = 0;
  /// How many ranks run on this rank's node, itself included. Collective like the rest.
  virtual int GetRanksOnNode() = 0;

  /// Element-wise over all ranks, in place; the vectors have equal length on all ranks.
  virtual void ReduceMinimum(std::vector<std::uint64_t>& values) = 0;
  virtual void ReduceMaximum(std::vector<std::uint64_t>& values) = 0;
  virtual void ReduceSum(std::vector<std::uint64_t>& values) = 0;

  /// Every rank's message, by rank, on every rank.
  virtual std::vector<Message> AllGather(const Message& mine) = 0;

  /// Sends outgoing[r] to rank r; returns what each rank sent to this one.
  virtual std::vector<Message> Exchange(std::vector<Message> outgoing) = 0;

  /**
   * The same of messages whose sizes are known to those that get them: incoming[r] has the size of
   * what rank r sends here, and is filled; the own message may have any. Calls arrived(r), from the
   * calling thread, when incoming[r] is there and not empty, so that work on it begins while the
   * others are under way.
   */
  virtual void Deliver(std::vector<Message> outgoing, std::vector<Message>& incoming,
    const std::function<void(int rank)>& arrived);

  /**
   * Makes one outcome of all ranks' outcomes: Ok if all are Ok; else the own error where there is
   * one, and RemoteFailure with the first failing rank's message elsewhere; Aborted if that rank
   * was stopped. Called before any collective that a failed rank could not enter, so that no rank
   * is left waiting.
   */
  Status Agree(const Status& mine);
};

/// A group of one rank.
class SerialCommunicator : public Communicator
{
public:
  int GetRank() const override { return 0; }
  int GetSize() const override { return 1; }
  int GetRanksOnNode() override { return 1; }
  void ReduceMinimum(std::vector<std::uint64_t>&) override {}
  void ReduceMaximum(std::vector<std::uint64_t>&) override {}
  void ReduceSum(std::vector<std::uint64_t>&) override {}
  std::vector<Message> AllGather(const Message& mine) override { return { mine }; }
  std::vector<Message> Exchange(std::vector<Message> outgoing) override { return outgoing; }
};

} // namespace isosurface

#endif
