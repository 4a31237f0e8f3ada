// SPDX-License-Identifier: BSD-3-Clause
/**
 * Flies a camera around, towards and through an isosurface of a blocked volume. Each image extracts and
 * draws only what the camera can see, at the level whose cells are at most so many pixels wide.
 *
 * An image descends the tree of blocks and leaves out what is beyond it, or behind the depths of the
 * image before. What it needs is extracted, nearest first, kept in buffers up to a limit, and drawn.
 * With a time per image, extraction stops when its share is over, coarser blocks that are kept stand in,
 * and the width of cells is adapted.
 *
 * Prints the medians of each part of the flight, and its slow images.
 */
#include "Surface/BlockBuffers.h"
#include "Surface/BlockTree.h"
#include "Volumes/VolumeQuery.h"

#include "vtkCamera.h"
#include "vtkFloatArray.h"
#include "vtkMatrix4x4.h"
#include "vtkNew.h"
#include "vtkPNGWriter.h"
#include "vtkRenderWindow.h"
#include "vtkRenderer.h"
#include "vtkWindowToImageFilter.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <unordered_set>
#include <vector>

using namespace isosurface;

namespace
{

constexpr int Width = 1280;
constexpr int Height = 800;

struct Options
{
  std::string Volume;
  std::vector<double> Isovalues;
  double Pixels = 1;  ///< the widest cell
  double Seconds = 0; ///< of an image; 0: as long as it takes
  double Memory = 2;  ///< GiB of buffers
  int Images = 40;    ///< of each part of the flight
  std::string Pictures;
};

/// What an image took, in seconds, and what it has.
struct Row
{
  double Extract = 0;
  double Draw = 0;
  double Total = 0;
  double Pixels = 0; ///< of a cell
  double Triangles = 0;
};

class Flight
{
public:
  Flight(BlockedVolume& volume, const Options& options)
    : Settings(options)
    , Tree(volume, options.Isovalues)
    , Buffers(volume, options.Isovalues, static_cast<std::uint64_t>(options.Memory * 0x1p30))
    , Pixels(16 * options.Pixels)
  {
    this->Window->SetOffScreenRendering(true);
    this->Window->SetMultiSamples(0);
    this->Window->SetSize(Width, Height);
    this->Window->AddRenderer(this->Renderer);
    this->Prop->Bounds = this->Tree.GetBounds();
    this->Renderer->AddViewProp(this->Prop);
    this->Renderer->ResetCamera(this->Prop->Bounds.data());
    this->Window->Render(); // makes the context
  }

  vtkCamera* GetCamera() { return this->Renderer->GetActiveCamera(); }
  const std::array<double, 6>& GetBounds() const { return this->Prop->Bounds; }

  Row Draw()
  {
    ++this->Number;
    Row row;
    row.Pixels = this->Pixels;
    this->Renderer->ResetCameraClippingRange(this->Prop->Bounds.data());
    const double begin = GetSeconds();
    SeenImage image = this->FindImage();
    const auto blocks = this->Tree.Choose(image, this->Before, this->Pixels);
    const double chosen = GetSeconds();
    this->Buffers.Extract(blocks, this->Number,
      this->Settings.Seconds > 0 ? chosen + 0.4 * this->Settings.Seconds : HUGE_VAL);
    const double extracted = GetSeconds();
    this->Prop->Blocks = this->FindDrawn(blocks);
    this->Prop->Image = image;
    this->Window->Render();
    this->Window->WaitForCompletion();
    const double drawn = GetSeconds();
    this->ReadDepths(image.Depths);
    this->Before = std::move(image);
    row.Extract = extracted - chosen;
    row.Draw = drawn - extracted;
    row.Total = GetSeconds() - begin;
    for (const BlockBuffer* block : this->Prop->Blocks)
    {
      row.Triangles += block->Count / 3.0;
    }
    this->Adapt(row);
    return row;
  }

  void SavePicture(const std::string& path)
  {
    vtkNew<vtkWindowToImageFilter> picture;
    picture->SetInput(this->Window);
    picture->ShouldRerenderOff();
    vtkNew<vtkPNGWriter> writer;
    writer->SetFileName(path.c_str());
    writer->SetInputConnection(picture->GetOutputPort());
    writer->Write();
  }

private:
  SeenImage FindImage()
  {
    SeenImage image;
    image.Width = Width;
    image.Height = Height;
    vtkCamera* camera = this->GetCamera();
    vtkMatrix4x4* matrix =
      camera->GetCompositeProjectionTransformMatrix(static_cast<double>(Width) / Height, -1, 1);
    std::memcpy(image.ModelToClip.data(), matrix->GetData(), sizeof(image.ModelToClip));
    camera->GetPosition(image.Position.data());
    image.PixelsAtOne = Height / 2.0 / std::tan(camera->GetViewAngle() / 2 * std::acos(-1.0) / 180);
    return image;
  }

  /// The buffers of blocks, or what stands in for them.
  std::vector<const BlockBuffer*> FindDrawn(const std::vector<LevelBlock>& blocks)
  {
    std::unordered_set<const BlockBuffer*> drawn; // a coarse block stands in for several
    for (LevelBlock block : blocks)
    {
      const BlockBuffer* buffer = this->Buffers.Find(block, this->Number);
      while (!buffer && this->Tree.FindParent(block))
      {
        LevelBlock coarser = block;
        ++coarser.Level;
        buffer = this->Buffers.Find(block, this->Number);
        buffer = buffer ? buffer : this->Buffers.Find(coarser, this->Number);
      }
      if (buffer && buffer->Count > 0)
      {
        drawn.insert(buffer);
      }
    }
    return { drawn.begin(), drawn.end() };
  }

