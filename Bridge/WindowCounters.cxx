// SPDX-License-Identifier: BSD-3-Clause
#include "WindowCounters.h"

#include <vtkMultiProcessController.h>
#if __has_include(<vtkMPIController.h>)
#  include <vtkMPI.h>
#  include <vtkMPICommunicator.h>
#  include <vtkMPIController.h>
#  define ISOSURFACE_HAS_MPI_CONTROLLER
#endif

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

#ifdef ISOSURFACE_HAS_MPI_CONTROLLER
namespace
{

Status MakeError(int code)
{
  std::string text(MPI_MAX_ERROR_STRING, '\0');
  int length = 0;
  MPI_Error_string(code, text.data(), &length);
  text.resize(static_cast<std::size_t>(length));
  return Status(StatusCode::IoError, "the ranks cannot share their work: " + text);
}

class WindowCounters : public SharedCounters
{
public:
  /// Collective. Takes over a communicator that returns errors.
  explicit WindowCounters(MPI_Comm ranks)
    : Ranks(ranks)
  {
    const MPI_Aint size = sizeof(std::uint64_t);
    const bool isThere = MPI_Win_allocate(size, sizeof(std::uint64_t), MPI_INFO_NULL, this->Ranks,
                           &this->Counter, &this->Window) == MPI_SUCCESS;
    int all = isThere ? 1 : 0;
    MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, this->Ranks);
    this->IsUsable = all != 0;
    if (!this->IsUsable)
    {
      return;
    }
    MPI_Win_set_errhandler(this->Window, MPI_ERRORS_RETURN);
    MPI_Win_lock_all(MPI_MODE_NOCHECK, this->Window);
    *this->Counter = 0;
    MPI_Win_sync(this->Window);
    MPI_Barrier(this->Ranks);
    MPI_Win_sync(this->Window);
  }

  ~WindowCounters() override
  {
    if (this->IsUsable)
    {
      MPI_Win_unlock_all(this->Window);
      MPI_Win_free(&this->Window);
    }
    MPI_Comm_free(&this->Ranks);
  }

  /// Whether all ranks have it.
  bool IsOnAllRanks() const { return this->IsUsable; }

  Result<std::uint64_t> Add(int rank, std::uint64_t amount) override
  {
    std::uint64_t before = 0;
    int code = MPI_Fetch_and_op(&amount, &before, MPI_UINT64_T, rank, 0, MPI_SUM, this->Window);
    code = code == MPI_SUCCESS ? MPI_Win_flush(rank, this->Window) : code;
    if (code != MPI_SUCCESS)
    {
      return MakeError(code);
    }
    return before;
  }

  Result<std::vector<std::uint64_t>> Read(const std::vector<int>& ranks) override
  {
    std::vector<std::uint64_t> values(ranks.size());
    const std::uint64_t nothing = 0;
    int code = MPI_SUCCESS;
    for (std::size_t n = 0; n < ranks.size() && code == MPI_SUCCESS; ++n)
    {
      code =
        MPI_Fetch_and_op(&nothing, &values[n], MPI_UINT64_T, ranks[n], 0, MPI_NO_OP, this->Window);
    }
    const int flushed = MPI_Win_flush_all(this->Window);
    code = code == MPI_SUCCESS ? flushed : code;
    if (code != MPI_SUCCESS)
    {
      return MakeError(code);
    }
    return values;
  }

  void LetOthersIn() override
  {
    int isThere = 0;
    MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, this->Ranks, &isThere, MPI_STATUS_IGNORE);
  }

private:
  MPI_Comm Ranks;
  MPI_Win Window = MPI_WIN_NULL;
  std::uint64_t* Counter = nullptr; ///< this rank's, in the window
  bool IsUsable = false;
};

} // namespace
#endif

std::unique_ptr<SharedCounters> MakeWindowCounters(vtkMultiProcessController* controller)
{
#ifdef ISOSURFACE_HAS_MPI_CONTROLLER
  auto* mpi = vtkMPIController::SafeDownCast(controller);
  auto* communicator = mpi ? vtkMPICommunicator::SafeDownCast(mpi->GetCommunicator()) : nullptr;
  MPI_Comm* handle =
    communicator && communicator->GetMPIComm() ? communicator->GetMPIComm()->GetHandle() : nullptr;
  if (handle && controller->GetNumberOfProcesses() > 1)
  {
    MPI_Comm own = MPI_COMM_NULL;
    if (MPI_Comm_dup(*handle, &own) != MPI_SUCCESS)
    {
      return nullptr;
    }
    MPI_Comm_set_errhandler(own, MPI_ERRORS_RETURN);
    auto counters = std::make_unique<WindowCounters>(own);
    if (counters->IsOnAllRanks())
    {
      return counters;
    }
  }
#endif
  static_cast<void>(controller);
  return nullptr;
}

} // namespace isosurface
