// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/CurlLibrary.h"

#include <utility>

#include <dlfcn.h>

namespace isosurface
{
namespace
{

/// Finds a function; false if the library has none of that name.
template <typename Function>
bool FindFunction(void* library, const char* name, Function& function)
{
  function = reinterpret_cast<Function>(::dlsym(library, name));
  return function != nullptr;
}

std::pair<CurlLibrary, std::string> LoadCurl()
{
  CurlLibrary curl;
  void* library = ::dlopen("libcurl.so.4", RTLD_NOW | RTLD_LOCAL);
  library = library ? library : ::dlopen("libcurl-gnutls.so.4", RTLD_NOW | RTLD_LOCAL);
  if (!library)
  {
    return { curl, "libcurl.so.4, which fetches it, is not installed" };
  }
  const bool isWhole = FindFunction(library, "curl_global_init", curl.GlobalInit) &&
    FindFunction(library, "curl_version", curl.Version) &&
    FindFunction(library, "curl_getdate", curl.GetDate) &&
    FindFunction(library, "curl_easy_init", curl.EasyInit) &&
    FindFunction(library, "curl_easy_cleanup", curl.EasyCleanup) &&
    FindFunction(library, "curl_easy_setopt", curl.EasySetOption) &&
    FindFunction(library, "curl_easy_getinfo", curl.EasyGetInformation) &&
    FindFunction(library, "curl_easy_strerror", curl.EasyError) &&
    FindFunction(library, "curl_slist_append", curl.ListAppend) &&
    FindFunction(library, "curl_slist_free_all", curl.ListFree) &&
    FindFunction(library, "curl_multi_init", curl.MultiInit) &&
    FindFunction(library, "curl_multi_setopt", curl.MultiSetOption) &&
    FindFunction(library, "curl_multi_add_handle", curl.MultiAdd) &&
    FindFunction(library, "curl_multi_remove_handle", curl.MultiRemove) &&
    FindFunction(library, "curl_multi_perform", curl.MultiPerform) &&
    FindFunction(library, "curl_multi_info_read", curl.MultiRead) &&
    FindFunction(library, "curl_multi_poll", curl.MultiPoll) &&
    FindFunction(library, "curl_multi_wakeup", curl.MultiWakeUp);
  constexpr long everything = 3;
  if (!isWhole || curl.GlobalInit(everything) != 0)
  {
    return { curl, "the libcurl of this system is older than 7.68" };
  }
  return { curl, "" };
}

} // namespace

Result<const CurlLibrary*> CurlLibrary::Load()
{
  static const std::pair<CurlLibrary, std::string> loaded = LoadCurl();
  return loaded.second.empty()
    ? Result<const CurlLibrary*>(&loaded.first)
    : Result<const CurlLibrary*>(Status(StatusCode::Unsupported, loaded.second));
}

} // namespace isosurface
