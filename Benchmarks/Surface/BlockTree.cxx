// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/BlockTree.h"

#include "Ranks/Sharing/QueryPlan.h"
#include "Surface/Drawing/BoxProjection.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace isosurface
{
namespace
{

double FindDistance(const std::array<double, 6>& bounds, const std::array<double, 3>& from)
{
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double off =
      std::max({ bounds[2 * axis] - from[axis], 0.0, from[axis] - bounds[2 * axis + 1] });
    sum += off * off;
  }
  return std::sqrt(sum);
}

} // namespace

struct BlockTree::Search
{
  const SeenImage& Image;
  const SeenImage& Before;
  BoxProjection Now;
  BoxProjection Then;
  double Pixels;
  std::vector<LevelBlock> Chosen;
};

BlockTree::BlockTree(BlockedVolume& volume, const std::vector<double>& isovalues)
  : Volume(volume)
{
  for (const VolumePart& part : volume.GetParts())
  {
    this->Active.emplace_back(static_cast<std::size_t>(part.Grid.GetNumberOfBlocks()));
    QueryStatistics statistics;
    auto plan = PlanQuery(volume, { { 0, 0, isovalues }, 0, 1 }, part.FirstLevel, statistics);
    if (!plan.IsOk())
    {
      std::fprintf(stderr, "%s\n", plan.GetStatus().GetMessage().c_str());
      std::exit(EXIT_FAILURE);
    }
    for (const BlockReference& block : plan->Blocks)
    {
      this->Active.back()[static_cast<std::size_t>(block.Block)] = block;
    }
  }
}

std::array<double, 6> BlockTree::GetBounds() const
{
  return this->FindBounds(this->Active.size() - 1, 0);
}

std::array<double, 6> BlockTree::FindBounds(std::size_t part, std::int64_t block) const
{
  const VolumePart& here = this->Volume.GetParts()[part];
  const GridGeometry grid = this->Volume.GetHeader().Grid.Coarsen(here.FirstLevel);
  const VertexBox box = here.Grid.GetVertices(block, 0);
  std::array<double, 6> bounds{};
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const auto place = [&](std::int64_t vertex)
    {
      return grid.Origin[axis] +
        grid.Spacing[axis] * static_cast<double>(grid.Extent[2 * axis] + vertex);
    };
    bounds[2 * axis] = place(box.Low[axis]);
    bounds[2 * axis + 1] = place(box.High[axis] - 1);
  }
  return bounds;
}

std::vector<LevelBlock> BlockTree::Choose(
  const SeenImage& image, const SeenImage& before, double pixels) const
{
  Search search{ image, before, BoxProjection(image.ModelToClip, image.Width, image.Height),
    BoxProjection(before.ModelToClip, before.Width, before.Height), pixels, {} };
  const std::size_t coarsest = this->Active.size() - 1;
  for (std::size_t block = 0; block < this->Active[coarsest].size(); ++block)
  {
    this->Descend(search, coarsest, static_cast<std::int64_t>(block));
  }
  std::sort(search.Chosen.begin(), search.Chosen.end(),
    [](const LevelBlock& a, const LevelBlock& b) { return a.Distance < b.Distance; });
  return search.Chosen;
}

void BlockTree::Descend(Search& search, std::size_t part, std::int64_t block) const
{
  const auto bounds = this->FindBounds(part, block);
  std::array<float, 6> box{};
  std::transform(bounds.begin(), bounds.end(), box.begin(),
    [](double bound) { return static_cast<float>(bound); });
  const ProjectedBox then = search.Then.Project(box);
  if (search.Now.Project(box).IsOutside || (then.IsKnown && search.Before.Depths.IsBehind(then)))
  {
    return;
  }
  const VolumePart& here = this->Volume.GetParts()[part];
  const double distance = FindDistance(bounds, search.Image.Position);
  const double cell =
    search.Image.PixelsAtOne * this->Volume.GetHeader().Grid.Spacing[0] / std::max(distance, 1e-6);
  const int wanted = std::max(0, static_cast<int>(std::floor(std::log2(search.Pixels / cell))));
  if (part == 0 || wanted >= here.FirstLevel)
  {
    if (const auto& active = this->Active[part][static_cast<std::size_t>(block)])
    {
      const int last = here.FirstLevel + here.Grid.GetNumberOfLevels() - 1;
      search.Chosen.push_back({ std::clamp(wanted, here.FirstLevel, last), *active, distance });
    }
    return;
  }
  const VolumePart& finer = this->Volume.GetParts()[part - 1];
  const int shift = here.FirstLevel - finer.FirstLevel;
  const Index3 at = here.Grid.GetBlockCoordinates(block);
  const Index3& size = finer.Grid.GetNumberOfBlocksPerAxis();
  for (std::int64_t k = at[2] << shift; k < std::min((at[2] + 1) << shift, size[2]); ++k)
  {
    for (std::int64_t j = at[1] << shift; j < std::min((at[1] + 1) << shift, size[1]); ++j)
    {
      for (std::int64_t i = at[0] << shift; i < std::min((at[0] + 1) << shift, size[0]); ++i)
      {
        this->Descend(search, part - 1, finer.Grid.GetBlockIndex({ i, j, k }));
      }
    }
  }
}

bool BlockTree::FindParent(LevelBlock& block) const
{
  const StoredLevel stored = this->Volume.FindLevel(block.Level);
  if (stored.Part + 1 >= this->Active.size())
  {
    return false;
  }
  const VolumePart& next = this->Volume.GetParts()[stored.Part + 1];
  const int shift = next.FirstLevel - this->Volume.GetParts()[stored.Part].FirstLevel;
  Index3 at = stored.Grid->GetBlockCoordinates(block.Block.Block);
  for (std::int64_t& place : at)
  {
    place >>= shift;
  }
  block.Level = next.FirstLevel;
  block.Block.Block = next.Grid.GetBlockIndex(at);
  return true;
}

} // namespace isosurface
