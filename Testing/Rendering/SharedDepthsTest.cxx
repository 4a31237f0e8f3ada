// SPDX-License-Identifier: BSD-3-Clause
// Large surfaces of several ranks, some behind others, beside the images of all their triangles.
#include "RankScene.h"

#include "vtkActor.h"
#include "vtkActorCollection.h"
#include "vtkCamera.h"
#include "vtkCellArray.h"
#include "vtkIsosurfaceMapper.h"
#include "vtkMath.h"
#include "vtkMetabufferPass.h"
#include "vtkNew.h"
#include "vtkPVLODActor.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkProperty.h"
#include "vtkRenderer.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

constexpr int DisplayWidth = 331;
constexpr int DisplayHeight = 263;

/// A sphere of 519,168 triangles, enough to leave some out, or of fewer. As an isosurface it comes in
/// blocks: patches of 512 triangles.
vtkSmartPointer<vtkPolyData> MakeSphere(double radius, int patchesOfSide = 13)
{
  constexpr int side = 16;
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> triangles;
  for (int patch = 0; patch < 6 * patchesOfSide * patchesOfSide; ++patch)
  {
    const std::size_t face = static_cast<std::size_t>(patch % 6);
    const int column = patch / 6 % patchesOfSide;
    const int row = patch / 6 / patchesOfSide;
    const vtkIdType first = points->GetNumberOfPoints();
    for (int point = 0; point < (side + 1) * (side + 1); ++point)
    {
      std::array<double, 3> place{};
      const double step = 2.0 / (side * patchesOfSide);
      place[face / 2] = face % 2 == 0 ? 1 : -1;
      place[(face / 2 + 1) % 3] = -1 + step * (column * side + point % (side + 1));
      place[(face / 2 + 2) % 3] = -1 + step * (row * side + point / (side + 1));
      const double scale = radius / vtkMath::Norm(place.data());
      points->InsertNextPoint(
        0.5 + scale * place[0], 0.5 + scale * place[1], 0.5 + scale * place[2]);
    }
    for (int cell = 0; cell < side * side; ++cell)
    {
      const vtkIdType corner = first + cell / side * (side + 1) + cell % side;
      triangles->InsertNextCell({ corner, corner + 1, corner + side + 1 });
      triangles->InsertNextCell({ corner + 1, corner + side + 2, corner + side + 1 });
    }
  }
  auto sphere = vtkSmartPointer<vtkPolyData>::New();
  sphere->SetPoints(points);
  sphere->SetPolys(triangles);
  return sphere;
}

vtkSmartPointer<vtkActor> MakeActor(vtkPolyData* surface, int color)
{
  vtkNew<vtkIsosurfaceMapper> mapper;
  mapper->SetOcclusionCulling(vtkIsosurfaceMapper::ALWAYS);
  mapper->SetInputDataObject(surface);
  mapper->ScalarVisibilityOff();
  auto actor = vtkSmartPointer<vtkPVLODActor>::New();
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(0.4 + 0.2 * (color % 4), 0.9 - 0.2 * (color % 3), 0.6);
  return actor;
}

/// Rank 0 has the outermost one. As in ParaView, an actor of nothing is drawn after it.
const Scene NestedSpheres = { "nested spheres",
  [](int rank, int)
  {
    return std::vector<vtkSmartPointer<vtkActor>>{
      MakeActor(MakeSphere(rank == 0 ? 0.45 : 0.35 - 0.03 * rank), rank),
      MakeActor(vtkNew<vtkPolyData>(), 0),
    };
  } };

/// Pairs of images, of all triangles and without those that are hidden.
class SharedDepthsOnRanks : public testing::Test
{
protected:
  SharedDepthsOnRanks()
    : All(RankWindow::Metabuffer, DisplayWidth, DisplayHeight)
    , Some(RankWindow::Metabuffer, DisplayWidth, DisplayHeight)
  {
  }

  void SetScene(const Scene& scene)
  {
    this->ForBoth(
      [&scene](RankWindow& window)
      {
        window.SetScene(scene);
        window.SetCamera(GetCameraPlaces()[0]);
      });
    this->SetCulling();
  }
  /// Has one of the windows draw all triangles.
  void SetCulling()
  {
    for (vtkIsosurfaceMapper* mapper : this->GetMappers(this->All))
    {
      mapper->SetOcclusionCulling(vtkIsosurfaceMapper::NEVER);
    }
  }

