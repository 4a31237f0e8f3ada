// SPDX-License-Identifier: BSD-3-Clause
// A surface that goes from ranks to ranks stays the surface that it was.
#include "Fixtures/CodedVolumes.h"
#include "Fixtures/LongTests.h"
#include "Fixtures/PlainContour.h"
#include "Fixtures/ThreadCommunicator.h"
#include "Fixtures/TriangleSet.h"

#include "Ranks/Redistribution/SurfaceExchange.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

using namespace isosurface;

namespace
{

constexpr int BlockSize = 16;
const std::vector<int> NumbersOfRanks =
  LongTests ? std::vector<int>{ 1, 2, 3, 4, 5, 6, 7 } : std::vector<int>{ 1, 2, 7 };
const std::vector<double> Isovalues = { 120.5, 90 };

const SampleVolume<std::uint8_t>& GetVolume()
{
  static const SampleVolume<std::uint8_t> volume = []
  {
    auto waves = MakeWaves<std::uint8_t>({ 60, 45, 52 }, 0.1);
    Displace(waves);
    waves.Geometry.Spacing = { 1, 1, 1 }; // the normals of PlainContour are those of cubes
    return waves;
  }();
  return volume;
}

EdgeIndexHeader MakeVolumeHeader(EdgeIndexMode mode, bool normals = false)
{
  EdgeIndexHeader header = MakeHeader(GetVolume(), Isovalues, mode, EdgeIndexProfile::Working);
  header.Settings.MaximumError = 0.05;
  if (normals)
  {
    EdgeIndexAttribute& attribute = header.Attributes.emplace_back();
    attribute.Name = "Normals";
    attribute.NumberOfComponents = 3;
    attribute.IsNormals = true;
  }
  return header;
}

// Which rank has a block.
using Deal = std::function<int(std::int64_t block, int ranks)>;
int DealInTurn(std::int64_t block, int ranks)
{
  return static_cast<int>(block % ranks);
}
int DealToLast(std::int64_t, int ranks)
{
  return ranks - 1;
}

void KeepOwnBlocks(
  TestBlockSource<std::uint8_t>& source, const Communicator& ranks, const Deal& deal)
{
  auto& blocks = source.Blocks;
  blocks.erase(
    std::remove_if(blocks.begin(), blocks.end(),
      [&](std::int64_t block) { return deal(block, ranks.GetSize()) != ranks.GetRank(); }),
    blocks.end());
}

// What all ranks have in the end.
struct Outcome
{
  explicit Outcome(int ranks)
    : Surfaces(static_cast<std::size_t>(ranks))
    , Costs(static_cast<std::size_t>(ranks))
  {
  }
  std::vector<Surface> Surfaces;
  std::vector<SurfaceExchange::Cost> Costs;
};

// The outcome of one rank that has the blocks dealt to it; `failing` of them cannot be read.
Status Exchange(Communicator& ranks, const Deal& deal, std::optional<std::size_t> failing = {},
  const Progress& progress = {})
{
  TestBlockSource<std::uint8_t> source(GetVolume(), BlockSize);
  KeepOwnBlocks(source, ranks, deal);
  source.Failing = failing;
  const EdgeIndexHeader header = MakeVolumeHeader(EdgeIndexMode::Lossless);
  const ContourRequest request = MakeRequest(Isovalues);
  SurfaceExchange exchange(ranks, header, request, {});
  return exchange.Run(source, progress).GetStatus();
}

Outcome Redistribute(int size, EdgeIndexMode mode, const SurfaceExchange::Settings& settings,
  const Deal& deal, bool normals = false)
{
  Outcome outcome(size);
  const EdgeIndexHeader header = MakeVolumeHeader(mode, normals);
  ThreadCommunicator::Run(size,
    [&](Communicator& ranks)
    {
      const auto rank = static_cast<std::size_t>(ranks.GetRank());
      TestBlockSource<std::uint8_t> source(GetVolume(), BlockSize);
      KeepOwnBlocks(source, ranks, deal);
      ContourRequest request = MakeRequest(Isovalues);
      request.Normals = normals;
      SurfaceExchange exchange(ranks, header, request, settings);
      Result<Surface> surface = exchange.Run(source);
      outcome.Costs[rank] = exchange.GetCost();
      ASSERT_TRUE(surface.IsOk()) << surface.GetStatus().GetMessage();
      outcome.Surfaces[rank] = std::move(*surface);
    });
  return outcome;
}

PlainSurface Unite(const Outcome& outcome)
{
  std::vector<PlainSurface> plain;
  for (const Surface& surface : outcome.Surfaces)
  {
    plain.push_back(MakePlain(surface));
  }
  return UniteRanks(plain);
}

SurfaceExchange::Settings MakeSettings(int drawingRanks, std::uint64_t roundBytes)
{
  SurfaceExchange::Settings settings;
  settings.DrawingRanks = drawingRanks;
  settings.RoundBytes = roundBytes;
  return settings;
}

// The GlobalIds around each polygon, from the lowest on; sorted.
std::vector<std::vector<std::int64_t>> ListPolygons(const Surface& surface)
{
  std::vector<std::vector<std::int64_t>> polygons;
  for (std::size_t cell = 0; cell < surface.NumberOfCells; ++cell)
  {
    std::vector<std::int64_t>& ids = polygons.emplace_back();
    for (std::int64_t corner = surface.Offsets[cell]; corner < surface.Offsets[cell + 1]; ++corner)
    {
      const std::int64_t point = surface.Connectivity[static_cast<std::size_t>(corner)];
      ids.push_back(surface.GlobalIds[static_cast<std::size_t>(point)]);
    }
    std::rotate(ids.begin(), std::min_element(ids.begin(), ids.end()), ids.end());
  }
  std::sort(polygons.begin(), polygons.end());
  return polygons;
}

// Alters what one rank gets.
class DamagingCommunicator : public Communicator
{
public:
  DamagingCommunicator(Communicator& inner, std::function<void(Message&)> damage)
    : Inner(inner)
    , Damage(std::move(damage))
  {
  }
  int GetRank() const override { return this->Inner.GetRank(); }
  int GetSize() const override { return this->Inner.GetSize(); }
  int GetRanksOnNode() override { return this->Inner.GetRanksOnNode(); }
  void ReduceMinimum(std::vector<std::uint64_t>& values) override
  {
    this->Inner.ReduceMinimum(values);
  }
  void ReduceMaximum(std::vector<std::uint64_t>& values) override
  {
    this->Inner.ReduceMaximum(values);
  }
  void ReduceSum(std::vector<std::uint64_t>& values) override { this->Inner.ReduceSum(values); }
  std::vector<Message> AllGather(const Message& mine) override
  {
    std::vector<Message> gathered = this->Inner.AllGather(mine);
    if (this->DamageDescriptions)
    {
      std::exchange(this->DamageDescriptions, nullptr)(gathered.front());
    }
    return gathered;
  }
  std::vector<Message> Exchange(std::vector<Message> outgoing) override
  {
    std::vector<Message> incoming = this->Inner.Exchange(std::move(outgoing));
    this->Damage(incoming.front());
    return incoming;
  }

