// SPDX-License-Identifier: BSD-3-Clause
#include "pqIndexStatus.h"

#include "ContourProxy.h"
#include "CountWords.h"
#include "StateLoading.h"

#include "pqActiveObjects.h"
#include "pqPipelineSource.h"
#include "pqServer.h"
#include "pqTimeKeeper.h"
#include "pqTimer.h"
#include "pqView.h"
#include "vtkBoundingBox.h"
#include "vtkCamera.h"
#include "vtkMath.h"
#include "vtkPVDataInformation.h"
#include "vtkSMRenderViewProxy.h"
#include "vtkSMSession.h"
#include "vtkSMSourceProxy.h"

#include <QAction>
#include <QGuiApplication>
#include <QMenu>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

using isosurface::CallOnServer;
using isosurface::RefinementStage;

pqIndexStatus::pqIndexStatus(QWidget* parent)
  : Superclass(parent)
  , Timer(new pqTimer(this))
{
  this->setObjectName("IndexStatus");
  this->setAutoRaise(true);
  this->setPopupMode(QToolButton::InstantPopup);
  this->setToolButtonStyle(Qt::ToolButtonTextOnly);
  this->setToolTip(tr("A sample of the file is shown. What is shown will be exact when the file is "
                      "indexed."));
  auto* stop = new QAction(tr("Stop indexing"), this);
  stop->setObjectName("StopIndexing");
  stop->setToolTip(tr("The next Apply goes on where it stopped."));
  QObject::connect(stop, &QAction::triggered, this, &pqIndexStatus::Stop);
  auto* menu = new QMenu(this);
  menu->setToolTipsVisible(true);
  menu->setObjectName("Menu");
  menu->addAction(stop);
  this->setMenu(menu);
  this->hide();
  this->Timer->setSingleShot(true);
  QObject::connect(this->Timer, &QTimer::timeout, this, &pqIndexStatus::Advance);
}

bool pqIndexStatus::IsReader(vtkSMProxy* proxy)
{
  return proxy && proxy->GetVTKClassName() &&
    std::strcmp(proxy->GetVTKClassName(), "vtkInPlaceVolumeReader") == 0;
}

vtkBoundingBox pqIndexStatus::FindBounds(pqPipelineSource* source)
{
  double bounds[6];
  source->getSourceProxy()->GetDataInformation(0)->GetBounds(bounds);
  return vtkBoundingBox(bounds);
}

void pqIndexStatus::FrameIfLarger(pqPipelineSource* source, const vtkBoundingBox& before)
{
  const auto measure = [](const vtkBoundingBox& bounds)
  { return bounds.IsValid() ? bounds.GetDiagonalLength() : 0; };
  // The last slice of a sample may be a little before that of the volume.
  if (measure(FindBounds(source)) > 1.1 * measure(before))
  {
    for (pqView* view : source->getViews())
    {
      view->resetDisplay();
    }
  }
}

void pqIndexStatus::Watch(pqPipelineSource* source)
{
  const bool isKnown =
    std::find(this->Readers.begin(), this->Readers.end(), source) != this->Readers.end();
  if (IsReader(source->getProxy()) && !isKnown &&
    isosurface::ReadRefinement(source->getProxy()).Stage == RefinementStage::Working)
  {
    this->Readers.emplace_back(source);
    this->Timer->start(0);
  }
}

void pqIndexStatus::Advance()
{
  Sources changed;
  int wait = PollMilliseconds;
  Sources readers;
  std::swap(readers, this->Readers);
  for (const QPointer<pqPipelineSource>& reader : readers)
  {
    if (reader &&
      (reader->getServer()->isProgressPending() || isosurface::IsStateLoading() ||
        this->AdvanceOne(reader, changed)))
    {
      wait = reader->getServer()->getNumberOfPartitions() > 1 ? PollRanksMilliseconds : wait;
      this->Readers.push_back(reader);
    }
  }
  this->setVisible(!this->Readers.empty());
  if (!this->Readers.empty())
  {
    this->Timer->start(wait);
  }
  this->Update(changed);
}

