// SPDX-License-Identifier: BSD-3-Clause
#include "pqProgressiveContourBehavior.h"

#include "StateLoading.h"
#include "SurfaceSizeQuestion.h"
#include "WindowCall.h"
#include "pqIndexStatus.h"
#include "pqRefinementStatus.h"
#include "pqSurfaceDrawing.h"

#include "pqApplicationCore.h"
#include "pqCoreUtilities.h"
#include "pqObjectBuilder.h"
#include "pqPipelineSource.h"
#include "pqPropertiesPanel.h"
#include "pqProxyWidget.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"
#include "pqTimeKeeper.h"
#include "pqTimer.h"
#include "pqUndoStack.h"
#include "pqView.h"
#include "vtkIsosurfaceMapper.h"
#include "vtkLogger.h"
#include "vtkPVGeneralSettings.h"
#include "vtkPVRenderView.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSession.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMTrace.h"
#include "vtkSMViewProxy.h"

#include <QDialog>
#include <QEvent>
#include <QGuiApplication>
#include <QMainWindow>
#include <QStatusBar>
#include <QTimer>
#include <QToolBar>
#include <QToolButton>

#include <algorithm>
#include <cstring>
#include <utility>

using isosurface::CallOnServer;
using isosurface::Refinement;
using isosurface::RefinementStage;

namespace
{

const pqServerManagerModel* GetModel()
{
  return pqApplicationCore::instance()->getServerManagerModel();
}

template <typename Fits>
QList<pqPipelineSource*> FindSources(const Fits& fits)
{
  QList<pqPipelineSource*> sources;
  for (pqPipelineSource* source : GetModel()->findItems<pqPipelineSource*>())
  {
    if (fits(source->getProxy()))
    {
      sources.push_back(source);
    }
  }
  return sources;
}

/// Whether what it makes can be coarse (AllowCoarse).
bool CanBeCoarse(vtkSMProxy* proxy)
{
  return isosurface::IsRefined(proxy) || pqIndexStatus::IsReader(proxy);
}

bool IsAnyServerWorking()
{
  const QList<pqServer*> servers = GetModel()->findItems<pqServer*>();
  return std::any_of(servers.begin(), servers.end(),
    [](const pqServer* server) { return server->isProgressPending(); });
}

/// Brings the views that show a contour up to date, and then the contour, if none shows it.
void UpdateBehind(pqPipelineSource* contour)
{
  for (pqView* view : contour->getViews())
  {
    view->getViewProxy()->Update();
  }
  contour->getSourceProxy()->UpdatePipeline(contour->getServer()->getTimeKeeper()->getTime());
}

/// Makes what views show of a surface while the camera moves, which would delay the first frame.
void PrepareDrag(pqPipelineSource* contour)
{
  for (pqView* view : contour->getViews())
  {
    vtkSMProxy* proxy = view->getProxy();
    auto* shown = vtkPVRenderView::SafeDownCast(proxy->GetClientSideObject());
    if (shown && shown->GetUseLODForInteractiveRender())
    {
      isosurface::CallOnServer(proxy, "UpdateLOD");
    }
  }
}

/// Whether a dialog asks where, or how, to save what depends on surfaces.
bool IsSavingDialog(const QDialog* dialog)
{
  const QString name = dialog->objectName();
  if (name.endsWith("Dialog") && name.contains("File") && !name.contains("State") &&
    (name.contains("Save") || name.contains("Export")))
  {
    return true;
  }
  // Extracts have folders of their own, so nobody is asked for a file; their dialog has no name.
  const auto* panel = dialog->findChild<pqProxyWidget*>();
  const char* proxy = panel && panel->proxy() ? panel->proxy()->GetXMLName() : nullptr;
  return proxy && std::strcmp(proxy, "SaveAnimationExtracts") == 0;
}

/// Whether the server of a contour still answers.
bool IsServerAlive(vtkSMProxy* contour)
{
  return contour->GetSession() && contour->GetSession()->GetIsAlive();
}

} // namespace

