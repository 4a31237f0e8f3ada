// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockVolumeOptions_h
#define isosurface_BlockVolumeOptions_h

#include "Formats/Plain/RawVolume.h"
#include "Ground/Base/Status.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// What the command line asks for.
struct BlockVolumeOptions
{
  enum class Command
  {
    Write,
    Info,
    Verify,
    List,
    Relocate, ///< the source of a volume in place
    Repair,   ///< stores that others have replicas of
    Print     ///< Text, and nothing else: help, version
  };

  Command What = Command::Write;
  std::string Text;
  std::string Input;
  std::string Output;
  bool IsQuiet = false;

  bool IsSandboxed = false;            ///< whether all is done in a process with limits (Sandbox.h)
  std::uint64_t SandboxMemory = 0;     ///< bytes of its address space
  std::uint64_t SandboxSeconds = 3600; ///< of its processor time without progress

  // Writing
  BlockedVolumeSettings Settings;
  std::vector<std::string> Arrays; ///< none: all
  bool WithCells = false;          ///< whether cell arrays are averaged to points
  std::string Axes;                ///< of a dataset, a letter each; empty: as the file says
  std::optional<std::size_t> Step; ///< of the input; none: all
  bool IsInPlace = false;          ///< whether the samples stay in the input
  std::optional<RawVolume> Raw;    ///< of a file without header
  std::optional<std::array<double, 6>> Region; ///< x0 x1 y0 y1 z0 z1 of the part to read; none: all
  std::uint64_t FetchBudget = 0;               ///< MiB that may be fetched; 0: no limit
  std::optional<std::array<double, 3>> Spacing;
  std::optional<std::array<double, 3>> Origin;
  LengthUnit Unit = LengthUnit::Unknown; ///< of spacing and origin; unknown: as the input says

  std::string Source; ///< the new place of the input of a volume in place

  // Info
  bool IsJson = false;
  bool WithSpectrum = false;

  /// Error: InvalidArgument, which names the option.
  static Result<BlockVolumeOptions> Parse(int argc, const char* const* argv);
};

} // namespace isosurface

#endif