void pqIndexStatus::Update(const Sources& changed)
{
  std::vector<vtkBoundingBox> before;
  for (const QPointer<pqPipelineSource>& reader : changed)
  {
    before.push_back(reader ? FindBounds(reader) : vtkBoundingBox());
  }
  if (!changed.empty())
  {
    Q_EMIT this->indexed();
  }
  for (std::size_t number = 0; number < changed.size(); ++number)
  {
    if (const QPointer<pqPipelineSource>& reader = changed[number])
    {
      FrameIfLarger(reader, before[number]);
    }
  }
}

std::vector<double> pqIndexStatus::FindSight()
{
  pqView* active = pqActiveObjects::instance().activeView();
  auto* view = vtkSMRenderViewProxy::SafeDownCast(active ? active->getProxy() : nullptr);
  vtkCamera* camera = view ? view->GetActiveCamera() : nullptr;
  if (!camera)
  {
    return {};
  }
  const QSize size = active->getSize();
  const double wide = std::max(1.0, size.height() > 0 ? 1.0 * size.width() / size.height() : 1.0);
  std::vector<double> sight(8);
  camera->GetPosition(sight.data());
  camera->GetDirectionOfProjection(sight.data() + 3);
  const bool isParallel = camera->GetParallelProjection() != 0;
  sight[6] = isParallel ? wide * camera->GetParallelScale() : 0;
  sight[7] =
    isParallel ? 0 : wide * std::tan(vtkMath::RadiansFromDegrees(camera->GetViewAngle() / 2));
  if (sight != this->Seen || QGuiApplication::mouseButtons() != Qt::NoButton)
  {
    this->Seen = sight;
    this->SinceSeen.start();
  }
  return this->SinceSeen.hasExpired(RestMilliseconds) ? sight : std::vector<double>();
}

bool pqIndexStatus::AdvanceOne(pqPipelineSource* source, Sources& changed)
{
  vtkSMProxy* reader = source->getProxy();
  const std::vector<double> sight = this->FindSight();
  std::vector<double>& told = this->Told[reader->GetGlobalID()];
  if (!sight.empty() && sight != told)
  {
    told = sight;
    CallOnServer(reader, "LookAlong", sight);
  }
  const bool isAlone = source->getServer()->getNumberOfPartitions() == 1;
  CallOnServer(reader, "AdvanceIndex", isAlone ? 0 : SliceMilliseconds);
  const isosurface::Refinement report = isosurface::ReadRefinement(reader);
  if (report.Stage == RefinementStage::Ready)
  {
    reader->InvokeCommand("TakeIndex");
    changed.emplace_back(source);
  }
  const QString left = report.Seconds < 0
    ? QString()
    : tr(", %1 left").arg(isosurface::FormatSeconds(std::max(1.0, std::round(report.Seconds))));
  const QString fetched = report.Bytes > 0
    ? tr(", %1 fetched").arg(isosurface::FormatBytes(report.Bytes)) +
      (report.FreeBytes > 0 ? tr(" of at most %1").arg(isosurface::FormatBytes(report.FreeBytes))
                            : QString())
    : QString();
  this->setText(report.Share < 0
      ? tr("Sample of %1 shown, exact where you look%2").arg(source->getSMName()).arg(fetched)
      : tr("Sample of %1 shown, indexing: %2 %%3%4")
          .arg(source->getSMName())
          .arg(std::floor(100 * report.Share))
          .arg(left)
          .arg(fetched));
  return report.Stage == RefinementStage::Working;
}

void pqIndexStatus::Finish()
{
  Sources finished;
  for (const QPointer<pqPipelineSource>& reader : std::exchange(this->Readers, {}))
  {
    if (reader && reader->getProxy()->GetSession()->GetIsAlive())
    {
      // Since it may not be coarse now, its update waits.
      reader->getProxy()->InvokeCommand("TakeIndex");
      reader->getSourceProxy()->UpdatePipeline(reader->getServer()->getTimeKeeper()->getTime());
      finished.push_back(reader);
    }
  }
  this->hide();
  this->Update(finished);
}

void pqIndexStatus::Stop()
{
  for (const QPointer<pqPipelineSource>& reader : this->Readers)
  {
    if (reader)
    {
      CallOnServer(reader->getProxy(), "StopIndex");
    }
  }
}
