// SPDX-License-Identifier: BSD-3-Clause
// Full resolution, compared with stock compositing, and with one rank that draws all.
#include "RankScene.h"

#include "vtkMetabufferPass.h"

#include "vtkActor.h"
#include "vtkBoundingBox.h"
#include "vtkCommand.h"
#include "vtkIceTCompositePass.h"
#include "vtkLogger.h"
#include "vtkNew.h"
#include "vtkOrderedCompositingHelper.h"
#include "vtkProperty.h"
#include "vtkRenderer.h"

#include <gtest/gtest.h>

#include <string>

using namespace isosurface;

namespace
{

void ExpectSame(const Image& ours, const Image& theirs, const std::string& what)
{
  EXPECT_EQ(ours.Width, theirs.Width) << what;
  EXPECT_EQ(ours.Height, theirs.Height) << what;
  EXPECT_EQ(CountDifferentColors(ours, theirs), 0U) << what;
  EXPECT_EQ(CountDifferentDepths(ours, theirs), 0U) << what;
}

/// All ranks' actors, drawn by this one.
Image RenderAllAlone(const Scene& scene, const CameraPlace& camera, int width, int height)
{
  std::vector<vtkSmartPointer<vtkActor>> all;
  for (int rank = 0; rank < GetNumberOfRanks(); ++rank)
  {
    for (const auto& actor : scene.Make(rank, GetNumberOfRanks()))
    {
      all.push_back(actor);
    }
  }
  return RenderAlone(all, camera, width, height);
}

constexpr int Width = 211;
constexpr int Height = 163;

} // namespace

TEST(MetabufferPass, FullResolutionIsTheImageOfStockCompositing)
{
  RankWindow stock(RankWindow::Stock, Width, Height);
  RankWindow ours(RankWindow::Metabuffer, Width, Height);
  std::size_t active = 0;
  for (const Scene& scene : GetScenes())
  {
    if (scene.Name == "wireframe" || scene.Name == "points")
    {
      continue; // stock compositing cuts them at the bounds
    }
    stock.SetScene(scene);
    ours.SetScene(scene);
    for (const CameraPlace& camera : GetCameraPlaces())
    {
      stock.SetCamera(camera);
      ours.SetCamera(camera);
      const Image expected = stock.Render();
      active += expected.CountActive();
      for (const int mode : { vtkMetabufferPass::DIRECT_SEND, vtkMetabufferPass::ICET })
      {
        ours.GetPass()->SetCompositeMode(mode);
        const std::string what = scene.Name + ", " + camera.Name + ", " + std::to_string(mode);
        ExpectSame(ours.Render(), expected, what);
        EXPECT_TRUE(ours.GetPass()->GetUsedViewports()) << what;
      }
    }
  }
  EXPECT_TRUE(IsTrueOnSomeRank(active > 50000));
}

TEST(MetabufferPass, FullResolutionIsTheImageOfOneRankThatDrawsAll)
{
  RankWindow ours(RankWindow::Metabuffer, Width, Height);
  for (const Scene& scene : GetScenes())
  {
    ours.SetScene(scene);
    for (const CameraPlace& camera : GetCameraPlaces())
    {
      ours.SetCamera(camera);
      const Image image = ours.Render();
      if (GetRank() == 0)
      {
        ExpectSame(
          image, RenderAllAlone(scene, camera, Width, Height), scene.Name + ", " + camera.Name);
      }
    }
  }
}

TEST(MetabufferPass, RanksDrawTheRectanglesThatTheirPropsCover)
{
  RankWindow ours(RankWindow::Metabuffer, Width, Height);
  for (const Scene& scene : GetScenes())
  {
    ours.SetScene(scene);
    for (const CameraPlace& camera : GetCameraPlaces())
    {
      ours.SetCamera(camera);
      ours.Render();
      // The pixels of this rank alone, found by looking at all of them.
      const Image mine =
        RenderAlone(scene.Make(GetRank(), GetNumberOfRanks()), camera, Width, Height);
      int viewport[5];
      ours.GetPass()->GetViewport(GetRank(), viewport);
      for (int y = 0; y < Height; ++y)
      {
        for (int x = 0; x < Width; ++x)
        {
          const bool isInside = x >= viewport[0] && x < viewport[0] + viewport[2] &&
            y >= viewport[1] && y < viewport[1] + viewport[3];
          const std::size_t pixel =
            static_cast<std::size_t>(y) * Width + static_cast<std::size_t>(x);
          EXPECT_FALSE(!isInside && mine.Depths[pixel] < 1.0F)
            << scene.Name << ", " << camera.Name << ": " << x << ", " << y;
        }
      }
      if (scene.Name == "nested" && camera.Name == "far away")
      {
        EXPECT_LT(viewport[2] * viewport[3], Width * Height / (GetRank() == 0 ? 1 : 2));
        EXPECT_EQ(ours.GetPass()->GetDrawnPixels(), viewport[2] * viewport[3]);
      }
      if (scene.Name == "nobody draws" || camera.Name == "beside")
      {
        EXPECT_EQ(viewport[2] * viewport[3], 0) << scene.Name;
      }
    }
  }
}

