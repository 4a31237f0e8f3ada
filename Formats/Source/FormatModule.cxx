// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/FormatModule.h"

#include "Ground/Base/UsedFileSystem.h"

#include <filesystem>

#include <dlfcn.h>

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

} // namespace

Result<const void*> LoadFormatModule(const std::string& name, const std::string& what)
{
  const std::string file = "libIsosurface" + name + ".so";
  const std::string path = (std::filesystem::path(FindOwnFolder()) / file).string();
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
