// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Islands/IslandJoin.h"

#include "Ground/Base/Coding.h"
#include "Ranks/Islands/IslandChoice.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

namespace isosurface
{
namespace
{

/// An island of a rank.
struct RankIsland
{
  std::uint32_t Rank = 0;
  std::uint64_t Island = 0;

  bool operator==(const RankIsland& other) const
  {
    return this->Rank == other.Rank && this->Island == other.Island;
  }
  bool operator<(const RankIsland& other) const
  {
    return std::tie(this->Rank, this->Island) < std::tie(other.Rank, other.Island);
  }
};

using Meeting = std::pair<RankIsland, RankIsland>;

/// The rank that compares an id.
std::size_t ChooseRank(std::int64_t id, std::size_t ranks)
{
  const std::uint64_t hash = static_cast<std::uint64_t>(id) * 0x9E3779B97F4A7C15u;
  return static_cast<std::size_t>((hash >> 32) % ranks);
}

std::vector<Message> AddressPoints(std::vector<SharedPoint>& points, std::size_t ranks)
{
  std::vector<Message> outgoing(ranks);
  for (const SharedPoint& point : points)
  {
    Message& message = outgoing[ChooseRank(point.Id, ranks)];
    AppendLittleEndian(message, point.Id);
    AppendLittleEndian(message, point.Island);
  }
  points = {};
  return outgoing;
}

/// The islands that have points with the same ids, each pair once.
std::vector<Meeting> FindMeetings(const std::vector<Message>& incoming)
{
  std::vector<std::pair<std::int64_t, RankIsland>> points;
  for (std::size_t rank = 0; rank < incoming.size(); ++rank)
  {
    ByteReader reader(incoming[rank]);
    while (reader.GetRemaining() > 0)
    {
      const auto id = reader.Read<std::int64_t>();
      points.push_back({ id, { static_cast<std::uint32_t>(rank), reader.Read<std::uint64_t>() } });
    }
  }
  std::sort(points.begin(), points.end());
  std::vector<Meeting> meetings;
  for (std::size_t n = 1; n < points.size(); ++n)
  {
    if (points[n].first == points[n - 1].first && !(points[n].second == points[n - 1].second))
    {
      meetings.emplace_back(points[n - 1].second, points[n].second);
    }
  }
  std::sort(meetings.begin(), meetings.end());
  meetings.erase(std::unique(meetings.begin(), meetings.end()), meetings.end());
  return meetings;
}

Message PackMeetings(const std::vector<Meeting>& meetings)
{
  Message message;
  for (const Meeting& meeting : meetings)
  {
    for (const RankIsland& one : { meeting.first, meeting.second })
    {
      AppendLittleEndian(message, one.Rank);
      AppendLittleEndian(message, one.Island);
    }
  }
  return message;
}

std::vector<Meeting> UnpackMeetings(const std::vector<Message>& messages)
{
  std::vector<Meeting> meetings;
  for (const Message& message : messages)
  {
    ByteReader reader(message);
    while (reader.GetRemaining() > 0)
    {
      Meeting meeting;
      for (RankIsland* one : { &meeting.first, &meeting.second })
      {
        one->Rank = reader.Read<std::uint32_t>();
        one->Island = reader.Read<std::uint64_t>();
      }
      meetings.push_back(meeting);
    }
  }
  return meetings;
}

/// The islands that meet others, in groups that are one island. Equal on all ranks.
class IslandGroups
{
public:
  explicit IslandGroups(const std::vector<Meeting>& meetings)
  {
    for (const Meeting& meeting : meetings)
    {
      this->Members.push_back(meeting.first);
      this->Members.push_back(meeting.second);
    }
    std::sort(this->Members.begin(), this->Members.end());
    this->Members.erase(
      std::unique(this->Members.begin(), this->Members.end()), this->Members.end());
    this->Parents.resize(this->Members.size());
    std::iota(this->Parents.begin(), this->Parents.end(), std::size_t{ 0 });
    for (const Meeting& meeting : meetings)
    {
      const std::size_t a = this->FindRoot(this->FindNumber(meeting.first));
      const std::size_t b = this->FindRoot(this->FindNumber(meeting.second));
      this->Parents[std::max(a, b)] = std::min(a, b);
    }
  }

  const std::vector<RankIsland>& GetMembers() const { return this->Members; }
  /// The first member of a member's group.
  std::size_t FindRoot(std::size_t member)
  {
    while (this->Parents[member] != member)
    {
      this->Parents[member] = this->Parents[this->Parents[member]];
      member = this->Parents[member];
    }
    return member;
  }

private:
  std::size_t FindNumber(const RankIsland& one) const
  {
    return static_cast<std::size_t>(
      std::lower_bound(this->Members.begin(), this->Members.end(), one) - this->Members.begin());
  }

  std::vector<RankIsland> Members;
  std::vector<std::size_t> Parents;
};

/// The measures of a rank's members, in their order.
Message PackMeasures(
  const IslandGroups& groups, std::size_t rank, const std::vector<IslandMeasure>& measures)
{
  Message message;
  for (const RankIsland& member : groups.GetMembers())
  {
    if (member.Rank == rank)
    {
      AppendLittleEndian(message, measures[member.Island]);
    }
  }
  return message;
}

void AddMeasures(IslandGroups& groups, std::size_t rank, const std::vector<Message>& messages,
  std::vector<IslandMeasure>& measures, std::vector<std::uint8_t>& areOwned)
{
  const std::vector<RankIsland>& members = groups.GetMembers();
  std::vector<IslandMeasure> sums(members.size());
  std::vector<ByteReader> readers(messages.begin(), messages.end());
  for (std::size_t member = 0; member < members.size(); ++member)
  {
    sums[groups.FindRoot(member)].Add(readers[members[member].Rank].Read<IslandMeasure>());
  }
  for (std::size_t member = 0; member < members.size(); ++member)
  {
    if (members[member].Rank == rank)
    {
      const std::size_t root = groups.FindRoot(member);
      measures[members[member].Island] = sums[root];
      areOwned[members[member].Island] = root == member ? 1 : 0;
    }
  }
}

} // namespace

Status JoinIslands(Communicator& ranks, std::vector<SharedPoint> points,
  std::vector<IslandMeasure>& measures, std::vector<std::uint8_t>& areOwned)
{
  const auto rank = static_cast<std::size_t>(ranks.GetRank());
  std::vector<Message> outgoing;
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(Attempt(NoMemoryForIslands,
    [&]
    {
      areOwned.assign(measures.size(), 1);
      outgoing = AddressPoints(points, static_cast<std::size_t>(ranks.GetSize()));
      return Status::Ok();
    })));
  std::vector<Message> incoming = ranks.Exchange(std::move(outgoing));
  ISOSURFACE_ASSIGN_OR_RETURN(auto all,
    GatherFromAll(ranks, NoMemoryForIslands,
      [&](Message& mine)
      {
        mine = PackMeetings(FindMeetings(incoming));
        incoming = {};
        return Status::Ok();
      }));
  std::optional<IslandGroups> groups;
  ISOSURFACE_ASSIGN_OR_RETURN(all,
    GatherFromAll(ranks, NoMemoryForIslands,
      [&](Message& mine)
      {
        groups.emplace(UnpackMeetings(all));
        mine = PackMeasures(*groups, rank, measures);
        return Status::Ok();
      }));
  return ranks.Agree(Attempt(NoMemoryForIslands,
    [&]
    {
      AddMeasures(*groups, rank, all, measures, areOwned);
      return Status::Ok();
    }));
}

} // namespace isosurface
