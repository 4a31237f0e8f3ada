// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Islands/IslandChoice.h"

#include "Ground/Base/Coding.h"
#include "Ranks/Islands/IslandJoin.h"
#include "Surface/Islands/IslandKeeping.h"
#include "Surface/Islands/IslandLabels.h"
#include "Surface/Islands/SurfaceRanges.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::size_t NumberOfBins = 64;

/// The size of islands, as whole numbers that compare as the sizes do.
class SizeScale
{
public:
  SizeScale(const IslandRequest& request, const IslandUnits& units)
    : Size(request.Size)
    , Unit(request.Size == IslandSize::Area    ? units.Area
          : request.Size == IslandSize::Volume ? units.Volume
                                               : std::ldexp(1.0, 2 * request.Level))
  {
  }

  std::uint64_t Measure(const IslandMeasure& island) const
  {
    switch (this->Size)
    {
      case IslandSize::Area:
        return static_cast<std::uint64_t>(island.Area);
      case IslandSize::Volume:
        return static_cast<std::uint64_t>(std::abs(island.Volume));
      case IslandSize::Triangles:
        break;
    }
    return island.Triangles;
  }
  double ToWorld(std::uint64_t size) const { return static_cast<double>(size) * this->Unit; }

  /// Whether an island comes before another one: the larger one, then that with the lower id.
  bool IsBefore(const IslandMeasure& a, const IslandMeasure& b) const
  {
    const std::uint64_t sizeOfA = this->Measure(a);
    const std::uint64_t sizeOfB = this->Measure(b);
    return sizeOfA != sizeOfB ? sizeOfA > sizeOfB : a.FirstId < b.FirstId;
  }

  /// 0 for a size of 0; else 1 + log2 of the size, rounded down.
  static std::size_t FindBin(std::uint64_t size)
  {
    std::size_t bin = 0;
    for (; size != 0 && bin < NumberOfBins - 1; size >>= 1)
    {
      ++bin;
    }
    return bin;
  }
  double GetBinBegin(std::size_t bin) const
  {
    return bin == 0 ? 0 : std::ldexp(this->Unit, static_cast<int>(bin) - 1);
  }

private:
  IslandSize Size;
  double Unit;
};

class IslandChoice
{
public:
  IslandChoice(Communicator& ranks, const IslandRequest& request, const IslandGrids& grids,
    int threads, Surface& surface, ChosenIslands& chosen)
    : Ranks(ranks)
    , Request(request)
    , Grids(grids)
    , Threads(threads)
    , Extracted(surface)
    , Chosen(chosen)
  {
  }

  Status Run()
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Find());
    const SizeScale scale(this->Request, this->Units);
    ISOSURFACE_RETURN_IF_ERROR(this->Count(scale));
    std::vector<IslandMeasure> largest;
    ISOSURFACE_RETURN_IF_ERROR(this->FindLargest(scale, largest));
    this->ChooseBySize(scale, largest);
    if (this->Request.Place)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->ChooseByPlace());
    }
    this->CountKept();
    return this->Keep(scale, largest);
  }

