// SPDX-License-Identifier: BSD-3-Clause
// blockvolume: writes, prints, checks and repairs blocked volumes. Alone or under mpirun.
#include "BlockVolumeOptions.h"
#include "InfoCommand.h"
#include "ListCommand.h"
#include "RepairCommand.h"
#include "SourceCommand.h"
#include "StopSignal.h"
#include "VerifyCommand.h"
#include "WriteCommand.h"

#include "vtkMPIController.h"
#include "vtkMultiProcessController.h"
#include "vtkSmartPointer.h"

#include "ControllerCommunicator.h"

#include <malloc.h>
#include <mpi.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iterator>
#include <new>

using namespace isosurface;

namespace
{

using Command = BlockVolumeOptions::Command;

Status Run(const Result<BlockVolumeOptions>& options, Communicator& ranks)
{
  ISOSURFACE_RETURN_IF_ERROR(options.GetStatus());
  if (options->What == Command::Write)
  {
    return RunWriteCommand(*options, ranks);
  }
  // One rank inspects a volume.
  if (ranks.GetRank() != 0)
  {
    return Status::Ok();
  }
  switch (options->What)
  {
    case Command::Info:
      return RunInfoCommand(*options);
    case Command::List:
      return RunListCommand(*options);
    case Command::Relocate:
      return RunSourceCommand(*options);
    case Command::Repair:
      return RunRepairCommand(*options);
    case Command::Verify:
      return RunVerifyCommand(*options);
    default:
      std::fputs(options->Text.c_str(), stdout);
      return Status::Ok();
  }
}

int Finish(const Status& status, int rank)
{
  if (status.IsOk())
  {
    return 0;
  }
  if (rank == 0)
  {
    std::fprintf(stderr, "blockvolume: %s\n", status.GetMessage().c_str());
  }
  return status.GetCode() == StatusCode::Aborted ? 130 : 1;
}

/// A rank that ends here cannot notify the others, which may wait for it.
int FailAtOnce(const char* reason, int ranks)
{
  std::fprintf(stderr, "blockvolume: %s\n", reason);
  if (ranks > 1)
  {
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
  return 1;
}

/// Whether this process may be one of several. Each launcher of MPI, and each scheduler that starts ranks
/// by itself, sets one of these variables.
bool IsStartedAsRank()
{
  constexpr const char* variables[] = { "OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "PMI_FD",
    "MV2_COMM_WORLD_RANK", "MPI_LOCALRANKID", "SLURM_PROCID", "ALPS_APP_PE", "PALS_RANKID",
    "FLUX_TASK_RANK" };
  return std::any_of(std::begin(variables), std::end(variables),
    [](const char* variable) { return std::getenv(variable) != nullptr; });
}

/// Libraries decode chunks in memory of the heap, in one thread after another. Freed chunks would
/// stay in the heaps of the threads, beyond the limit of memory.
void ReturnLargeMemory()
{
#ifdef __GLIBC__
  ::mallopt(M_MMAP_THRESHOLD, 1 << 18);
  ::mallopt(M_ARENA_MAX, 2);
#endif
}

} // namespace

int main(int argc, char** argv)
{
  ReturnLargeMemory();
  // One process needs no MPI, which takes longer to start than most commands take.
  vtkSmartPointer<vtkMPIController> controller;
  if (IsStartedAsRank())
  {
    controller = vtkSmartPointer<vtkMPIController>::New();
    controller->Initialize(&argc, &argv);
    vtkMultiProcessController::SetGlobalController(controller);
  }
  CatchStopSignals("blockvolume");
  const int ranks = controller ? controller->GetNumberOfProcesses() : 1;
  int code = 1;
  try
  {
    ControllerCommunicator communicator(controller);
    const auto options = BlockVolumeOptions::Parse(argc, argv);
    code = Finish(Run(options, communicator), communicator.GetRank());
  }
  catch (const std::bad_alloc&)
  {
    code = FailAtOnce("out of memory; a smaller --memory may help", ranks);
  }
  catch (const std::exception& error)
  {
    code = FailAtOnce(error.what(), ranks);
  }
  if (controller)
  {
    vtkMultiProcessController::SetGlobalController(nullptr);
    controller->Finalize();
  }
  return code;
}
