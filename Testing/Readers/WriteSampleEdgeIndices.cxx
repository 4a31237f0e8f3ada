// SPDX-License-Identifier: BSD-3-Clause
// Writes edge-index files into a folder: every type, mode and profile, attributes, values that are
// not numbers, and values far from each other; each as small as shows it.
#include "Fixtures/AttributedSource.h"
#include "Fixtures/CodedVolumes.h"

#include "Fixtures/EdgeIndexFileWriter.h"
#include "Ground/Base/FileSystem.h"

#include <cstdio>
#include <filesystem>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace isosurface
{
namespace
{

constexpr int BlockSize = 8;

bool Write(const std::string& folder, const std::string& name, const EdgeIndexHeader& header,
  BlockSource& source)
{
  const Status status =
    WriteEdgeIndexFile(GetLocalFileSystem(), folder + "/" + name + ".eix", header, source, 1);
  if (!status.IsOk())
  {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), status.GetMessage().c_str());
  }
  return status.IsOk();
}

template <typename T>
bool Write(const std::string& folder, const std::string& name, const EdgeIndexHeader& header,
  const SampleVolume<T>& volume)
{
  TestBlockSource<T> source(volume, BlockSize);
  return Write(folder, name, header, source);
}

template <typename T>
EdgeIndexHeader MakeNamedHeader(const SampleVolume<T>& volume, const std::vector<double>& isovalues,
  EdgeIndexMode mode, EdgeIndexProfile profile)
{
  EdgeIndexHeader header = MakeHeader(volume, isovalues, mode, profile);
  header.Array = "scalars";
  header.Settings.MaximumError = 0.02;
  return header;
}

template <typename T>
bool WriteLossless(const std::string& folder, const std::string& type, EdgeIndexProfile profile)
{
  SampleVolume<T> volume = MakeWaves<T>({ 19, 14, 11 }, 0.3);
  Displace(volume);
  const double middle = std::is_signed_v<T> ? 0 : std::ldexp(0.5, std::numeric_limits<T>::digits);
  return Write(folder, "lossless-" + type,
    MakeNamedHeader(volume, { middle }, EdgeIndexMode::Lossless, profile), volume);
}

bool WriteTypes(const std::string& folder)
{
  using Profile = EdgeIndexProfile;
  return WriteLossless<std::int8_t>(folder, "int8", Profile::Small) &&
    WriteLossless<std::uint8_t>(folder, "uint8", Profile::Small) &&
    WriteLossless<std::uint32_t>(folder, "uint32", Profile::Small) &&
    WriteLossless<std::int64_t>(folder, "int64", Profile::Small) &&
    WriteLossless<std::uint64_t>(folder, "uint64", Profile::Small) &&
    WriteLossless<float>(folder, "float32", Profile::Small) &&
    WriteLossless<double>(folder, "float64", Profile::Small) &&
    WriteLossless<std::int16_t>(folder, "int16", Profile::Working) &&
    WriteLossless<std::uint16_t>(folder, "uint16", Profile::Working) &&
    WriteLossless<std::int32_t>(folder, "int32", Profile::Working);
}

/// Few values, many of them the isovalue, some of them NaN: of floats also infinities, and numbers
/// of every size, so that every context and every number of digits comes up.
template <typename T>
SampleVolume<T> MakeWild()
{
  std::mt19937 random(3);
  SampleVolume<T> volume = MakeRandomVolume<T>(random, { 12, 10, 9 }, 4);
  using Limits = std::numeric_limits<T>;
  const T specials[] = { Limits::infinity(), -Limits::infinity(), T(-0.0), Limits::denorm_min(),
    -Limits::denorm_min(), Limits::max(), Limits::lowest() };
  for (T& sample : volume.Samples)
  {
    const auto drawn = random() % 40;
    sample = drawn < 7 ? specials[drawn]
      : drawn < 20
      ? std::ldexp(
          sample, static_cast<int>(random() % (2 * Limits::max_exponent)) - Limits::max_exponent)
      : sample;
  }
  volume.Geometry.Direction = { 0, 1, 0, 1, 0, 0, 0, 0, 1 };
  return volume;
}

