// SPDX-License-Identifier: BSD-3-Clause
#include "WindowCounters.h"

#include <vtkMultiProcessController.h>
#if __has_include(<vtkMPIController.h>)
#  include <vtkMPI.h>
#  include <vtkMPICommunicator.h>
#  include <vtkMPIController.h>
#  define ISOSURFACE_HAS_MPI_CONTROLLER
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
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

/// The window of a communicator, on all of its ranks.
class CounterWindow
{
public:
  /// Collective. Takes over a communicator that returns errors.
  explicit CounterWindow(MPI_Comm ranks)
    : Ranks(ranks)
  {
    constexpr int size = sizeof(std::uint64_t);
    const bool isThere = MPI_Win_allocate(Slots * size, size, MPI_INFO_NULL, this->Ranks,
                           &this->Own, &this->Window) == MPI_SUCCESS;
    if (isThere)
    {
      MPI_Win_set_errhandler(this->Window, MPI_ERRORS_RETURN);
      MPI_Win_lock_all(MPI_MODE_NOCHECK, this->Window);
      std::fill_n(this->Own, Slots, 0);
      MPI_Win_sync(this->Window);
    }
    // One that not all ranks have is not freed: that would be collective, too.
    int all = isThere ? 1 : 0;
    MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, this->Ranks);
    this->IsUsable = all != 0;
  }

  CounterWindow(const CounterWindow&) = delete;
  CounterWindow& operator=(const CounterWindow&) = delete;

  ~CounterWindow() { this->Close(); }

  /// Collective. Frees what is MPI's.
  void Close()
  {
    if (this->IsUsable)
    {
      this->IsUsable = false;
      MPI_Win_unlock_all(this->Window);
      MPI_Win_free(&this->Window);
    }
    if (this->Ranks != MPI_COMM_NULL)
    {
      MPI_Comm_free(&this->Ranks);
    }
  }

  /**
   * Collective: whether all ranks want counters and can have them. Uses take turns with two slots.
   * When all ranks have met here, none uses the slot of the use before any more, so each clears its
   * counter there; the next meeting tells all that it is cleared.
   */
  bool Begin(bool wanted)
  {
    int all = wanted && this->IsUsable && !this->IsUsed ? 1 : 0;
    if (MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, this->Ranks) != MPI_SUCCESS ||
      all == 0)
    {
      return false;
    }
    this->IsUsed = true;
    this->Slot = (this->Slot + 1) % Slots;
    this->Own[(this->Slot + 1) % Slots] = 0;
    MPI_Win_sync(this->Window);
    return true;
  }

  void End() { this->IsUsed = false; }

  MPI_Comm GetRanks() const { return this->Ranks; }
  MPI_Win GetWindow() const { return this->Window; }
  MPI_Aint GetSlot() const { return this->Slot; }

private:
  static constexpr int Slots = 2;

  MPI_Comm Ranks;
  MPI_Win Window = MPI_WIN_NULL;
  std::uint64_t* Own = nullptr; ///< this rank's part of the window
  int Slot = 0;                 ///< the one in use, or that was used last
  bool IsUsable = false;
  bool IsUsed = false;
};

/// Counters in a slot of the window.
class WindowCounters : public SharedCounters
{
public:
  explicit WindowCounters(CounterWindow& window)
    : Counters(window)
  {
  }

  ~WindowCounters() override { this->Counters.End(); }

  Result<std::uint64_t> Add(int rank, std::uint64_t amount) override
  {
    const MPI_Win window = this->Counters.GetWindow();
    std::uint64_t before = 0;
    int code = MPI_Fetch_and_op(
      &amount, &before, MPI_UINT64_T, rank, this->Counters.GetSlot(), MPI_SUM, window);
    code = code == MPI_SUCCESS ? MPI_Win_flush(rank, window) : code;
    if (code != MPI_SUCCESS)
    {
      return MakeError(code);
    }
    return before;
  }

