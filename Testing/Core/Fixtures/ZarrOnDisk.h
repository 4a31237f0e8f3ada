// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_ZarrOnDisk_h
#define isosurface_Testing_ZarrOnDisk_h

#include "Fixtures/MemoryDisk.h"
#include "Fixtures/SampleVolume.h"

#include <functional>
#include <string>

namespace isosurface
{

/// Writes a volume of int16 as an array of Zarr 2, big-endian, without compression: chunks of any
/// shape (z, y, x), the last ones whole, as the format has them. Chunks that `isLeftOut` names are
/// missing; their samples are the fill value, -7.
inline void WriteZarr(MemoryDisk& disk, const std::string& folder,
  const SampleVolume<std::int16_t>& volume, const Index3& chunk,
  const std::function<bool(const Index3& chunk)>& isLeftOut = {})
{
  const Index3 size = volume.GetDimensions();
  const auto list = [](const Index3& of)
  {
    return "[" + std::to_string(of[2]) + ", " + std::to_string(of[1]) + ", " +
      std::to_string(of[0]) + "]";
  };
  const std::string metadata = "{\"zarr_format\": 2, \"shape\": " + list(size) +
    ", \"chunks\": " + list(chunk) +
    ", \"dtype\": \">i2\", \"compressor\": null, \"filters\": null, \"fill_value\": -7, "
    "\"order\": \"C\"}";
  static_cast<void>(disk.MakeDirectories(folder));
  disk.SetFile(folder + "/.zarray", MemoryDisk::Bytes(metadata.begin(), metadata.end()));
  Index3 at{};
  for (at[2] = 0; at[2] * chunk[2] < size[2]; ++at[2])
  {
    for (at[1] = 0; at[1] * chunk[1] < size[1]; ++at[1])
    {
      for (at[0] = 0; at[0] * chunk[0] < size[0]; ++at[0])
      {
        MemoryDisk::Bytes bytes;
        for (std::int64_t n = 0; n < chunk[0] * chunk[1] * chunk[2]; ++n)
        {
          const std::int64_t i = at[0] * chunk[0] + n % chunk[0];
          const std::int64_t j = at[1] * chunk[1] + n / chunk[0] % chunk[1];
          const std::int64_t k = at[2] * chunk[2] + n / chunk[0] / chunk[1];
          const bool isInside = i < size[0] && j < size[1] && k < size[2];
          const auto value =
            static_cast<std::uint16_t>(isInside ? volume.At(i, j, k) : std::int16_t{ -1 });
          bytes.push_back(static_cast<std::uint8_t>(value >> 8));
          bytes.push_back(static_cast<std::uint8_t>(value & 255));
        }
        if (!isLeftOut || !isLeftOut(at))
        {
          disk.SetFile(folder + "/" + std::to_string(at[2]) + "." + std::to_string(at[1]) + "." +
              std::to_string(at[0]),
            std::move(bytes));
        }
      }
    }
  }
}

} // namespace isosurface

#endif
