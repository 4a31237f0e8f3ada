// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceSizeQuestion_h
#define isosurface_SurfaceSizeQuestion_h

#include "ContourProxy.h"

#include <QString>

#include <functional>

class QDialog;

namespace isosurface
{

/// Asks what to do about a surface that does not fit into memory, and does not wait for the answer:
/// one of the functions is called then, or none, if the user keeps what is shown. The dialog belongs
/// to the main window, and deletes itself when it is closed.
QDialog* AskAboutSurfaceSize(const QString& title, const Refinement& report,
  const std::function<void()>& useFittingLevel, const std::function<void()>& extractAnyway);

} // namespace isosurface

#endif