  std::vector<vtkIsosurfaceMapper*> GetMappers(RankWindow& window)
  {
    std::vector<vtkIsosurfaceMapper*> mappers;
    vtkActorCollection* actors = window.GetRenderer()->GetActors();
    vtkCollectionSimpleIterator place;
    actors->InitTraversal(place);
    while (vtkActor* actor = actors->GetNextActor(place))
    {
      if (auto* mapper = vtkIsosurfaceMapper::SafeDownCast(actor->GetMapper()))
      {
        mappers.push_back(mapper);
      }
    }
    return mappers;
  }

  double CountDrawn(RankWindow& window)
  {
    double count = 0;
    for (vtkIsosurfaceMapper* mapper : this->GetMappers(window))
    {
      count += static_cast<double>(mapper->GetNumberOfDrawnTriangles());
    }
    return count;
  }

  /// The share of this rank's triangles that was drawn.
  double Draw(const std::string& what)
  {
    const Image expected = this->All.Render();
    const Image drawn = this->Some.Render();
    EXPECT_EQ(CountDifferentColors(drawn, expected), 0U) << what;
    EXPECT_EQ(CountDifferentDepths(drawn, expected), 0U) << what;
    EXPECT_TRUE(expected.IsEmpty() || expected.CountActive() > 1000U) << what;
    const double all = this->CountDrawn(this->All);
    return all > 0 ? this->CountDrawn(this->Some) / all : 0;
  }

  void ForBoth(const std::function<void(RankWindow&)>& change)
  {
    change(this->All);
    change(this->Some);
  }

  RankWindow All;
  RankWindow Some;
};

} // namespace

TEST_F(SharedDepthsOnRanks, WhatIsBehindAnotherRanksTrianglesIsNotDrawn)
{
  this->SetScene(NestedSpheres);
  this->Draw("first image: nothing is known");
  this->Draw("second image: the ranks know of each other");
  for (int turn = 0; turn < 4; ++turn)
  {
    const double share = this->Draw("turned " + std::to_string(turn));
    EXPECT_LE(share, GetRank() == 0 ? 0.8 : 0) << turn;
    this->ForBoth(
      [](RankWindow& window)
      {
        window.GetRenderer()->GetActiveCamera()->Azimuth(7);
        window.GetRenderer()->GetActiveCamera()->Elevation(2);
        window.GetRenderer()->GetActiveCamera()->SetClippingRange(1, 8);
      });
  }

  this->ForBoth([](RankWindow& window) { window.GetPass()->ShareDepthsOff(); });
  this->Draw("not shared");
  EXPECT_GT(this->Draw("not shared"), 0.4);
}

TEST_F(SharedDepthsOnRanks, SharingGoesOnAfterTheCoarserImagesOfAMovingCamera)
{
  this->SetScene(NestedSpheres);
  this->Draw("first image");
  this->Draw("second image");
  const auto setDivisor = [](int divisor)
  {
    return [divisor](RankWindow& window)
    {
      window.GetPass()->SetNumberOfDivisors(1);
      window.GetPass()->SetDivisor(0, divisor);
    };
  };
  for (int turn = 0; turn < 2; ++turn)
  {
    this->ForBoth(setDivisor(2));
    this->Draw("coarser");
    this->Draw("coarser, second image");
    this->ForBoth(setDivisor(1));
    this->Draw("at rest: begins with what the coarser image needed of this rank");
    EXPECT_LE(this->Draw("at rest"), GetRank() == 0 ? 0.8 : 0) << turn;
  }
}

