// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EdgeIndexOptions_h
#define isosurface_EdgeIndexOptions_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/LengthUnit.h"

#include <cstdint>
#include <optional>
#include <string>

namespace isosurface
{

/// What edgeindex's command line asks for.
struct EdgeIndexOptions
{
  enum class Command
  {
    Info,
    Verify,
    Decode,
    Print ///< Text, and nothing else: help, version
  };

  Command What = Command::Print;
  std::string Text;
  std::string Input;
  std::string Output; ///< of Decode; empty: no file
  bool IsQuiet = false;
  bool IsJson = false;
  bool IsPreview = false;
  bool IsCompressed = false;             ///< .glb
  std::optional<double> Isovalue;        ///< only this one
  LengthUnit Unit = LengthUnit::Unknown; ///< .glb: of the points; unknown: as the file says
  std::uint64_t NumberOfTriangles = 0;   ///< about the number to simplify to; 0: all
  std::uint64_t MemoryMebibytes = 1024;
  int Threads = 0; ///< 0: all cores

  /// Error: InvalidArgument, which names the option.
  static Result<EdgeIndexOptions> Parse(int argc, const char* const* argv);
};

} // namespace isosurface

#endif