  std::function<void(Message&)> DamageDescriptions; ///< of blocks, which are gathered first

private:
  Communicator& Inner;
  std::function<void(Message&)> Damage;
};

} // namespace

TEST(SurfaceExchange, OneDrawingRankHasTheExtractedSurfaceBitByBit)
{
  TestBlockSource<std::uint8_t> all(GetVolume(), BlockSize);
  const auto expected =
    Require(ExtractSurface(GetVolume().Geometry, all, MakeRequest(Isovalues), 1));
  for (const int size : NumbersOfRanks)
  {
    const Outcome outcome =
      Redistribute(size, EdgeIndexMode::Lossless, MakeSettings(1, 20000), DealInTurn);
    ExpectSamePoints(expected, outcome.Surfaces[0]);
    for (std::size_t rank = 1; rank < outcome.Surfaces.size(); ++rank)
    {
      EXPECT_EQ(outcome.Surfaces[rank].NumberOfPoints, 0U);
    }
  }
}

TEST(SurfaceExchange, PiecesOfAllRanksAreTheWholeSurfaceWithNormals)
{
  PlainSurface expected = ContourPlainly(GetVolume(), Isovalues);
  std::sort(expected.Triangles.begin(), expected.Triangles.end());
  for (const int size : NumbersOfRanks)
  {
    for (const Deal& deal : { Deal(DealInTurn), Deal(DealToLast) })
    {
      const std::uint64_t roundBytes = size % 2 == 0 ? 1 : std::uint64_t{ 1 } << 20;
      const PlainSurface united =
        Unite(Redistribute(size, EdgeIndexMode::Lossless, MakeSettings(0, roundBytes), deal, true));
      EXPECT_EQ(united.Triangles, expected.Triangles) << size << " ranks";
      EXPECT_TRUE(united.Points == expected.Points) << size << " ranks";
    }
  }
}

