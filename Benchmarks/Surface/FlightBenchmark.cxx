// SPDX-License-Identifier: BSD-3-Clause
/**
 * Flies a camera around, towards and through an isosurface of a blocked volume. Each image extracts and
 * draws only what the camera can see, at the level whose cells are at most so many pixels wide.
 *
 * The blocks of all levels are a tree: a block of an overview has the place of 64 of the next finer part
 * of the volume. An image descends from the coarsest block and leaves out what is beyond the image, or
 * behind the depths of the image before. What it needs is extracted by threads, nearest first, kept in
 * buffers of the graphics card up to a limit, and drawn. With a time per image, extraction stops when its
 * share is over, coarser blocks that are kept stand in, and the width of cells is adapted.
 *
 * Prints one row for each image, or the medians and the slowest of each part of the flight.
 */
#include "Volumes/VolumeQuery.h"

#include "vtkActor.h"
#include "vtkCamera.h"
#include "vtkFloatArray.h"
#include "vtkMatrix4x4.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLShaderCache.h"
#include "vtkPNGWriter.h"
#include "vtkProp.h"
#include "vtkRenderWindow.h"
#include "vtkRenderer.h"
#include "vtkShaderProgram.h"
#include "vtkWindowToImageFilter.h"

#include "OpenGLFunctions.h"
#include "Ranks/Sharing/QueryPlan.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"
#include "Surface/Drawing/DepthPyramid.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <unordered_map>
#include <unordered_set>
#include <vector>

using namespace isosurface;

namespace
{

struct Options
{
  std::string Volume;
  std::vector<double> Isovalues;
  double Pixels = 1;  ///< the widest cell
  double Seconds = 0; ///< of an image; 0: as long as it takes
  double Memory = 2;  ///< GiB of surfaces
  std::vector<int> Size = { 1280, 800 };
  int Images = 60; ///< of each part of the flight
  int Threads = 2;
  std::string Pictures; ///< folder
  bool Each = false;
  bool All = false; ///< also what is hidden
};

/// A block at one of its levels, which tells the part of the volume.
struct Node
{
  int Level = 0;
  BlockReference Block;
  double Distance = 0; ///< of the camera

  std::uint64_t GetKey() const
  {
    return static_cast<std::uint64_t>(this->Level) << 48 |
      static_cast<std::uint64_t>(this->Block.Block);
  }
};

struct View
{
  std::array<double, 16> ModelToClip{};
  std::array<double, 3> Position{};
  double PixelsAtOne = 0; ///< how many pixels a length of 1 has at a distance of 1
  int Width = 0;
  int Height = 0;
};

/// What the image before has told.
struct Seen
{
  View From;
  DepthPyramid Depths;
  bool IsKnown = false;
};

[[noreturn]] void Fail(const Status& status)
{
  std::fprintf(stderr, "%s\n", status.GetMessage().c_str());
  std::exit(EXIT_FAILURE);
}

/// The active blocks of all parts of a volume.
class BlockTree
{
public:
  BlockTree(BlockedVolume& volume, const std::vector<double>& isovalues)
    : Volume(volume)
  {
    for (const VolumePart& part : volume.GetParts())
    {
      this->Active.emplace_back(static_cast<std::size_t>(part.Grid.GetNumberOfBlocks()));
      QueryStatistics statistics;
      auto plan = PlanQuery(volume, { { 0, 0, isovalues }, 0, 1 }, part.FirstLevel, statistics);
      if (!plan.IsOk())
      {
        Fail(plan.GetStatus());
      }
      for (const BlockReference& block : plan->Blocks)
      {
        auto& active = this->Active.back()[static_cast<std::size_t>(block.Block)];
        active = std::make_unique<BlockReference>(block);
      }
    }
  }

