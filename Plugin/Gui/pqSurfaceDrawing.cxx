// SPDX-License-Identifier: BSD-3-Clause
#include "pqSurfaceDrawing.h"

#include "pqApplicationCore.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"
#include "pqTimer.h"
#include "pqView.h"
#include "vtkIsosurfaceMapper.h"
#include "vtkLogger.h"
#include "vtkPVRenderView.h"
#include "vtkRenderWindow.h"
#include "vtkSMRenderViewProxy.h"

#include <QGuiApplication>
#include <QWidget>

namespace
{

vtkPVRenderView* FindView(pqView* view)
{
  return vtkPVRenderView::SafeDownCast(view->getProxy()->GetClientSideObject());
}

bool IsDrawnHere(pqView* view)
{
  return FindView(view) && !view->getServer()->isRemote() && view->widget() &&
    view->widget()->isVisible();
}

} // namespace

//------------------------------------------------------------------------------
pqSurfaceDrawing::pqSurfaceDrawing(QObject* parent)
  : Superclass(parent)
  , Timer(new pqTimer(this))
{
  this->Timer->setSingleShot(true);
  QObject::connect(this->Timer, &QTimer::timeout, this, &pqSurfaceDrawing::Advance);
}

//------------------------------------------------------------------------------
pqSurfaceDrawing::~pqSurfaceDrawing() = default;

//------------------------------------------------------------------------------
void pqSurfaceDrawing::Begin()
{
  this->Stop();
  const auto* model = pqApplicationCore::instance()->getServerManagerModel();
  for (pqView* view : model->findItems<pqView*>())
  {
    if (IsDrawnHere(view))
    {
      this->Views.push_back(view);
      QObject::connect(
        view, &pqView::endRender, this, &pqSurfaceDrawing::Forget, Qt::UniqueConnection);
    }
    else
    {
      view->render();
    }
  }
  this->Timer->start(0);
}

//------------------------------------------------------------------------------
void pqSurfaceDrawing::Stop()
{
  this->Timer->stop();
  this->Views.clear();
}

//------------------------------------------------------------------------------
void pqSurfaceDrawing::Advance()
{
  this->Views.removeAll(nullptr);
  if (this->Views.empty())
  {
    return;
  }
  pqView* view = this->Views.front();
  if (QGuiApplication::mouseButtons() != Qt::NoButton || view->getServer()->isProgressPending())
  {
    this->Timer->start(PollMilliseconds);
    return;
  }
  if (view->getViewProxy()->GetNeedsUpdate())
  {
    view->getViewProxy()->Update(); // a portion by itself
    this->Timer->start(0);
    return;
  }
  ++this->Portions;
  if (this->Portions > MostPortions)
  {
    view->forceRender();
  }
  if (this->Portions > MostPortions || this->DrawPortion(view))
  {
    this->Views.removeAll(view);
    this->Portions = 0;
  }
  this->Timer->start(0);
}

//------------------------------------------------------------------------------
bool pqSurfaceDrawing::DrawPortion(pqView* view)
{
  const QPointer<pqView> kept = view; // rendering may process events
  auto* proxy = vtkSMRenderViewProxy::SafeDownCast(view->getViewProxy());
  vtkRenderWindow* window = proxy->GetRenderWindow();
  this->IsInPortion = true;
  window->SwapBuffersOff();
  vtkIsosurfaceMapper::BeginBudget(PortionSeconds);
  proxy->StillRender();
  const bool isWhole = vtkIsosurfaceMapper::EndBudget();
  this->IsInPortion = false;
  if (!kept)
  {
    return true;
  }
  window->SwapBuffersOn();
  if (isWhole)
  {
    vtkLogF(1, "drawn in %d portions", this->Portions);
    window->MakeCurrent();
    window->Frame();
  }
  return isWhole;
}

//------------------------------------------------------------------------------
void pqSurfaceDrawing::Forget()
{
  auto* view = qobject_cast<pqView*>(this->sender());
  if (!this->IsInPortion && view && !FindView(view)->GetUsedLODForLastRender())
  {
    this->Views.removeAll(view);
    this->Portions = 0;
  }
}
