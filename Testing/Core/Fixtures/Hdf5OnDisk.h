// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_Hdf5OnDisk_h
#define isosurface_Testing_Hdf5OnDisk_h

#include "Fixtures/Require.h"
#include "Fixtures/ScratchFolder.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Base/FileSystem.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <string>
#include <vector>

namespace isosurface
{

/// The 4 x 5 x 6 samples of every dataset that Hdf5OnDisk writes.
inline std::vector<std::int16_t> MakeHdf5Samples()
{
  std::vector<std::int16_t> samples(4 * 5 * 6);
  std::iota(samples.begin(), samples.end(), std::int16_t{ 1 });
  return samples;
}

/// An HDF5 file that is written by the library itself.
class Hdf5OnDisk
{
public:
  explicit Hdf5OnDisk(const std::string& path, hid_t access = H5P_DEFAULT)
    : File(::H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access))
  {
    EXPECT_GE(this->File, 0);
  }
  Hdf5OnDisk(const Hdf5OnDisk&) = delete;
  Hdf5OnDisk& operator=(const Hdf5OnDisk&) = delete;
  ~Hdf5OnDisk() { ::H5Fclose(this->File); }

  hid_t Get() const { return this->File; }

  /// With no samples, only what says where they are. Closes the list of properties.
  void AddDataset(const std::string& name, hid_t plist = H5P_DEFAULT, bool hasSamples = true)
  {
    const hsize_t size[] = { 4, 5, 6 };
    const hid_t space = ::H5Screate_simple(3, size, nullptr);
    const hid_t links = ::H5Pcreate(H5P_LINK_CREATE);
    ::H5Pset_create_intermediate_group(links, 1);
    const hid_t dataset =
      ::H5Dcreate2(this->File, name.c_str(), H5T_STD_I16LE, space, links, plist, H5P_DEFAULT);
    EXPECT_GE(dataset, 0);
    if (hasSamples)
    {
      EXPECT_GE(::H5Dwrite(dataset, H5T_NATIVE_INT16, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                  MakeHdf5Samples().data()),
        0);
    }
    ::H5Dclose(dataset);
    ::H5Pclose(links);
    ::H5Sclose(space);
    if (plist != H5P_DEFAULT)
    {
      ::H5Pclose(plist);
    }
  }
  void AddAttribute(
    const char* object, const char* name, hid_t type, hsize_t count, const void* values)
  {
    const hid_t space = ::H5Screate_simple(1, &count, nullptr);
    const hid_t attribute = ::H5Acreate_by_name(
      this->File, object, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    EXPECT_GE(::H5Awrite(attribute, type, values), 0);
    ::H5Aclose(attribute);
    ::H5Sclose(space);
  }
  void AddLink(const std::string& name, const std::string& file, const std::string& object)
  {
    EXPECT_GE(::H5Lcreate_external(
                file.c_str(), object.c_str(), this->File, name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
      0);
  }
  /// A dataset whose samples are in a file of their own.
  void AddExternal(const std::string& name, const std::string& file, std::int64_t offset = 0)
  {
    const hid_t plist = ::H5Pcreate(H5P_DATASET_CREATE);
    EXPECT_GE(::H5Pset_external(plist, file.c_str(), offset, 240), 0);
    this->AddDataset(name, plist, false);
  }
  /// A dataset whose samples are those of another one.
  void AddVirtual(const std::string& name, const std::string& file, const std::string& object)
  {
    const hsize_t size[] = { 4, 5, 6 };
    const hid_t space = ::H5Screate_simple(3, size, nullptr);
    const hid_t plist = ::H5Pcreate(H5P_DATASET_CREATE);
    EXPECT_GE(::H5Pset_virtual(plist, space, file.c_str(), object.c_str(), space), 0);
    this->AddDataset(name, plist, false);
    ::H5Sclose(space);
  }
  /// A dataset of slices without end, each in a file with its number in place of "%b".
  void AddVirtualSlices(const std::string& name, const std::string& file, const std::string& object)
  {
    const hsize_t size[] = { 1, 5, 6 };
    const hsize_t most[] = { H5S_UNLIMITED, 5, 6 };
    const hsize_t start[] = { 0, 0, 0 };
    const hsize_t count[] = { H5S_UNLIMITED, 1, 1 };
    const hsize_t stride[] = { 1, 1, 1 };
    const hid_t space = ::H5Screate_simple(3, size, most);
    ::H5Sselect_hyperslab(space, H5S_SELECT_SET, start, stride, count, size);
    const hid_t source = ::H5Screate_simple(3, size, nullptr);
    const hid_t plist = ::H5Pcreate(H5P_DATASET_CREATE);
    EXPECT_GE(::H5Pset_virtual(plist, space, file.c_str(), object.c_str(), source), 0);
    const hid_t dataset =
      ::H5Dcreate2(this->File, name.c_str(), H5T_STD_I16LE, space, H5P_DEFAULT, plist, H5P_DEFAULT);
    EXPECT_GE(dataset, 0);
    ::H5Dclose(dataset);
    ::H5Pclose(plist);
    ::H5Sclose(source);
    ::H5Sclose(space);
  }
  /// Groups in one another: the path of the innermost.
  std::string AddGroups(const std::string& name, int count)
  {
    std::string path;
    hid_t group = ::H5Gopen2(this->File, "/", H5P_DEFAULT);
    for (int depth = 0; depth < count; ++depth)
    {
      const hid_t inner = ::H5Gcreate2(group, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
      EXPECT_GE(inner, 0);
      ::H5Gclose(group);
      group = inner;
      path += "/" + name;
    }
    ::H5Gclose(group);
    return path;
  }

private:
  hid_t File;
};

/// A file of samples without a header, in the byte order that the datasets have.
inline void WriteRawSamples(
  const std::string& path, std::size_t before = 0, std::size_t missing = 0)
{
  const std::vector<std::int16_t> samples = MakeHdf5Samples();
  std::ofstream file(path, std::ios::binary);
  file << std::string(before, 'x');
  file.write(reinterpret_cast<const char*>(samples.data()),
    static_cast<std::streamsize>(2 * samples.size() - missing));
}

inline Result<OpenedVolume> OpenLocal(const std::string& name)
{
  return OpenForeignVolume(GetLocalFileSystem(), name);
}

/// Expects the samples of MakeHdf5Samples().
inline void ExpectVolume(const std::string& name)
{
  const auto volume = Require(OpenLocal(name));
  const VertexBox& box = volume.Source->GetBox();
  ASSERT_TRUE(box.GetSize() == (Index3{ 6, 5, 4 }));
  const auto slab = Require(volume.Source->Read(box));
  const auto* samples = reinterpret_cast<const std::int16_t*>(slab.Arrays[0].First);
  const std::vector<std::int16_t> expected = MakeHdf5Samples();
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), samples));
}

/// Expects an error that has the words.
inline void ExpectWords(const Status& status, const std::vector<std::string>& words)
{
  ASSERT_FALSE(status.IsOk());
  for (const std::string& word : words)
  {
    ExpectMessage(status, word);
  }
}

} // namespace isosurface

#endif