  std::array<double, 6> FindBounds(int part, std::int64_t block) const
  {
    const VolumePart& here = this->Volume.GetParts()[static_cast<std::size_t>(part)];
    const GridGeometry grid = this->Volume.GetHeader().Grid.Coarsen(here.FirstLevel);
    const VertexBox box = here.Grid.GetVertices(block, 0);
    std::array<double, 6> bounds{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const double origin =
        grid.Origin[axis] + grid.Spacing[axis] * static_cast<double>(grid.Extent[2 * axis]);
      bounds[2 * axis] = origin + grid.Spacing[axis] * static_cast<double>(box.Low[axis]);
      bounds[2 * axis + 1] = origin + grid.Spacing[axis] * static_cast<double>(box.High[axis] - 1);
    }
    return bounds;
  }

  /// What a view needs, at the levels whose cells are at most so many pixels wide.
  std::vector<Node> Choose(const View& view, const Seen* seen, double pixels) const
  {
    std::vector<Node> chosen;
    const int last = static_cast<int>(this->Volume.GetParts().size()) - 1;
    const auto blocks = this->Volume.GetParts().back().Grid.GetNumberOfBlocks();
    const Search search{ view, BoxProjection(view.ModelToClip, view.Width, view.Height),
      BoxProjection(seen ? seen->From.ModelToClip : view.ModelToClip, view.Width, view.Height),
      seen ? &seen->Depths : nullptr, pixels };
    for (std::int64_t block = 0; block < blocks; ++block)
    {
      this->Descend(search, last, block, chosen);
    }
    std::sort(chosen.begin(), chosen.end(),
      [](const Node& a, const Node& b) { return a.Distance < b.Distance; });
    return chosen;
  }

  /// The block of the next coarser part; false if there is none.
  bool FindParent(Node& node) const
  {
    const StoredLevel stored = this->Volume.FindLevel(node.Level);
    if (stored.Part + 1 >= this->Volume.GetParts().size())
    {
      return false;
    }
    const VolumePart& next = this->Volume.GetParts()[stored.Part + 1];
    const int shift = next.FirstLevel - this->Volume.GetParts()[stored.Part].FirstLevel;
    Index3 at = stored.Grid->GetBlockCoordinates(node.Block.Block);
    for (std::int64_t& place : at)
    {
      place >>= shift;
    }
    const auto block = static_cast<std::size_t>(next.Grid.GetBlockIndex(at));
    node.Level = next.FirstLevel;
    const auto& active = this->Active[stored.Part + 1][block];
    node.Block = active ? *active : BlockReference{ static_cast<std::int64_t>(block) };
    return true;
  }

private:
  struct Search
  {
    const View& From;
    BoxProjection Now;
    BoxProjection Before;
    const DepthPyramid* Depths;
    double Pixels;
  };

  static double FindDistance(const std::array<double, 6>& bounds, const std::array<double, 3>& from)
  {
    double sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const double off =
        std::max({ bounds[2 * axis] - from[axis], 0.0, from[axis] - bounds[2 * axis + 1] });
      sum += off * off;
    }
    return std::sqrt(sum);
  }

