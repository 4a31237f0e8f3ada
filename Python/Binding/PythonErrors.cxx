// SPDX-License-Identifier: BSD-3-Clause
#include "PythonErrors.h"

#include <atomic>
#include <cerrno>

#include <pthread.h>

namespace isosurface
{
namespace
{

constexpr std::chrono::milliseconds TimeBetweenLooks{ 100 };

std::atomic<int> Workers{ 0 }; ///< threads at work without the GIL
std::atomic<bool> IsForkedAtWork{ false };

/// Text for a person. Of a name that is not UTF-8, the other bytes are told by their numbers.
pybind11::str MakeText(const std::string& message)
{
  return pybind11::reinterpret_steal<pybind11::str>(PyUnicode_DecodeUTF8(
    message.data(), static_cast<Py_ssize_t>(message.size()), "backslashreplace"));
}

/// Raises an OSError, or the kind of it that belongs to the number.
[[noreturn]] void RaiseSystemError(int number, const std::string& message)
{
  const pybind11::object error =
    pybind11::reinterpret_borrow<pybind11::object>(PyExc_OSError)(number, MakeText(message));
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error.ptr())), error.ptr());
  throw pybind11::error_already_set();
}

[[noreturn]] void Raise(PyObject* type, const std::string& message)
{
  PyErr_SetObject(type, MakeText(message).ptr());
  throw pybind11::error_already_set();
}

} // namespace

void ThrowIfError(const Status& status)
{
  const std::string& message = status.GetMessage();
  switch (status.GetCode())
  {
    case StatusCode::Ok:
      return;
    case StatusCode::InvalidArgument:
      Raise(PyExc_ValueError, message);
    case StatusCode::NotFound:
      RaiseSystemError(ENOENT, message);
    case StatusCode::DiskFull:
      RaiseSystemError(ENOSPC, message);
    case StatusCode::OutOfMemory:
      Raise(PyExc_MemoryError, message);
    case StatusCode::IoError:
    case StatusCode::Corrupt:
    case StatusCode::Unsupported:
    case StatusCode::Aborted:
    case StatusCode::RemoteFailure:
      break;
  }
  Raise(PyExc_OSError, message);
}

void Warn(const std::string& message)
{
  if (!message.empty() && PyErr_WarnEx(PyExc_UserWarning, message.c_str(), 2) != 0)
  {
    throw pybind11::error_already_set(); // warnings are errors there
  }
}

void WatchForks()
{
  ::pthread_atfork(nullptr, nullptr, [] { IsForkedAtWork = Workers > 0; });
}

WorkWithoutGil::Worker::Worker()
{
  if (IsForkedAtWork)
  {
    PyErr_SetString(PyExc_RuntimeError,
      "this process was forked while another thread read or wrote; start processes by 'spawn', or "
      "before there are threads");
    throw pybind11::error_already_set();
  }
  ++Workers;
}

WorkWithoutGil::Worker::~Worker()
{
  --Workers;
}

Progress SignalWatch::GetProgress()
{
  return [this](double) { return this->Look(); };
}

bool SignalWatch::Look()
{
  const auto now = std::chrono::steady_clock::now();
  if (now - this->LastLook >= TimeBetweenLooks && !this->Raised)
  {
    this->LastLook = now;
    const pybind11::gil_scoped_acquire held;
    if (PyErr_CheckSignals() != 0)
    {
      this->Raised.emplace();
    }
  }
  return !this->Raised;
}

void SignalWatch::Warn(const std::string& message)
{
  constexpr int caller = 3; // of the function of the package that calls one that writes
  const pybind11::gil_scoped_acquire held;
  if (!this->Raised && PyErr_WarnEx(PyExc_UserWarning, message.c_str(), caller) != 0)
  {
    this->Raised.emplace();
  }
}

void SignalWatch::Rethrow() const
{
  if (this->Raised)
  {
    throw pybind11::error_already_set(*this->Raised);
  }
}

} // namespace isosurface
