// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FormatModule_h
#define isosurface_FormatModule_h

#include "Ground/Base/Status.h"

#include <string>

namespace isosurface
{

/**
 * Loads the module NAME, libIsosurfaceNAME.so in the folder of this library, and finds IsosurfaceNAME
 * in it. So the library that a format is read by is loaded with the first file of that format. The
 * module stays loaded. Error: a sentence that begins with `what` and names the module and the reason.
 */
Result<const void*> LoadFormatModule(const std::string& name, const std::string& what);

} // namespace isosurface

#endif
