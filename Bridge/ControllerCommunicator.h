// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ControllerCommunicator_h
#define isosurface_ControllerCommunicator_h

#include "IsosurfaceBridgeModule.h"

#include "Ground/Base/Communicator.h"

#include "vtkType.h"

#include <cstddef>
#include <vector>

class vtkMultiProcessController;

namespace isosurface
{

/**
 * The ranks of a vtkMultiProcessController as Core sees them. The controller is not owned and must
 * outlive this object; a null controller is a group of one rank.
 *
 * Exchange() sends without blocking where the controller is a vtkMPIController; with any other
 * controller pairs of ranks take turns, the lower rank sending first. Deliver() polls MPI
 * and sleeps in between, so that other threads of the process can use the core.
 *
 * VTK's messages count in vtkIdType, but MPI counts in int: longer messages go in several parts.
 *
 * Where a collective allocates AgreedBytes or more on any rank, the ranks agree that each has the memory
 * before any sends; otherwise all throw NoMemoryForMessages. To gather FewBytes together needs none but
 * that of the messages, one by one.
 */
class ISOSURFACEBRIDGE_EXPORT ControllerCommunicator : public Communicator
{
public:
  /// As many bytes as any implementation of MPI sends in one call.
  static constexpr std::size_t LargestPart = std::size_t{ 1 } << 30;

  /// From this number of bytes on, the cost of agreeing, one more reduction, is small beside a message.
  static constexpr std::size_t AgreedBytes = 1024;
  static constexpr std::size_t FewBytes = 32768; ///< on the stack

  /// A call of MPI sends, or gathers from all ranks, at most `largestPart` bytes; but at least one
  /// from each rank. More than LargestPart means LargestPart. The same on all ranks.
  explicit ControllerCommunicator(
    vtkMultiProcessController* controller, std::size_t largestPart = LargestPart);

  int GetRank() const override;
  int GetSize() const override;
  /// Compares host names over all ranks: collective.
  int GetRanksOnNode() override;
  void ReduceMinimum(std::vector<std::uint64_t>& values) override;
  void ReduceMaximum(std::vector<std::uint64_t>& values) override;
  void ReduceSum(std::vector<std::uint64_t>& values) override;
  std::vector<Message> AllGather(const Message& mine) override;
  std::vector<Message> Exchange(std::vector<Message> outgoing) override;
  void Deliver(std::vector<Message> outgoing, std::vector<Message>& incoming,
    const std::function<void(int rank)>& arrived) override;
  /// In an MPI window; null unless the controller is a vtkMPIController.
  std::unique_ptr<SharedCounters> MakeCounters(bool wanted) override;

private:
  void Reduce(std::vector<std::uint64_t>& values, int operation);
  /// Allocates memory for messages, of which a rank may need `largest` bytes, the same number on all
  /// ranks. Collective.
  template <typename Allocate>
  void AllocateTogether(std::size_t largest, const Allocate& allocate);
  /// Appends up to `part` bytes of each rank's message, from `offset` on, to `messages`; `all`: takes
  /// them together.
  void GatherPart(const Message& mine, std::size_t offset, std::size_t part,
    const std::vector<vtkIdType>& lengths, std::uint8_t* all, std::vector<Message>& messages);
  void Send(const Message& message, int rank);
  void Receive(Message& message, int rank);
  /// Resizes the messages that other ranks will send. Collective.
  void PrepareIncoming(const std::vector<Message>& outgoing, std::vector<Message>& incoming);
  /// False if the controller is no vtkMPIController: then nothing is sent.
  bool ExchangeWithoutBlocking(
    const std::vector<Message>& outgoing, std::vector<Message>& incoming);

  vtkMultiProcessController* Controller;
  std::size_t PartBytes;
};

} // namespace isosurface

#endif