  void ReadDepths(DepthPyramid& depths)
  {
    vtkNew<vtkFloatArray> values;
    this->Window->GetZbufferData(0, 0, Width - 1, Height - 1, values);
    const float* first = values->GetPointer(0);
    depths.Build({ first, first + values->GetNumberOfValues() }, Width, Height);
  }

  void Adapt(const Row& row)
  {
    const double goal = this->Settings.Seconds;
    if (goal <= 0)
    {
      this->Pixels = std::max(this->Settings.Pixels, this->Pixels / 2);
      return;
    }
    // Much is extracted in one image, and kept for the next ones.
    const double seconds = row.Total - row.Extract + std::min(row.Extract, 0.3 * goal);
    const double factor = std::clamp(std::sqrt(seconds / goal / 0.9), 0.7, 1.6);
    this->Pixels =
      std::clamp(this->Pixels * factor, this->Settings.Pixels, 64 * this->Settings.Pixels);
  }

  const Options& Settings;
  BlockTree Tree;
  BlockBuffers Buffers;
  double Pixels;
  int Number = 0;
  SeenImage Before;
  vtkNew<vtkRenderer> Renderer;
  vtkNew<vtkRenderWindow> Window;
  vtkNew<vtkBlockBuffersProp> Prop;
};

/// The value that a share of the images do not exceed.
double FindPercentile(std::vector<Row> rows, double Row::*member, double share)
{
  std::sort(rows.begin(), rows.end(),
    [member](const Row& a, const Row& b) { return a.*member < b.*member; });
  return rows[static_cast<std::size_t>(share * static_cast<double>(rows.size() - 1))].*member;
}

void PrintRows(const char* name, const std::vector<Row>& rows)
{
  const auto find = [&rows](double Row::*member, double share)
  { return FindPercentile(rows, member, share); };
  std::printf(
    "%-8s %.3f s (95 %% within %.3f s, slowest %.3f s; extract %.3f s, slowest %.3f s; draw "
    "%.3f s), cells of %.1f pixels (most %.1f), %.2f million triangles (most %.2f)\n",
    name, find(&Row::Total, 0.5), find(&Row::Total, 0.95), find(&Row::Total, 1),
    find(&Row::Extract, 0.5), find(&Row::Extract, 1), find(&Row::Draw, 0.5),
    find(&Row::Pixels, 0.5), find(&Row::Pixels, 1), find(&Row::Triangles, 0.5) / 1e6,
    find(&Row::Triangles, 1) / 1e6);
}

std::string FindPeakMemory()
{
  std::ifstream status("/proc/self/status");
  std::string line;
  while (std::getline(status, line) && line.rfind("VmHWM", 0) != 0)
  {
  }
  return line;
}

} // namespace

int main(int argc, char** argv)
{
  Options options;
  CLI::App app("Flies through an isosurface, of which only what is seen is extracted.");
  app.add_option("volume", options.Volume, ".bvol")->required();
  app.add_option("--isovalues", options.Isovalues, "of the first array")->required();
  app.add_option("--pixels", options.Pixels, "the widest cell of the final level");
  app.add_option("--seconds", options.Seconds, "of an image; 0: as long as it takes");
  app.add_option("--memory", options.Memory, "GiB of buffers that are kept");
  app.add_option("--images", options.Images, "of each part of the flight")
    ->check(CLI::PositiveNumber);
  app.add_option("--pictures", options.Pictures, "folder for the last image of each part");
  CLI11_PARSE(app, argc, argv);

  auto volume = BlockedVolume::Open(
    options.Volume, GetLocalFileSystem(), std::make_shared<BlockCache>(std::uint64_t{ 512 } << 20));
  if (!volume.IsOk())
  {
    std::fprintf(stderr, "%s\n", volume.GetStatus().GetMessage().c_str());
    return EXIT_FAILURE;
  }
  for (int level = 0; level < 4; ++level)
  {
    double triangles = 0;
    for (const double isovalue : options.Isovalues)
    {
      const auto estimate = (*volume)->EstimateTriangles(0, 0, isovalue, level);
      triangles += estimate.IsOk() ? *estimate : 0;
    }
    std::printf("level %d: %.1f million triangles\n", level, triangles / 1e6);
  }
  Flight flight(**volume, options);
  const auto& bounds = flight.GetBounds();
  const double side = bounds[1] - bounds[0];
  vtkCamera* camera = flight.GetCamera();

  const auto fly = [&](const char* name, auto move)
  {
    std::vector<Row> rows;
    for (int image = 0; image < options.Images; ++image)
    {
      move();
      rows.push_back(flight.Draw());
    }
    PrintRows(name, rows);
    if (!options.Pictures.empty())
    {
      flight.SavePicture(options.Pictures + "/" + name + ".png");
    }
  };
  fly("first", [] {});
  fly("around", [&] { camera->Azimuth(2); });
  fly("towards",
    [&]
    {
      camera->Azimuth(0.5);
      camera->Dolly(std::pow(4.0, 1.0 / options.Images));
    });
  fly("rest", [] {});
  const std::array<double, 2> middle = { bounds[0] + side / 2, bounds[4] + side / 2 };
  double y = bounds[2] - side / 8;
  camera->SetViewAngle(60);
  camera->SetViewUp(0, 0, 1);
  fly("through",
    [&]
    {
      y += side / options.Images;
      camera->SetPosition(middle[0], y, middle[1]);
      camera->SetFocalPoint(middle[0], y + side, middle[1]);
    });
  std::printf("%s\n", FindPeakMemory().c_str());
  return EXIT_SUCCESS;
}