TEST(SurfaceExchange, PolygonsArriveAsTheyWere)
{
  ContourRequest request = MakeRequest(Isovalues);
  request.Polygons = true;
  TestBlockSource<std::uint8_t> all(GetVolume(), BlockSize);
  const auto expected = Require(ExtractSurface(GetVolume().Geometry, all, request, 1));
  const EdgeIndexHeader header = MakeVolumeHeader(EdgeIndexMode::Lossless);
  ThreadCommunicator::Run(3,
    [&](Communicator& ranks)
    {
      TestBlockSource<std::uint8_t> source(GetVolume(), BlockSize);
      KeepOwnBlocks(source, ranks, DealInTurn);
      SurfaceExchange exchange(ranks, header, request, MakeSettings(1, 1 << 20));
      const auto surface = exchange.Run(source);
      ASSERT_TRUE(surface.IsOk()) << surface.GetStatus().GetMessage();
      if (ranks.GetRank() == 0)
      {
        EXPECT_EQ(ListPolygons(*surface), ListPolygons(expected));
        EXPECT_EQ(surface->NumberOfTriangles, expected.NumberOfTriangles);
      }
    });
}

TEST(SurfaceExchange, PointsOfABoundedSurfaceAreEqualWherePiecesMeet)
{
  const EdgeIndexHeader header = MakeVolumeHeader(EdgeIndexMode::Bounded);
  TestBlockSource<std::uint8_t> all(GetVolume(), BlockSize);
  const auto bytes = Require(EncodeSurface(header, all, 1));
  const auto decoded =
    Require(DecodeSurface(bytes.data(), bytes.size(), MakeRequest(Isovalues), 1));
  for (const int size : { 2, 5 })
  {
    // One rank has everything, and keeps some: what it keeps must be moved as well.
    EXPECT_TRUE(Unite(Redistribute(size, EdgeIndexMode::Bounded, MakeSettings(0, 5000),
                  DealToLast)) == MakePlain(decoded))
      << size << " ranks";
  }
}

TEST(SurfaceExchange, PiecesDoNotDependOnWhereTheBlocksWere)
{
  const Outcome expected =
    Redistribute(3, EdgeIndexMode::Smallest, MakeSettings(3, 1 << 20), DealToLast);
  for (const int size : { 3, 4, 7 })
  {
    SurfaceExchange::Settings settings = MakeSettings(3, 3000);
    settings.Threads = size % 3 + 1;
    const Outcome outcome = Redistribute(size, EdgeIndexMode::Smallest, settings, DealInTurn);
    for (std::size_t rank = 0; rank < 3; ++rank)
    {
      ExpectSamePoints(expected.Surfaces[rank], outcome.Surfaces[rank]);
    }
  }
}

TEST(SurfaceExchange, PiecesHaveAboutEqualNumbersOfTriangles)
{
  const Outcome outcome =
    Redistribute(4, EdgeIndexMode::Lossless, MakeSettings(0, 1 << 20), DealToLast);
  std::size_t total = 0;
  std::size_t most = 0;
  for (const Surface& surface : outcome.Surfaces)
  {
    total += surface.NumberOfTriangles;
    most = std::max(most, surface.NumberOfTriangles);
  }
  EXPECT_LE(static_cast<double>(most), 1.1 * static_cast<double>(total) / 4);
}

TEST(SurfaceExchange, CostCountsWhatWasSentAndReceived)
{
  const Outcome outcome =
    Redistribute(4, EdgeIndexMode::Bounded, MakeSettings(3, 10000), DealToLast);
  std::uint64_t blocks = 0;
  std::uint64_t raw = 0;
  for (std::size_t rank = 0; rank < 4; ++rank)
  {
    const SurfaceExchange::Cost& cost = outcome.Costs[rank];
    EXPECT_EQ(cost.Rounds, outcome.Costs[0].Rounds);
    // The last rank draws nothing itself, so all goes away, and descriptions to three ranks.
    EXPECT_GE(cost.SentBytes, cost.EncodedBytes);
    EXPECT_LE(cost.SentBytes, cost.EncodedBytes + 3 * 20 * cost.EncodedBlocks);
    EXPECT_EQ(cost.EncodedBytes > 0, rank == 3);
    EXPECT_EQ(cost.ReceivedBlocks > 0, rank < 3);
    EXPECT_GE(cost.ReceivedPoints, outcome.Surfaces[rank].NumberOfPoints);
    blocks += cost.ReceivedBlocks;
    raw += GetSurfaceBytes(outcome.Surfaces[rank]);
  }
  const SurfaceExchange::Cost& sender = outcome.Costs[3];
  EXPECT_EQ(blocks, sender.EncodedBlocks);
  EXPECT_GE(sender.Rounds, sender.EncodedBytes / 12000);
  EXPECT_LT(sender.SentBytes * 15, raw);
  RecordProperty("RawOverSent",
    std::to_string(static_cast<double>(raw) / static_cast<double>(sender.SentBytes)));
}

TEST(SurfaceExchange, EmptySourcesMakeEmptySurfaces)
{
  const Outcome outcome = Redistribute(
    3, EdgeIndexMode::Lossless, MakeSettings(0, 100), [](std::int64_t, int) { return -1; });
  for (const Surface& surface : outcome.Surfaces)
  {
    EXPECT_EQ(surface.NumberOfTriangles, 0U);
  }
}

