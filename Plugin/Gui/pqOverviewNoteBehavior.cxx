// SPDX-License-Identifier: BSD-3-Clause
#include "pqOverviewNoteBehavior.h"

#include "pqBlockedVolumeDecorator.h"

#include "pqActiveObjects.h"
#include "pqApplicationCore.h"
#include "pqCoreUtilities.h"
#include "pqPipelineFilter.h"
#include "pqPropertiesPanel.h"
#include "pqServerManagerModel.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"

#include <QBoxLayout>
#include <QLabel>

#include <algorithm>
#include <cstring>
#include <iterator>

namespace
{

/// Those that take the volume's blocks, not the reader's output.
const char* const OwnFilters[] = { "Isosurface", "StabbingContour", "ContourSpectrum",
  "VolumeSlice", "VolumeRegion", "VolumeProbe" };

bool IsNamed(const pqPipelineSource* source, const char* name)
{
  return std::strcmp(source->getProxy()->GetXMLName(), name) == 0;
}

/// What a filter has got of a blocked volume, if that is a coarse level; else nothing.
QString FindShown(pqPipelineSource* source)
{
  const auto* filter = qobject_cast<pqPipelineFilter*>(source);
  const pqPipelineSource* reader =
    filter && filter->getInputCount() > 0 ? filter->getInput(0) : nullptr;
  if (!reader || !pqBlockedVolumeDecorator::IsReader(reader->getProxy()) ||
    std::any_of(std::begin(OwnFilters), std::end(OwnFilters),
      [filter](const char* name) { return IsNamed(filter, name); }))
  {
    return QString();
  }
  vtkSMProxy* proxy = reader->getProxy();
  proxy->UpdatePropertyInformation(proxy->GetProperty("Shown"));
  const QString shown = vtkSMPropertyHelper(proxy, "Shown").GetAsString();
  return shown.startsWith("level") ? shown : QString();
}

} // namespace

void pqOverviewNoteBehavior::OnStartup()
{
  QObject::connect(
    &pqActiveObjects::instance(), SIGNAL(sourceChanged(pqPipelineSource*)), this, SLOT(Update()));
  QObject::connect(pqApplicationCore::instance()->getServerManagerModel(),
    SIGNAL(dataUpdated(pqPipelineSource*)), this, SLOT(Update()));
}

QLabel* pqOverviewNoteBehavior::FindLine()
{
  const QWidget* window = pqCoreUtilities::mainWidget();
  auto* panel = window ? window->findChild<pqPropertiesPanel*>() : nullptr;
  auto* column = panel ? qobject_cast<QBoxLayout*>(panel->layout()) : nullptr;
  if (!this->Line && column)
  {
    this->Line = new QLabel(panel);
    this->Line->setObjectName("OverviewNote");
    this->Line->setWordWrap(true);
    column->insertWidget(column->count() - 1, this->Line);
  }
  return this->Line;
}

void pqOverviewNoteBehavior::Update()
{
  if (QLabel* line = this->FindLine())
  {
    const QString shown = FindShown(pqActiveObjects::instance().activeSource());
    line->setVisible(!shown.isEmpty());
    line->setText(shown.isEmpty()
        ? QString()
        : tr("The input is %1. Isosurface takes the volume itself.").arg(shown));
  }
}
