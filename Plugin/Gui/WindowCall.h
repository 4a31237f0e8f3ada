// SPDX-License-Identifier: BSD-3-Clause
/** A call to a part of the plugin that needs ParaView's window. */

#ifndef WindowCall_h
#define WindowCall_h

#include "pqApplicationCore.h"
#include "pqCoreUtilities.h"

#include <QTimer>

namespace isosurface
{

/// Calls an object as soon as the window has the plugin's filters. A plugin in PV_PLUGIN_PATH is
/// loaded before there is a window; then that is when the window is complete.
template <typename Object>
void CallWithWindow(Object* object, void (Object::*member)())
{
  if (pqCoreUtilities::mainWidget())
  {
    QTimer::singleShot(0, object, member);
  }
  else
  {
    QObject::connect(
      pqApplicationCore::instance(), &pqApplicationCore::clientEnvironmentDone, object, member);
  }
}

} // namespace isosurface

#endif
