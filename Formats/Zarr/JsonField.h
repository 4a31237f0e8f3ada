// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_JsonField_h
#define isosurface_JsonField_h

#include <nlohmann/json.hpp>

#include <string>

namespace isosurface
{

/// The member of a JSON object; null if there is none, or if it is no object.
inline const nlohmann::json& FindJson(const nlohmann::json& object, const char* name)
{
  static const nlohmann::json nothing;
  if (!object.is_object())
  {
    return nothing;
  }
  const auto found = object.find(name);
  return found == object.end() ? nothing : *found;
}

inline std::string GetJsonText(const nlohmann::json& json, const std::string& otherwise = {})
{
  return json.is_string() ? json.get<std::string>() : otherwise;
}

/// The text of a member; `otherwise` if it is no text.
inline std::string FindJsonText(
  const nlohmann::json& object, const char* name, const std::string& otherwise = {})
{
  return GetJsonText(FindJson(object, name), otherwise);
}

} // namespace isosurface

#endif