  void Descend(const Search& search, int part, std::int64_t block, std::vector<Node>& chosen) const
  {
    const auto bounds = this->FindBounds(part, block);
    std::array<float, 6> box{};
    std::transform(
      bounds.begin(), bounds.end(), box.begin(), [](double x) { return static_cast<float>(x); });
    const ProjectedBox now = search.Now.Project(box);
    if (now.IsOutside)
    {
      return;
    }
    if (search.Depths)
    {
      const ProjectedBox before = search.Before.Project(box);
      if (!before.IsOutside && before.IsKnown && search.Depths->IsBehind(before))
      {
        return;
      }
    }
    const auto& parts = this->Volume.GetParts();
    const VolumePart& here = parts[static_cast<std::size_t>(part)];
    const double distance = FindDistance(bounds, search.From.Position);
    const double cell =
      search.From.PixelsAtOne * this->Volume.GetHeader().Grid.Spacing[0] / std::max(distance, 1e-6);
    const int wanted = std::max(0, static_cast<int>(std::floor(std::log2(search.Pixels / cell))));
    if (part > 0 && wanted < here.FirstLevel)
    {
      const VolumePart& finer = parts[static_cast<std::size_t>(part) - 1];
      const int shift = here.FirstLevel - finer.FirstLevel;
      const Index3 at = here.Grid.GetBlockCoordinates(block);
      const Index3& size = finer.Grid.GetNumberOfBlocksPerAxis();
      for (std::int64_t k = at[2] << shift; k < std::min((at[2] + 1) << shift, size[2]); ++k)
      {
        for (std::int64_t j = at[1] << shift; j < std::min((at[1] + 1) << shift, size[1]); ++j)
        {
          for (std::int64_t i = at[0] << shift; i < std::min((at[0] + 1) << shift, size[0]); ++i)
          {
            this->Descend(search, part - 1, finer.Grid.GetBlockIndex({ i, j, k }), chosen);
          }
        }
      }
      return;
    }
    const auto& active =
      this->Active[static_cast<std::size_t>(part)][static_cast<std::size_t>(block)];
    if (active)
    {
      const int levels = here.Grid.GetNumberOfLevels();
      chosen.push_back(
        { std::clamp(wanted, here.FirstLevel, here.FirstLevel + levels - 1), *active, distance });
    }
  }

  BlockedVolume& Volume;
  std::vector<std::vector<std::unique_ptr<BlockReference>>> Active; ///< by part and block
};

/// The triangles of a block, in buffers of the graphics card.
struct DrawnBlock
{
  GLuint Array = 0;
  GLuint Points = 0;
  GLuint Indices = 0;
  GLsizei Count = 0; ///< of indices
  std::uint64_t Bytes = 0;
  int Image = 0; ///< the last one that needed it
};

/// Draws blocks, one after the other.
class vtkDrawnBlocks : public vtkProp
{
public:
  static vtkDrawnBlocks* New();
  vtkTypeMacro(vtkDrawnBlocks, vtkProp);

  std::array<double, 6> Place{};
  std::vector<const DrawnBlock*> Blocks;
  std::array<float, 16> ModelToClip{}; ///< column by column
  std::array<float, 3> Eye{};

  double* GetBounds() override { return this->Place.data(); }
  vtkTypeBool HasTranslucentPolygonalGeometry() override { return 0; }
  int RenderOpaqueGeometry(vtkViewport* viewport) override
  {
    auto* window = vtkOpenGLRenderWindow::SafeDownCast(viewport->GetVTKWindow());
    vtkShaderProgram* program =
      window->GetShaderCache()->ReadyShaderProgram(VertexShader, FragmentShader, "");
    if (!program)
    {
      return 0;
    }
    glUniformMatrix4fv(program->FindUniform("modelToClip"), 1, GL_FALSE, this->ModelToClip.data());
    glUniform3fv(program->FindUniform("eye"), 1, this->Eye.data());
    for (const DrawnBlock* block : this->Blocks)
    {
      glBindVertexArray(block->Array);
      glDrawElements(GL_TRIANGLES, block->Count, GL_UNSIGNED_INT, nullptr);
    }
    glBindVertexArray(0);
    return 1;
  }

private:
  static const char* const VertexShader;
  static const char* const FragmentShader;
};

vtkStandardNewMacro(vtkDrawnBlocks);

const char* const vtkDrawnBlocks::VertexShader = R"(//VTK::System::Dec
in vec3 point;
in vec3 normal;
uniform mat4 modelToClip;
uniform vec3 eye;
out float light;
void main()
{
  gl_Position = modelToClip * vec4(point, 1.0);
  light = abs(dot(normalize(normal), normalize(eye - point)));
}
)";
const char* const vtkDrawnBlocks::FragmentShader = R"(//VTK::System::Dec
//VTK::Output::Dec
in float light;
void main()
{
  gl_FragData[0] = vec4(vec3(light), 1.0);
}
)";

