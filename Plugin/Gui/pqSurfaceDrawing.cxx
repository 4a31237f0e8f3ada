// SPDX-License-Identifier: BSD-3-Clause
#include "pqSurfaceDrawing.h"

#include "StateLoading.h"

#include "pqApplicationCore.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"
#include "pqTimer.h"
#include "pqView.h"
#include "vtkCommand.h"
#include "vtkEventQtSlotConnect.h"
#include "vtkIsosurfaceMapper.h"
#include "vtkLogger.h"
#include "vtkPVRenderView.h"
#include "vtkRenderWindow.h"
#include "vtkRenderWindowInteractor.h"
#include "vtkSMRenderViewProxy.h"

#include <QEvent>
#include <QGuiApplication>
#include <QWidget>

#include <utility>

namespace
{

// Whether a view has shown an image. The first one is never held: ParaView 6.1 would show none after it.
constexpr const char* WasDrawn = "IsosurfaceWasDrawn";

const pqServerManagerModel* GetPipelineModel()
{
  return pqApplicationCore::instance()->getServerManagerModel();
}

vtkPVRenderView* FindView(pqView* view)
{
  return vtkPVRenderView::SafeDownCast(view->getProxy()->GetClientSideObject());
}

vtkRenderWindowInteractor* GetInteractor(pqView* view)
{
  auto* proxy = vtkSMRenderViewProxy::SafeDownCast(view->getProxy());
  return proxy ? proxy->GetInteractor() : nullptr;
}

bool IsDrawnHere(pqView* view)
{
  return FindView(view) && !view->getServer()->isRemote() && view->widget() &&
    view->widget()->isVisible();
}

} // namespace

pqSurfaceDrawing::pqSurfaceDrawing(QObject* parent)
  : Superclass(parent)
  , Timer(new pqTimer(this))
{
  this->Timer->setSingleShot(true);
  QObject::connect(this->Timer, &QTimer::timeout, this, &pqSurfaceDrawing::Advance);
  QObject::connect(
    GetPipelineModel(), &pqServerManagerModel::viewAdded, this, &pqSurfaceDrawing::Observe);
  for (pqView* view : GetPipelineModel()->findItems<pqView*>())
  {
    this->Observe(view);
  }
  QCoreApplication::instance()->installEventFilter(this);
}

bool pqSurfaceDrawing::eventFilter(QObject*, QEvent* event)
{
  const QEvent::Type type = event->type();
  if (type == QEvent::MouseMove || type == QEvent::MouseButtonPress || type == QEvent::Wheel ||
    type == QEvent::KeyPress)
  {
    this->SinceHand.start();
  }
  return false;
}

bool pqSurfaceDrawing::IsHandMoving(int milliseconds) const
{
  return this->SinceHand.isValid() && !this->SinceHand.hasExpired(milliseconds);
}

void pqSurfaceDrawing::Observe(pqView* view)
{
  if (FindView(view))
  {
    isosurface::DrawWholeUntilLoaded(view);
    QObject::connect(view, &pqView::representationAdded, this, &pqSurfaceDrawing::ObserveCamera);
    QObject::connect(view, &pqView::endRender, this, &pqSurfaceDrawing::Forget);
  }
}

void pqSurfaceDrawing::ObserveCamera()
{
  vtkRenderWindowInteractor* interactor = GetInteractor(qobject_cast<pqView*>(this->sender()));
  if (interactor)
  {
    this->Connections->Disconnect(interactor);
    for (const unsigned long event : { vtkCommand::StartInteractionEvent,
           vtkCommand::EndInteractionEvent, vtkCommand::RenderEvent })
    {
      this->Connections->Connect(
        interactor, event, this, SLOT(HoldImage(vtkObject*, unsigned long)), nullptr, 1.0F);
      this->Connections->Connect(
        interactor, event, this, SLOT(DrawHeldImage(vtkObject*, unsigned long)), nullptr, -1.0F);
    }
  }
}

