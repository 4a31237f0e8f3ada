// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Dicom/DicomStream.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace isosurface
{
namespace
{

constexpr std::size_t WindowSize = std::size_t{ 16 } << 10;
constexpr std::uint64_t AppendSize = std::uint64_t{ 1 } << 20;

} // namespace

/// Inflates what it is given, piece by piece.
class DicomStream::Inflater
{
public:
  Inflater() { this->IsReady = ::inflateInit2(&this->Stream, -MAX_WBITS) == Z_OK; }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() { ::inflateEnd(&this->Stream); }

  bool HasInput() const { return this->Stream.avail_in > 0; }
  bool IsAtEnd() const { return this->HasEnded; }
  /// The bytes that are inflated next, once the ones before are used up.
  std::array<std::uint8_t, WindowSize>& GetInput() { return this->Input; }
  void SetInput(std::size_t size)
  {
    this->Stream.next_in = this->Input.data();
    this->Stream.avail_in = static_cast<uInt>(size);
  }

  /// Inflates some bytes; nothing if the stream is damaged.
  bool Inflate(std::vector<std::uint8_t>& to)
  {
    const std::size_t before = to.size();
    to.resize(before + WindowSize);
    this->Stream.next_out = to.data() + before;
    this->Stream.avail_out = static_cast<uInt>(WindowSize);
    const int result = this->IsReady ? ::inflate(&this->Stream, Z_NO_FLUSH) : Z_STREAM_ERROR;
    to.resize(to.size() - this->Stream.avail_out);
    this->HasEnded = result == Z_STREAM_END;
    return result == Z_OK || result == Z_STREAM_END;
  }

private:
  ::z_stream Stream = {};
  std::array<std::uint8_t, WindowSize> Input{};
  bool IsReady = false;
  bool HasEnded = false;
};

DicomStream::DicomStream(const RandomAccessFile& file)
  : File(file)
{
}

DicomStream::~DicomStream() = default;

Status DicomStream::MakeError(StatusCode code, const std::string& reason) const
{
  return Status(code, this->File.GetPath() + ": cannot be read: " + reason);
}

void DicomStream::Inflate()
{
  this->Position -= this->GetHeld();
  this->Window.clear();
  this->Begin = 0;
  this->Deflated = std::make_unique<Inflater>();
}

Result<bool> DicomStream::Extend()
{
  const auto count = static_cast<std::size_t>(
    std::min<std::uint64_t>(WindowSize, this->File.GetSize() - this->Position));
  if (!this->Deflated)
  {
    const std::size_t before = this->Window.size();
    this->Window.resize(before + count);
    ISOSURFACE_RETURN_IF_ERROR(
      this->File.Read(this->Position, count, this->Window.data() + before));
    this->Position += count;
    return count > 0;
  }
  if (!this->Deflated->HasInput())
  {
    ISOSURFACE_RETURN_IF_ERROR(
      this->File.Read(this->Position, count, this->Deflated->GetInput().data()));
    this->Deflated->SetInput(count);
    this->Position += count;
  }
  const bool isAtEnd = this->Deflated->IsAtEnd() || !this->Deflated->HasInput();
  if (!this->Deflated->IsAtEnd() && this->Deflated->Inflate(this->Window))
  {
    return true;
  }
  return isAtEnd ? Result<bool>(false)
                 : this->MakeError(StatusCode::Corrupt, "its deflated bytes are damaged");
}

bool DicomStream::MayHave(std::uint64_t size) const
{
  return this->Deflated || size <= this->GetHeld() + (this->File.GetSize() - this->Position);
}

Status DicomStream::Peek(std::size_t size, void* bytes)
{
  if (this->GetHeld() < size)
  {
    this->Window.erase(
      this->Window.begin(), this->Window.begin() + static_cast<std::ptrdiff_t>(this->Begin));
    this->Begin = 0;
  }
  while (this->GetHeld() < size)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto isMore, this->Extend());
    if (!isMore)
    {
      return this->MakeError(StatusCode::Corrupt, "it is truncated, or has no pixels");
    }
  }
  std::memcpy(bytes, this->Window.data() + this->Begin, size);
  return Status::Ok();
}

Status DicomStream::Read(std::size_t size, void* bytes)
{
  auto* to = static_cast<std::uint8_t*>(bytes);
  while (size > 0)
  {
    if (!this->Deflated && this->GetHeld() == 0 && size >= WindowSize)
    {
      this->Position += size;
      return this->File.Read(this->Position - size, size, to); // samples, past the window
    }
    const std::size_t part = std::min(size, std::max<std::size_t>(1, this->GetHeld()));
    ISOSURFACE_RETURN_IF_ERROR(this->Peek(part, to));
    this->Begin += part;
    to += part;
    size -= part;
  }
  return Status::Ok();
}

Status DicomStream::Append(std::uint64_t size, std::vector<std::uint8_t>& to)
{
  if (!this->MayHave(size))
  {
    return this->MakeError(StatusCode::Corrupt, "it is truncated, or has no pixels");
  }
  while (size > 0)
  {
    const auto part = static_cast<std::size_t>(this->Deflated ? std::min(size, AppendSize) : size);
    to.resize(to.size() + part);
    ISOSURFACE_RETURN_IF_ERROR(this->Read(part, to.data() + to.size() - part));
    size -= part;
  }
  return Status::Ok();
}

Status DicomStream::Skip(std::uint64_t size)
{
  if (!this->MayHave(size))
  {
    return this->MakeError(StatusCode::Corrupt, "it is truncated, or has no pixels");
  }
  while (size > 0 && (this->Deflated || this->GetHeld() > 0))
  {
    std::uint8_t next = 0;
    ISOSURFACE_RETURN_IF_ERROR(this->Peek(1, &next));
    const std::uint64_t part = std::min<std::uint64_t>(size, this->GetHeld());
    this->Begin += static_cast<std::size_t>(part);
    size -= part;
  }
  this->Position += size;
  return Status::Ok();
}

} // namespace isosurface
