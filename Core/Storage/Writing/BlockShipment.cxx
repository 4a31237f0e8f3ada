// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Writing/BlockShipment.h"

#include "Ground/Base/Coding.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::size_t BlockHeaderSize = 8;

} // namespace

BlockShipment::Load BlockShipment::GetLoad(const std::vector<BlockSpan>& spans) const
{
  Load load;
  for (std::size_t maker = 0; maker < spans.size(); ++maker)
  {
    for (std::int64_t block = spans[maker].Begin; block < spans[maker].End; ++block)
    {
      const bool isMade = maker == this->Rank;
      const bool isWritten = this->FindWriter(block) == this->Rank;
      load.Sent += isMade && !isWritten ? 1 : 0;
      load.Received += !isMade && isWritten ? 1 : 0;
      load.Kept += isMade && isWritten ? 1 : 0;
    }
  }
  return load;
}

std::vector<Message> BlockShipment::Pack(
  std::vector<PendingBlock>& blocks, RecordBuffers& buffers) const
{
  std::vector<Message> messages(this->Ranks);
  std::vector<std::size_t> sizes(this->Ranks, 0);
  for (const PendingBlock& block : blocks)
  {
    sizes[this->FindWriter(block.Block)] += BlockHeaderSize + block.Layout.Size;
  }
  for (std::size_t rank = 0; rank < this->Ranks; ++rank)
  {
    messages[rank].reserve(rank == this->Rank ? 0 : sizes[rank]);
  }
  std::vector<PendingBlock> mine;
  for (PendingBlock& block : blocks)
  {
    const std::size_t writer = this->FindWriter(block.Block);
    if (writer == this->Rank)
    {
      mine.push_back(std::move(block));
      continue;
    }
    Message& message = messages[writer];
    std::uint8_t header[BlockHeaderSize];
    StoreLittleEndian(header, static_cast<std::uint64_t>(block.Block));
    const std::uint8_t* record = block.Record.GetData();
    message.insert(message.end(), header, header + BlockHeaderSize);
    message.insert(message.end(), record, record + block.Layout.Size);
    buffers.Return(std::move(block.Record));
  }
  blocks = std::move(mine);
  return messages;
}

Status BlockShipment::Unpack(
  std::vector<Message>& messages, std::vector<PendingBlock>& blocks, RecordBuffers& buffers) const
{
  Status damaged(StatusCode::Corrupt, "a message between ranks arrived damaged");
  for (std::size_t rank = 0; rank < messages.size(); ++rank)
  {
    const Message message = std::exchange(messages[rank], {});
    for (std::size_t position = 0; position < message.size();)
    {
      if (message.size() - position < BlockHeaderSize)
      {
        return damaged;
      }
      const auto number = LoadLittleEndian<std::uint64_t>(message.data() + position);
      if (number >= this->Stores.size() ||
        this->FindWriter(static_cast<std::int64_t>(number)) != this->Rank)
      {
        return damaged;
      }
      position += BlockHeaderSize;
      PendingBlock block(this->Grid, static_cast<std::int64_t>(number), this->Stores[number],
        this->Types, buffers.Take());
      if (message.size() - position < block.Layout.Size)
      {
        return damaged;
      }
      std::memcpy(block.Record.GetData(), message.data() + position, block.Layout.Size);
      position += block.Layout.Size;
      blocks.push_back(std::move(block));
    }
  }
  std::sort(blocks.begin(), blocks.end(),
    [](const PendingBlock& a, const PendingBlock& b) { return a.Block < b.Block; });
  return Status::Ok();
}

} // namespace isosurface