bool WriteWild(const std::string& folder)
{
  const auto narrow = MakeWild<float>();
  const auto wide = MakeWild<double>();
  using Mode = EdgeIndexMode;
  using Profile = EdgeIndexProfile;
  EdgeIndexHeader smallest = MakeNamedHeader(wide, { 1 }, Mode::Smallest, Profile::Small);
  smallest.Settings.MaximumError = 0.0001;
  return Write(folder, "wild-float32",
           MakeNamedHeader(narrow, { 0, 1, -1e30, 1e-40 }, Mode::Lossless, Profile::Small),
           narrow) &&
    Write(folder, "wild-float64",
      MakeNamedHeader(wide, { 0, 1e-300, 1e200 }, Mode::Lossless, Profile::Small), wide) &&
    Write(folder, "wild-bounded", MakeNamedHeader(narrow, { 0, 1 }, Mode::Bounded, Profile::Small),
      narrow) &&
    Write(folder, "wild-smallest", smallest, wide) &&
    Write(folder, "wild-working",
      MakeNamedHeader(wide, { 0, 1e-300 }, Mode::Lossless, Profile::Working), wide) &&
    Write(folder, "wild-narrow-working",
      MakeNamedHeader(narrow, { 0, 1e-40 }, Mode::Lossless, Profile::Working), narrow) &&
    Write(folder, "wild-bounded-working",
      MakeNamedHeader(narrow, { 0, 1 }, Mode::Bounded, Profile::Working), narrow);
}

/// Without every third island.
template <typename T>
bool WriteWithoutIslands(const std::string& folder, const std::string& name, EdgeIndexHeader header,
  const SampleVolume<T>& volume)
{
  TestBlockSource<T> source(volume, BlockSize);
  LeaveOutIslands(header, source, 3);
  return Write(folder, name, header, source);
}

bool WriteModes(const std::string& folder)
{
  using Mode = EdgeIndexMode;
  using Profile = EdgeIndexProfile;
  const auto bytes = MakeWaves<std::uint8_t>({ 19, 14, 11 }, 0.4);
  auto waves = MakeWaves<double>({ 19, 14, 11 }, 0.1);
  Displace(waves);
  EdgeIndexHeader bounded = MakeNamedHeader(waves, { 0.1 }, Mode::Bounded, Profile::Small);
  bounded.PreviewLevel = 2;
  bounded.Settings.MaximumError = 0.0001;
  EdgeIndexHeader coarse =
    MakeNamedHeader(bytes, { 150, 255, 0.5 }, Mode::Quantized, Profile::Small);
  coarse.Settings.QuantizationBits = 2;
  EdgeIndexHeader fine = MakeNamedHeader(waves, { 0.1, 2 }, Mode::Quantized, Profile::Small);
  fine.Settings.QuantizationBits = 24;
  fine.Settings.QuantizationMinimum = -0.5;
  fine.Settings.QuantizationMaximum = 0.3;
  EdgeIndexHeader working = MakeNamedHeader(waves, { 0.1 }, Mode::Quantized, Profile::Working);
  working.PreviewLevel = 1;
  working.Geometry.Unit = LengthUnit::Foot;
  working.Settings.QuantizationMinimum = -0.5;
  working.Settings.QuantizationMaximum = 0.3;
  EdgeIndexHeader closed = MakeNamedHeader(bytes, { 150, 60 }, Mode::Lossless, Profile::Small);
  closed.PreviewLevel = 1;
  closed.ClosedSides = GridSides::All();
  EdgeIndexHeader pores = MakeNamedHeader(waves, { 0.1 }, Mode::Bounded, Profile::Working);
  pores.ClosedSides = GridSides::All();
  pores.ClosedSides.AreBeyondInside = true;
  const auto dust = MakeWaves<std::uint8_t>({ 21, 17, 13 }, 3);
  EdgeIndexHeader islands = MakeNamedHeader(dust, { 150, 110 }, Mode::Smallest, Profile::Small);
  EdgeIndexHeader bodies = MakeNamedHeader(dust, { 150, 110 }, Mode::Lossless, Profile::Working);
  bodies.ClosedSides = GridSides::All();
  islands.PreviewLevel = bodies.PreviewLevel = 1;
  return WriteWithoutIslands(folder, "islands", islands, dust) &&
    WriteWithoutIslands(folder, "islands-closed", bodies, dust) &&
    Write(folder, "closed", closed, bytes) && Write(folder, "closed-below", pores, waves) &&
    Write(folder, "bounded", bounded, waves) &&
    Write(folder, "quantized-working", working, waves) &&
    Write(folder, "quantized-coarsely", coarse, bytes) &&
    Write(folder, "quantized-finely", fine, waves);
}

