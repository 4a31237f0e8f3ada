// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Status_h
#define isosurface_Status_h

#include <cassert>
#include <cstdint>
#include <exception>
#include <new>
#include <optional>
#include <string>
#include <utility>

namespace isosurface
{

/// The kinds of error that callers treat differently.
enum class StatusCode : std::uint8_t
{
  Ok,
  InvalidArgument, ///< an argument that makes no sense
  NotFound,        ///< a file, store or array does not exist
  IoError,         ///< the operating system refused (permission, too many threads, ...)
  DiskFull,        ///< the disk, a quota or a limit of file sizes has no room
  Corrupt,         ///< the bytes are not those that were written: truncated, altered, inconsistent
  Unsupported,     ///< a newer format version, an unknown codec or value type
  OutOfMemory,     ///< there is not enough memory
  Aborted,         ///< the user asked to stop
  RemoteFailure    ///< another rank failed, and reports its own error
};

/**
 * The outcome of an operation: Ok or an error. Core returns errors instead of throwing exceptions.
 * A message is one sentence for the user that names the file and the reason.
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

/// What a C++ exception says, behind `context`: OutOfMemory for a std::bad_alloc, else IoError (the
/// system has no more threads or locks).
inline Status MakeExceptionError(const std::string& context, const std::exception& exception)
{
  return dynamic_cast<const std::bad_alloc*>(&exception)
    ? Status(StatusCode::OutOfMemory, context + ": there is not enough memory")
    : Status(StatusCode::IoError, context + ": " + exception.what());
}

/// Runs a step of this rank alone, before the ranks agree: an exception (a shortage of memory or of
/// threads) is an error like others, MakeExceptionError(context, ...).
template <typename Step>
auto Attempt(const std::string& context, Step&& step) -> decltype(step())
{
  try
  {
    return step();
  }
  catch (const std::exception& exception)
  {
    return MakeExceptionError(context, exception);
  }
}

/**
 * A value, or the error that prevented it. Only access the value if IsOk().
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

/// Gives `variable` (`auto x`, `const auto x`, or one that exists) the value of the Result behind it,
/// or returns from the enclosing function with its error. Several statements: in braces behind an if.
#define ISOSURFACE_ASSIGN_OR_RETURN(variable, ...) \
  ISOSURFACE_ASSIGN_RESULT_(ISOSURFACE_UNIQUE_NAME_(__LINE__), variable, (__VA_ARGS__))
#define ISOSURFACE_ASSIGN_RESULT_(result, variable, expression) \
  auto result = expression;                                     \
  if (!result.IsOk())                                           \
  {                                                             \
    return result.GetStatus();                                  \
  }                                                             \
  variable = std::move(*result)
#define ISOSURFACE_UNIQUE_NAME_(line) ISOSURFACE_JOIN_(isosurfaceResult, line)
#define ISOSURFACE_JOIN_(first, second) first##second

#endif
