// SPDX-License-Identifier: BSD-3-Clause
// What windows show, frames with a time budget, and frames that fail.
#include "RankScene.h"

#include "vtkMetabufferPass.h"

#include "vtkActor.h"
#include "vtkCallbackCommand.h"
#include "vtkCommand.h"
#include "vtkCommunicator.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkPVDefaultPass.h"
#include "vtkProperty.h"
#include "vtkRenderPass.h"
#include "vtkRenderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

constexpr int FrameWidth = 211;
constexpr int FrameHeight = 163;

/// Draws, or throws on request.
class FaultyPass : public vtkRenderPass
{
public:
  static FaultyPass* New();
  vtkTypeMacro(FaultyPass, vtkRenderPass);
  void Render(const vtkRenderState* state) override
  {
    if (this->IsFaulty)
    {
      throw std::runtime_error("ink has run out");
    }
    this->Inner->Render(state);
  }
  bool IsFaulty = false;

private:
  vtkNew<vtkPVDefaultPass> Inner;
};
vtkStandardNewMacro(FaultyPass);

int SumOverRanks(int mine)
{
  int all = 0;
  vtkMultiProcessController::GetGlobalController()->AllReduce(
    &mine, &all, 1, vtkCommunicator::SUM_OP);
  return all;
}

std::vector<int> GetAllDivisors(RankWindow& window)
{
  std::vector<int> divisors;
  for (int rank = 0; rank < GetNumberOfRanks(); ++rank)
  {
    int viewport[5];
    window.GetPass()->GetViewport(rank, viewport);
    divisors.push_back(viewport[4]);
  }
  return divisors;
}

/// Peak signal to noise ratio of red, green, blue.
double GetDecibels(const Image& image, const Image& expected)
{
  double sum = 0;
  for (std::size_t pixel = 0; pixel < expected.Colors.size(); ++pixel)
  {
    for (int byte = 0; byte < 3; ++byte)
    {
      const auto get = [byte](std::uint32_t color)
      { return static_cast<double>(color >> (8 * byte) & 0xffU); };
      sum += std::pow(get(image.Colors[pixel]) - get(expected.Colors[pixel]), 2);
    }
  }
  return 10 * std::log10(255.0 * 255.0 * 3.0 * static_cast<double>(expected.Colors.size()) / sum);
}

} // namespace

TEST(MetabufferFrame, WindowsShowWhatTheyShowWithStockCompositing)
{
  RankWindow stock(RankWindow::Stock, FrameWidth, FrameHeight);
  RankWindow ours(RankWindow::Metabuffer, FrameWidth, FrameHeight);
  std::vector<std::vector<std::uint32_t>> images;
  for (const bool hasGradient : { false, true })
  {
    for (const bool hasFXAA : { false, true })
    {
      for (const std::size_t scene : { 0U, 2U, 4U })
      {
        for (RankWindow* window : { &stock, &ours })
        {
          window->SetScene(GetScenes()[scene]);
          window->SetCamera(GetCameraPlaces()[0]);
          window->GetRenderer()->SetGradientBackground(hasGradient);
          window->GetRenderer()->SetBackground2(0.9, 0.8, 0.3);
          window->GetRenderer()->SetUseFXAA(hasFXAA);
          window->Render();
        }
        if (GetRank() == 0)
        {
          images.push_back(ours.GetShownColors());
          EXPECT_TRUE(images.back() == stock.GetShownColors())
            << hasGradient << ", " << hasFXAA << ", " << scene;
        }
      }
    }
  }
  for (std::size_t image = 1; image < images.size(); ++image)
  {
    // Each setting changes the image.
    EXPECT_EQ(images[image] == images[image - 1], false);
  }
}

TEST(MetabufferFrame, WhatIsNotOpaqueIsBlendedOverTheBackground)
{
  RankWindow stock(RankWindow::Stock, FrameWidth, FrameHeight);
  RankWindow ours(RankWindow::Metabuffer, FrameWidth, FrameHeight);
  for (RankWindow* window : { &stock, &ours })
  {
    window->SetScene({ "translucent",
      [](int rank, int ranks)
      {
        auto actors = GetScenes()[0].Make(rank, ranks);
        for (const auto& actor : actors)
        {
          actor->GetProperty()->SetOpacity(0.5);
        }
        return actors;
      } });
    window->SetCamera(GetCameraPlaces()[0]);
    window->Render();
  }
  if (GetRank() == 0 && GetNumberOfRanks() == 1)
  {
    // On several ranks the order is undefined without a vtkOrderedCompositingHelper.
    EXPECT_EQ(ours.GetShownColors(), stock.GetShownColors());
  }
}

