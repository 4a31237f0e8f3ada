// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/JsonDepth.h"

namespace isosurface
{

bool IsJsonDeeperThan(const std::string& text, int depth)
{
  int open = 0;
  bool isInString = false;
  for (std::size_t n = 0; n < text.size(); ++n)
  {
    const char character = text[n];
    if (isInString && character == '\\')
    {
      ++n; // an escaped character does not end the string
    }
    else if (character == '"')
    {
      isInString = !isInString;
    }
    else if (!isInString && (character == '{' || character == '['))
    {
      ++open;
    }
    else if (!isInString && (character == '}' || character == ']'))
    {
      --open;
    }
    if (open > depth)
    {
      return true;
    }
  }
  return false;
}

} // namespace isosurface
