// SPDX-License-Identifier: BSD-3-Clause
// Libraries of formats are loaded when a file needs them. This program is linked with none of them.
#include "Fixtures/MemoryDisk.h"
#include "Fixtures/Require.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Formats/Opener/VolumeFormat.h"

#include <gtest/gtest.h>

#include <link.h>

using namespace isosurface;

namespace
{

/// Whether a library of this process has the text in its path.
bool IsLoaded(const std::string& text)
{
  std::pair<const std::string&, bool> search(text, false);
  ::dl_iterate_phdr(
    [](dl_phdr_info* info, std::size_t, void* data)
    {
      auto& wanted = *static_cast<std::pair<const std::string&, bool>*>(data);
      wanted.second =
        wanted.second || std::string(info->dlpi_name).find(wanted.first) != std::string::npos;
      return 0;
    },
    &search);
  return search.second;
}

void PutText(MemoryDisk& disk, const std::string& path, const std::string& text)
{
  auto file = Require(disk.CreateForWriting(path));
  ASSERT_TRUE(file->Append(text.data(), text.size()).IsOk());
}

} // namespace

TEST(FormatModule, IsLoadedWithTheFirstFileOfItsFormat)
{
  MemoryDisk disk;
  PutText(disk, "/data/a.mhd",
    "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = "
    "a.raw\n");
  PutText(disk, "/data/a.raw", "12345678");
  EXPECT_TRUE(OpenForeignVolume(disk, "/data/a.mhd").IsOk());
  for (const char* library : { "libhdf5", "libnetcdf", "libgdcm", "libtiff", "libblosc" })
  {
    EXPECT_FALSE(IsLoaded(library)) << library;
  }
  PutText(disk, "/data/a.tif", "no TIFF");
  EXPECT_FALSE(OpenForeignVolume(disk, "/data/a.tif").IsOk());
  EXPECT_TRUE(IsLoaded("libtiff"));
  EXPECT_FALSE(IsLoaded("libgdcm"));
}

TEST(FormatModule, IsNamedWithTheReasonIfItCannotBeLoaded)
{
  VolumeFormat format;
  format.Name = "Hologram";
  format.Module = "HologramFormat";
  const auto functions = format.Load("/data/a.holo");
  ASSERT_FALSE(functions.IsOk());
  EXPECT_EQ(functions.GetStatus().GetCode(), StatusCode::Unsupported);
  const std::string message = functions.GetStatus().GetMessage();
  EXPECT_EQ(
    message.find("/data/a.holo: Hologram is read by the module libIsosurfaceHologramFormat.so, "
                 "which cannot be loaded: "),
    0u)
    << message;
  EXPECT_NE(message.find("No such file or directory"), std::string::npos) << message;
}