TEST(MetabufferFrame, ARankThatFailsInDrawingEndsTheFrameOnAllWithOneError)
{
  RankWindow ours(RankWindow::Metabuffer, FrameWidth, FrameHeight);
  ours.SetScene(GetScenes()[1]);
  ours.SetCamera(GetCameraPlaces()[0]);
  const Image before = ours.Render();
  vtkNew<FaultyPass> pass;
  ours.SetRenderPass(pass);
  int errors = 0;
  vtkNew<vtkCallbackCommand> count;
  count->SetClientData(&errors);
  count->SetCallback(
    [](vtkObject*, unsigned long, void* sum, void* text)
    {
      ++*static_cast<int*>(sum);
      EXPECT_NE(std::string(static_cast<char*>(text)).find("ink has run out"), std::string::npos);
    });
  ours.GetPass()->AddObserver(vtkCommand::ErrorEvent, count);
  for (const int divisor : { 1, 2 })
  {
    ours.GetPass()->SetDivisor(0, divisor);
    // In the window's framebuffer, and in one that the pass makes.
    ours.GetPass()->SetAntiAliasing(divisor == 2);
    pass->IsFaulty = GetRank() == GetNumberOfRanks() - 1;
    EXPECT_TRUE(ours.Render().IsEmpty());
    EXPECT_EQ(SumOverRanks(errors), 1);
    errors = 0;
  }
  pass->IsFaulty = false;
  ours.GetPass()->SetDivisor(0, 1);
  ours.GetPass()->AntiAliasingOff();
  const Image after = ours.Render();
  EXPECT_EQ(SumOverRanks(errors), 0);
  EXPECT_EQ(CountDifferentColors(after, before), 0U);
  EXPECT_EQ(CountDifferentDepths(after, before), 0U);
}

TEST(MetabufferFrame, ABudgetChoosesTheSameResolutionsOnAllRanks)
{
  RankWindow ours(RankWindow::Metabuffer, FrameWidth, FrameHeight);
  ours.SetScene(GetScenes()[0]);
  ours.SetCamera(GetCameraPlaces()[0]);
  const Image full = ours.Render();
  const auto renderWith = [&ours](double budget, int frames)
  {
    ours.GetPass()->SetFrameTimeBudget(budget);
    for (int frame = 1; frame < frames; ++frame)
    {
      ours.Render();
    }
    return ours.Render();
  };
  const Image coarse = renderWith(1e-6, 2);
  for (const int divisor : GetAllDivisors(ours))
  {
    EXPECT_TRUE(divisor == 16 || divisor == 0) << divisor; // 0: a rank without balls
  }
  renderWith(0.02, 5);
  const std::vector<int> mine = GetAllDivisors(ours);
  std::vector<int> all(mine.size() * mine.size());
  vtkMultiProcessController::GetGlobalController()->AllGather(
    mine.data(), all.data(), static_cast<vtkIdType>(mine.size()));
  for (std::size_t index = 0; index < all.size(); ++index)
  {
    EXPECT_EQ(all[index], mine[index % mine.size()]);
  }
  const Image plenty = renderWith(1000, 6);
  const Image still = renderWith(0, 1);
  if (GetRank() == 0)
  {
    EXPECT_GT(CountDifferentColors(coarse, full), 1000U);
    EXPECT_EQ(CountDifferentColors(plenty, full), 0U);
    EXPECT_EQ(CountDifferentColors(still, full), 0U);
    EXPECT_EQ(CountDifferentDepths(still, full), 0U);
  }
}

TEST(MetabufferFrame, ABackgroundAtAQuarterOfTheResolutionIsCloseToTheFullImage)
{
  RankWindow ours(RankWindow::Metabuffer, 800, 640);
  ours.SetCamera(GetCameraPlaces()[0]);
  ours.SetScene({ "row", MakeRowOfBalls });
  const Image full = ours.Render();
  ours.GetPass()->SetDivisor(0, 1);
  if (GetNumberOfRanks() > 1)
  {
    ours.GetPass()->SetDivisor(1, 4);
  }
  const Image coarse = ours.Render();
  if (GetRank() == 0 && GetNumberOfRanks() > 1)
  {
    EXPECT_GT(CountDifferentColors(coarse, full), 100U);
    EXPECT_GE(GetDecibels(coarse, full), 35.0);
  }
}
