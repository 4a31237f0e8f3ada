// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Communicator_h
#define isosurface_Communicator_h

#include "Ground/Base/SharedCounters.h"
#include "Ground/Base/Status.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace isosurface
{

/// Bytes that one rank sends to another.
using Message = std::vector<std::uint8_t>;

/// Something that has to be the same on all ranks.
struct CommonValue
{
  std::uint64_t Value;    ///< the thing itself, or a checksum of it
  std::string Difference; ///< what to tell the user if it is not the same
};

/// The content of a file, told by its fingerprint, which ranks may see differently under its path.
CommonValue MakeCommonFile(const std::string& path, std::uint64_t fingerprint);

/// Thrown on every rank by a collective when any rank cannot allocate its message buffers. Then nothing
/// was sent, and the ranks may go on to another collective.
class NoMemoryForMessages : public std::bad_alloc
{
public:
  const char* what() const noexcept override;
};

/// Runs collective steps. NoMemoryForMessages is an error of all ranks then, OutOfMemory: `context`, a
/// path or what cannot be done, and the reason.
template <typename Steps>
auto RunCollective(const std::string& context, const Steps& steps) -> decltype(steps())
{
  try
  {
    return steps();
  }
  catch (const NoMemoryForMessages& exception)
  {
    return Status(StatusCode::OutOfMemory, context + ": " + exception.what());
  }
}

/**
 * The communication that the parallel algorithms of Core need. Every function is collective: all
 * ranks call it, in the same order. The VTK classes implement it with a vtkMultiProcessController;
 * SerialCommunicator is a group of one rank. Reductions and messages of a few KiB and more may throw
 * NoMemoryForMessages.
 */
class Communicator
{
public:
  virtual ~Communicator() = default;

  virtual int GetRank() const = 0;
  virtual int GetSize() const = 0;
  /// The number of ranks on this rank's node, itself included. Collective, too.
  virtual int GetRanksOnNode() = 0;
  /// As many threads as `wanted`, or, if that is 0, this rank's share of the node. Collective, too,
  /// so that what one rank wants does not leave it out.
  int ChooseThreads(int wanted);

  /// Reduce element by element, in place. The vectors have the same length on all ranks.
  virtual void ReduceMinimum(std::vector<std::uint64_t>& values) = 0;
  virtual void ReduceMaximum(std::vector<std::uint64_t>& values) = 0;
  virtual void ReduceSum(std::vector<std::uint64_t>& values) = 0;
  /// The same for one value of each rank.
  std::uint64_t Minimum(std::uint64_t mine);
  std::uint64_t Maximum(std::uint64_t mine);
  std::uint64_t Sum(std::uint64_t mine);
  bool All(bool mine) { return this->Minimum(mine ? 1 : 0) != 0; }
  bool Any(bool mine) { return this->Maximum(mine ? 1 : 0) != 0; }

  /// Gives every rank the messages of all ranks, in the order of the ranks.
  virtual std::vector<Message> AllGather(const Message& mine) = 0;

  /// Sends outgoing[r] to rank r; returns what each rank sent to this one.
  virtual std::vector<Message> Exchange(std::vector<Message> outgoing) = 0;

  /**
   * Exchanges messages whose sizes the receivers know: the caller gives incoming[r] the size of the
   * message from rank r (the size of its own message does not matter), and it is filled. Calls
   * arrived(r) in the calling thread as soon as incoming[r] is complete, unless it is empty, so
   * that work on one message overlaps the transfer of the others.
   */
  virtual void Deliver(std::vector<Message> outgoing, std::vector<Message>& incoming,
    const std::function<void(int rank)>& arrived);

  /**
   * A counter for each rank, all 0. Null on all ranks if one of them does not want it, or if they
   * cannot reach each other's memory. Each rank destroys it when it is ready, before it enters the
   * next collective, and until then makes no others.
   */
  virtual std::unique_ptr<SharedCounters> MakeCounters(bool wanted)
  {
    static_cast<void>(wanted);
    return nullptr;
  }

  /**
   * Tells all ranks whether one has failed. Returns Ok if all are Ok. If one of them was Aborted,
   * all get Aborted, with the message of the first such rank, whatever others failed with: so all
   * end in the same way. Otherwise a rank with an error gets its own error back; every other rank
   * gets RemoteFailure with the message of the first failing rank. Call it before a collective that
   * a failed rank would not enter: otherwise the other ranks would wait forever.
   */
  Status Agree(const Status& mine);

  /// ReduceMaximum, if no rank has failed; else what Agree returns. One reduction for both.
  Status ReduceAgreed(const Status& mine, std::vector<std::uint64_t>& maxima);

  /// Gives every rank the messages of all, as AllGather, if no rank has failed; else what Agree returns. The
  /// first byte of `mine` is reserved, and not among what is returned. No reduction.
  Result<std::vector<Message>> GatherAgreed(const Status& status, const Message& mine);

  /**
   * The same as the other Agree, and if no rank has failed, whether the ranks have the same values: otherwise all get
   * InvalidArgument with the Difference of the first value that is not the same, and the first rank
   * that has another one than rank 0. Call it before a branch that a value decides and that leads
   * to a collective. All ranks give the same number of values; those of a failed rank do not count.
   */
  Status Agree(const Status& mine, const std::vector<CommonValue>& values);

private:
  Status NameDifference(const CommonValue& mine);
};

/// Runs a step on each rank, which is not collective; then all agree on how it ended. A shortage of
/// memory or of threads is an error like others (Attempt).
template <typename Step>
Status AttemptOnAll(Communicator& ranks, const std::string& context, const Step& step)
{
  return ranks.Agree(Attempt(context, step));
}

/// Runs a step on each rank that appends to its message; gives every rank the messages of all. An error of
/// any rank is one of all.
template <typename Step>
Result<std::vector<Message>> GatherFromAll(
  Communicator& ranks, const std::string& context, const Step& step)
{
  Message mine;
  const auto fill = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(step(mine));
    mine.insert(mine.begin(), std::uint8_t{ 0 });
    return Status::Ok();
  };
  const Status status = Attempt(context, fill);
  return ranks.GatherAgreed(status, mine);
}

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
