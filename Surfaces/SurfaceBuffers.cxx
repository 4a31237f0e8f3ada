// SPDX-License-Identifier: BSD-3-Clause
#include "SurfaceBuffers.h"

#include "DrawingBudget.h"
#include "OpenGLFunctions.h"

#include "Ground/Base/HugePages.h"
#include "Ground/Base/KeptMemory.h"

#include <cstring>
#include <utility>

namespace isosurface
{
namespace
{

// Of GL_AMD_pinned_memory, for which headers may have no name.
constexpr GLenum ExternalMemory = 0x9160;

/// Whether buffers can be in memory of this process without a loss: not behind a bus.
bool CanUseOwnMemory()
{
  constexpr const char* rasterizer = "llvmpipe";
  const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  if (!renderer || std::strncmp(renderer, rasterizer, std::strlen(rasterizer)) != 0)
  {
    return false;
  }
  GLint count = 0;
  glGetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLint n = 0; n < count; ++n)
  {
    const auto* name =
      reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(n)));
    if (name && std::strcmp(name, "GL_AMD_pinned_memory") == 0)
    {
      return true;
    }
  }
  return false;
}

} // namespace

SurfaceBuffers::~SurfaceBuffers()
{
  this->ReleaseUsed();
}

void SurfaceBuffers::Add(vtkOpenGLBufferObject* buffer, vtkOpenGLBufferObject::ObjectType type,
  std::vector<std::size_t> ends, WriteFunction write)
{
  buffer->GenerateBuffer(type);
  if (!ends.empty())
  {
    const auto handle = static_cast<unsigned int>(buffer->GetHandle());
    this->Unwritten.push_back({ handle, std::move(ends), std::move(write) });
  }
}

void SurfaceBuffers::Write(const DrawingBudget* budget)
{
  do
  {
    Buffer& buffer = this->Unwritten.front();
    // A target that no vertex array object knows: the one in use stays as it is.
    glBindBuffer(GL_COPY_WRITE_BUFFER, buffer.Handle);
    if (!std::exchange(buffer.HasMemory, true))
    {
      this->MakeMemory(buffer);
    }
    else
    {
      WriteNext(buffer);
    }
    glBindBuffer(GL_COPY_WRITE_BUFFER, 0);
    if (buffer.Next == buffer.Ends.size())
    {
      this->Unwritten.erase(this->Unwritten.begin());
    }
  } while (!this->Unwritten.empty() && !(budget && budget->GetSecondsLeft() <= 0));
}

void SurfaceBuffers::Clear()
{
  this->Unwritten.clear();
  if (!this->Used.empty())
  {
    glFinish();
    this->ReleaseUsed();
  }
}

void SurfaceBuffers::ReleaseUsed()
{
  for (void* memory : std::exchange(this->Used, {}))
  {
    ReleaseMemory(memory);
  }
}

void SurfaceBuffers::MakeMemory(const Buffer& buffer)
{
  // Vertices are read in registers, which may reach beyond the last one.
  constexpr std::size_t margin = 256;
  const std::size_t bytes = buffer.Ends.back();
  const auto size = static_cast<GLsizeiptr>(bytes);
  void* memory = CanUseOwnMemory() ? TakeMemory(bytes + margin) : nullptr;
  if (memory)
  {
    AdviseHugePages(memory, bytes);
    glBindBuffer(ExternalMemory, buffer.Handle);
    glBufferData(ExternalMemory, size, memory, GL_STATIC_DRAW);
    glBindBuffer(ExternalMemory, 0);
    const void* mapped = glMapBufferRange(GL_COPY_WRITE_BUFFER, 0, size, GL_MAP_WRITE_BIT);
    const bool isUsed =
      mapped && glUnmapBuffer(GL_COPY_WRITE_BUFFER) == GL_TRUE && mapped == memory;
    if (isUsed)
    {
      this->Used.push_back(memory);
      return;
    }
  }
  glBufferData(GL_COPY_WRITE_BUFFER, size, nullptr, GL_STATIC_DRAW);
  ReleaseMemory(memory);
}

void SurfaceBuffers::WriteNext(Buffer& buffer)
{
  const std::size_t first = buffer.Next > 0 ? buffer.Ends[buffer.Next - 1] : 0;
  const std::size_t bytes = buffer.Ends[buffer.Next] - first;
  const auto place = static_cast<GLintptr>(first);
  const auto length = static_cast<GLsizeiptr>(bytes);
  void* mapped = buffer.MayBeMapped && bytes > 0
    ? glMapBufferRange(
        GL_COPY_WRITE_BUFFER, place, length, GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_RANGE_BIT)
    : nullptr;
  if (mapped)
  {
    try
    {
      buffer.Write(buffer.Next, mapped);
    }
    catch (...)
    {
      glUnmapBuffer(GL_COPY_WRITE_BUFFER);
      throw;
    }
    buffer.MayBeMapped = glUnmapBuffer(GL_COPY_WRITE_BUFFER) == GL_TRUE;
    // Memory that was lost while it was mapped is lost as a whole.
    buffer.Next = buffer.MayBeMapped ? buffer.Next + 1 : 0;
  }
  else
  {
    std::vector<unsigned char> values(bytes);
    buffer.Write(buffer.Next, values.data());
    glBufferSubData(GL_COPY_WRITE_BUFFER, place, length, values.data());
    ++buffer.Next;
  }
}

} // namespace isosurface
