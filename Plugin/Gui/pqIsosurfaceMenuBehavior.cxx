// SPDX-License-Identifier: BSD-3-Clause
#include "pqIsosurfaceMenuBehavior.h"

#include "SpectrumCurve.h"

#include "pqApplicationCore.h"
#include "pqCoreUtilities.h"
#include "pqDataRepresentation.h"
#include "pqServerManagerModel.h"
#include "pqView.h"
#include "vtkCommand.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSourceProxy.h"

#include <QMainWindow>
#include <QTimer>
#include <QToolBar>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

namespace
{

constexpr std::size_t Triangles = 1; ///< in a row
constexpr double Decades = 100;      ///< more than this between the ends: a logarithmic axis
constexpr double Headroom = 1.3;     ///< of the axis above the maximum

/// The minimum (above 0) and the maximum number of triangles over all isovalues; 0, 0 if no
/// isovalue has any.
std::pair<double, double> FindTriangleRange(vtkSMSourceProxy* spectrum)
{
  spectrum->UpdatePropertyInformation(spectrum->GetProperty("Spectrum"));
  const std::vector<double> rows = vtkSMPropertyHelper(spectrum, "Spectrum").GetDoubleArray();
  std::pair<double, double> range(0, 0);
  for (std::size_t at = Triangles; at < rows.size(); at += isosurface::SpectrumCurve::RowLength)
  {
    if (rows[at] > 0)
    {
      range.first = range.first > 0 ? std::min(range.first, rows[at]) : rows[at];
      range.second = std::max(range.second, rows[at]);
    }
  }
  return range;
}

bool IsOfSpectrum(const pqDataRepresentation* representation)
{
  return representation &&
    std::strcmp(representation->getProxy()->GetXMLName(), "ContourSpectrumRepresentation") == 0;
}

/// Gives the left axis a range without 0, which no logarithmic axis can have.
void SetRange(vtkSMProxy* view, const std::pair<double, double>& triangles)
{
  vtkSMPropertyHelper(view, "LeftAxisUseCustomRange").Set(1);
  vtkSMPropertyHelper(view, "LeftAxisRangeMinimum").Set(triangles.first);
  vtkSMPropertyHelper(view, "LeftAxisRangeMaximum").Set(triangles.second * Headroom);
}

} // namespace

void pqIsosurfaceMenuBehavior::OnStartup()
{
  const pqServerManagerModel* model = pqApplicationCore::instance()->getServerManagerModel();
  QObject::connect(
    model, &pqServerManagerModel::viewAdded, this, &pqIsosurfaceMenuBehavior::ObserveView);
  QObject::connect(pqApplicationCore::instance(), &pqApplicationCore::clientEnvironmentDone, this,
    &pqIsosurfaceMenuBehavior::MoveToolBar);
}

void pqIsosurfaceMenuBehavior::MoveToolBar()
{
  auto* window = qobject_cast<QMainWindow*>(pqCoreUtilities::mainWidget());
  if (auto* bar = window ? window->findChild<QToolBar*>("Scalable Isosurface") : nullptr)
  {
    window->addToolBar(bar);
  }
}

void pqIsosurfaceMenuBehavior::ObserveView(pqView* view)
{
  if (std::strcmp(view->getProxy()->GetXMLName(), "XYChartView") == 0)
  {
    QObject::connect(
      view, &pqView::representationAdded, this, &pqIsosurfaceMenuBehavior::ArrangeChart);
  }
}

void pqIsosurfaceMenuBehavior::ArrangeChart(pqRepresentation* representation)
{
  auto* shown = qobject_cast<pqDataRepresentation*>(representation);
  if (!IsOfSpectrum(shown))
  {
    return;
  }
  vtkSMProxy* view = shown->getView() ? shown->getView()->getProxy() : nullptr;
  auto* spectrum =
    vtkSMSourceProxy::SafeDownCast(vtkSMPropertyHelper(shown->getProxy(), "Input").GetAsProxy());
  // A chart that somebody has given a title is left alone.
  if (!view || !spectrum || !view->GetProperty("LeftAxisLogScale") ||
    *vtkSMPropertyHelper(view, "LeftAxisTitle").GetAsString() != '\0')
  {
    return;
  }
  vtkSMPropertyHelper visible(shown->getProxy(), "SeriesVisibility");
  for (unsigned int series = 0; series < visible.GetNumberOfElements(); series += 2)
  {
    const bool isTriangles = std::strcmp(visible.GetAsString(series), "Triangles") == 0;
    visible.Set(series + 1, isTriangles ? "1" : "0");
  }
  shown->getProxy()->UpdateVTKObjects();

  const char* array =
    vtkSMPropertyHelper(spectrum, "SelectInputScalars").GetInputArrayNameToProcess();
  vtkSMPropertyHelper(view, "LeftAxisTitle").Set("Triangles");
  vtkSMPropertyHelper(view, "BottomAxisTitle").Set(array && *array ? array : "Isovalue");
  const std::pair<double, double> triangles = FindTriangleRange(spectrum);
  if (triangles.second > Decades * triangles.first)
  {
    vtkSMPropertyHelper(view, "LeftAxisLogScale").Set(1);
    SetRange(view, triangles);
    // Resetting the view, as the first Apply does, takes the range from the data.
    pqCoreUtilities::connect(view->GetProperty("LeftAxisUseCustomRange"), vtkCommand::ModifiedEvent,
      this, SLOT(ExpectReset()));
  }
  view->UpdateVTKObjects();
}

void pqIsosurfaceMenuBehavior::ExpectReset()
{
  QTimer::singleShot(0, this, &pqIsosurfaceMenuBehavior::KeepRanges);
}

void pqIsosurfaceMenuBehavior::KeepRanges()
{
  const pqServerManagerModel* model = pqApplicationCore::instance()->getServerManagerModel();
  for (pqDataRepresentation* shown : model->findItems<pqDataRepresentation*>())
  {
    vtkSMProxy* view = shown->getView() ? shown->getView()->getProxy() : nullptr;
    if (!view || !IsOfSpectrum(shown) ||
      vtkSMPropertyHelper(view, "LeftAxisLogScale").GetAsInt() == 0 ||
      vtkSMPropertyHelper(view, "LeftAxisUseCustomRange").GetAsInt() != 0)
    {
      continue;
    }
    auto* spectrum =
      vtkSMSourceProxy::SafeDownCast(vtkSMPropertyHelper(shown->getProxy(), "Input").GetAsProxy());
    const std::pair<double, double> triangles = FindTriangleRange(spectrum);
    if (triangles.second > 0)
    {
      SetRange(view, triangles);
      view->UpdateVTKObjects();
      shown->renderViewEventually();
    }
  }
}
