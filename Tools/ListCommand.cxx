// SPDX-License-Identifier: BSD-3-Clause
#include "BlockVolumeCommands.h"

#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/PrintableText.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>

namespace isosurface
{

Status RunListCommand(const BlockVolumeOptions& options)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto list, ListForeignVolumes(GetLocalFileSystem(), options.Input));
  for (VolumeListing& entry : list)
  {
    for (std::string* text : { &entry.Name, &entry.Shape, &entry.Type, &entry.Storage })
    {
      *text = MakePrintable(*text);
    }
  }
  std::size_t widths[3] = {};
  for (const VolumeListing& entry : list)
  {
    widths[0] = std::max(widths[0], entry.Name.size());
    widths[1] = std::max(widths[1], entry.Shape.size());
    widths[2] = std::max(widths[2], entry.Type.size());
  }
  for (const VolumeListing& entry : list)
  {
    std::printf("%-*s  %-*s  %-*s  %s\n", static_cast<int>(widths[0]), entry.Name.c_str(),
      static_cast<int>(widths[1]), entry.Shape.c_str(), static_cast<int>(widths[2]),
      entry.Type.c_str(), entry.Storage.c_str());
  }
  return Status::Ok();
}

} // namespace isosurface
