// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Benchmarks_BlockBuffers_h
#define isosurface_Benchmarks_BlockBuffers_h

#include "Surface/BlockTree.h"

#include "vtkProp.h"

#include "OpenGLFunctions.h"
#include "Surface/Contour/Surface.h"

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace isosurface
{

/// The triangles of a block, in buffers of the graphics card.
struct BlockBuffer
{
  GLuint Array = 0;
  GLuint Points = 0;
  GLuint Indices = 0;
  GLsizei Count = 0; ///< of indices
  std::uint64_t Bytes = 0;
  int Image = 0; ///< the last one that needed it
};

/// The surfaces of blocks in buffers, the least recently used ones of which are dropped beyond a limit.
class BlockBuffers
{
public:
  BlockBuffers(BlockedVolume& volume, std::vector<double> isovalues, std::uint64_t limit);

  /// Null if it is not kept.
  const BlockBuffer* Find(const LevelBlock& block, int image);

  /// Extracts blocks that are not kept, by two threads, in their order, until a time of GetSeconds().
  /// Ends the program with a message if they cannot be read.
  void Extract(const std::vector<LevelBlock>& blocks, int image, double until);

private:
  Surface ExtractOne(const LevelBlock& block) const;
  void Drop(int image);

  BlockedVolume& Volume;
  std::vector<double> Isovalues;
  std::uint64_t Limit;
  std::unordered_map<std::uint64_t, BlockBuffer> Kept;
  std::uint64_t Bytes = 0;
};

/// Draws blocks, lit by the camera.
class vtkBlockBuffersProp : public vtkProp
{
public:
  static vtkBlockBuffersProp* New();
  vtkTypeMacro(vtkBlockBuffersProp, vtkProp);

  std::vector<const BlockBuffer*> Blocks;
  std::array<double, 6> Bounds{};
  SeenImage Image;

  double* GetBounds() override { return this->Bounds.data(); }
  vtkTypeBool HasTranslucentPolygonalGeometry() override { return 0; }
  int RenderOpaqueGeometry(vtkViewport* viewport) override;
};

} // namespace isosurface

#endif
