// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffImage_h
#define isosurface_TiffImage_h

#include "Ground/Base/Status.h"

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace isosurface
{

/// The unit of length that OME or ImageJ names; empty for pixels.
std::string NormalizeUnit(const std::string& unit);

/// Brings lengths on three axes to the unit of the first one. False if they have several, and one of
/// them is no known unit of length; then they stay.
bool UniteLengths(std::array<double, 3>& lengths, const std::array<std::string, 3>& units);

/**
 * An image of TIFF files, as their descriptions tell it: slices, channels and frames (time steps),
 * whose planes are pages in any order, perhaps of several files.
 */
struct TiffImage
{
  enum Axis : std::size_t
  {
    Slices,
    Channels,
    Frames
  };

  /// Planes that follow each other: in the order of the image from `FirstPlane` on, and as pages of a
  /// file from `FirstPage` on.
  struct Run
  {
    std::string File; ///< in the folder of the description; empty: that of the description
    std::int64_t FirstPage = 0;
    std::int64_t FirstPlane = 0;
    std::int64_t Count = 0; ///< -1: all pages of the file
  };
  /// How many pages a file has, of the name that a run has.
  using Counter = std::function<Result<std::int64_t>(const std::string& file)>;
  /// A plane, by its place on each axis, and the page that it is.
  using Visitor = std::function<Status(
    const std::array<std::int64_t, 3>& place, const std::string& file, std::int64_t page)>;

  std::string Name;                                             ///< perhaps empty
  std::string Id;                                               ///< the same
  std::array<std::int64_t, 3> Sizes{ 1, 1, 1 };                 ///< on each Axis
  std::array<std::size_t, 3> Order{ Slices, Channels, Frames }; ///< the fastest Axis first
  std::vector<Run> Runs;
  std::int64_t Width = 0; ///< 0: not known
  std::int64_t Height = 0;
  std::array<double, 3> Spacing{ 1, 1, 1 };
  std::array<double, 3> Origin{ 0, 0, 0 };
  std::string Unit; ///< of lengths; perhaps empty
  double TimeStep = 1;
  std::vector<std::string> ChannelNames;
  std::string SampleUnit;
  std::string Type;            ///< of samples, in words of OME; perhaps empty
  bool IsOffset = false;       ///< whether uint16 samples are those of int16, increased by 32768
  Status Fault = Status::Ok(); ///< why it cannot be opened: a sentence without a file
  std::string Notes; ///< what is told: sentences without an end, with semicolons between them

  void AddNote(const std::string& note) { this->Notes += (this->Notes.empty() ? "" : "; ") + note; }
  std::int64_t GetNumberOfPlanes() const;
  /// "2 channels, 6 slices and 1 frames".
  std::string DescribeSizes() const;
  /// If there is a single slice, and several of either channels or frames: takes these as slices, and
  /// tells it. Programs call the pages of a stack so if they are not told what they are.
  void TakePagesAsSlices();
  /// Visits each plane of the runs. Error: `name` and a sentence, or that of a function.
  Status Visit(const std::string& name, const Counter& count, const Visitor& visit) const;
};

} // namespace isosurface

#endif
