// SPDX-License-Identifier: BSD-3-Clause
#include "BallScene.h"

#include "vtkActor.h"
#include "vtkAppendPolyData.h"
#include "vtkNew.h"
#include "vtkPolyData.h"
#include "vtkPolyDataMapper.h"
#include "vtkSphereSource.h"

#include <algorithm>
#include <array>
#include <functional>
#include <numeric>
#include <random>
#include <vector>

namespace
{

using Center = std::array<double, 3>;

// The owners of the balls: dealt out one by one, or as boxes of equally many balls, which are cut in
// turn across x, y and z.
std::vector<int> AssignOwners(const std::vector<Center>& centers, int ranks, bool isCompact)
{
  std::vector<int> owners(centers.size());
  std::vector<std::size_t> order(centers.size());
  for (std::size_t ball = 0; ball < centers.size(); ++ball)
  {
    owners[ball] = static_cast<int>(ball % static_cast<std::size_t>(ranks));
    order[ball] = ball;
  }
  std::function<void(std::size_t, std::size_t, int, int, std::size_t)> cut =
    [&](std::size_t begin, std::size_t end, int first, int count, std::size_t axis)
  {
    if (count == 1)
    {
      for (std::size_t index = begin; index < end; ++index)
      {
        owners[order[index]] = first;
      }
      return;
    }
    const std::size_t middle =
      begin + (end - begin) * static_cast<std::size_t>(count / 2) / static_cast<std::size_t>(count);
    const auto at = [&order](std::size_t index)
    { return order.begin() + static_cast<std::ptrdiff_t>(index); };
    std::nth_element(at(begin), at(middle), at(end),
      [&](std::size_t a, std::size_t b) { return centers[a][axis] < centers[b][axis]; });
    cut(begin, middle, first, count / 2, (axis + 1) % 3);
    cut(middle, end, first + count / 2, count - count / 2, (axis + 1) % 3);
  };
  if (isCompact)
  {
    cut(0, centers.size(), 0, ranks, 0);
  }
  return owners;
}

// Layers of equally many balls, one behind the other as seen by the first camera.
std::vector<int> AssignLayers(const std::vector<Center>& centers, int ranks)
{
  std::vector<std::size_t> order(centers.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto depth = [&centers](std::size_t ball)
  { return 1.5 * centers[ball][0] + centers[ball][1] + 2.1 * centers[ball][2]; };
  std::sort(
    order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return depth(a) > depth(b); });
  std::vector<int> owners(centers.size());
  for (std::size_t index = 0; index < order.size(); ++index)
  {
    owners[order[index]] = static_cast<int>(index * static_cast<std::size_t>(ranks) / order.size());
  }
  return owners;
}

} // namespace

vtkSmartPointer<vtkActor> MakeBalls(const BallScene& scene, int rank, int ranks)
{
  std::mt19937 random(42);
  std::uniform_real_distribution<double> place(0, 1);
  std::vector<Center> centers(static_cast<std::size_t>(scene.Balls));
  for (Center& center : centers)
  {
    center = { place(random), place(random), place(random) };
  }
  const std::vector<int> owners = scene.Layout == "layers"
    ? AssignLayers(centers, ranks)
    : AssignOwners(centers, ranks, scene.Layout == "compact");
  vtkNew<vtkAppendPolyData> append;
  append->AddInputData(vtkNew<vtkPolyData>());
  for (std::size_t ball = 0; ball < centers.size(); ++ball)
  {
    if (owners[ball] == rank)
    {
      vtkNew<vtkSphereSource> sphere;
      sphere->SetCenter(centers[ball].data());
      sphere->SetRadius(scene.Radius);
      sphere->SetThetaResolution(24);
      sphere->SetPhiResolution(24);
      sphere->Update();
      append->AddInputData(sphere->GetOutput());
    }
  }
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(append->GetOutputPort());
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  return actor;
}
