// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Call_h
#define isosurface_Call_h

#include "Interface/scalable_isosurface.h"

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>

namespace isosurface
{

/// A structure of the caller's version as this library knows it: what the caller does not know is 0. Errors:
/// InvalidArgument without a size; Unsupported if it says what this library does not know. `what` names it.
template <typename T>
Result<T> TakeStructure(const T* given, const char* what)
{
  T taken{};
  if (given)
  {
    const auto* const bytes = reinterpret_cast<const unsigned char*>(given);
    if (given->size < sizeof(given->size))
    {
      return Status(
        StatusCode::InvalidArgument, std::string(what) + " does not begin with its size");
    }
    const std::size_t known = std::min(given->size, sizeof(T));
    if (std::any_of(
          bytes + known, bytes + given->size, [](unsigned char byte) { return byte != 0; }))
    {
      return Status(
        StatusCode::Unsupported, std::string(what) + " is of a newer version than the library");
    }
    std::memcpy(&taken, given, known);
  }
  taken.size = sizeof(T);
  return taken;
}

inline std::string ToText(const char* text)
{
  return text ? text : "";
}

/// A call of a C program: what it has said of how the call runs.
class Call
{
public:
  explicit Call(const si_run& run);
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  /// Of the work of the calling thread.
  const Progress& GetProgress() const { return this->Advance; }
  /// Tells a warning, unless it is empty.
  void Warn(const std::string& message);
  /// Whether a callback has said so.
  bool IsStopped() const { return this->Stopped; }
  Communicator& GetRanks() { return *this->Ranks; }
  /// Those of a process that is alone.
  int CountThreads() const { return SerialCommunicator().ChooseThreads(this->Run.threads); }
  /// This rank's share. Collective.
  int ShareThreads() { return this->Ranks->ChooseThreads(this->Run.threads); }
  /// As they are wanted: 0 if the caller does not mind.
  int GetThreads() const { return this->Run.threads; }

private:
  bool Look(double done);

  const si_run Run;
  std::unique_ptr<Communicator> Ranks;
  Progress Advance;
  std::chrono::steady_clock::time_point LastLook = std::chrono::steady_clock::now();
  bool Stopped = false;
};

/// The status as C has it; the error of this thread if it is none.
si_result EndCall(const Status& status);
si_result RunCall(
  const std::string& context, const si_run* run, const std::function<Status(Call&)>& work);

/// A call without callbacks, which gives a pointer, or NULL and the error of this thread.
template <typename Work>
auto GetOrNull(const Work& work) -> decltype(work())
{
  try
  {
    return work();
  }
  catch (const std::exception& exception)
  {
    EndCall(MakeExceptionError("the library", exception));
    return nullptr;
  }
}

/// What a call gives: frees it unless the call has ended well.
template <typename Owner, typename Given>
Status Give(std::unique_ptr<Owner> made, Given** given)
{
  *given = made.release();
  return Status::Ok();
}

} // namespace isosurface

#endif