TEST(MetabufferPass, FullDisplayAsViewportGivesTheSameImage)
{
  RankWindow ours(RankWindow::Metabuffer, Width, Height);
  ours.SetScene(GetScenes()[0]);
  ours.SetCamera(GetCameraPlaces()[0]);
  const Image bounds = ours.Render();
  ours.GetPass()->SetViewportMode(vtkMetabufferPass::FULL_DISPLAY);
  ExpectSame(ours.Render(), bounds, "full display");
  EXPECT_EQ(ours.GetPass()->GetDrawnPixels(), Width * Height);
}

TEST(MetabufferPass, WithoutDepthsTheColorsAreTheSame)
{
  RankWindow ours(RankWindow::Metabuffer, Width, Height);
  ours.SetScene(GetScenes()[1]);
  ours.SetCamera(GetCameraPlaces()[0]);
  const Image full = ours.Render();
  ours.GetPass()->CollectDepthsOff();
  for (const int mode : { vtkMetabufferPass::DIRECT_SEND, vtkMetabufferPass::ICET })
  {
    ours.GetPass()->SetCompositeMode(mode);
    const Image colors = ours.Render();
    EXPECT_EQ(CountDifferentColors(colors, full), 0U);
    EXPECT_TRUE(colors.Depths.empty());
  }
}

TEST(MetabufferPass, DepthsAreCollectedIfOneRankWantsThem)
{
  RankWindow ours(RankWindow::Metabuffer, Width, Height);
  ours.SetScene(GetScenes()[0]);
  ours.SetCamera(GetCameraPlaces()[0]);
  ours.GetPass()->SetCollectDepths(GetRank() == GetNumberOfRanks() - 1);
  const Image image = ours.Render();
  EXPECT_EQ(image.Depths.size(), image.Colors.size());
}

TEST(MetabufferPass, WhereViewportsCannotBeUsedTheImageIsTheStockOne)
{
  RankWindow stock(RankWindow::Stock, Width, Height);
  RankWindow ours(RankWindow::Metabuffer, Width, Height);
  stock.SetScene(GetScenes()[0]);
  ours.SetScene(GetScenes()[0]);
  stock.SetCamera(GetCameraPlaces()[0]);
  ours.SetCamera(GetCameraPlaces()[0]);
  ours.GetPass()->SetRenderEmptyImages(true);
  ExpectSame(ours.Render(), stock.Render(), "empty images");
  EXPECT_FALSE(ours.GetPass()->GetUsedViewports());
  ours.GetPass()->SetRenderEmptyImages(false);
  ExpectSame(ours.Render(), stock.Render(), "viewports again");
  EXPECT_TRUE(ours.GetPass()->GetUsedViewports());
  // Ambient occlusion draws an image of the window's size, whatever the viewport's resolution.
  for (RankWindow* window : { &stock, &ours })
  {
    window->GetRenderer()->UseSSAOOn();
    window->GetRenderer()->SetSSAORadius(0.2);
  }
  ours.GetPass()->AntiAliasingOn();
  ExpectSame(ours.Render(), stock.Render(), "ambient occlusion");
  EXPECT_FALSE(ours.GetPass()->GetUsedViewports());
}

TEST(MetabufferPass, RanksThatDifferEndTheFrameWithAnErrorAndTheNextOneWorks)
{
  if (GetNumberOfRanks() == 1)
  {
    GTEST_SKIP() << "one rank agrees with itself";
  }
  struct Listener
  {
    void Run(vtkObject*, unsigned long, void* text)
    {
      this->Messages += static_cast<const char*>(text);
    }
    std::string Messages;
  } listener;
  RankWindow ours(RankWindow::Metabuffer, Width, Height);
  ours.SetScene(GetScenes()[0]);
  ours.SetCamera(GetCameraPlaces()[0]);
  const Image expected = ours.Render();
  vtkMetabufferPass* pass = ours.GetPass();
  pass->AddObserver(vtkCommand::ErrorEvent, &listener, &Listener::Run);
  const bool isOdd = GetRank() == GetNumberOfRanks() - 1;

  pass->SetCompositeMode(isOdd ? vtkMetabufferPass::ICET : vtkMetabufferPass::DIRECT_SEND);
  ours.Render();
  EXPECT_NE(listener.Messages.find("different composite modes (rank"), std::string::npos)
    << listener.Messages;
  pass->SetCompositeMode(vtkMetabufferPass::DIRECT_SEND);
  ExpectSame(ours.Render(), expected, "the same mode on all ranks again");

  listener.Messages.clear();
  pass->SetTileDimensions(isOdd ? 2 : 1, 1);
  ours.Render();
  EXPECT_NE(listener.Messages.find("different displays (rank"), std::string::npos)
    << listener.Messages;
  pass->SetTileDimensions(1, 1);
  ExpectSame(ours.Render(), expected, "the same display on all ranks again");

  // Viewports are used by all ranks or by none.
  pass->SetRenderEmptyImages(isOdd);
  ours.Render();
  EXPECT_FALSE(pass->GetUsedViewports());
  pass->SetRenderEmptyImages(false);
  ExpectSame(ours.Render(), expected, "viewports again");
}

