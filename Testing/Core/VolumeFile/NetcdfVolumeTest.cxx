// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/Hdf5OnDisk.h"

#include "VolumeFile/VolumeFile.h"

using namespace isosurface;

namespace
{

Result<VolumeFile> Open(const std::string& name)
{
  return VolumeFile::Open(GetLocalFileSystem(), name);
}

void ExpectVolume(const std::string& name)
{
  const auto volume = Open(name);
  ASSERT_TRUE(volume.IsOk()) << volume.GetStatus().GetMessage();
  const VertexBox& box = volume->Source->GetBox();
  ASSERT_TRUE(box.GetSize() == (Index3{ 6, 5, 4 }));
  const auto slab = volume->Source->Read(box);
  ASSERT_TRUE(slab.IsOk()) << slab.GetStatus().GetMessage();
  const auto* samples = reinterpret_cast<const std::int16_t*>(slab->Arrays[0].First);
  const std::vector<std::int16_t> expected = MakeHdf5Samples();
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), samples));
}

void ExpectWords(const Status& status, const std::vector<std::string>& words)
{
  ASSERT_FALSE(status.IsOk());
  for (const std::string& word : words)
  {
    EXPECT_NE(status.GetMessage().find(word), std::string::npos) << status.GetMessage();
  }
}

/// One error, of opening and of listing, which has the words.
void ExpectRefused(const std::string& path, const std::vector<std::string>& words)
{
  ExpectWords(Open(path).GetStatus(), words);
  ExpectWords(VolumeFile::List(GetLocalFileSystem(), path).GetStatus(), words);
}

} // namespace

TEST(NetcdfVolume, Version4WithLinksToRegularFilesIsRead)
{
  const ScratchFolder folder;
  Hdf5OnDisk(folder / "part.nc").AddDataset("data");
  Hdf5OnDisk(folder / "a.nc").AddLink("link", "part.nc", "/data");
  Hdf5OnDisk(folder / "b.nc").AddVirtual("virtual", "part.nc", "/data");
  ExpectVolume(folder / "a.nc");
  ExpectVolume(folder / "b.nc");
}

TEST(NetcdfVolume, Version4WithLinksToAFifoIsRefusedWithoutWaiting)
{
  const ScratchFolder folder;
  folder.MakeFifo("fifo");
  Hdf5OnDisk(folder / "link.nc").AddLink("link", "fifo", "/data");
  Hdf5OnDisk(folder / "virtual.nc").AddVirtual("virtual", "fifo", "/data");
  Hdf5OnDisk(folder / "external.nc").AddExternal("external", folder / "fifo");
  ExpectRefused(folder / "link.nc", { "link.nc:/link: cannot be read: ", "it is a FIFO" });
  ExpectRefused(folder / "virtual.nc", { "virtual.nc:/virtual", "it is a FIFO" });
  ExpectRefused(folder / "external.nc", { "external.nc:/external", "not read of NetCDF" });
}

TEST(NetcdfVolume, Version4WithGroupsDeeperThan32IsRefused)
{
  const ScratchFolder folder;
  {
    Hdf5OnDisk file(folder / "deep.nc");
    file.AddDataset(file.AddGroups("g", 40) + "/data");
  }
  {
    Hdf5OnDisk file(folder / "cycle.nc");
    file.AddDataset("/a/data");
    ::H5Lcreate_soft("/a", file.Get(), "/a/a", H5P_DEFAULT, H5P_DEFAULT);
  }
  ExpectRefused(folder / "deep.nc", { "deep.nc:/g/g", "deeper than 32" });
  ExpectRefused(folder / "cycle.nc", { "cycle.nc:/a/a", "deeper than 32" });
}