pqProgressiveContourBehavior::pqProgressiveContourBehavior(QObject* parent)
  : QObject(parent)
  , Timer(new pqTimer(this))
  , Drawing(new pqSurfaceDrawing(this))
{
  this->Timer->setSingleShot(true);
  QObject::connect(this->Timer, &QTimer::timeout, this, &pqProgressiveContourBehavior::Advance);
}

void pqProgressiveContourBehavior::OnStartup()
{
  pqApplicationCore* application = pqApplicationCore::instance();
  QObject::connect(
    GetModel(), &pqServerManagerModel::sourceAdded, this, &pqProgressiveContourBehavior::Observe);
  for (pqPipelineSource* source : GetModel()->findItems<pqPipelineSource*>())
  {
    this->Observe(source);
  }
  QObject::connect(application->getObjectBuilder(), &pqObjectBuilder::filterCreated, this,
    &pqProgressiveContourBehavior::ObserveFirst);
  QObject::connect(application->getObjectBuilder(), &pqObjectBuilder::sourceCreated, this,
    &pqProgressiveContourBehavior::ObserveFirst);
  QObject::connect(application->getObjectBuilder(),
    QOverload<pqPipelineSource*, const QStringList&>::of(&pqObjectBuilder::readerCreated), this,
    &pqProgressiveContourBehavior::ObserveFirst);
  if (pqUndoStack* stack = application->getUndoStack())
  {
    QObject::connect(
      stack, &pqUndoStack::undone, this, &pqProgressiveContourBehavior::RenderByHand);
    QObject::connect(
      stack, &pqUndoStack::redone, this, &pqProgressiveContourBehavior::RenderByHand);
  }
  isosurface::CallWithWindow(this, &pqProgressiveContourBehavior::ObserveWindow);
  QCoreApplication::instance()->installEventFilter(this);
}

void pqProgressiveContourBehavior::OnShutdown()
{
  this->Timer->stop();
  this->Drawing->Stop();
  this->All.clear();
  QCoreApplication::instance()->removeEventFilter(this);
}

void pqProgressiveContourBehavior::ObserveWindow()
{
  auto* window = qobject_cast<QMainWindow*>(pqCoreUtilities::mainWidget());
  if (!window)
  {
    return;
  }
  this->Status = new pqRefinementStatus(window);
  window->statusBar()->insertPermanentWidget(0, this->Status);
  this->Indices = new pqIndexStatus(window);
  window->statusBar()->insertPermanentWidget(0, this->Indices);
  QObject::connect(
    this->Indices, &pqIndexStatus::indexed, this, &pqProgressiveContourBehavior::RenderByHand);
  QObject::connect(
    this->Status, &pqRefinementStatus::stopped, this, &pqProgressiveContourBehavior::Stop);
  // ParaView's own slots are connected already: views are up to date when the last signal comes.
  for (pqPropertiesPanel* panel : window->findChildren<pqPropertiesPanel*>())
  {
    QObject::connect(panel, QOverload<pqProxy*>::of(&pqPropertiesPanel::applied), this,
      &pqProgressiveContourBehavior::BeginByHand);
    QObject::connect(panel, QOverload<>::of(&pqPropertiesPanel::applied), this,
      &pqProgressiveContourBehavior::EndByHand);
  }
  this->ObserveTimeButtons(window);
}

void pqProgressiveContourBehavior::ObserveTimeButtons(QMainWindow* window)
{
  // A button's action, which goes to the time and updates the views, or plays until the end, is
  // triggered between these two signals. The second one also comes if the mouse is let go elsewhere.
  if (const auto* toolbar = window->findChild<QToolBar*>("VCRToolbar"))
  {
    for (QToolButton* button : toolbar->findChildren<QToolButton*>())
    {
      QObject::connect(
        button, &QToolButton::pressed, this, &pqProgressiveContourBehavior::BeginTime);
      QObject::connect(
        button, &QToolButton::released, this, &pqProgressiveContourBehavior::EndTime);
    }
  }
}