TEST(MetabufferPass, OrderedCompositingOfTranslucentPropsIsTheStockOne)
{
  // The log has the message once.
  int messages = 0;
  vtkLogger::AddCallback(
    "count",
    [](void* count, const vtkLogger::Message& message)
    {
      *static_cast<int*>(count) +=
        std::string(message.message).find("Viewports are not used") != std::string::npos ? 1 : 0;
    },
    &messages, vtkLogger::VERBOSITY_INFO);
  const Scene scene = GetScenes()[0];
  vtkNew<vtkOrderedCompositingHelper> order;
  std::vector<vtkBoundingBox> slabs;
  for (int rank = 0; rank < GetNumberOfRanks(); ++rank)
  {
    const double width = 1.0 / GetNumberOfRanks();
    slabs.emplace_back(rank * width, (rank + 1) * width, 0.0, 1.0, 0.0, 1.0);
  }
  order->SetBoundingBoxes(slabs);
  RankWindow stock(RankWindow::Stock, Width, Height);
  RankWindow ours(RankWindow::Metabuffer, Width, Height);
  std::vector<Image> images;
  for (RankWindow* window : { &stock, &ours })
  {
    window->SetScene({ scene.Name,
      [&scene](int rank, int ranks)
      {
        auto actors = scene.Make(rank, ranks);
        for (const auto& actor : actors)
        {
          actor->GetProperty()->SetOpacity(0.4);
        }
        return actors;
      } });
    window->SetCamera(GetCameraPlaces()[0]);
    window->GetIceTPass()->SetOrderedCompositingHelper(order);
    window->GetIceTPass()->SetUseOrderedCompositing(true);
    images.push_back(window->Render());
  }
  ExpectSame(images[1], images[0], "translucent");
  EXPECT_FALSE(ours.GetPass()->GetUsedViewports());
  ours.Render();
  vtkLogger::RemoveCallback("count");
  EXPECT_EQ(messages, GetRank() == 0 ? 1 : 0);
}

TEST(MetabufferPass, ShowsTheViewportsOnRequest)
{
  RankWindow ours(RankWindow::Metabuffer, Width, Height);
  ours.SetScene(GetScenes()[2]);
  ours.SetCamera(GetCameraPlaces()[0]);
  const Image plain = ours.Render();
  ours.GetPass()->ShowViewportsOn();
  const Image outlined = ours.Render();
  int viewport[5];
  ours.GetPass()->GetViewport(GetNumberOfRanks() - 1, viewport);
  if (GetRank() == 0)
  {
    // The last rank's outline is drawn over all others.
    const auto pixel = static_cast<std::size_t>(viewport[1] * Width + viewport[0]);
    EXPECT_NE(outlined.Colors[pixel], plain.Colors[pixel]);
    EXPECT_GE(CountDifferentColors(outlined, plain),
      static_cast<std::size_t>(2 * (viewport[2] + viewport[3] - 2)));
    EXPECT_EQ(CountDifferentDepths(outlined, plain), 0U);
  }
}

TEST(MetabufferPass, ARendererInARectangleOfItsWindow)
{
  // The oracle is not stock compositing, which rounds the projection.
  RankWindow ours(RankWindow::Metabuffer, 200, 160);
  ours.GetRenderer()->SetViewport(0.25, 0.1, 0.75, 0.85);
  const Scene scene = GetScenes()[1];
  const CameraPlace camera = GetCameraPlaces()[0];
  ours.SetScene(scene);
  ours.SetCamera(camera);
  const Image image = ours.Render();
  if (GetRank() == 0)
  {
    ExpectSame(image, RenderAllAlone(scene, camera, 100, 120), "rectangle of a window");
  }
}