/// A small ball in a large block, so that runs are long; far from the origin, so that float32 tells
/// few places on an edge apart.
bool WriteLarge(const std::string& folder)
{
  SampleVolume<float> volume({ 66, 40, 9 });
  for (std::int64_t k = 0; k < 9; ++k)
  {
    for (std::int64_t j = 0; j < 40; ++j)
    {
      for (std::int64_t i = 0; i < 66; ++i)
      {
        volume.At(i, j, k) =
          static_cast<float>((i - 50) * (i - 50) + 2 * (j - 20) * (j - 20) + 3 * (k - 3) * (k - 3));
      }
    }
  }
  for (int axis = 0; axis < 3; ++axis)
  {
    volume.Geometry.Extent[2 * axis] -= 1 << 20;
    volume.Geometry.Extent[2 * axis + 1] -= 1 << 20;
  }
  TestBlockSource<float> source(volume, 64);
  using Mode = EdgeIndexMode;
  using Profile = EdgeIndexProfile;
  EdgeIndexHeader bounded = MakeNamedHeader(volume, { 40.5 }, Mode::Bounded, Profile::Small);
  bounded.Settings.MaximumError = 0.1;
  bounded.PreviewLevel = 1;
  return Write(folder, "large-bounded", bounded, source) &&
    Write(folder, "large-small", MakeNamedHeader(volume, { 40.5 }, Mode::Lossless, Profile::Small),
      source) &&
    Write(folder, "large-working",
      MakeNamedHeader(volume, { 40.5 }, Mode::Lossless, Profile::Working), source);
}

bool WriteAttributed(const std::string& folder)
{
  using Mode = EdgeIndexMode;
  using Profile = EdgeIndexProfile;
  const auto volume = MakeWaves<std::uint8_t>({ 17, 12, 10 }, 0.3);
  const std::vector<double> isovalues = { 150.5, 180 };
  AttributedSource source(volume, BlockSize, true);
  const auto write = [&](const std::string& name, Mode mode, Profile profile, double maximumError)
  {
    EdgeIndexHeader header = MakeAttributedHeader(volume, isovalues, mode, profile, maximumError);
    header.Array = "scalars";
    return Write(folder, name, header, source);
  };
  return write("attributes-as-they-are", Mode::Lossless, Profile::Small, 0) &&
    write("attributes-bounded", Mode::Bounded, Profile::Small, 0.01) &&
    write("attributes-with-exceptions", Mode::Quantized, Profile::Small, 1e-30) &&
    write("attributes-working", Mode::Lossless, Profile::Working, 0.01);
}

} // namespace
} // namespace isosurface

int main(int argc, char* argv[])
{
  if (argc != 2)
  {
    std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
    return 2;
  }
  const std::string folder = argv[1];
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  using namespace isosurface;
  return WriteTypes(folder) && WriteWild(folder) && WriteModes(folder) && WriteLarge(folder) &&
      WriteAttributed(folder)
    ? 0
    : 1;
}
