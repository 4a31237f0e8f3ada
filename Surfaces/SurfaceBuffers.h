// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceBuffers_h
#define isosurface_SurfaceBuffers_h

#include "vtkOpenGLBufferObject.h"

#include <cstddef>
#include <functional>
#include <vector>

namespace isosurface
{

class DrawingBudget;

/**
 * Buffers of the graphics card whose values are written in portions, so that those of a large surface
 * do not hold the window. Mesa's rasterizer reads them where they are written, in memory that is kept
 * from surface to surface; it would clear memory of its own. All functions but the destructor need the
 * window's context.
 */
class SurfaceBuffers
{
public:
  /// Writes the values of a portion where the graphics card reads them, or into memory that is copied
  /// there.
  using WriteFunction = std::function<void(std::size_t portion, void* values)>;

  SurfaceBuffers() = default;
  SurfaceBuffers(const SurfaceBuffers&) = delete;
  SurfaceBuffers& operator=(const SurfaceBuffers&) = delete;
  /// Nothing may be drawn from the buffers afterwards.
  ~SurfaceBuffers();

  /// Adds a buffer that will be as large as all portions together. They lie one behind the other;
  /// `ends` says where each of them ends, in bytes. What `write` reads must outlive its last call.
  void Add(vtkOpenGLBufferObject* buffer, vtkOpenGLBufferObject::ObjectType type,
    std::vector<std::size_t> ends, WriteFunction write);

  /// Whether all is written.
  bool IsWritten() const { return this->Unwritten.empty(); }

  /// Makes the memory of at least one buffer, or writes a portion, and goes on until the budget's time
  /// is over, or to the end without a budget. Something is unwritten.
  void Write(const DrawingBudget* budget);

  /// To be called when all buffers have been deleted: gives their memory back.
  void Clear();

private:
  struct Buffer
  {
    unsigned int Handle = 0;
    std::vector<std::size_t> Ends;
    WriteFunction Write;
    std::size_t Next = 0; ///< the first portion that is not written
    bool HasMemory = false;
    bool MayBeMapped = true; ///< false once its memory was lost while it was mapped
  };

  void MakeMemory(const Buffer& buffer);
  static void WriteNext(Buffer& buffer);
  void ReleaseUsed();

  std::vector<Buffer> Unwritten;
  std::vector<void*> Used; ///< memory of this process that buffers are in
};

} // namespace isosurface

#endif
