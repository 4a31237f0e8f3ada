// SPDX-License-Identifier: BSD-3-Clause
#include "StateLoading.h"

#include "pqApplicationCore.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"
#include "pqView.h"
#include "vtkPVXMLElement.h" // of signals
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxyLocator.h" // of signals
#include "vtkSMSessionProxyManager.h"
#include "vtkSMViewProxy.h"

#include <algorithm>
#include <memory>

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
  if (!IsStateLoading())
  {
    return;
  }
  auto* held = new QObject(view);
  const auto delay = std::make_shared<double>(0);
  const auto hold = [view, delay]
  {
    vtkSMPropertyHelper property(view->getProxy(), ResizeDelay, /*quiet*/ true);
    if (property.GetAsDouble() > 0)
    {
      *delay = property.GetAsDouble();
      property.Set(0.0);
    }
  };
  hold();
  // In ParaView 6.1 the view gets the delay of the state only now.
  QObject::connect(pqApplicationCore::instance(), &pqApplicationCore::stateLoaded, held, hold);
  QObject::connect(view, &pqView::endRender, held,
    [view, held, delay]
    {
      if (!IsStateLoading())
      {
        vtkSMPropertyHelper(view->getProxy(), ResizeDelay, /*quiet*/ true).Set(*delay);
        held->deleteLater();
      }
    });
}

} // namespace isosurface