void pqSurfaceDrawing::HoldImage(vtkObject* interactor, unsigned long event)
{
  if (event != vtkCommand::RenderEvent)
  {
    this->IsTurning = event == vtkCommand::StartInteractionEvent;
  }
  if (this->IsTurning)
  {
    return; // its images are of thinned surfaces
  }
  for (pqView* view : GetPipelineModel()->findItems<pqView*>())
  {
    if (view->property(WasDrawn).toBool() && IsDrawnHere(view) &&
      GetInteractor(view) == interactor && FindView(view)->GetUseLODForInteractiveRender())
    {
      FindView(view)->SuppressRenderingOn();
      this->Held = view;
      this->IsImageHeld = false;
      // Whatever another observer does, the view draws again.
      QTimer::singleShot(0, this, [this, event] { this->DrawHeldImage(nullptr, event); });
    }
  }
}

void pqSurfaceDrawing::DrawHeldImage(vtkObject*, unsigned long event)
{
  const QPointer<pqView> view = std::exchange(this->Held, nullptr);
  if (!view)
  {
    return;
  }
  FindView(view)->SuppressRenderingOff();
  if (this->IsImageHeld)
  {
    // A hand that has dragged the camera sees where it is; one at the wheel does not.
    if (event == vtkCommand::RenderEvent)
    {
      view->getViewProxy()->InteractiveRender();
    }
    this->Add(view, RestMilliseconds);
  }
}

void pqSurfaceDrawing::Begin()
{
  for (pqView* view : GetPipelineModel()->findItems<pqView*>())
  {
    if (!this->Add(view))
    {
      view->render();
    }
  }
}

bool pqSurfaceDrawing::Add(pqView* view, int milliseconds)
{
  if (!IsDrawnHere(view))
  {
    return false;
  }
  this->Views.removeAll(view);
  this->Views.push_back(view);
  this->Portions = 0;
  this->Timer->start(milliseconds);
  return true;
}

void pqSurfaceDrawing::Stop()
{
  this->Timer->stop();
  this->Views.clear();
}

void pqSurfaceDrawing::Advance()
{
  this->Views.removeAll(nullptr);
  if (this->Views.empty())
  {
    return;
  }
  pqView* view = this->Views.front();
  if (QGuiApplication::mouseButtons() != Qt::NoButton || view->getServer()->isProgressPending() ||
    isosurface::IsStateLoading())
  {
    this->Timer->start(PollMilliseconds);
    return;
  }
  if (view->getViewProxy()->GetNeedsUpdate())
  {
    const bool isHandMoving = this->IsHandMoving();
    view->getViewProxy()->Update(); // a portion by itself
    if (isHandMoving)
    {
      this->SinceHand.start(); // what it did meanwhile is not known yet
    }
    this->Timer->start(isHandMoving ? PauseMilliseconds : 0);
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
  this->Timer->start(this->IsHandMoving() ? PauseMilliseconds : 0);
}

bool pqSurfaceDrawing::DrawPortion(pqView* view)
{
  const QPointer<pqView> kept = view; // rendering may process events
  auto* proxy = vtkSMRenderViewProxy::SafeDownCast(view->getViewProxy());
  vtkRenderWindow* window = proxy->GetRenderWindow();
  this->IsInPortion = true;
  window->SwapBuffersOff();
  vtkIsosurfaceMapper::BeginBudget(
    this->IsHandMoving() ? MovingPortionSeconds : RestingPortionSeconds);
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

void pqSurfaceDrawing::Forget()
{
  auto* view = qobject_cast<pqView*>(this->sender());
  if (this->IsInPortion || !view || FindView(view)->GetUsedLODForLastRender())
  {
    return;
  }
  if (view == this->Held)
  {
    this->IsImageHeld = true;
    return;
  }
  view->setProperty(WasDrawn, true);
  this->Views.removeAll(view);
  this->Portions = 0;
}
