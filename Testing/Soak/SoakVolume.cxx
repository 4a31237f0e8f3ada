// SPDX-License-Identifier: BSD-3-Clause
#include "SoakVolume.h"

#include "vtkDataObject.h"
#include "vtkInformation.h"

#include <functional>
#include <string_view>

namespace isosurface
{
namespace
{

struct VolumeKind
{
  Extent Grid;
  int Type;
  VolumeSettings Settings;
  std::size_t Steps;
};

using Writer = vtkBlockedVolumeWriter;
const VolumeKind Kinds[NumberOfSoakVolumes] = {
  { { 0, 60, 0, 50, 0, 40 }, VTK_UNSIGNED_CHAR, { 16, 1, Writer::GREEDY, Writer::ZSTD }, 1 },
  { { -7, 57, 3, 50, 0, 33 }, VTK_SHORT, { 32, 3, Writer::RANDOM, Writer::LZ4 }, 1 },
  { { 0, 40, -9, 38, 5, 70 }, VTK_FLOAT, { 16, 2, Writer::GREEDY, Writer::NONE }, 1 },
  { { 0, 31, 0, 64, 0, 40 }, VTK_DOUBLE, { 16, 5, Writer::GREEDY, Writer::LZ4 }, 1 },
  { { 0, 45, 0, 33, -20, 20 }, VTK_UNSIGNED_SHORT, { 16, 2, Writer::RANDOM, Writer::LZ4 }, 3 },
};

enum : std::size_t
{
  Plain,
  WithoutNormals,
  Progressive
};

template <typename T>
void AddToHash(std::size_t& hash, const std::vector<T>& values)
{
  const std::string_view bytes(
    reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  hash = 31 * hash + std::hash<std::string_view>()(bytes);
}

std::size_t ComputeHash(EdgeSurface& surface)
{
  std::size_t hash = surface.Triangles.size();
  AddToHash(hash, surface.Triangles);
  AddToHash(hash, surface.Points);
  return hash;
}

} // namespace

SoakVolume::SoakVolume(int kind, const std::string& path)
  : Kind(kind)
  , Path(path)
{
  this->MakeImages();
  this->Write();
  this->Reopen();
}

// Waves with noise, from about 40 to 200, other ones in each generation and time step.
void SoakVolume::MakeImages()
{
  const VolumeKind& kind = Kinds[this->Kind];
  this->Images.clear();
  this->Times.clear();
  this->Hashes.clear();
  for (std::size_t step = 0; step < kind.Steps; ++step)
  {
    const unsigned int seed = 1 + this->Generation * 100 + static_cast<unsigned int>(step);
    const double shift = 2.0 * (seed % 7);
    const auto image = MakeImage(kind.Grid, kind.Type,
      [shift, waves = MakeWaves(70), noise = MakeNoise(8, seed)](int i, int j, int k)
      { return 110 + shift + waves(i, j, k) + noise(i, j, k); });
    TurnObliquely(image);
    this->Times.push_back(0.5 * static_cast<double>(step));
    image->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), this->Times.back());
    this->Images.push_back(image);
  }
}

void SoakVolume::Write()
{
  const VolumeSettings& settings = Kinds[this->Kind].Settings;
  vtkNew<vtkBlockedVolumeWriter> writer;
  const ExpectNoErrors errors(writer);
  writer->SetController(nullptr);
  writer->SetFileName(this->Path.c_str());
  writer->SetBlockSize(settings.BlockSize);
  writer->SetNumberOfStores(settings.NumberOfStores);
  writer->SetDistribution(settings.Distribution);
  writer->SetCompression(settings.Compression);
  for (std::size_t step = 0; step < this->Images.size(); ++step)
  {
    writer->SetInputData(this->Images[step]);
    writer->SetAppendTimeStep(step > 0);
    EXPECT_EQ(writer->Write(), 1);
  }
}

void SoakVolume::Replace()
{
  ++this->Generation;
  this->MakeImages();
  this->Write();
  this->Pipes->Reader->Modified();
}

void SoakVolume::Reopen()
{
  this->Pipes = std::make_unique<Pipeline>();
  this->Pipes->Reader->SetController(nullptr);
  this->Pipes->Reader->SetFileName(this->Path.c_str());
  this->Pipes->Errors = std::make_unique<ErrorCounter>(this->Pipes->Reader);
  for (Consumer& consumer : this->Pipes->Consumers)
  {
    consumer.Contour->SetController(nullptr);
    consumer.Contour->SetInputConnection(this->Pipes->Reader->GetOutputPort());
    consumer.Errors = std::make_unique<ErrorCounter>(consumer.Contour);
  }
  this->Pipes->Consumers[WithoutNormals].Contour->ComputeNormalsOff();
  this->Pipes->Consumers[Progressive].Contour->ProgressiveOn();
}

double SoakVolume::GetIsovalue(std::size_t number) const
{
  const double isovalues[NumberOfIsovalues] = { 80, 100.5, 125, 140.25, 150 };
  return isovalues[number];
}

std::size_t SoakVolume::GetExpectedHash(const SoakQuery& query, int level)
{
  const bool normals = query.Consumer != WithoutNormals;
  const std::array<std::size_t, 4> key = { query.Step, query.Isovalue,
    static_cast<std::size_t>(level), normals ? 1U : 0U };
  const auto known = this->Hashes.find(key);
  if (known != this->Hashes.end())
  {
    return known->second;
  }
  EdgeSurface surface = ContourByFlyingEdges(
    SubsampleImage(this->Images[query.Step], level), this->GetIsovalue(query.Isovalue));
  EXPECT_TRUE(level > 0 || !surface.Triangles.empty())
    << "volume " << this->Kind << " step " << query.Step << " isovalue "
    << this->GetIsovalue(query.Isovalue);
  if (!normals)
  {
    surface.DropNormals();
  }
  surface.ClearZeroNormals(true);
  return this->Hashes[key] = ComputeHash(surface);
}

void SoakVolume::ExpectSurface(const SoakQuery& query)
{
  vtkPolyData* output = this->Pipes->Consumers[query.Consumer].Contour->GetOutput();
  const int level = static_cast<int>(GetCost(output, "Level"));
  EdgeSurface surface = ToEdges(output);
  surface.ClearZeroNormals(false);
  EXPECT_EQ(ComputeHash(surface), this->GetExpectedHash(query, level))
    << "volume " << this->Kind << ", generation " << this->Generation << ", step " << query.Step
    << ", isovalue " << this->GetIsovalue(query.Isovalue) << ", level " << level;
}

void SoakVolume::Ask(const SoakQuery& query, std::mt19937& random)
{
  Consumer& consumer = this->Pipes->Consumers[query.Consumer];
  vtkStabbingContour* contour = consumer.Contour;
  contour->SetValue(0, this->GetIsovalue(query.Isovalue));
  contour->SetLevel(query.Level);
  contour->UpdateTimeStep(this->Times[query.Step]);
  this->ExpectSurface(query);
  // The next query may come while a finer surface is being extracted.
  for (unsigned int rest = random() % 6; rest > 0 && !contour->GetFinal(); --rest)
  {
    contour->PrepareRefinement(static_cast<int>(random() % 4));
    if (random() % 2 == 0)
    {
      contour->Refine();
      contour->UpdateTimeStep(this->Times[query.Step]);
      this->ExpectSurface(query);
    }
  }
  EXPECT_EQ(consumer.Errors->Messages, std::vector<std::string>());
  EXPECT_EQ(this->Pipes->Errors->Messages, std::vector<std::string>());
}

} // namespace isosurface
