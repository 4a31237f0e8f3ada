// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IceTCompositor_h
#define isosurface_IceTCompositor_h

#include "Ranks/Compositing/DisplayLayout.h"
#include "Ranks/Compositing/Image.h"

#include "vtkSynchronizedRenderers.h"

#include <cstdint>

class vtkFloatArray;

namespace isosurface
{

/// The tiles that the current IceT context was told of, with one sample for each pixel.
DisplayLayout GetIceTDisplay();

/**
 * Merges the ranks' images by IceT, in its current context. IceT merges images of full resolution,
 * so each rank upsamples its own; only the pixels of its viewport are valid.
 */
class IceTCompositor
{
public:
  /// Takes the memory of Composite(), 8 bytes a pixel of the display. Not collective.
  void Prepare(const DisplayLayout& display);

  /**
   * Collective, after Prepare(). `viewport` and `mine` are this rank's. Fills `colors` and, if wanted, `depths` with
   * the image of this rank's tile; leaves them as they are on ranks without a tile.
   */
  void Composite(const DisplayLayout& display, const Viewport& viewport, const ImageView& mine,
    bool wantsDepths, vtkSynchronizedRenderers::vtkRawImage& colors, vtkFloatArray* depths);

  /// Bytes that this rank sent to other ranks in the last frame.
  std::int64_t GetBytesSent() const { return this->BytesSent; }

private:
  ImageBuffer Upsampled; ///< of the display's size; undefined outside of the viewport
  std::int64_t BytesSent = 0;
};

} // namespace isosurface

#endif
