// SPDX-License-Identifier: BSD-3-Clause
#include "TrainingSurface.h"

#include "Volumes/BenchmarkVolume.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace isosurface
{
namespace
{

void SetGeometry(TrainingSurface& surface, const Index3& size, ValueType type, double isovalue)
{
  surface.View.Type = type;
  surface.View.First = surface.Bytes.data();
  surface.View.Stride = { 1, static_cast<std::ptrdiff_t>(size[0]),
    static_cast<std::ptrdiff_t>(size[0] * size[1]) };
  surface.View.Box.High = size;
  surface.View.Available = surface.View.Box;
  surface.Grid = BlockGrid(size, 64);
  surface.Header.Geometry.Extent = { 0, size[0] - 1, 0, size[1] - 1, 0, size[2] - 1 };
  surface.Header.Type = type;
  surface.Header.Isovalues = { isovalue };
}

/// words: a file of raw samples, its dimensions, type and isovalue.
bool ReadSurface(const std::string* words, TrainingSurface& surface)
{
  const Index3 size{ std::atoll(words[1].c_str()), std::atoll(words[2].c_str()),
    std::atoll(words[3].c_str()) };
  const auto type = FindValueType(words[4]);
  std::ifstream stream(words[0], std::ios::binary);
  if (!type || !stream || size[0] < 2 || size[1] < 2 || size[2] < 2)
  {
    return false;
  }
  surface.Bytes.resize(static_cast<std::size_t>(size[0] * size[1] * size[2]) * GetValueSize(*type));
  stream.read(surface.Bytes.data(), static_cast<std::streamsize>(surface.Bytes.size()));
  SetGeometry(surface, size, *type, std::atof(words[5].c_str()));
  return static_cast<bool>(stream);
}

TrainingSurface MakeGenerated(int side, double isovalue)
{
  const std::vector<std::uint16_t> volume = MakeBenchmarkVolume(side, 2);
  TrainingSurface surface;
  const char* first = reinterpret_cast<const char*>(volume.data());
  surface.Bytes.assign(first, first + 2 * volume.size());
  SetGeometry(surface, { side, side, side }, ValueType::UInt16, isovalue);
  return surface;
}

} // namespace

void AddSurfaceOption(CLI::App& application, std::vector<std::string>& words)
{
  application.add_option("--surface", words, "raw samples, three dimensions, type, isovalue")
    ->type_size(6)
    ->expected(-1)
    ->required();
}

bool ReadSurfaces(const std::vector<std::string>& words, std::vector<TrainingSurface>& surfaces)
{
  surfaces.resize(words.size() / 6);
  for (std::size_t n = 0; n < surfaces.size(); ++n)
  {
    if (!ReadSurface(&words[6 * n], surfaces[n]))
    {
      std::fprintf(stderr, "%s: cannot be read\n", words[6 * n].c_str());
      return false;
    }
  }
  surfaces.push_back(MakeGenerated(192, 34000.5));
  surfaces.push_back(MakeGenerated(160, 40000.5));
  return true;
}

} // namespace isosurface