TEST_F(SharedDepthsOnRanks, SharingGoesOnAfterTheThinnedSurfacesOfAMovingCamera)
{
  const Scene thinned = { "nested spheres, also thinned",
    [](int rank, int ranks)
    {
      auto actors = NestedSpheres.Make(rank, ranks);
      vtkNew<vtkIsosurfaceMapper> mapper;
      mapper->SetInputDataObject(MakeSphere(rank == 0 ? 0.45 : 0.35 - 0.03 * rank, 4));
      mapper->ScalarVisibilityOff();
      vtkPVLODActor::SafeDownCast(actors.front())->SetLODMapper(mapper);
      return actors;
    } };
  this->SetScene(thinned);
  const auto thin = [this](bool isThinned)
  {
    this->ForBoth(
      [isThinned](RankWindow& window)
      {
        vtkActorCollection* actors = window.GetRenderer()->GetActors();
        vtkPVLODActor::SafeDownCast(actors->GetItemAsObject(0))->SetEnableLOD(isThinned);
      });
  };
  this->Draw("first image");
  this->Draw("second image");
  for (int turn = 0; turn < 2; ++turn)
  {
    thin(true);
    this->Draw("thinned");
    this->Draw("thinned, second image");
    thin(false);
    EXPECT_LE(this->Draw("at rest"), GetRank() == 0 ? 0.8 : 0) << turn;
  }
}

TEST_F(SharedDepthsOnRanks, WhatAppearsIsDrawnAtOnce)
{
  if (GetNumberOfRanks() == 1)
  {
    GTEST_SKIP() << "nothing is behind the outermost sphere";
  }
  this->SetScene(NestedSpheres);
  this->Draw("first image");
  this->Draw("second image");
  const auto hide = [this](bool isHidden)
  {
    this->ForBoth(
      [isHidden](RankWindow& window)
      {
        if (GetRank() == 0)
        {
          vtkActorCollection* actors = window.GetRenderer()->GetActors();
          vtkActor::SafeDownCast(actors->GetItemAsObject(0))->SetVisibility(!isHidden);
        }
      });
  };
  hide(true);
  const double share = this->Draw("without the outermost");
  EXPECT_TRUE(GetRank() != 1 || share > 0.4);
  hide(false);
  this->Draw("with it again");
  const double hidden = this->Draw("with it again, second image");
  EXPECT_TRUE(GetRank() != 1 || hidden == 0);

  this->ForBoth(
    [](RankWindow& window)
    {
      vtkCamera* camera = window.GetRenderer()->GetActiveCamera();
      camera->SetPosition(0.5, 0.5, 0.92); // between the spheres
      camera->SetFocalPoint(0.5, 0.5, 0.5);
      camera->SetClippingRange(0.001, 2);
    });
  const double inside = this->Draw("from between the spheres");
  EXPECT_TRUE(GetRank() != 1 || inside > 0);
}

TEST_F(SharedDepthsOnRanks, ImagesAreTheSameWithOtherThingsBesideTheSurfaces)
{
  // A small surface on one rank, none on another, resolutions, antialiasing, both ways to merge, and
  // props that may draw last.
  const Scene mixed = { "mixed",
    [](int rank, int ranks)
    {
      std::vector<vtkSmartPointer<vtkActor>> actors;
      if (rank != ranks - 1 || ranks == 1)
      {
        actors.push_back(MakeActor(MakeSphere(0.45 - 0.1 * rank, rank == 1 ? 4 : 13), rank));
      }
      return actors;
    } };
  this->SetScene(mixed);
  for (int image = 0; image < 3; ++image)
  {
    this->Draw("mixed");
  }
  this->ForBoth([](RankWindow& window) { window.GetPass()->SetCompositeMode(0); });
  this->Draw("IceT");
  this->ForBoth(
    [](RankWindow& window)
    {
      window.GetPass()->SetCompositeMode(1);
      window.GetPass()->AntiAliasingOn();
    });
  this->Draw("antialiased");
  this->Draw("antialiased, second image");
  this->ForBoth(
    [](RankWindow& window)
    {
      window.GetPass()->AntiAliasingOff();
      window.GetPass()->SetNumberOfDivisors(2);
      window.GetPass()->SetDivisor(1, 2);
    });
  this->Draw("coarser on some ranks");
  this->ForBoth(
    [](RankWindow& window)
    {
      window.GetPass()->SetNumberOfDivisors(0);
      window.GetRenderer()->AddActor(MakeActor(MakeSphere(0.2), 3));
    });
  this->SetCulling();
  this->Draw("another large surface");
  this->Draw("another large surface, second image");
  this->ForBoth([](RankWindow& window)
    { window.GetRenderer()->GetActors()->GetLastActor()->GetProperty()->SetOpacity(0.5); });
  this->Draw("a translucent one");
  this->Draw("a translucent one, second image");
}
