// SPDX-License-Identifier: BSD-3-Clause
#include "pqOverviewNoteBehavior.h"

#include "pqApplicationCore.h"
#include "pqCoreUtilities.h"
#include "pqPipelineFilter.h"
#include "pqServerManagerModel.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"

#include <QMainWindow>
#include <QStatusBar>

#include <algorithm>
#include <cstring>
#include <iterator>

namespace
{

constexpr int NoteMilliseconds = 20000;

/// Those that take the volume's blocks, not the reader's output.
const char* const OwnFilters[] = { "StabbingContour", "ContourSpectrum" };

bool IsNamed(const pqPipelineSource* source, const char* name)
{
  return std::strcmp(source->getProxy()->GetXMLName(), name) == 0;
}

} // namespace

//------------------------------------------------------------------------------
pqOverviewNoteBehavior::pqOverviewNoteBehavior(QObject* parent)
  : QObject(parent)
{
}

//------------------------------------------------------------------------------
pqOverviewNoteBehavior::~pqOverviewNoteBehavior() = default;

//------------------------------------------------------------------------------
void pqOverviewNoteBehavior::OnStartup()
{
  QObject::connect(pqApplicationCore::instance()->getServerManagerModel(),
    QOverload<pqPipelineSource*, pqPipelineSource*, int>::of(
      &pqServerManagerModel::connectionAdded),
    this, &pqOverviewNoteBehavior::Observe);
}

//------------------------------------------------------------------------------
void pqOverviewNoteBehavior::Observe(pqPipelineSource* reader, pqPipelineSource* filter)
{
  if (!IsNamed(reader, "BlockedVolumeReader") ||
    std::any_of(std::begin(OwnFilters), std::end(OwnFilters),
      [filter](const char* name) { return IsNamed(filter, name); }))
  {
    return;
  }
  QObject::connect(filter,
    static_cast<void (pqPipelineSource::*)(pqPipelineSource*)>(&pqPipelineSource::dataUpdated),
    this, &pqOverviewNoteBehavior::Tell, Qt::UniqueConnection);
}

//------------------------------------------------------------------------------
void pqOverviewNoteBehavior::Tell(pqPipelineSource* source)
{
  // Once: what the reader shows hardly changes.
  QObject::disconnect(source, nullptr, this, nullptr);
  const auto* filter = qobject_cast<pqPipelineFilter*>(source);
  pqPipelineSource* reader = filter && filter->getInputCount() > 0 ? filter->getInput(0) : nullptr;
  auto* window = qobject_cast<QMainWindow*>(pqCoreUtilities::mainWidget());
  if (!reader || !IsNamed(reader, "BlockedVolumeReader") || !window)
  {
    return;
  }
  vtkSMProxy* proxy = reader->getProxy();
  proxy->UpdatePropertyInformation(proxy->GetProperty("Shown"));
  const QString shown = vtkSMPropertyHelper(proxy, "Shown").GetAsString();
  if (shown.startsWith("level"))
  {
    window->statusBar()->showMessage(
      tr("%1 has got %2 samples. Isosurface (Stabbing Contour) takes the volume itself.")
        .arg(source->getSMName(), shown),
      NoteMilliseconds);
  }
}
