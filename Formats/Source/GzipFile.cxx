// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/GzipFile.h"

#include <zlib.h>

#include <algorithm>
#include <new>

namespace isosurface
{
namespace
{

constexpr std::uint64_t MaximumPlaces = 1024;
constexpr std::uint64_t MinimumSpacing = std::uint64_t{ 4 } << 20;
constexpr std::size_t WindowSize = 32768;
constexpr std::size_t InputSize = std::size_t{ 1 } << 18;
constexpr std::size_t SkipSize = std::size_t{ 1 } << 18;
/// zlib's codes: a gzip or zlib header, which is recognised, or none, at a place in the stream.
constexpr int AnyHeader = 15 + 32;
constexpr int NoHeader = -15;
constexpr std::uint64_t GzipTrailerSize = 8;

/// The bytes from one place to the next.
std::uint64_t FindSpacing(std::uint64_t size)
{
  return std::max(MinimumSpacing, size / MaximumPlaces + 1);
}

} // namespace

/// A zlib stream that reads its input from a file.
class GzipFile::Inflater
{
public:
  Inflater(const RandomAccessFile& file, std::uint64_t in, std::uint64_t out, int header)
    : File(file)
    , In(in)
    , Out(out)
    , IsRaw(header == NoHeader)
    , Input(InputSize)
  {
    if (::inflateInit2(&this->Stream, header) != Z_OK)
    {
      throw std::bad_alloc();
    }
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() { ::inflateEnd(&this->Stream); }

  std::uint64_t GetOut() const { return this->Out; }
  std::uint64_t GetIn() const { return this->In - this->Stream.avail_in; }
  int GetBits() const { return this->Stream.data_type & 7; }
  /// Whether the next byte is the first one of a block.
  bool IsBetweenBlocks() const
  {
    return (this->Stream.data_type & 128) != 0 && (this->Stream.data_type & 64) == 0;
  }
  std::vector<std::uint8_t> GetWindow()
  {
    std::vector<std::uint8_t> window(WindowSize);
    uInt size = 0;
    ::inflateGetDictionary(&this->Stream, window.data(), &size);
    window.resize(size);
    return window;
  }

  Status Resume(int bits, const std::vector<std::uint8_t>& window)
  {
    if (bits != 0)
    {
      std::uint8_t before = 0;
      ISOSURFACE_RETURN_IF_ERROR(this->File.Read(this->In - 1, 1, &before));
      ::inflatePrime(&this->Stream, bits, before >> (8 - bits));
    }
    ::inflateSetDictionary(&this->Stream, window.data(), static_cast<uInt>(window.size()));
    return Status::Ok();
  }

  /// Inflates up to the end of the next block, but at most `size` bytes. Sets `count` to the
  /// number.
  Status Inflate(std::uint8_t* bytes, std::size_t size, std::size_t& count)
  {
    constexpr std::size_t maximum = std::size_t{ 1 } << 30;
    this->Stream.next_out = bytes;
    this->Stream.avail_out = static_cast<uInt>(std::min(size, maximum));
    const uInt room = this->Stream.avail_out;
    if (this->Stream.avail_in == 0)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->FillInput());
    }
    const int code = ::inflate(&this->Stream, Z_BLOCK);
    count = room - this->Stream.avail_out;
    this->Out += count;
    if (code == Z_STREAM_END)
    {
      return this->StartNextMember();
    }
    if (code != Z_OK && code != Z_BUF_ERROR)
    {
      return Status(StatusCode::Corrupt,
        this->File.GetPath() + ": its compressed samples are damaged: " +
          (this->Stream.msg ? this->Stream.msg : "not a gzip stream"));
    }
    return Status::Ok();
  }

  /// Continues to the end of the current member and checks its checksum, unless inflating started
  /// in the middle of the member.
  Status CheckEnd(std::vector<std::uint8_t>& scratch)
  {
    Status status;
    const std::uint64_t members = this->Members;
    std::size_t count = 0;
    while (status.IsOk() && !this->IsRaw && this->Members == members)
    {
      status = this->Inflate(scratch.data(), scratch.size(), count);
    }
    return status;
  }

private:
  Status FillInput()
  {
    const std::uint64_t size = this->File.GetSize();
    if (this->In >= size)
    {
      return Status(StatusCode::Corrupt,
        this->File.GetPath() + ": truncated: its compressed samples end after " +
          std::to_string(this->Out) + " bytes");
    }
    const auto count =
      static_cast<std::size_t>(std::min<std::uint64_t>(InputSize, size - this->In));
    ISOSURFACE_RETURN_IF_ERROR(this->File.Read(this->In, count, this->Input.data()));
    this->In += count;
    this->Stream.next_in = this->Input.data();
    this->Stream.avail_in = static_cast<uInt>(count);
    return Status::Ok();
  }