/// The surfaces of blocks on the graphics card, the least recently used ones of which are dropped beyond
/// a limit.
class BlockSurfaces
{
public:
  BlockSurfaces(BlockedVolume& volume, const Options& options)
    : Volume(volume)
    , Settings(options)
  {
  }

  const DrawnBlock* Find(std::uint64_t key, int image)
  {
    const auto found = this->Kept.find(key);
    if (found == this->Kept.end())
    {
      return nullptr;
    }
    found->second.Image = image;
    return &found->second;
  }

  /// Extracts nodes that are not kept, in their order, until the time is over.
  std::size_t Extract(const std::vector<Node>& nodes, int image, double until)
  {
    std::vector<const Node*> missing;
    for (const Node& node : nodes)
    {
      if (!this->Find(node.GetKey(), image))
      {
        missing.push_back(&node);
      }
    }
    std::vector<std::unique_ptr<Surface>> made(missing.size());
    std::atomic<std::size_t> next{ 0 };
    const auto work = [&]
    {
      for (std::size_t at = next++; at < missing.size() && GetSeconds() < until; at = next++)
      {
        made[at] = std::make_unique<Surface>(this->ExtractOne(*missing[at]));
      }
    };
    std::vector<std::thread> threads;
    for (int thread = 1; thread < this->Settings.Threads; ++thread)
    {
      threads.emplace_back(work);
    }
    work();
    for (std::thread& thread : threads)
    {
      thread.join();
    }
    std::size_t count = 0;
    for (std::size_t at = 0; at < missing.size(); ++at)
    {
      if (made[at])
      {
        DrawnBlock block = Upload(*made[at]);
        block.Image = image;
        this->Bytes += block.Bytes;
        this->Kept[missing[at]->GetKey()] = block;
        ++count;
      }
    }
    this->Drop(image);
    return count;
  }

  std::uint64_t GetBytes() const { return this->Bytes; }

private:
  static DrawnBlock Upload(const Surface& surface)
  {
    DrawnBlock block;
    block.Count = static_cast<GLsizei>(3 * surface.NumberOfCells);
    block.Bytes = 16 * surface.NumberOfPoints + 12 * surface.NumberOfCells + 256;
    if (block.Count == 0)
    {
      return block;
    }
    struct Point
    {
      std::array<float, 3> Place;
      std::array<std::int8_t, 4> Normal;
    };
    std::vector<Point> points(surface.NumberOfPoints);
    for (std::size_t at = 0; at < points.size(); ++at)
    {
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        points[at].Place[axis] = surface.Points[3 * at + axis];
        points[at].Normal[axis] = static_cast<std::int8_t>(127 * surface.Normals[3 * at + axis]);
      }
    }
    glGenVertexArrays(1, &block.Array);
    glBindVertexArray(block.Array);
    glGenBuffers(1, &block.Points);
    glBindBuffer(GL_ARRAY_BUFFER, block.Points);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(points.size() * sizeof(Point)),
      points.data(), GL_STATIC_DRAW);
    glGenBuffers(1, &block.Indices);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, block.Indices);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(block.Count) * 4,
      surface.Connectivity.Values32.GetData(), GL_STATIC_DRAW);
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Point), nullptr);
    glEnableVertexAttribArray(1);
    glVertexAttribPointer(1, 3, GL_BYTE, GL_TRUE, sizeof(Point), reinterpret_cast<const void*>(12));
    glBindVertexArray(0);
    return block;
  }

  Surface ExtractOne(const Node& node)
  {
    StoredBlockSource source(this->Volume, 0, 0, node.Level, { node.Block });
    ContourRequest request;
    request.Isovalues = this->Settings.Isovalues;
    request.Normals = true;
    auto surface =
      ExtractSurface(this->Volume.GetHeader().Grid.Coarsen(node.Level), source, request, 1);
    if (!surface.IsOk())
    {
      Fail(surface.GetStatus());
    }
    return std::move(*surface);
  }

  void Drop(int image)
  {
    const auto limit =
      static_cast<std::uint64_t>(this->Settings.Memory * (std::uint64_t{ 1 } << 30));
    if (this->Bytes <= limit)
    {
      return;
    }
    std::vector<std::pair<int, std::uint64_t>> byAge;
    for (const auto& [key, block] : this->Kept)
    {
      if (block.Image < image)
      {
        byAge.emplace_back(block.Image, key);
      }
    }
    std::sort(byAge.begin(), byAge.end());
    for (auto at = byAge.begin(); at != byAge.end() && this->Bytes > limit / 4 * 3; ++at)
    {
      const auto found = this->Kept.find(at->second);
      this->Bytes -= found->second.Bytes;
      glDeleteVertexArrays(1, &found->second.Array);
      glDeleteBuffers(1, &found->second.Points);
      glDeleteBuffers(1, &found->second.Indices);
      this->Kept.erase(found);
    }
  }

  BlockedVolume& Volume;
  const Options& Settings;
  std::unordered_map<std::uint64_t, DrawnBlock> Kept;
  std::uint64_t Bytes = 0;
};