private:
  /// Runs a step that needs memory on this rank. Collective.
  template <typename Step>
  Status Try(const Step& step)
  {
    return this->Ranks.Agree(Attempt(NoMemoryForIslands,
      [&]
      {
        step();
        return Status::Ok();
      }));
  }

  /// The islands of all ranks, with their measures.
  Status Find()
  {
    const std::uint64_t triangles = this->Ranks.Sum(this->Extracted.NumberOfTriangles);
    this->Chosen.Triangles = triangles;
    this->Units = IslandUnits(this->Grids.Bounds, triangles);
    std::vector<SharedPoint> shared;
    ISOSURFACE_RETURN_IF_ERROR(this->Try(
      [&]
      {
        this->Labels = IslandLabels(this->Extracted, this->Threads);
        this->Measures = MeasureIslands(this->Extracted, this->Labels, this->Units, this->Threads);
        shared = FindSharedPoints(this->Extracted, this->Labels, this->Grids.Shared, this->Threads);
        this->AreKept.resize(this->Measures.size());
        this->Counts.resize(2 * NumberOfBins);
      }));
    return JoinIslands(this->Ranks, std::move(shared), this->Measures, this->AreOwned);
  }

  /// How many there are, by their sizes.
  Status Count(const SizeScale& scale)
  {
    for (std::size_t island = 0; island < this->Measures.size(); ++island)
    {
      if (this->AreOwned[island] != 0)
      {
        const std::size_t bin = SizeScale::FindBin(scale.Measure(this->Measures[island]));
        this->Counts[2 * bin] += 1;
        this->Counts[2 * bin + 1] += this->Measures[island].Triangles;
      }
    }
    this->Ranks.ReduceSum(this->Counts);
    return this->Try(
      [&]
      {
        for (std::size_t bin = 0; bin < NumberOfBins; ++bin)
        {
          const std::uint64_t islands = this->Counts[2 * bin];
          this->Chosen.Islands += islands;
          if (islands > 0)
          {
            this->Chosen.Bins.push_back(
              { scale.GetBinBegin(bin), islands, this->Counts[2 * bin + 1] });
          }
        }
      });
  }

  std::size_t CountIsovalues() const
  {
    return this->Grids.Shared.empty()
      ? 1
      : std::max<std::size_t>(1, this->Grids.Shared.front().GetNumberOfIsovalues());
  }
  std::size_t FindIsovalue(const IslandMeasure& island) const
  {
    const std::vector<SharedPlanes>& grids = this->Grids.Shared;
    const auto behind = std::upper_bound(grids.begin(), grids.end(), island.FirstId,
      [](std::int64_t id, const SharedPlanes& grid) { return id < grid.GetFirstId(); });
    return behind == grids.begin() ? 0 : std::prev(behind)->FindIsovalue(island.FirstId);
  }

  /// As many of the largest islands of each isovalue of all ranks as are needed, in their order.
  Status FindLargest(const SizeScale& scale, std::vector<IslandMeasure>& largest)
  {
    // The place among all is known if all are.
    const std::uint64_t wanted =
      this->Request.Ids ? this->Chosen.Islands : this->Request.MaximumIslands;
    const std::size_t count = std::min(
      this->Chosen.Islands, std::max(wanted, static_cast<std::uint64_t>(MaximumListedIslands)));
    const auto isBefore = [&](const IslandMeasure& a, const IslandMeasure& b)
    { return scale.IsBefore(a, b); };
    const auto keepFirst = [&](std::vector<IslandMeasure>& islands)
    {
      std::vector<IslandMeasure> kept;
      auto begin = islands.begin();
      for (std::size_t isovalue = 0; isovalue < this->CountIsovalues(); ++isovalue)
      {
        const auto end = std::partition(begin, islands.end(),
          [&](const IslandMeasure& island) { return this->FindIsovalue(island) == isovalue; });
        const auto middle = begin + std::min(static_cast<std::ptrdiff_t>(count), end - begin);
        std::partial_sort(begin, middle, end, isBefore);
        kept.insert(kept.end(), begin, middle);
        begin = end;
      }
      std::sort(kept.begin(), kept.end(), isBefore);
      islands = std::move(kept);
    };
    Message mine;
    ISOSURFACE_RETURN_IF_ERROR(this->Try(
      [&]
      {
        std::vector<IslandMeasure> owned;
        for (std::size_t island = 0; island < this->Measures.size(); ++island)
        {
          if (this->AreOwned[island] != 0)
          {
            owned.push_back(this->Measures[island]);
          }
        }
        keepFirst(owned);
        for (const IslandMeasure& island : owned)
        {
          AppendLittleEndian(mine, island);
        }
      }));
    const std::vector<Message> all = this->Ranks.AllGather(mine);
    return this->Try(
      [&]
      {
        for (const Message& message : all)
        {
          ByteReader reader(message);
          while (reader.GetRemaining() > 0)
          {
            largest.push_back(reader.Read<IslandMeasure>());
          }
        }
        keepFirst(largest);
        this->ListLargest(largest);
      });
  }

  void ListLargest(const std::vector<IslandMeasure>& largest)
  {
    for (std::size_t n = 0; n < std::min(largest.size(), MaximumListedIslands); ++n)
    {
      this->Chosen.Largest.push_back(
        { largest[n].Triangles, static_cast<double>(largest[n].Area) * this->Units.Area,
          static_cast<double>(std::abs(largest[n].Volume)) * this->Units.Volume });
    }
  }

  void ChooseBySize(const SizeScale& scale, const std::vector<IslandMeasure>& largest)
  {
    std::vector<std::uint64_t> counts(this->CountIsovalues(), 0);
    std::vector<const IslandMeasure*> lasts(this->CountIsovalues(), nullptr);
    for (const IslandMeasure& island : largest)
    {
      const std::size_t isovalue = this->FindIsovalue(island);
      if (++counts[isovalue] == this->Request.MaximumIslands)
      {
        lasts[isovalue] = &island;
      }
    }
    for (std::size_t island = 0; island < this->Measures.size(); ++island)
    {
      const IslandMeasure& measure = this->Measures[island];
      const bool isLarge = scale.ToWorld(scale.Measure(measure)) >= this->Request.MinimumSize;
      const IslandMeasure* last = lasts[this->FindIsovalue(measure)];
      this->AreKept[island] = isLarge && !(last && scale.IsBefore(*last, measure)) ? 1 : 0;
    }
  }

  Status ChooseByPlace()
  {
    NearestIsland nearest;
    Message mine;
    ISOSURFACE_RETURN_IF_ERROR(this->Try(
      [&]
      {
        nearest = FindNearestIsland(this->Extracted, this->Labels, this->Measures, this->AreKept,
          *this->Request.Place, this->Threads);
        AppendLittleEndian(mine, nearest);
      }));
    for (const Message& message : this->Ranks.AllGather(mine))
    {
      const auto other = LoadLittleEndian<NearestIsland>(message.data());
      nearest = other.IsNearerThan(nearest) ? other : nearest;
    }
    for (std::size_t island = 0; island < this->Measures.size(); ++island)
    {
      this->AreKept[island] = this->Measures[island].FirstId == nearest.FirstId ? 1 : 0;
    }
    return Status::Ok();
  }

  void CountKept()
  {
    // Of each isovalue the numbers of IsovalueIslands, in their order.
    std::vector<std::uint64_t> sums(4 * this->CountIsovalues(), 0);
    for (std::size_t island = 0; island < this->Measures.size(); ++island)
    {
      const IslandMeasure& measure = this->Measures[island];
      const std::uint64_t owned = this->AreOwned[island] != 0 ? 1 : 0;
      const std::uint64_t kept = this->AreKept[island] != 0 ? owned : 0;
      std::uint64_t* sum = &sums[4 * this->FindIsovalue(measure)];
      sum[0] += owned;
      sum[1] += owned * measure.Triangles;
      sum[2] += kept;
      sum[3] += kept * measure.Triangles;
    }
    this->Ranks.ReduceSum(sums);
    for (std::size_t first = 0; first < sums.size(); first += 4)
    {
      const IsovalueIslands one = { sums[first], sums[first + 1], sums[first + 2],
        sums[first + 3] };
      this->Chosen.OfIsovalues.push_back(one);
      this->Chosen.KeptIslands += one.KeptIslands;
      this->Chosen.KeptTriangles += one.KeptTriangles;
    }
  }

  Status Keep(const SizeScale& scale, const std::vector<IslandMeasure>& largest)
  {
    return this->Try(
      [&]
      {
        if (this->Request.Ids)
        {
          this->FillIds(scale, largest);
        }
        if (this->Chosen.KeptIslands < this->Chosen.Islands)
        {
          KeepIslands(this->Labels, this->AreKept, this->Threads, this->Extracted);
        }
      });
  }

  /// Before islands are dropped.
  void FillIds(const SizeScale& scale, const std::vector<IslandMeasure>& largest)
  {
    std::vector<std::int64_t> ids(this->Measures.size(), 0);
    for (std::size_t island = 0; island < this->Measures.size(); ++island)
    {
      if (this->AreKept[island] != 0)
      {
        ids[island] =
          std::lower_bound(largest.begin(), largest.end(), this->Measures[island],
            [&](const IslandMeasure& a, const IslandMeasure& b) { return scale.IsBefore(a, b); }) -
          largest.begin();
      }
    }
    const Surface& surface = this->Extracted;
    WithCells(surface,
      [&](const auto& cells)
      {
        const auto isKept = [&](std::size_t cell)
        { return this->AreKept[this->Labels[cells.GetFirstPoint(cell)]] != 0; };
        std::vector<std::size_t> firsts(CountRanges(surface.NumberOfCells) + 1, 0);
        ForRanges(surface.NumberOfCells, this->Threads,
          [&](std::size_t begin, std::size_t end, std::size_t range)
          {
            for (std::size_t cell = begin; cell < end; ++cell)
            {
              firsts[range] += isKept(cell) ? 1 : 0;
            }
          });
        SumRanges(firsts);
        this->Chosen.Ids = Buffer<std::int64_t>(firsts.back());
        ForRanges(surface.NumberOfCells, this->Threads,
          [&](std::size_t begin, std::size_t end, std::size_t range)
          {
            std::size_t kept = firsts[range];
            for (std::size_t cell = begin; cell < end; ++cell)
            {
              if (isKept(cell))
              {
                this->Chosen.Ids[kept++] = ids[this->Labels[cells.GetFirstPoint(cell)]];
              }
            }
          });
      });
  }

  Communicator& Ranks;
  const IslandRequest& Request;
  const IslandGrids& Grids;
  const int Threads;
  Surface& Extracted;
  ChosenIslands& Chosen;

  IslandUnits Units;
  IslandLabels Labels;
  std::vector<IslandMeasure> Measures; ///< of this rank's islands, wherever their triangles are
  std::vector<std::uint8_t> AreOwned;  ///< counted by this rank
  std::vector<std::uint8_t> AreKept;
  std::vector<std::uint64_t> Counts; ///< islands and triangles of each bin
};