bool pqProgressiveContourBehavior::eventFilter(QObject* object, QEvent* event)
{
  if (event->type() == QEvent::Show)
  {
    auto* dialog = qobject_cast<QDialog*>(object);
    if (dialog && IsSavingDialog(dialog))
    {
      QObject::connect(dialog, &QDialog::accepted, this, &pqProgressiveContourBehavior::Finish,
        Qt::UniqueConnection);
    }
  }
  return QObject::eventFilter(object, event);
}

void pqProgressiveContourBehavior::Observe(pqPipelineSource* source)
{
  if (CanBeCoarse(source->getProxy()))
  {
    QObject::connect(source,
      static_cast<void (pqPipelineSource::*)(pqPipelineSource*)>(&pqPipelineSource::dataUpdated),
      this, &pqProgressiveContourBehavior::Watch);
  }
}

//------------------------------------------------------------------------------
// Changes by hand

bool pqProgressiveContourBehavior::IsCoarseFirst() const
{
  return this->Status && this->Status->IsCoarseFirst();
}

void pqProgressiveContourBehavior::AllowCoarse(bool allowed)
{
  const bool coarse = allowed && this->IsCoarseFirst();
  for (pqPipelineSource* source : FindSources(CanBeCoarse))
  {
    CallOnServer(source->getProxy(), "AllowCoarse", coarse ? 1 : 0);
  }
}

void pqProgressiveContourBehavior::ObserveFirst(pqPipelineSource* source)
{
  // No others: until Apply scripts may ask them for their surfaces.
  if (CanBeCoarse(source->getProxy()) && this->IsCoarseFirst())
  {
    CallOnServer(source->getProxy(), "AllowCoarse", 1);
  }
}

void pqProgressiveContourBehavior::BeginByHand()
{
  this->AllowCoarse(true);
}

void pqProgressiveContourBehavior::EndByHand()
{
  this->AllowCoarse(false);
}

void pqProgressiveContourBehavior::BeginTime()
{
  this->ChangingTime = true;
  // Cached surfaces would be saved with an animation.
  this->AllowCoarse(!vtkPVGeneralSettings::GetInstance()->GetCacheGeometryForAnimation());
}

void pqProgressiveContourBehavior::EndTime()
{
  this->ChangingTime = false;
  this->AllowCoarse(false);
}

void pqProgressiveContourBehavior::RenderByHand()
{
  this->AllowCoarse(true);
  for (pqView* view : GetModel()->findItems<pqView*>())
  {
    if (view->getViewProxy()->GetNeedsUpdate())
    {
      view->getViewProxy()->Update();
    }
  }
  this->AllowCoarse(false);
}

//------------------------------------------------------------------------------
// Refinement

void pqProgressiveContourBehavior::Watch(pqPipelineSource* source)
{
  if (!isosurface::IsRefined(source->getProxy()))
  {
    if (this->Indices)
    {
      this->Indices->Watch(source);
    }
    return;
  }
  const auto known = std::find_if(this->All.begin(), this->All.end(),
    [source](const Watched& watched) { return watched.Source == source; });
  if (known == this->All.end())
  {
    this->All.push_back({ source });
  }
  else
  {
    *known = { source }; // a new surface
  }
  this->Timer->start(0);
}

