// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/FormatModule.h"

#include "Ground/Base/UsedFileSystem.h"

#include <filesystem>
#include <fstream>

#include <dlfcn.h>
#include <link.h>

namespace isosurface
{
namespace
{

/// The folder of the library that this function is in.
std::string FindOwnFolder()
{
  static const char anchor = 0;
  Dl_info info = {};
  const bool isKnown = ::dladdr(&anchor, &info) != 0 && info.dli_fname;
  return isKnown ? std::filesystem::path(info.dli_fname).parent_path().string() : std::string();
}

/// Whether all of a library is there, up to the header of the last section. The loader maps what the first
/// header tells: of a part the process would die.
bool IsWhole(const std::string& path)
{
  ElfW(Ehdr) header = {};
  ElfW(Shdr) last = {};
  std::ifstream file(path, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(&header), sizeof(header)) || header.e_shnum == 0)
  {
    return true; // the loader tells what it is
  }
  file.seekg(static_cast<std::streamoff>(
    header.e_shoff + std::uint64_t{ header.e_shentsize } * (header.e_shnum - 1u)));
  file.read(reinterpret_cast<char*>(&last), sizeof(last));
  return file && last.sh_type != SHT_NULL;
}

} // namespace

Result<const void*> LoadFormatModule(const std::string& name, const std::string& what)
{
  const std::string file = "libIsosurface" + name + ".so";
  const std::string path = (std::filesystem::path(FindOwnFolder()) / file).string();
  if (!IsWhole(path))
  {
    return Status(StatusCode::Unsupported,
      what + " is read by the module " + file + ", which is damaged: a part of it is missing");
  }
  void* const module = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  const void* const found = module ? ::dlsym(module, ("Isosurface" + name).c_str()) : nullptr;
  if (void* const use = found ? ::dlsym(module, "IsosurfaceUseFileSystem") : nullptr)
  {
    reinterpret_cast<decltype(&IsosurfaceUseFileSystem)>(use)(GetLocalFileSystem());
  }
  if (!found)
  {
    const char* const reason = ::dlerror();
    return Status(StatusCode::Unsupported,
      what + " is read by the module " + file +
        ", which cannot be loaded: " + (reason ? reason : "it is of another version"));
  }
  return found;
}

} // namespace isosurface