/// What an image took.
struct Row
{
  double Choose = 0;
  double Extract = 0;
  double Draw = 0;
  double Depths = 0;
  double Total = 0;
  double Pixels = 0;
  std::size_t Nodes = 0;
  std::size_t Extracted = 0;
  std::size_t Absent = 0; ///< nodes that are not extracted, with or without a coarser one
  std::size_t Triangles = 0;
};

class Flight
{
public:
  Flight(BlockedVolume& volume, const Options& options)
    : Settings(options)
    , Tree(volume, options.Isovalues)
    , Surfaces(volume, options)
    , Pixels(16 * options.Pixels)
  {
    this->Window->SetOffScreenRendering(true);
    this->Window->SetMultiSamples(0);
    this->Window->SetSize(options.Size[0], options.Size[1]);
    this->Window->AddRenderer(this->Renderer);
    const int last = static_cast<int>(volume.GetParts().size()) - 1;
    this->Bounds = this->Tree.FindBounds(last, 0);
    this->Prop->Place = this->Bounds;
    this->Renderer->AddViewProp(this->Prop);
    this->Renderer->ResetCamera(this->Bounds.data());
    this->Window->Render(); // makes the context
  }

  vtkCamera* GetCamera() { return this->Renderer->GetActiveCamera(); }
  const std::array<double, 6>& GetBounds() const { return this->Bounds; }
  vtkRenderWindow* GetWindow() { return this->Window; }
  double GetPixels() const { return this->Pixels; }
  std::uint64_t GetBytes() const { return this->Surfaces.GetBytes(); }

  Row Draw()
  {
    ++this->Image;
    Row row;
    row.Pixels = this->Pixels;
    this->Renderer->ResetCameraClippingRange(this->Bounds.data());
    const double begin = GetSeconds();
    const View view = this->FindView();
    const auto nodes = this->Tree.Choose(
      view, this->Last.IsKnown && !this->Settings.All ? &this->Last : nullptr, this->Pixels);
    const double chosen = GetSeconds();
    const double until =
      this->Settings.Seconds > 0 ? chosen + 0.4 * this->Settings.Seconds : HUGE_VAL;
    row.Extracted = this->Surfaces.Extract(nodes, this->Image, until);
    const double extracted = GetSeconds();
    this->Prop->Blocks = this->Collect(nodes, row);
    for (std::size_t at = 0; at < 16; ++at)
    {
      this->Prop->ModelToClip[at] = static_cast<float>(view.ModelToClip[at % 4 * 4 + at / 4]);
    }
    std::copy(view.Position.begin(), view.Position.end(), this->Prop->Eye.begin());
    const double collected = GetSeconds();
    this->Window->Render();
    this->Window->WaitForCompletion();
    const double drawn = GetSeconds();
    this->ReadDepths(view);
    const double end = GetSeconds();
    row.Choose = chosen - begin;
    row.Extract = extracted - chosen;
    row.Draw = drawn - collected;
    row.Depths = end - drawn;
    row.Total = end - begin;
    row.Nodes = nodes.size();
    for (const DrawnBlock* block : this->Prop->Blocks)
    {
      row.Triangles += static_cast<std::size_t>(block->Count / 3);
    }
    this->Adapt(row);
    return row;
  }

private:
  View FindView()
  {
    View view;
    vtkCamera* camera = this->GetCamera();
    view.Width = this->Settings.Size[0];
    view.Height = this->Settings.Size[1];
    vtkMatrix4x4* matrix = camera->GetCompositeProjectionTransformMatrix(
      static_cast<double>(view.Width) / view.Height, -1, 1);
    std::memcpy(view.ModelToClip.data(), matrix->GetData(), sizeof(view.ModelToClip));
    camera->GetPosition(view.Position.data());
    view.PixelsAtOne =
      view.Height / 2.0 / std::tan(camera->GetViewAngle() / 2 * std::acos(-1.0) / 180);
    return view;
  }

