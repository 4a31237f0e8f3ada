// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ControllerCommunicator_h
#define isosurface_ControllerCommunicator_h

#include "IsosurfaceBridgeModule.h"

#include "Base/Communicator.h"

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
 */
class ISOSURFACEBRIDGE_EXPORT ControllerCommunicator : public Communicator
{
public:
  explicit ControllerCommunicator(vtkMultiProcessController* controller);

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
  std::unique_ptr<SharedCounters> MakeCounters() override;

private:
  void Reduce(std::vector<std::uint64_t>& values, int operation);
  void Send(const Message& message, int rank);
  void Receive(Message& message, int rank);
  /// Resizes the messages that other ranks will send. Collective.
  void PrepareIncoming(const std::vector<Message>& outgoing, std::vector<Message>& incoming);
  /// False if the controller is no vtkMPIController: then nothing is sent.
  bool ExchangeWithoutBlocking(
    const std::vector<Message>& outgoing, std::vector<Message>& incoming);

  vtkMultiProcessController* Controller;
};

} // namespace isosurface

#endif
