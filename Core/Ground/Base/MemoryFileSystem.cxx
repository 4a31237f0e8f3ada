// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/MemoryFileSystem.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

namespace isosurface
{
namespace
{

/// Whether a file is `path`, or in a folder of this name.
bool IsWithin(const std::string& file, const std::string& path)
{
  return file == path || file.compare(0, path.size() + 1, path + "/") == 0;
}

} // namespace

class MemoryFileSystem::Reader : public RandomAccessFile
{
public:
  Reader(MemoryFileSystem& files, std::string path, std::shared_ptr<const Content> content)
    : Files(files)
    , Path(std::move(path))
    , Bytes(std::move(content))
  {
  }
  Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override
  {
    const std::lock_guard<std::mutex> lock(this->Files.Mutex);
    if (offset > this->Bytes->size() || size > this->Bytes->size() - offset)
    {
      return Status(StatusCode::Corrupt, this->Path + ": truncated");
    }
    std::copy_n(this->Bytes->begin() + static_cast<std::ptrdiff_t>(offset), size,
      static_cast<std::uint8_t*>(bytes));
    return Status::Ok();
  }
  std::uint64_t GetSize() const override
  {
    const std::lock_guard<std::mutex> lock(this->Files.Mutex);
    return this->Bytes->size();
  }
  const std::string& GetPath() const override { return this->Path; }

private:
  MemoryFileSystem& Files;
  const std::string Path;
  const std::shared_ptr<const Content> Bytes;
};

class MemoryFileSystem::Writer : public WritableFile
{
public:
  Writer(MemoryFileSystem& files, std::string path, std::shared_ptr<Content> content)
    : Files(files)
    , Path(std::move(path))
    , Bytes(std::move(content))
  {
  }
  Status Append(const void* bytes, std::size_t size) override
  {
    return this->WriteAt(this->GetSize(), bytes, size);
  }
  Status WriteAt(std::uint64_t offset, const void* bytes, std::size_t size) override
  {
    const std::lock_guard<std::mutex> lock(this->Files.Mutex);
    const std::uint64_t end = std::max<std::uint64_t>(this->Bytes->size(), offset + size);
    const std::uint64_t more = end - this->Bytes->size();
    if (more > this->Files.LimitBytes - this->Files.Bytes)
    {
      return Status(StatusCode::DiskFull,
        this->Path + ": cannot be kept in memory: its limit is " +
          std::to_string(this->Files.LimitBytes >> 20) + " MiB");
    }
    this->Bytes->resize(static_cast<std::size_t>(end));
    this->Files.Bytes += more;
    std::copy_n(static_cast<const std::uint8_t*>(bytes), size,
      this->Bytes->begin() + static_cast<std::ptrdiff_t>(offset));
    return Status::Ok();
  }
  std::uint64_t GetSize() const override
  {
    const std::lock_guard<std::mutex> lock(this->Files.Mutex);
    return this->Bytes->size();
  }
  Status Sync() override { return Status::Ok(); }
  Status SyncAndClose() override { return Status::Ok(); }
  const std::string& GetPath() const override { return this->Path; }

private:
  MemoryFileSystem& Files;
  const std::string Path;
  const std::shared_ptr<Content> Bytes;
};

MemoryFileSystem::MemoryFileSystem(FileSystem& others, std::string prefix, std::uint64_t limitBytes)
  : Others(others)
  , Prefix(std::move(prefix))
  , LimitBytes(limitBytes)
{
}

Status MemoryFileSystem::CheckPath(const std::string& path) const
{
  return path.compare(0, this->Prefix.size(), this->Prefix) == 0 ||
      path.compare(0, this->Prefix.size() + 1, HidePath(this->Prefix)) == 0
    ? Status::Ok()
    : Status(StatusCode::IoError, path + ": cannot be written: it is not kept in memory");
}

std::shared_ptr<MemoryFileSystem::Content> MemoryFileSystem::Find(const std::string& path)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  const auto found = this->Files.find(path);
  return found == this->Files.end() ? nullptr : found->second;
}

Result<std::unique_ptr<RandomAccessFile>> MemoryFileSystem::OpenForReading(const std::string& path)
{
  if (auto content = this->Find(path))
  {
    return std::unique_ptr<RandomAccessFile>(new Reader(*this, path, std::move(content)));
  }
  return this->Others.OpenForReading(path);
}

Result<std::unique_ptr<WritableFile>> MemoryFileSystem::CreateForWriting(const std::string& path)
{
  ISOSURFACE_RETURN_IF_ERROR(this->RemoveAll(path));
  auto content = std::make_shared<Content>();
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Files[path] = content;
  return std::unique_ptr<WritableFile>(new Writer(*this, path, std::move(content)));
}

Status MemoryFileSystem::Rename(const std::string& from, const std::string& to)
{
  auto content = this->Find(from);
  if (!content)
  {
    return Status(StatusCode::NotFound, from + ": cannot be renamed: there is no such file");
  }
  ISOSURFACE_RETURN_IF_ERROR(this->RemoveAll(to));
  const std::lock_guard<std::mutex> lock(this->Mutex);
  this->Files.erase(from);
  this->Files[to] = std::move(content);
  return Status::Ok();
}

Status MemoryFileSystem::MakeDirectories(const std::string& path)
{
  return this->CheckPath(path); // a folder is there as soon as a file is in it
}

Status MemoryFileSystem::RemoveAll(const std::string& path)
{
  ISOSURFACE_RETURN_IF_ERROR(this->CheckPath(path));
  const std::lock_guard<std::mutex> lock(this->Mutex);
  for (auto file = this->Files.begin(); file != this->Files.end();)
  {
    const bool isGoing = IsWithin(file->first, path);
    this->Bytes -= isGoing ? file->second->size() : 0;
    file = isGoing ? this->Files.erase(file) : std::next(file);
  }
  return Status::Ok();
}

bool MemoryFileSystem::Exists(const std::string& path)
{
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    if (std::any_of(this->Files.begin(), this->Files.end(),
          [&path](const auto& file) { return IsWithin(file.first, path); }))
    {
      return true;
    }
  }
  return !this->CheckPath(path).IsOk() && this->Others.Exists(path);
}

Result<std::vector<std::string>> MemoryFileSystem::List(const std::string& path)
{
  if (!this->CheckPath(path).IsOk())
  {
    return this->Others.List(path);
  }
  const std::lock_guard<std::mutex> lock(this->Mutex);
  std::set<std::string> names;
  for (const auto& file : this->Files)
  {
    if (file.first != path && IsWithin(file.first, path))
    {
      const std::string rest = file.first.substr(path.size() + 1);
      names.insert(rest.substr(0, rest.find('/')));
    }
  }
  return std::vector<std::string>(names.begin(), names.end());
}

Result<FileState> MemoryFileSystem::FindState(const std::string& path)
{
  return this->Others.FindState(path);
}

Status MemoryFileSystem::CheckRegular(const std::string& path, const char* action)
{
  return this->CheckPath(path).IsOk() ? Status::Ok() : this->Others.CheckRegular(path, action);
}

Status MemoryFileSystem::SyncDirectory(const std::string&)
{
  return Status::Ok();
}

} // namespace isosurface