  std::vector<const DrawnBlock*> Collect(const std::vector<Node>& nodes, Row& row)
  {
    std::vector<const DrawnBlock*> found;
    std::unordered_set<const DrawnBlock*> shown;
    for (Node node : nodes)
    {
      const DrawnBlock* surface = this->Surfaces.Find(node.GetKey(), this->Image);
      row.Absent += surface ? 0 : 1;
      while (!surface && this->Tree.FindParent(node))
      {
        // Of either of its levels.
        for (int finer = 0; !surface && finer < 2; ++finer)
        {
          Node coarser = node;
          coarser.Level += finer;
          surface = this->Surfaces.Find(coarser.GetKey(), this->Image);
        }
      }
      if (surface && row.Absent > 0 && !shown.insert(surface).second)
      {
        continue; // stands in for several
      }
      if (surface && surface->Count > 0)
      {
        found.push_back(surface);
      }
    }
    return found;
  }

  void ReadDepths(const View& view)
  {
    this->Window->GetZbufferData(0, 0, view.Width - 1, view.Height - 1, this->DepthValues);
    const float* values = this->DepthValues->GetPointer(0);
    this->Last.Depths.Build(
      std::vector<float>(values, values + this->DepthValues->GetNumberOfValues()), view.Width,
      view.Height);
    this->Last.From = view;
    this->Last.IsKnown = true;
  }

  void Adapt(const Row& row)
  {
    if (this->Settings.Seconds <= 0)
    {
      this->Pixels = std::max(this->Settings.Pixels, this->Pixels / 2);
      return;
    }
    const double slower =
      (row.Total - row.Extract + std::min(row.Extract, 0.3 * this->Settings.Seconds)) /
      this->Settings.Seconds;
    const double factor = std::clamp(std::sqrt(slower / 0.9), 0.7, 1.6);
    this->Pixels =
      std::clamp(this->Pixels * factor, this->Settings.Pixels, 64 * this->Settings.Pixels);
  }

  const Options& Settings;
  BlockTree Tree;
  BlockSurfaces Surfaces;
  double Pixels;
  int Image = 0;
  std::array<double, 6> Bounds{};
  Seen Last;
  vtkNew<vtkRenderer> Renderer;
  vtkNew<vtkRenderWindow> Window;
  vtkNew<vtkDrawnBlocks> Prop;
  vtkNew<vtkFloatArray> DepthValues;
};

