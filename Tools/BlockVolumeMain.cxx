// SPDX-License-Identifier: BSD-3-Clause
// blockvolume: writes, prints, checks and repairs blocked volumes. Alone or under mpirun.
#include "BlockVolumeCommands.h"
#include "BlockVolumeOptions.h"
#include "Sandbox.h"
#include "StopSignal.h"

#include "vtkMPIController.h"
#include "vtkMultiProcessController.h"
#include "vtkSmartPointer.h"

#include "ControllerCommunicator.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/PrintableText.h"
#include "Storage/Writing/GenerationFolder.h"

#include <malloc.h>
#include <mpi.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iterator>
#include <new>
#include <string>

using namespace isosurface;

namespace
{

using Command = BlockVolumeOptions::Command;

Status Run(const Result<BlockVolumeOptions>& options, Communicator& ranks)
{
  ISOSURFACE_RETURN_IF_ERROR(options.GetStatus());
  if (options->IsSandboxed && ranks.GetSize() > 1)
  {
    return Status(StatusCode::InvalidArgument,
      "--sandbox: ranks share one job, which a crash ends; one process takes all cores, too");
  }
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
    std::fprintf(stderr, "blockvolume: %s\n", MakePrintable(status.GetMessage()).c_str());
  }
  return status.GetCode() == StatusCode::Aborted ? 130 : 1;
}

/// A rank that ends here cannot notify the others, which may wait for it.
int FailAtOnce(const char* reason, int ranks)
{
  std::fprintf(stderr, "blockvolume: %s\n", MakePrintable(reason).c_str());
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

/// Runs the command, and tells its error. `controller`: of all ranks; null: one process.
int RunAndTell(const Result<BlockVolumeOptions>& options, vtkMultiProcessController* controller)
{
  const int ranks = controller ? controller->GetNumberOfProcesses() : 1;
  try
  {
    ControllerCommunicator communicator(controller);
    const Status status = Run(options, communicator);
    return Finish(status.IsOk() ? FlushStandardOutput() : status, communicator.GetRank());
  }
  catch (const std::bad_alloc&)
  {
    const std::string reason = IsInSandbox()
      ? options->Input + ": out of memory; --sandbox-memory allows more"
      : "out of memory; a smaller --memory may help";
    return FailAtOnce(reason.c_str(), ranks);
  }
  catch (const std::exception& error)
  {
    return FailAtOnce(error.what(), ranks);
  }
}

/// Runs the command in a process with limits, and removes what that one left if it could not.
int RunInSandboxAndTell(const Result<BlockVolumeOptions>& options)
{
  FileSystem& files = GetLocalFileSystem();
  // What is written, if anything is: a volume, or stores beside one.
  const std::string& path = options->Output.empty() ? options->Input : options->Output;
  SandboxLimits limits;
  limits.MemoryBytes = options->SandboxMemory;
  limits.Seconds = options->SandboxSeconds;
  // A tenth of the disk stays free. Messages may go to a file, wherever that is.
  constexpr std::uint64_t messages = std::uint64_t{ 1 } << 24;
  limits.FileBytes = std::max(files.FindFreeBytes(path).value_or(0) / 10 * 9, messages);
  const bool isWriting = options->What != Command::Info && options->What != Command::List &&
    options->What != Command::Verify;
  const auto ended = RunInSandbox(limits,
    [&](const Status& limited)
    { return limited.IsOk() ? RunAndTell(options, nullptr) : Finish(limited, 0); });
  const int code = ended.IsOk() ? *ended
                                : Finish(Status(ended.GetStatus().GetCode(),
                                           options->Input + ": " + ended.GetStatus().GetMessage()),
                                    0);
  if (code != 0 && isWriting)
  {
    GenerationFolder::RemoveUnfinished(files, path);
  }
  return code;
}

void EndRanks(vtkSmartPointer<vtkMPIController>& controller)
{
  if (controller)
  {
    vtkMultiProcessController::SetGlobalController(nullptr);
    controller->Finalize();
    controller = nullptr;
  }
}

/// Ends the process. After a failure libraries are not closed: HDF5 tries again and again to close what a
/// damaged file has left open, and prints that.
int End(int code)
{
  if (code != 0)
  {
    std::fflush(nullptr);
    std::_Exit(code);
  }
  return 0;
}

} // namespace

int main(int argc, char** argv)
{
  OpenStandardStreams();
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
  const auto options = BlockVolumeOptions::Parse(argc, argv);
  if (options.IsOk() && options->IsSandboxed &&
    (!controller || controller->GetNumberOfProcesses() == 1))
  {
    // The threads of MPI do not follow into another process.
    EndRanks(controller);
    return End(RunInSandboxAndTell(options));
  }
  const int code = RunAndTell(options, controller);
  ReleaseStopSignals();
  EndRanks(controller);
  return End(code);
}
