// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_Require_h
#define isosurface_Testing_Require_h

#include "Ground/Base/Status.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace isosurface
{

/// The value of a result. An error ends the test, which reports it: GoogleTest catches what is
/// thrown. In a thread that a test starts it ends the program.
template <typename T>
T Require(Result<T> result)
{
  if (!result.IsOk())
  {
    throw std::runtime_error(result.GetStatus().GetMessage());
  }
  return std::move(*result);
}

/// Expects an error whose message has a text.
inline void ExpectMessage(const Status& status, const std::string& text)
{
  EXPECT_NE(status.GetMessage().find(text), std::string::npos)
    << '"' << text << "\" is not in: " << status.GetMessage();
}

inline void ExpectError(const Status& status, StatusCode code, const std::string& text)
{
  EXPECT_EQ(status.GetCode(), code) << status.GetMessage();
  ExpectMessage(status, text);
}

} // namespace isosurface

#endif