std::string GroupDigits(std::uint64_t number)
{
  std::string digits = std::to_string(number);
  for (std::size_t end = digits.size(); end > 3; end -= 3)
  {
    digits.insert(end - 3, ",");
  }
  return digits;
}

} // namespace

Status ChooseIslands(Communicator& ranks, const IslandRequest& request, const IslandGrids& grids,
  int threads, Surface& surface, ChosenIslands& chosen)
{
  return IslandChoice(ranks, request, grids, threads, surface, chosen).Run();
}

Status ChooseIslands(Communicator& ranks, const Status& extracted, const IslandRequest& request,
  const std::function<IslandGrids()>& makeGrids, int threads, Surface& surface,
  ChosenIslands& chosen)
{
  IslandGrids grids;
  const auto make = [&]() -> Status
  {
    ISOSURFACE_RETURN_IF_ERROR(extracted);
    grids = makeGrids();
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, NoMemoryForIslands, make));
  return ChooseIslands(ranks, request, grids, threads, surface, chosen);
}

std::string SummariseIslands(const ChosenIslands& islands, const std::vector<double>& isovalues)
{
  std::string summary;
  const std::vector<IsovalueIslands>& all = islands.OfIsovalues;
  for (std::size_t n = 0; n < all.size(); ++n)
  {
    std::array<char, 64> text{};
    if (all.size() > 1 && n < isovalues.size())
    {
      std::snprintf(text.data(), text.size(), "%s%g: ", n > 0 ? "; " : "", isovalues[n]);
      summary += text.data();
    }
    const auto triangles = static_cast<double>(all[n].Triangles);
    std::snprintf(text.data(), text.size(), "%.1f",
      triangles > 0 ? 100 * static_cast<double>(all[n].KeptTriangles) / triangles : 100.0);
    summary += GroupDigits(all[n].KeptIslands) + " of " + GroupDigits(all[n].Islands) +
      " islands, " + text.data() + " % of the triangles";
  }
  return summary;
}

} // namespace isosurface