TEST(SurfaceExchange, AFailedRankStopsAllRanks)
{
  const auto errors = ThreadCommunicator::Collect(4,
    [](Communicator& ranks)
    {
      return Exchange(
        ranks, DealInTurn, ranks.GetRank() == 2 ? std::optional<std::size_t>(1) : std::nullopt);
    });
  for (std::size_t rank = 0; rank < 4; ++rank)
  {
    EXPECT_EQ(errors[rank].GetCode(), rank == 2 ? StatusCode::IoError : StatusCode::RemoteFailure);
    ExpectMessage(errors[rank], "no medium");
  }
}

TEST(SurfaceExchange, StopsOnAllRanksWhenOneIsStopped)
{
  for (const Status& error : ThreadCommunicator::Collect(3,
         [](Communicator& ranks)
         {
           const bool goesOn = ranks.GetRank() != 1;
           return Exchange(ranks, DealInTurn, {}, [goesOn](double) { return goesOn; });
         }))
  {
    EXPECT_EQ(error.GetCode(), StatusCode::Aborted);
  }
}

TEST(SurfaceExchange, RefusesHeadersWithAPreview)
{
  EdgeIndexHeader header = MakeVolumeHeader(EdgeIndexMode::Lossless);
  header.PreviewLevel = 2;
  SerialCommunicator ranks;
  TestBlockSource<std::uint8_t> source(GetVolume(), BlockSize);
  const ContourRequest request = MakeRequest(Isovalues);
  SurfaceExchange exchange(ranks, header, request, {});
  EXPECT_EQ(exchange.Run(source).GetStatus().GetCode(), StatusCode::InvalidArgument);
}

TEST(SurfaceExchange, DamagedMessagesFailOnAllRanks)
{
  const EdgeIndexHeader header = MakeVolumeHeader(EdgeIndexMode::Lossless);
  std::vector<std::function<void(Message&)>> damages = {
    [](Message& message) { message.clear(); },
    [](Message& message) { message.push_back(0); },
    [](Message& message)
    {
      const Message twice = message;
      message.insert(message.end(), twice.begin(), twice.end());
    },
    [&header](Message& message)
    {
      // The last record is left out: what is there is whole.
      std::size_t at = 0;
      std::size_t last = 0;
      std::size_t used = 0;
      for (; at < message.size(); at += used)
      {
        last = at;
        ASSERT_TRUE(
          EdgeIndexRecord::Parse(header, message.data() + at, message.size() - at, used).IsOk());
      }
      message.resize(last);
    },
  };
  for (std::size_t part = 0; part < 20; ++part)
  {
    damages.push_back([part](Message& message) { message.resize(message.size() * part / 20); });
    damages.push_back([part](Message& message) { message[message.size() * part / 20] ^= 0x24; });
    damages.push_back([part](Message& message) { message[part] ^= 0x81; });
  }
  for (std::size_t n = 0; n < damages.size(); ++n)
  {
    const auto errors = ThreadCommunicator::Collect(2,
      [&](Communicator& inner)
      {
        const bool isDamaged = inner.GetRank() == 1;
        DamagingCommunicator ranks(
          inner, isDamaged ? damages[n] : [](Message&) {});
        return Exchange(
          ranks, [](std::int64_t block, int) { return block == 8  ? 1
                                                 : block % 9 != 0 ? -1
                                                                  : 0; });
      });
    EXPECT_EQ(errors[0].GetCode(), StatusCode::RemoteFailure) << "damage " << n;
    EXPECT_EQ(errors[1].GetCode(), StatusCode::Corrupt) << "damage " << n;
  }
}

TEST(SurfaceExchange, DamagedDescriptionsOfBlocksFailOnAllRanks)
{
  const std::vector<std::function<void(Message&)>> damages = {
    [](Message& message) { message.pop_back(); }, [](Message& message) { message.push_back(1); },
    [](Message& message) { std::fill(message.begin(), message.end(), std::uint8_t{ 255 }); },
    [](Message& message) { message[0] = 127; }, // a block beyond the grid
    [](Message& message) { message[1] = 0; },   // a block without vertices
  };
  for (std::size_t n = 0; n < damages.size(); ++n)
  {
    const auto errors = ThreadCommunicator::Collect(2,
      [&](Communicator& inner)
      {
        DamagingCommunicator ranks(inner, [](Message&) {});
        if (inner.GetRank() == 1)
        {
          ranks.DamageDescriptions = damages[n];
        }
        return Exchange(ranks, DealInTurn);
      });
    EXPECT_EQ(errors[0].GetCode(), StatusCode::Corrupt) << "damage " << n;
    EXPECT_EQ(errors[1].GetCode(), StatusCode::Corrupt) << "damage " << n;
  }
}
