// SPDX-License-Identifier: BSD-3-Clause
#include "IceTCompositor.h"

#include "Ranks/Compositing/ImageScaling.h"

#include "vtkFloatArray.h"
#include "vtkUnsignedCharArray.h"

#include <IceT.h>

#include <array>

namespace isosurface
{

DisplayLayout GetIceTDisplay()
{
  IceTInt count = 0;
  icetGetIntegerv(ICET_NUM_TILES, &count);
  std::vector<IceTInt> viewports(4 * static_cast<std::size_t>(count));
  std::vector<IceTInt> ranks(static_cast<std::size_t>(count));
  if (count > 0)
  {
    icetGetIntegerv(ICET_TILE_VIEWPORTS, viewports.data());
    icetGetIntegerv(ICET_DISPLAY_NODES, ranks.data());
  }
  std::array<IceTInt, 4> global{};
  icetGetIntegerv(ICET_GLOBAL_VIEWPORT, global.data());
  DisplayLayout display;
  for (std::size_t tile = 0; tile < ranks.size(); ++tile)
  {
    display.Tiles.push_back(
      { { viewports[4 * tile] - global[0], viewports[4 * tile + 1] - global[1],
          viewports[4 * tile + 2], viewports[4 * tile + 3] },
        ranks[tile] });
  }
  return display;
}

void IceTCompositor::Prepare(const DisplayLayout& display)
{
  this->Upsampled.Resize(display.GetExtent());
}

void IceTCompositor::Composite(const DisplayLayout& display, const Viewport& viewport,
  const ImageView& mine, bool wantsDepths, vtkSynchronizedRenderers::vtkRawImage& colors,
  vtkFloatArray* depths)
{
  const PixelRectangle extent = display.GetExtent();
  const PixelRectangle pixels = viewport.GetPixels(extent);
  UpsampleBlocks(mine, viewport.Divisor, pixels, this->Upsampled);
  if (wantsDepths)
  {
    icetDisable(ICET_COMPOSITE_ONE_BUFFER);
  }
  else
  {
    icetEnable(ICET_COMPOSITE_ONE_BUFFER);
  }
  std::array<IceTInt, 4> global{};
  icetGetIntegerv(ICET_GLOBAL_VIEWPORT, global.data());
  const std::array<IceTInt, 4> valid = { pixels.X + global[0], pixels.Y + global[1], pixels.Width,
    pixels.Height };
  const std::array<IceTFloat, 4> background = { 0, 0, 0, 0 };
  const IceTImage image = icetCompositeImage(this->Upsampled.Colors.data(),
    this->Upsampled.Depths.data(), valid.data(), nullptr, nullptr, background.data());

  if (icetImageGetColorFormat(image) != ICET_IMAGE_COLOR_NONE)
  {
    colors.Resize(
      static_cast<int>(icetImageGetWidth(image)), static_cast<int>(icetImageGetHeight(image)), 4);
    icetImageCopyColorub(image, colors.GetRawPtr()->GetPointer(0), ICET_IMAGE_COLOR_RGBA_UBYTE);
    colors.MarkValid();
  }
  if (wantsDepths && icetImageGetDepthFormat(image) != ICET_IMAGE_DEPTH_NONE)
  {
    depths->SetNumberOfTuples(icetImageGetNumPixels(image));
    icetImageCopyDepthf(image, depths->GetPointer(0), ICET_IMAGE_DEPTH_FLOAT);
  }
  IceTInt bytes = 0;
  icetGetIntegerv(ICET_BYTES_SENT, &bytes);
  this->BytesSent = bytes;
}

} // namespace isosurface
