// SPDX-License-Identifier: BSD-3-Clause
#include "RankGroup.h"

#include "TestImages.h"

#include "vtkCommunicator.h"
#include "vtkMultiProcessController.h"

#include <algorithm>
#include <type_traits>

namespace isosurface
{
namespace
{

template <typename T>
std::vector<T> GatherItems(const std::vector<T>& mine)
{
  static_assert(std::is_trivially_copyable_v<T>, "items travel as bytes");
  const auto size = static_cast<vtkIdType>(mine.size() * sizeof(T));
  std::vector<vtkIdType> sizes(static_cast<std::size_t>(GetNumberOfRanks()));
  GetRanks()->AllGather(&size, sizes.data(), 1);
  std::vector<vtkIdType> offsets;
  vtkIdType total = 0;
  for (const vtkIdType one : sizes)
  {
    offsets.push_back(total);
    total += one;
  }
  std::vector<T> all(GetRank() == 0 ? static_cast<std::size_t>(total) / sizeof(T) : 0);
  GetRanks()->GatherV(reinterpret_cast<const char*>(mine.data()),
    reinterpret_cast<char*>(all.data()), size, sizes.data(), offsets.data(), 0);
  return all;
}

} // namespace

vtkMultiProcessController* GetRanks()
{
  return vtkMultiProcessController::GetGlobalController();
}

int GetRank()
{
  return GetRanks()->GetLocalProcessId();
}

int GetNumberOfRanks()
{
  return GetRanks()->GetNumberOfProcesses();
}

std::uint64_t SumOverRanks(std::uint64_t mine)
{
  const unsigned long long one = mine;
  unsigned long long sum = 0;
  GetRanks()->AllReduce(&one, &sum, 1, vtkCommunicator::SUM_OP);
  return sum;
}

EdgeSurface GatherSurfaces(const EdgeSurface& mine)
{
  EdgeSurface all;
  all.Points = GatherItems(mine.Points);
  all.Triangles = GatherItems(mine.Triangles);
  std::sort(all.Points.begin(), all.Points.end());
  std::sort(all.Triangles.begin(), all.Triangles.end());
  return all;
}

EdgeSurface GatherSurface(vtkPolyData* mine, std::int64_t firstId, std::int64_t endId)
{
  EdgeSurface all = GatherSurfaces(ToEdges(mine, firstId, endId));
  all.MergeEqualPoints();
  return all;
}

void OnFirstRank(const std::function<void()>& deed)
{
  GetRanks()->Barrier();
  if (GetRank() == 0)
  {
    deed();
  }
  GetRanks()->Barrier();
}

std::vector<std::string> GatherTexts(const std::string& mine)
{
  std::vector<std::string> texts;
  for (int rank = 0; rank < GetNumberOfRanks(); ++rank)
  {
    auto size = static_cast<vtkIdType>(mine.size());
    GetRanks()->Broadcast(&size, 1, rank);
    std::string text = rank == GetRank() ? mine : std::string(static_cast<std::size_t>(size), ' ');
    if (size > 0)
    {
      GetRanks()->Broadcast(&text[0], size, rank);
    }
    texts.push_back(text);
  }
  return texts;
}

} // namespace isosurface
