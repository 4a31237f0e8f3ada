// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_OutputCheck_h
#define isosurface_OutputCheck_h

#include "Ground/Base/Status.h"

#include <filesystem>
#include <string>
#include <system_error>

namespace isosurface
{

/// InvalidArgument if a file to write is one that is read, under whatever spellings and links.
inline Status CheckIsOther(const std::string& output, const std::string& input)
{
  std::error_code error; // also of what does not exist
  return std::filesystem::equivalent(output, input, error)
    ? Status(StatusCode::InvalidArgument,
        output + ": is " + (output == input ? "the input itself" : "the same file as " + input) +
          "; take another name for the output")
    : Status::Ok();
}

} // namespace isosurface

#endif