double Percentile(std::vector<double> values, double share)
{
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

template <typename GetT>
std::vector<double> Column(const std::vector<Row>& rows, GetT get)
{
  std::vector<double> column;
  std::transform(rows.begin(), rows.end(), std::back_inserter(column), get);
  return column;
}

void PrintSummary(const char* name, const std::vector<Row>& rows)
{
  const auto median = [&](auto get) { return Percentile(Column(rows, get), 0.5); };
  const auto total = [](const Row& row) { return row.Total; };
  std::printf("%-10s median %.3f s, 95 %% %.3f s, slowest %.3f s; cells of %.1f pixels (most "
              "%.1f); choose %.3f extract %.3f "
              "draw %.3f depths %.3f; %.0f blocks, %.1f new, %.0f absent; %.2f million triangles\n",
    name, median(total), Percentile(Column(rows, total), 0.95), Percentile(Column(rows, total), 1),
    median([](const Row& row) { return row.Pixels; }),
    Percentile(Column(rows, [](const Row& row) { return row.Pixels; }), 1),
    median([](const Row& row) { return row.Choose; }),
    median([](const Row& row) { return row.Extract; }),
    median([](const Row& row) { return row.Draw; }),
    median([](const Row& row) { return row.Depths; }),
    median([](const Row& row) { return static_cast<double>(row.Nodes); }),
    median([](const Row& row) { return static_cast<double>(row.Extracted); }),
    median([](const Row& row) { return static_cast<double>(row.Absent); }),
    median([](const Row& row) { return static_cast<double>(row.Triangles) / 1e6; }));
}

void SavePicture(vtkRenderWindow* window, const std::string& path)
{
  vtkNew<vtkWindowToImageFilter> image;
  image->SetInput(window);
  image->ShouldRerenderOff();
  vtkNew<vtkPNGWriter> writer;
  writer->SetFileName(path.c_str());
  writer->SetInputConnection(image->GetOutputPort());
  writer->Write();
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
  app.add_option("--memory", options.Memory, "GiB of surfaces that are kept");
  app.add_option("--size", options.Size, "of the window")->expected(2);
  app.add_option("--images", options.Images, "of each part of the flight")
    ->check(CLI::PositiveNumber);
  app.add_option("--threads", options.Threads, "that extract")->check(CLI::PositiveNumber);
  app.add_option("--pictures", options.Pictures, "folder for some images");
  app.add_flag("--each", options.Each, "print each image");
  app.add_flag("--all", options.All, "extract what is hidden, too");
  CLI11_PARSE(app, argc, argv);

  auto volume = BlockedVolume::Open(
    options.Volume, GetLocalFileSystem(), std::make_shared<BlockCache>(std::uint64_t{ 512 } << 20));
  if (!volume.IsOk())
  {
    Fail(volume.GetStatus());
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
  const double begin = GetSeconds();
  Flight flight(**volume, options);
  std::printf("tree of active blocks: %.3f s\n", GetSeconds() - begin);
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
      const Row& row = rows.back();
      if (options.Each)
      {
        std::printf(
          "%s %d: %.3f s = choose %.3f extract %.3f draw %.3f depths %.3f; cells of %.1f pixels, "
          "%zu blocks, %zu new, %zu absent; %.2f million triangles; %.2f GB\n",
          name, image, row.Total, row.Choose, row.Extract, row.Draw, row.Depths, row.Pixels,
          row.Nodes, row.Extracted, row.Absent, static_cast<double>(row.Triangles) / 1e6,
          static_cast<double>(flight.GetBytes()) / 1e9);
      }
      if (!options.Pictures.empty() && image == options.Images - 1)
      {
        SavePicture(flight.GetWindow(), options.Pictures + "/" + name + ".png");
      }
    }
    PrintSummary(name, rows);
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
  camera->SetViewAngle(60);
  camera->SetPosition(bounds[0] + side / 2, bounds[2] - side / 8, bounds[4] + side / 2);
  camera->SetFocalPoint(bounds[0] + side / 2, bounds[2] + side / 2, bounds[4] + side / 2);
  camera->SetViewUp(0, 0, 1);
  fly("through",
    [&]
    {
      std::array<double, 3> at{};
      camera->GetPosition(at.data());
      camera->SetPosition(at[0], at[1] + side / options.Images, at[2]);
      camera->SetFocalPoint(at[0], at[1] + side, at[2]);
    });
  std::printf("%s\n", FindPeakMemory().c_str());
  return EXIT_SUCCESS;
}