void pqProgressiveContourBehavior::Advance()
{
  if (!this->Status)
  {
    this->All.clear(); // the window is closed
    return;
  }
  if (IsAnyServerWorking() || this->Finishing || this->ChangingTime || this->Drawing->IsDrawing() ||
    isosurface::IsStateLoading())
  {
    this->Timer->start(PollMilliseconds);
    return;
  }
  bool refined = false;
  bool isLarge = false;
  std::vector<Watched> all;
  std::swap(all, this->All);
  for (Watched& watched : all)
  {
    bool keep = false;
    if (watched.Source && this->AdvanceOne(watched, keep))
    {
      refined = true;
      isLarge = isLarge || watched.IsLarge;
    }
    if (keep)
    {
      this->All.push_back(watched);
    }
  }
  const bool isGone = std::all_of(
    all.begin(), all.end(), [](const Watched& watched) { return watched.Source.isNull(); });
  if (!all.empty() && isGone && this->All.empty())
  {
    this->Status->Clear();
  }
  if (refined && isLarge)
  {
    this->Drawing->Begin();
  }
  else if (refined)
  {
    pqApplicationCore::instance()->render();
  }
  if (!this->All.empty())
  {
    const bool areGrowing = std::all_of(
      this->All.begin(), this->All.end(), [](const Watched& watched) { return watched.IsGrowing; });
    this->Timer->start(areGrowing ? GrowthMilliseconds : PollMilliseconds);
  }
}

bool pqProgressiveContourBehavior::AdvanceOne(Watched& watched, bool& keep)
{
  vtkSMProxy* contour = watched.Source->getProxy();
  const int ranks = watched.Source->getServer()->getNumberOfPartitions();
  const int slice = ranks > 1 ? SliceMilliseconds : 0;
  if (!watched.Asked)
  {
    CallOnServer(contour, "PrepareRefinement", slice);
    this->Status->ShowBegin();
    watched.Asked = true;
    keep = true;
    return false;
  }
  const Refinement report = isosurface::ReadRefinement(contour);
  watched.IsGrowing = report.Stage == RefinementStage::Growing;
  watched.HasGrown = watched.HasGrown || watched.IsGrowing;
  switch (report.Stage)
  {
    case RefinementStage::Growing:
      this->FrameGrown(watched.Source);
      this->Status->ShowGrowth(report);
      CallOnServer(contour, "PrepareRefinement", slice);
      keep = true;
      return false;
    case RefinementStage::Working:
      this->Status->ShowRefinement(report);
      CallOnServer(contour, "PrepareRefinement", slice);
      keep = true;
      return false;
    case RefinementStage::Ready:
      keep = QGuiApplication::mouseButtons() != Qt::NoButton || this->IsHandMoving(watched, report);
      if (!keep)
      {
        watched.IsLarge =
          report.Triangles > static_cast<double>(vtkIsosurfaceMapper::TRIANGLES_OF_PORTIONS);
        if (watched.HasGrown)
        {
          this->BoundsBefore[contour->GetGlobalID()] = pqIndexStatus::FindBounds(watched.Source);
        }
        vtkLogF(1, "%s: level %d was shown until the exact result was there",
          contour->GetLogNameOrDefault(), isosurface::ReadLevel(contour));
        contour->InvokeCommand("Refine");
      }
      return !keep;
    case RefinementStage::TooLarge:
      this->AskAboutSize(watched.Source, report);
      return false;
    default:
      if (isosurface::IsFinal(contour))
      {
        vtkLogF(1, "%s: the surface is final", contour->GetLogNameOrDefault());
        this->Status->ShowEnd(isosurface::ReadLevel(contour), false);
        // The level of a sample would say that it is exact.
        this->Status->setVisible(!this->Indices || !this->Indices->isVisible());
        PrepareDrag(watched.Source);
      }
      // Else it was changed since, and is watched again when it has been updated.
      return false;
  }
}

void pqProgressiveContourBehavior::FrameGrown(pqPipelineSource* source)
{
  const auto before = this->BoundsBefore.find(source->getProxy()->GetGlobalID());
  if (before != this->BoundsBefore.end())
  {
    pqIndexStatus::FrameIfLarger(source, before->second);
    this->BoundsBefore.erase(before);
  }
}

