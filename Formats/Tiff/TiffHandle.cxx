// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffHandle.h"

#include "Formats/Source/TextFields.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>

namespace isosurface
{
namespace
{

// What libtiff calls in place of the system, with the handle.

tmsize_t ReadBytes(thandle_t client, void* bytes, tmsize_t size)
{
  auto* handle = static_cast<TiffHandle*>(client);
  const std::uint64_t end = handle->File->GetSize();
  const std::uint64_t left = handle->Position < end ? end - handle->Position : 0;
  const auto count = std::min<std::uint64_t>(static_cast<std::uint64_t>(size), left);
  const Status status =
    handle->File->Read(handle->Position, static_cast<std::size_t>(count), bytes);
  if (!status.IsOk())
  {
    handle->Failure = handle->Failure.IsOk() ? status : handle->Failure;
    return 0;
  }
  handle->Position += count;
  return static_cast<tmsize_t>(count);
}

tmsize_t WriteBytes(thandle_t, void*, tmsize_t)
{
  return -1;
}

toff_t Seek(thandle_t client, toff_t offset, int whence)
{
  auto* handle = static_cast<TiffHandle*>(client);
  const toff_t from = whence == SEEK_CUR ? handle->Position
    : whence == SEEK_END                 ? handle->File->GetSize()
                                         : 0;
  handle->Position = from + offset;
  return handle->Position;
}

int Close(thandle_t)
{
  return 0;
}

toff_t GetSize(thandle_t client)
{
  return static_cast<TiffHandle*>(client)->File->GetSize();
}

int TakeError(::TIFF*, void* user, const char*, const char* format, va_list arguments)
{
  auto* handle = static_cast<TiffHandle*>(user);
  if (handle->Reason.empty())
  {
    char text[256];
    std::vsnprintf(text, sizeof(text), format, arguments);
    handle->Reason = TrimText(text);
    const std::string path = handle->File->GetPath() + ": "; // which our own errors begin with
    handle->Reason.erase(0, handle->Reason.rfind(path, 0) == 0 ? path.size() : 0);
  }
  return 1;
}

int PassWarning(::TIFF*, void*, const char*, const char*, va_list)
{
  return 1;
}

} // namespace

Result<std::unique_ptr<TiffHandle>> TiffHandle::Open(std::unique_ptr<RandomAccessFile> file)
{
  const std::string path = file->GetPath();
  ::TIFFOpenOptions* options = ::TIFFOpenOptionsAlloc();
  if (!options)
  {
    return Status(StatusCode::OutOfMemory, path + ": no memory to open it");
  }
  auto handle = std::make_unique<TiffHandle>();
  handle->File = std::move(file);
  // A valid file needs no memory larger than the file, except for the tables of the codecs.
  ::TIFFOpenOptionsSetMaxSingleMemAlloc(
    options, static_cast<tmsize_t>(handle->File->GetSize() + MaximumTableSize));
  ::TIFFOpenOptionsSetErrorHandlerExtR(options, TakeError, handle.get());
  ::TIFFOpenOptionsSetWarningHandlerExtR(options, PassWarning, handle.get());
  // Flags: no memory mapping, no chopping of strips, their offsets read on demand.
  handle->Tiff = ::TIFFClientOpenExt(path.c_str(), "rmcO", handle.get(), ReadBytes, WriteBytes,
    Seek, Close, GetSize, nullptr, nullptr, options);
  ::TIFFOpenOptionsFree(options);
  ISOSURFACE_RETURN_IF_ERROR(handle->Failure);
  if (!handle->Tiff)
  {
    return Status(StatusCode::Corrupt,
      path + ": not a TIFF file" + (handle->Reason.empty() ? "" : ": ") + handle->Reason);
  }
  return handle;
}

std::pair<std::uint32_t, const void*> TiffHandle::FindUnknown(std::uint32_t tag) const
{
  const ::TIFFField* field = ::TIFFFindField(this->Tiff, tag, TIFF_ANY);
  std::uint32_t count = 0;
  const void* found = nullptr;
  if (!field)
  {
    return { 0, nullptr };
  }
  // libtiff counts the values of tags that it does not know, unless GDAL is in the process, which makes
  // it know them.
  if (::TIFFFieldPassCount(field) != 0 && ::TIFFFieldReadCount(field) == TIFF_VARIABLE2)
  {
    return ::TIFFGetField(this->Tiff, tag, &count, &found) == 1 ? std::pair(count, found)
                                                                : std::pair(0U, found);
  }
  if (::TIFFFieldPassCount(field) != 0)
  {
    std::uint16_t few = 0;
    return ::TIFFGetField(this->Tiff, tag, &few, &found) == 1
      ? std::pair(std::uint32_t{ few }, found)
      : std::pair(0U, found);
  }
  const bool isText = ::TIFFFieldDataType(field) == TIFF_ASCII;
  const bool isThere = isText && ::TIFFGetField(this->Tiff, tag, &found) == 1 && found;
  return { isThere ? static_cast<std::uint32_t>(std::strlen(static_cast<const char*>(found))) : 0,
    isThere ? found : nullptr };
}

TiffHandle::~TiffHandle()
{
  if (this->Tiff)
  {
    ::TIFFClose(this->Tiff);
  }
}

} // namespace isosurface
