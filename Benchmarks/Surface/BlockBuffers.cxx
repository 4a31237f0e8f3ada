// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/BlockBuffers.h"

#include "Volumes/VolumeQuery.h"

#include "vtkObjectFactory.h"
#include "vtkOpenGLRenderWindow.h"
#include "vtkOpenGLShaderCache.h"
#include "vtkShaderProgram.h"
#include "vtkViewport.h"

#include "Ground/Base/ParallelFor.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

constexpr int Threads = 2;

const char* const VertexShader = R"(//VTK::System::Dec
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
const char* const FragmentShader = R"(//VTK::System::Dec
//VTK::Output::Dec
in float light;
void main()
{
  gl_FragData[0] = vec4(vec3(light), 1.0);
}
)";

BlockBuffer WriteBuffer(const Surface& surface)
{
  struct Point
  {
    std::array<float, 3> Place;
    std::array<std::int8_t, 4> Normal;
  };
  BlockBuffer buffer;
  buffer.Count = static_cast<GLsizei>(3 * surface.NumberOfCells);
  buffer.Bytes = sizeof(Point) * surface.NumberOfPoints + 12 * surface.NumberOfCells;
  if (buffer.Count == 0)
  {
    return buffer;
  }
  std::vector<Point> points(surface.NumberOfPoints);
  for (std::size_t at = 0; at < points.size(); ++at)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      points[at].Place[axis] = surface.Points[3 * at + axis];
      points[at].Normal[axis] = static_cast<std::int8_t>(127 * surface.Normals[3 * at + axis]);
    }
  }
  const auto write = [](GLuint& number, GLenum target, const void* from, std::size_t bytes)
  {
    glGenBuffers(1, &number);
    glBindBuffer(target, number);
    glBufferData(target, static_cast<GLsizeiptr>(bytes), from, GL_STATIC_DRAW);
  };
  glGenVertexArrays(1, &buffer.Array);
  glBindVertexArray(buffer.Array);
  write(buffer.Points, GL_ARRAY_BUFFER, points.data(), sizeof(Point) * points.size());
  write(buffer.Indices, GL_ELEMENT_ARRAY_BUFFER, surface.Connectivity.Values32.GetData(),
    12 * surface.NumberOfCells);
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Point), nullptr);
  glEnableVertexAttribArray(1);
  glVertexAttribPointer(
    1, 3, GL_BYTE, GL_TRUE, sizeof(Point), reinterpret_cast<const void*>(sizeof(Point::Place)));
  glBindVertexArray(0);
  return buffer;
}

} // namespace

BlockBuffers::BlockBuffers(
  BlockedVolume& volume, std::vector<double> isovalues, std::uint64_t limit)
  : Volume(volume)
  , Isovalues(std::move(isovalues))
  , Limit(limit)
{
}

const BlockBuffer* BlockBuffers::Find(const LevelBlock& block, int image)
{
  const auto found = this->Kept.find(block.GetKey());
  if (found == this->Kept.end())
  {
    return nullptr;
  }
  found->second.Image = image;
  return &found->second;
}

void BlockBuffers::Extract(const std::vector<LevelBlock>& blocks, int image, double until)
{
  std::vector<const LevelBlock*> missing;
  for (const LevelBlock& block : blocks)
  {
    if (!this->Find(block, image))
    {
      missing.push_back(&block);
    }
  }
  std::vector<std::optional<Surface>> made(missing.size());
  ParallelFor(missing.size(), Threads,
    [&](std::size_t at, int)
    {
      if (GetSeconds() < until)
      {
        made[at] = this->ExtractOne(*missing[at]);
      }
    });
  for (std::size_t at = 0; at < missing.size(); ++at)
  {
    if (made[at])
    {
      BlockBuffer buffer = WriteBuffer(*made[at]);
      buffer.Image = image;
      this->Bytes += buffer.Bytes;
      this->Kept[missing[at]->GetKey()] = buffer;
    }
  }
  this->Drop(image);
}

Surface BlockBuffers::ExtractOne(const LevelBlock& block) const
{
  StoredBlockSource source(this->Volume, 0, 0, block.Level, { block.Block });
  ContourRequest request;
  request.Isovalues = this->Isovalues;
  request.Normals = true;
  auto surface =
    ExtractSurface(this->Volume.GetHeader().Grid.Coarsen(block.Level), source, request, 1);
  if (!surface.IsOk())
  {
    std::fprintf(stderr, "%s\n", surface.GetStatus().GetMessage().c_str());
    std::exit(EXIT_FAILURE);
  }
  return std::move(*surface);
}

void BlockBuffers::Drop(int image)
{
  std::vector<std::pair<int, std::uint64_t>> byAge;
  for (const auto& [key, buffer] : this->Kept)
  {
    if (this->Bytes > this->Limit && buffer.Image < image)
    {
      byAge.emplace_back(buffer.Image, key);
    }
  }
  std::sort(byAge.begin(), byAge.end());
  for (auto at = byAge.begin(); at != byAge.end() && this->Bytes > this->Limit / 4 * 3; ++at)
  {
    const auto found = this->Kept.find(at->second);
    this->Bytes -= found->second.Bytes;
    glDeleteVertexArrays(1, &found->second.Array);
    glDeleteBuffers(1, &found->second.Points);
    glDeleteBuffers(1, &found->second.Indices);
    this->Kept.erase(found);
  }
}

vtkStandardNewMacro(vtkBlockBuffersProp);

int vtkBlockBuffersProp::RenderOpaqueGeometry(vtkViewport* viewport)
{
  auto* window = vtkOpenGLRenderWindow::SafeDownCast(viewport->GetVTKWindow());
  vtkShaderProgram* program =
    window->GetShaderCache()->ReadyShaderProgram(VertexShader, FragmentShader, "");
  if (!program)
  {
    return 0;
  }
  std::array<float, 16> matrix{};
  std::transform(this->Image.ModelToClip.begin(), this->Image.ModelToClip.end(), matrix.begin(),
    [](double value) { return static_cast<float>(value); });
  std::array<float, 3> eye{};
  std::transform(this->Image.Position.begin(), this->Image.Position.end(), eye.begin(),
    [](double value) { return static_cast<float>(value); });
  glUniformMatrix4fv(program->FindUniform("modelToClip"), 1, GL_TRUE, matrix.data());
  glUniform3fv(program->FindUniform("eye"), 1, eye.data());
  for (const BlockBuffer* block : this->Blocks)
  {
    glBindVertexArray(block->Array);
    glDrawElements(GL_TRIANGLES, block->Count, GL_UNSIGNED_INT, nullptr);
  }
  glBindVertexArray(0);
  return 1;
}

} // namespace isosurface