bool pqProgressiveContourBehavior::IsHandMoving(Watched& watched, const Refinement& report) const
{
  if (!watched.Ready.isValid())
  {
    watched.Ready.start();
  }
  return report.Triangles > LargeSurface && this->Drawing->IsHandMoving(RestMilliseconds) &&
    !watched.Ready.hasExpired(PatienceMilliseconds);
}

void pqProgressiveContourBehavior::Stop()
{
  for (const Watched& watched : std::exchange(this->All, {}))
  {
    if (watched.Source)
    {
      vtkSMProxy* contour = watched.Source->getProxy();
      CallOnServer(contour, "DropRefinement");
      this->Status->ShowEnd(isosurface::ReadLevel(contour), true);
    }
  }
}

void pqProgressiveContourBehavior::Finish()
{
  vtkLogF(1, "Surfaces are finished before they are saved");
  this->Finishing = true;
  QGuiApplication::setOverrideCursor(Qt::WaitCursor);
  if (this->Indices)
  {
    this->Indices->Finish();
  }
  // An update may process events.
  QList<QPointer<pqPipelineSource>> contours;
  for (pqPipelineSource* source : FindSources(isosurface::IsRefined))
  {
    contours.push_back(source);
  }
  for (const QPointer<pqPipelineSource>& source : contours)
  {
    if (source)
    {
      this->FinishOne(source);
    }
  }
  QGuiApplication::restoreOverrideCursor();
  this->Finishing = false;
  pqApplicationCore::instance()->render();
}

void pqProgressiveContourBehavior::FinishOne(pqPipelineSource* source)
{
  const QPointer<pqPipelineSource> kept = source;
  vtkSMProxy* contour = source->getProxy();
  while (kept && IsServerAlive(contour) && !isosurface::IsFinal(contour))
  {
    CallOnServer(contour, "PrepareRefinement", SliceMilliseconds);
    const Refinement report = isosurface::ReadRefinement(contour);
    if (report.Stage == RefinementStage::Ready)
    {
      contour->InvokeCommand("Refine");
      UpdateBehind(source);
    }
    else if (report.Stage == RefinementStage::TooLarge)
    {
      vtkGenericWarningMacro(
        << qPrintable(source->getSMName()) << ": the surface of level " << report.FinalLevel
        << " does not fit into memory, so level " << report.ShownLevel
        << " is saved. Set 'Level', or save as .eix, which goes block by block.");
      return;
    }
    else if (report.Stage != RefinementStage::Working)
    {
      return; // changed and not applied
    }
  }
}

//------------------------------------------------------------------------------
// Surfaces that are too large

void pqProgressiveContourBehavior::AskAboutSize(pqPipelineSource* source, const Refinement& report)
{
  this->Status->ShowEnd(report.ShownLevel, true);
  // One question at a time, about a contour that is there.
  delete this->Question.data();
  const QPointer<pqPipelineSource> contour = source;
  this->Question = isosurface::AskAboutSurfaceSize(
    source->getSMName(), report,
    [this, contour, level = report.FittingLevel]
    {
      if (contour)
      {
        this->UseLevel(contour, level);
      }
    },
    [this, contour]
    {
      if (contour)
      {
        CallOnServer(contour->getProxy(), "AcceptSize");
        this->Watch(contour);
      }
    });
  QObject::connect(source, &QObject::destroyed, this->Question.data(), &QDialog::close);
}

void pqProgressiveContourBehavior::UseLevel(pqPipelineSource* source, int level)
{
  BEGIN_UNDO_SET(tr("Use Level %1").arg(level));
  {
    SM_SCOPED_TRACE(PropertiesModified).arg("proxy", source->getProxy());
    vtkSMPropertyHelper(source->getProxy(), "Level").Set(level);
    source->getProxy()->UpdateVTKObjects();
  }
  END_UNDO_SET();
  this->RenderByHand();
  pqApplicationCore::instance()->render();
}
