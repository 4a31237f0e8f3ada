// SPDX-License-Identifier: BSD-3-Clause
#include "StateLoading.h"

#include "pqApplicationCore.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"
#include "pqView.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSessionProxyManager.h"
#include "vtkSMViewProxy.h"

#include <algorithm>

namespace isosurface
{
namespace
{

constexpr const char* ResizeDelay = "WindowResizeNonInteractiveRenderDelay";

} // namespace

bool IsStateLoading()
{
  const QList<pqServer*> servers =
    pqApplicationCore::instance()->getServerManagerModel()->findItems<pqServer*>();
  return std::any_of(servers.begin(), servers.end(),
    [](const pqServer* server) { return server->proxyManager()->GetInLoadXMLState(); });
}

void DrawWholeUntilLoaded(pqView* view)
{
  vtkSMPropertyHelper property(view->getProxy(), ResizeDelay, /*quiet*/ true);
  const double delay = property.GetAsDouble();
  if (!IsStateLoading() || !(delay > 0))
  {
    return;
  }
  property.Set(0.0);
  auto* held = new QObject(view);
  QObject::connect(view, &pqView::endRender, held,
    [view, held, delay]
    {
      if (!IsStateLoading())
      {
        vtkSMPropertyHelper(view->getProxy(), ResizeDelay).Set(delay);
        held->deleteLater();
      }
    });
}

} // namespace isosurface