  Result<std::vector<std::uint64_t>> Read(const std::vector<int>& ranks) override
  {
    const MPI_Win window = this->Counters.GetWindow();
    std::vector<std::uint64_t> values(ranks.size());
    const std::uint64_t nothing = 0;
    int code = MPI_SUCCESS;
    for (std::size_t n = 0; n < ranks.size() && code == MPI_SUCCESS; ++n)
    {
      code = MPI_Fetch_and_op(
        &nothing, &values[n], MPI_UINT64_T, ranks[n], this->Counters.GetSlot(), MPI_NO_OP, window);
    }
    const int flushed = MPI_Win_flush_all(window);
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
    MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, this->Counters.GetRanks(), &isThere, MPI_STATUS_IGNORE);
  }

private:
  CounterWindow& Counters;
};

/// All windows of this process. Never destroyed: MPI_Finalize may be called when the process exits.
std::vector<CounterWindow*>& GetWindows()
{
  static auto* windows = new std::vector<CounterWindow*>();
  return *windows;
}

/// Called by MPI when a communicator is freed, by all ranks together. That of all ranks is so at
/// the end of MPI_Finalize, when windows are gone.
int FreeWindow(MPI_Comm, int, void* window, void*)
{
  std::vector<CounterWindow*>& windows = GetWindows();
  windows.erase(std::remove(windows.begin(), windows.end(), window), windows.end());
  delete static_cast<CounterWindow*>(window);
  return MPI_SUCCESS;
}

/// Called by MPI when MPI_Finalize begins, which frees MPI_COMM_SELF first.
int CloseWindows(MPI_Comm, int, void*, void*)
{
  for (CounterWindow* window : GetWindows())
  {
    window->Close();
  }
  return MPI_SUCCESS;
}

/// The attribute of a communicator that is its window.
int GetKey()
{
  static int key = MPI_KEYVAL_INVALID;
  if (key == MPI_KEYVAL_INVALID)
  {
    MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, FreeWindow, &key, nullptr);
    int ofEnd = MPI_KEYVAL_INVALID;
    MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, CloseWindows, &ofEnd, nullptr);
    MPI_Comm_set_attr(MPI_COMM_SELF, ofEnd, nullptr);
  }
  return key;
}

/// The window of a communicator, made at the first call. Collective then. Null if there can be none.
CounterWindow* GetWindow(MPI_Comm ranks)
{
  // Communicators without a rank in common can have the same number, by which Open MPI before 5 names
  // the shared memory of a window: one of them would get the other's, if they made theirs at once.
  int size = 0;
  int all = 0;
  MPI_Comm_size(ranks, &size);
  MPI_Comm_size(MPI_COMM_WORLD, &all);
  if (size != all)
  {
    return nullptr;
  }
  const int key = GetKey();
  void* kept = nullptr;
  int isKept = 0;
  MPI_Comm_get_attr(ranks, key, &kept, &isKept);
  if (isKept != 0)
  {
    return static_cast<CounterWindow*>(kept);
  }
  MPI_Comm own = MPI_COMM_NULL;
  if (MPI_Comm_dup(ranks, &own) != MPI_SUCCESS)
  {
    return nullptr;
  }
  MPI_Comm_set_errhandler(own, MPI_ERRORS_RETURN);
  auto window = std::make_unique<CounterWindow>(own);
  MPI_Comm_set_attr(ranks, key, window.get());
  GetWindows().push_back(window.get());
  return window.release();
}

} // namespace
#endif

std::unique_ptr<SharedCounters> MakeWindowCounters(
  vtkMultiProcessController* controller, bool wanted)
{
#ifdef ISOSURFACE_HAS_MPI_CONTROLLER
  auto* mpi = vtkMPIController::SafeDownCast(controller);
  auto* communicator = mpi ? vtkMPICommunicator::SafeDownCast(mpi->GetCommunicator()) : nullptr;
  MPI_Comm* handle =
    communicator && communicator->GetMPIComm() ? communicator->GetMPIComm()->GetHandle() : nullptr;
  if (handle && controller->GetNumberOfProcesses() > 1)
  {
    CounterWindow* window = GetWindow(*handle);
    if (window && window->Begin(wanted))
    {
      return std::make_unique<WindowCounters>(*window);
    }
  }
#endif
  static_cast<void>(controller);
  static_cast<void>(wanted);
  return nullptr;
}

} // namespace isosurface