  Status StartNextMember()
  {
    // Without a header, zlib does not expect a trailer either.
    const std::uint64_t trailer = this->IsRaw ? GzipTrailerSize : 0;
    if (this->Stream.avail_in >= trailer)
    {
      // Members may be empty: the input is not read again for each of them.
      this->Stream.next_in += trailer;
      this->Stream.avail_in -= static_cast<uInt>(trailer);
    }
    else
    {
      this->In = this->GetIn() + trailer;
      this->Stream.avail_in = 0;
    }
    this->IsRaw = false;
    ++this->Members;
    ::inflateReset2(&this->Stream, AnyHeader);
    return Status::Ok();
  }

  const RandomAccessFile& File;
  std::uint64_t In; ///< offset in the file after Input
  std::uint64_t Out;
  bool IsRaw;
  std::uint64_t Members = 0; ///< members that have ended
  std::vector<std::uint8_t> Input;
  z_stream Stream = {};
};

GzipFile::GzipFile(
  std::unique_ptr<RandomAccessFile> file, std::uint64_t begin, std::uint64_t size, bool isWhole)
  : File(std::move(file))
  , Begin(begin)
  , Size(size)
  , IsWhole(isWhole)
  , Spacing(FindSpacing(size))
{
}

GzipFile::~GzipFile() = default;

std::uint64_t GzipFile::GetHeldBytes(std::uint64_t size)
{
  return InputSize + SkipSize + (size / FindSpacing(size) + 3) * (WindowSize + sizeof(Place));
}

/// Sets State to an inflater at or before the offset, with no place between.
Status GzipFile::Seek(std::uint64_t offset) const
{
  const auto next = std::upper_bound(this->Places.begin(), this->Places.end(), offset,
    [](std::uint64_t a, const Place& place) { return a < place.Out; });
  const Place* place = next == this->Places.begin() ? nullptr : &*std::prev(next);
  if (this->State && this->State->GetOut() <= offset &&
    (!place || place->Out <= this->State->GetOut()))
  {
    return Status::Ok();
  }
  if (!place)
  {
    this->State = std::make_unique<Inflater>(*this->File, this->Begin, 0, AnyHeader);
    return Status::Ok();
  }
  this->State = std::make_unique<Inflater>(*this->File, place->In, place->Out, NoHeader);
  return this->State->Resume(place->Bits, place->Window);
}

void GzipFile::NotePlace() const
{
  const std::uint64_t last = this->Places.empty() ? 0 : this->Places.back().Out;
  if (this->State->IsBetweenBlocks() && this->State->GetOut() >= last + this->Spacing)
  {
    this->Places.push_back({ this->State->GetIn(), this->State->GetOut(), this->State->GetBits(),
      this->State->GetWindow() });
  }
}

Status GzipFile::Read(std::uint64_t offset, std::size_t size, void* bytes) const
{
  if (offset > this->Size || size > this->Size - offset)
  {
    return Status(StatusCode::Corrupt, this->GetPath() + ": truncated");
  }
  const std::lock_guard<std::mutex> lock(this->Mutex);
  Status status = this->Seek(offset);
  std::vector<std::uint8_t> skipped(SkipSize);
  auto* to = static_cast<std::uint8_t*>(bytes);
  while (status.IsOk() && size > 0)
  {
    std::size_t count = 0;
    const std::uint64_t position = this->State->GetOut();
    if (position < offset)
    {
      const auto rest =
        static_cast<std::size_t>(std::min<std::uint64_t>(SkipSize, offset - position));
      status = this->State->Inflate(skipped.data(), rest, count);
    }
    else
    {
      status = this->State->Inflate(to, size, count);
      to += count;
      size -= count;
    }
    if (status.IsOk())
    {
      this->NotePlace();
    }
  }
  if (status.IsOk() && this->State->GetOut() == this->Size)
  {
    status = this->State->CheckEnd(skipped);
    if (status.IsOk() && this->IsWhole && this->State->GetOut() > this->Size)
    {
      status = Status(StatusCode::Corrupt,
        this->GetPath() + ": its compressed samples are more than the " +
          std::to_string(this->Size) + " bytes that its header tells");
    }
  }
  if (!status.IsOk())
  {
    this->State.reset();
  }
  return status;
}

} // namespace isosurface
