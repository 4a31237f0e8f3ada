// SPDX-License-Identifier: BSD-3-Clause
// Files that are whole, but belong to another store, array, component or time step.
#include "Fixtures/ActiveBlocks.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Storage/Verification/VolumeVerification.h"

using namespace isosurface;

namespace
{

const std::string Steps = HidePath(VolumePath + ".stores") + "/";
const Index3 SizeOfVolume = { 40, 33, 20 };

/// Two time steps in two stores: an array of one component, and one of two. All files of one kind
/// are equally long, and nothing but what is in them tells them apart.
class StoreIdentity : public testing::Test
{
protected:
  void SetUp() override
  {
    BlockedVolumeSettings settings = MakeSettings(16, 2);
    settings.Append = true;
    SerialCommunicator alone;
    BlockedVolumeWriter writer(alone, this->Disk);
    for (unsigned step = 0; step < 2; ++step)
    {
      std::vector<SampleVolume<std::uint8_t>> volumes;
      VolumePiece piece;
      piece.Box = { { 0, 0, 0 }, SizeOfVolume };
      for (unsigned component = 0; component < 3; ++component)
      {
        volumes.push_back(MakeVolume<std::uint8_t>(SizeOfVolume, 10 * step + component + 1));
      }
      for (const SampleVolume<std::uint8_t>& volume : volumes)
      {
        piece.Arrays.push_back(volume.GetView());
      }
      settings.Time = step;
      const auto written = Require(writer.Write(VolumePath, MakeGeometry(SizeOfVolume),
        { { "density", ValueType::UInt8 }, { "pair", ValueType::UInt8, 2 } }, piece, settings));
    }
    ASSERT_EQ(this->Query(), "");
    ASSERT_EQ(this->Verify(), "");
  }

  /// The first error of asking for surfaces and spectra of the first time step; empty if none.
  std::string Query()
  {
    const auto volume = OpenVolume(this->Disk);
    QueryStatistics statistics;
    for (std::size_t variable = 0; variable < volume->GetVariables().GetCount(); ++variable)
    {
      for (int level = 0; level < volume->GetNumberOfLevels(); ++level)
      {
        if (volume->GetSpectrumLevel(level) == level)
        {
          const auto active =
            FindActiveBlocks(*volume, { { 0, variable, { 50 } } }, statistics, level);
          const auto spectrum = volume->GetSpectrum(0, variable, level);
          if (!active.IsOk() || !spectrum.IsOk())
          {
            return active.GetStatus().GetMessage() + spectrum.GetStatus().GetMessage();
          }
        }
      }
    }
    return "";
  }

  /// The first fault that a check of the whole volume finds; empty if none.
  std::string Verify()
  {
    const auto found = VerifyBlockedVolume(VolumePath, this->Disk, 1);
    return found.IsOk() && found->Faults.empty() ? "" : found->Faults.front().GetMessage();
  }

  /// Puts a file in place of another one of the first time step, for a while.
  void ExpectRefused(const std::string& other, const std::string& path, const std::string& reason)
  {
    const MemoryDisk::Bytes own = this->Disk.GetFile(path);
    this->Disk.SetFile(path, this->Disk.GetFile(other));
    ASSERT_NE(this->Disk.GetFile(path), own) << "the test needs files that differ";
    for (const std::string& error : { this->Query(), this->Verify() })
    {
      EXPECT_EQ(error.find(path), 0u) << error;
      EXPECT_NE(error.find(reason), std::string::npos) << error;
    }
    this->Disk.SetFile(path, own);
    ASSERT_EQ(this->Query(), "");
  }

  MemoryDisk Disk;
};

} // namespace

TEST_F(StoreIdentity, FilesOfAnotherTimeStepAreRefused)
{
  for (const char* store : { "/store-00000/", "/store-00001/", "/overview-1/store-00000/" })
  {
    for (const char* tree : { "array-0.tree", "array-1-component-0.tree",
           "array-1-component-1.tree", "array-1-magnitude.tree" })
    {
      const std::string name = std::string(store) + tree;
      this->ExpectRefused(Steps + "000002" + name, Steps + "000001" + name,
        "the tree of another store, array, component or time step");
    }
    const std::string directory = std::string(store) + "directory";
    this->ExpectRefused(Steps + "000002" + directory, Steps + "000001" + directory, "another");
  }
  for (const char* spectra : { "/spectra", "/overview-1/spectra" })
  {
    this->ExpectRefused(Steps + "000002" + spectra, Steps + "000001" + spectra,
      "has the spectra of another time step");
  }
}

TEST_F(StoreIdentity, TreesOfAnotherArrayOrComponentAreRefused)
{
  const std::string store = Steps + "000001/store-00000/";
  const std::vector<std::string> trees = { "array-0.tree", "array-1-component-0.tree",
    "array-1-component-1.tree", "array-1-magnitude.tree" };
  for (const std::string& tree : trees)
  {
    for (const std::string& other : trees)
    {
      if (tree != other)
      {
        this->ExpectRefused(store + other, store + tree, "the tree of another store, array");
      }
    }
  }
}

TEST_F(StoreIdentity, FilesOfAnotherStoreAreRefused)
{
  for (const std::string& name : { std::string("array-0.tree"), std::string("directory") })
  {
    this->ExpectRefused(
      Steps + "000001/store-00001/" + name, Steps + "000001/store-00000/" + name, "");
  }
}
