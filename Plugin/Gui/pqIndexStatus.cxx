// SPDX-License-Identifier: BSD-3-Clause
#include "pqIndexStatus.h"

#include "ContourProxy.h"
#include "CountWords.h"

#include "pqPipelineSource.h"
#include "pqServer.h"
#include "pqTimer.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSession.h"
#include "vtkSMSourceProxy.h"

#include <QAction>
#include <QMenu>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

using isosurface::CallOnServer;

namespace
{

/// vtkInPlaceVolumeReader's Indexing, as its documentation says.
struct IndexReport
{
  enum Stages
  {
    Nothing,
    Working,
    Ready,
    Failed
  };
  int Stage = Nothing;
  double Share = 0;
  double Seconds = -1;
};

IndexReport ReadReport(vtkSMProxy* reader)
{
  reader->UpdatePropertyInformation(reader->GetProperty("Indexing"));
  const std::vector<double> values = vtkSMPropertyHelper(reader, "Indexing").GetDoubleArray();
  IndexReport report;
  if (values.size() == 3)
  {
    report.Stage = static_cast<int>(values[0]);
    report.Share = values[1];
    report.Seconds = values[2];
  }
  return report;
}

} // namespace

//------------------------------------------------------------------------------
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
  QObject::connect(stop, &QAction::triggered, this, &pqIndexStatus::Stop);
  auto* menu = new QMenu(this);
  menu->setObjectName("Menu");
  menu->addAction(stop);
  this->setMenu(menu);
  this->hide();
  this->Timer->setSingleShot(true);
  QObject::connect(this->Timer, &QTimer::timeout, this, &pqIndexStatus::Advance);
}

//------------------------------------------------------------------------------
pqIndexStatus::~pqIndexStatus() = default;

//------------------------------------------------------------------------------
bool pqIndexStatus::IsReader(vtkSMProxy* proxy)
{
  return proxy && proxy->GetXMLName() &&
    std::strcmp(proxy->GetXMLName(), "InPlaceVolumeReader") == 0;
}

//------------------------------------------------------------------------------
void pqIndexStatus::Watch(pqPipelineSource* source)
{
  const bool isKnown =
    std::find(this->Readers.begin(), this->Readers.end(), source) != this->Readers.end();
  if (IsReader(source->getProxy()) && !isKnown &&
    ReadReport(source->getProxy()).Stage == IndexReport::Working)
  {
    this->Readers.emplace_back(source);
    this->Timer->start(0);
  }
}

//------------------------------------------------------------------------------
void pqIndexStatus::Advance()
{
  bool isIndexed = false;
  int wait = PollMilliseconds;
  std::vector<QPointer<pqPipelineSource>> readers;
  std::swap(readers, this->Readers);
  for (const QPointer<pqPipelineSource>& reader : readers)
  {
    if (reader && (reader->getServer()->isProgressPending() || this->AdvanceOne(reader, isIndexed)))
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
  if (isIndexed)
  {
    Q_EMIT this->indexed();
  }
}

//------------------------------------------------------------------------------
bool pqIndexStatus::AdvanceOne(pqPipelineSource* source, bool& isIndexed)
{
  vtkSMProxy* reader = source->getProxy();
  const bool isAlone = source->getServer()->getNumberOfPartitions() == 1;
  CallOnServer(reader, "AdvanceIndex", isAlone ? 0 : SliceMilliseconds);
  const IndexReport report = ReadReport(reader);
  if (report.Stage == IndexReport::Ready)
  {
    reader->InvokeCommand("TakeIndex");
    isIndexed = true;
  }
  const QString left = report.Seconds < 0
    ? QString()
    : tr(", %1 left").arg(isosurface::FormatSeconds(std::max(1.0, std::round(report.Seconds))));
  this->setText(tr("Sample of %1 shown, indexing: %2 %%3")
                  .arg(source->getSMName())
                  .arg(std::floor(100 * report.Share))
                  .arg(left));
  return report.Stage == IndexReport::Working;
}

//------------------------------------------------------------------------------
void pqIndexStatus::Finish()
{
  bool isIndexed = false;
  for (const QPointer<pqPipelineSource>& reader : std::exchange(this->Readers, {}))
  {
    while (reader && reader->getProxy()->GetSession()->GetIsAlive() &&
      this->AdvanceOne(reader, isIndexed))
    {
      CallOnServer(reader->getProxy(), "AdvanceIndex", SliceMilliseconds);
    }
  }
  this->hide();
  if (isIndexed)
  {
    Q_EMIT this->indexed();
  }
}

//------------------------------------------------------------------------------
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
