// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Status_h
#define isosurface_Status_h

#include <cassert>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace isosurface
{

/// What went wrong, in the few kinds that a caller treats differently.
enum class StatusCode : std::uint8_t
{
  Ok,
  InvalidArgument, ///< the caller asked for something that cannot be
  NotFound,        ///< a file, store or array that is not there
  IoError,         ///< the operating system refused (disk full, permission, ...)
  Corrupt,         ///< bytes that are not what was written: truncated, altered, inconsistent
  Unsupported,     ///< a newer format version, an unknown codec or value type
  OutOfMemory,     ///< what was asked for does not fit
  Aborted,         ///< the user asked to stop
  RemoteFailure    ///< another rank failed; its own message is told by that rank
};

/**
 * The outcome of an operation: an error is a value, never an exception. A message names the file
 * and the reason in one sentence, ready to be shown to a user.
 */
class [[nodiscard]] Status
{
public:
  Status() = default;
  Status(StatusCode code, std::string message)
    : Code(code)
    , Message(std::move(message))
  {
  }
  static Status Ok() { return {}; }

  bool IsOk() const { return this->Code == StatusCode::Ok; }
  StatusCode GetCode() const { return this->Code; }
  const std::string& GetMessage() const { return this->Message; }

private:
  StatusCode Code = StatusCode::Ok;
  std::string Message;
};

/**
 * A value or the reason why there is none. The value may be asked for only when IsOk().
 */
template <typename T>
class [[nodiscard]] Result
{
public:
  Result(T value)
    : Value(std::move(value))
  {
  }
  Result(Status error)
    : Error(std::move(error))
  {
    assert(!this->Error.IsOk());
  }

  bool IsOk() const { return this->Value.has_value(); }
  const Status& GetStatus() const { return this->Error; }

  T& operator*() { return *this->Value; }
  const T& operator*() const { return *this->Value; }
  T* operator->() { return &*this->Value; }
  const T* operator->() const { return &*this->Value; }

private:
  std::optional<T> Value;
  Status Error;
};

} // namespace isosurface

/// Returns from the enclosing function with the error that `expression` gives, if any.
#define ISOSURFACE_RETURN_IF_ERROR(expression)            \
  do                                                      \
  {                                                       \
    ::isosurface::Status isosurfaceStatus = (expression); \
    if (!isosurfaceStatus.IsOk())                         \
    {                                                     \
      return isosurfaceStatus;                            \
    }                                                     \
  } while (false)

#endif
