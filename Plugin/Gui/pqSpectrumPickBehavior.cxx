// SPDX-License-Identifier: BSD-3-Clause
#include "pqSpectrumPickBehavior.h"

#include "ContourProxy.h"
#include "PickedRows.h"
#include "SpectrumCurve.h"
#include "ValueAxis.h"
#include "pqSpectrumSource.h"

#include "pqActiveObjects.h"
#include "pqApplicationCore.h"
#include "pqContextView.h"
#include "pqCoreUtilities.h"
#include "pqDataRepresentation.h"
#include "pqOutputPort.h"
#include "pqPipelineSource.h"
#include "pqServerManagerModel.h"
#include "pqUndoStack.h"
#include "vtkAxis.h"
#include "vtkChartXY.h"
#include "vtkCommand.h"
#include "vtkContextView.h"
#include "vtkRenderWindowInteractor.h"
#include "vtkSMContextViewProxy.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMTrace.h"
#include "vtkSMVectorProperty.h"

#include <QMainWindow>
#include <QStatusBar>

#include <cstring>
#include <vector>

namespace
{

bool IsSource(const pqPipelineSource* source, const char* name)
{
  return std::strcmp(source->getProxy()->GetXMLName(), name) == 0;
}

/// Whether a contour and a spectrum are of the same input, array and component.
bool AreOfTheSame(vtkSMProxy* contour, vtkSMProxy* spectrum)
{
  vtkSMPropertyHelper ours(contour, "Input");
  vtkSMPropertyHelper theirs(spectrum, "Input");
  const char* ourArray =
    vtkSMPropertyHelper(contour, "SelectInputScalars").GetInputArrayNameToProcess();
  const char* theirArray =
    vtkSMPropertyHelper(spectrum, "SelectInputScalars").GetInputArrayNameToProcess();
  return ours.GetAsProxy() == theirs.GetAsProxy() &&
    ours.GetOutputPort() == theirs.GetOutputPort() && ourArray && theirArray &&
    std::strcmp(ourArray, theirArray) == 0 &&
    vtkSMPropertyHelper(contour, "Component").GetAsInt() ==
    vtkSMPropertyHelper(spectrum, "Component").GetAsInt();
}

/// The contour whose isovalues are picked; null if there is none.
pqPipelineSource* FindContour(vtkSMProxy* spectrum)
{
  const pqServerManagerModel* model = pqApplicationCore::instance()->getServerManagerModel();
  const pqPipelineSource* active = pqActiveObjects::instance().activeSource();
  pqPipelineSource* found = nullptr;
  for (pqPipelineSource* source : model->findItems<pqPipelineSource*>())
  {
    if (isosurface::IsStabbingContour(source->getProxy()) &&
      AreOfTheSame(source->getProxy(), spectrum))
    {
      found = source;
      if (source == active)
      {
        break;
      }
    }
  }
  return found;
}

/// The rows of a table that a selection has, in any order.
std::vector<std::size_t> FindRows(vtkSMSourceProxy* selection)
{
  std::vector<std::size_t> rows;
  vtkSMPropertyHelper parts(selection, "Input");
  for (unsigned int part = 0; part < parts.GetNumberOfElements(); ++part)
  {
    vtkSMProxy* source = parts.GetAsProxy(part);
    auto* ids = vtkSMVectorProperty::SafeDownCast(source ? source->GetProperty("IDs") : nullptr);
    if (!ids)
    {
      continue;
    }
    // Of each tuple the last number is the row; before it stand process and block.
    const unsigned int length = ids->GetNumberOfElementsPerCommand();
    const std::vector<vtkIdType> tuples = vtkSMPropertyHelper(ids).GetIdTypeArray();
    for (std::size_t last = length - 1; last < tuples.size(); last += length)
    {
      rows.push_back(static_cast<std::size_t>(tuples[last]));
    }
  }
  return rows;
}

/// The isovalue at a place of a chart, in pixels from its low left corner, with as many digits as
/// pixels can tell apart; false beside the plot.
bool FindIsovalue(vtkChartXY* chart, const int place[2], bool integers, double& isovalue)
{
  vtkAxis* axis = chart->GetAxis(vtkAxis::BOTTOM);
  const double left = axis->GetPoint1()[0];
  const double right = axis->GetPoint2()[0];
  const double bottom = axis->GetPoint1()[1];
  const double top = chart->GetAxis(vtkAxis::LEFT)->GetPoint2()[1];
  if (place[0] < left || place[0] > right || place[1] < bottom || place[1] > top || left >= right)
  {
    return false;
  }
  isosurface::ValueAxis values;
  values.SetRange(axis->GetMinimum(), axis->GetMaximum(), integers);
  values.SetPixels(left, right - left);
  isovalue = values.Snap(values.ToValue(place[0]));
  return true;
}

/// The spectrum that a view shows; null if there is none.
vtkSMSourceProxy* FindSpectrum(pqView* view)
{
  for (pqRepresentation* representation : view->getRepresentations())
  {
    auto* shown = qobject_cast<pqDataRepresentation*>(representation);
    if (shown && shown->isVisible() && shown->getInput() &&
      IsSource(shown->getInput(), "ContourSpectrum"))
    {
      return vtkSMSourceProxy::SafeDownCast(shown->getInput()->getProxy());
    }
  }
  return nullptr;
}

void Tell(const QString& words)
{
  if (auto* window = qobject_cast<QMainWindow*>(pqCoreUtilities::mainWidget()))
  {
    window->statusBar()->showMessage(words, 5000);
  }
}

} // namespace

void pqSpectrumPickBehavior::OnStartup()
{
  pqServerManagerModel* model = pqApplicationCore::instance()->getServerManagerModel();
  QObject::connect(
    model, &pqServerManagerModel::sourceAdded, this, &pqSpectrumPickBehavior::Observe);
  for (pqPipelineSource* source : model->findItems<pqPipelineSource*>())
  {
    this->Observe(source);
  }
  QObject::connect(
    model, &pqServerManagerModel::viewAdded, this, &pqSpectrumPickBehavior::ObserveView);
}

void pqSpectrumPickBehavior::Observe(pqPipelineSource* source)
{
  if (IsSource(source, "ContourSpectrum"))
  {
    QObject::connect(
      source, &pqPipelineSource::selectionChanged, this, &pqSpectrumPickBehavior::Pick);
  }
}

void pqSpectrumPickBehavior::Pick(pqOutputPort* port)
{
  vtkSMSourceProxy* selection = port->getSelectionInput();
  if (!selection)
  {
    return;
  }
  auto* spectrum = vtkSMSourceProxy::SafeDownCast(port->getSource()->getProxy());
  spectrum->UpdatePropertyInformation(spectrum->GetProperty("Spectrum"));
  const std::vector<double> table = vtkSMPropertyHelper(spectrum, "Spectrum").GetDoubleArray();
  std::vector<double> column;
  for (std::size_t at = 0; at < table.size(); at += isosurface::SpectrumCurve::RowLength)
  {
    column.push_back(table[at]);
  }
  this->SetIsovalues(spectrum, isosurface::ChooseIsovalues(column, FindRows(selection)), false);
}

void pqSpectrumPickBehavior::ObserveView(pqView* view)
{
  auto* chart = qobject_cast<pqContextView*>(view);
  vtkContextView* scene = chart ? chart->getVTKContextView() : nullptr;
  if (scene && scene->GetInteractor() &&
    std::strcmp(view->getProxy()->GetXMLName(), "XYChartView") == 0)
  {
    pqCoreUtilities::connect(scene->GetInteractor(), vtkCommand::LeftButtonDoubleClickEvent, this,
      SLOT(PickPlace(vtkObject*)));
  }
}

void pqSpectrumPickBehavior::PickPlace(vtkObject* caller)
{
  auto* interactor = vtkRenderWindowInteractor::SafeDownCast(caller);
  const pqServerManagerModel* model = pqApplicationCore::instance()->getServerManagerModel();
  for (pqContextView* view : model->findItems<pqContextView*>())
  {
    auto* chart = vtkChartXY::SafeDownCast(view->getContextViewProxy()->GetContextItem());
    vtkSMSourceProxy* spectrum = FindSpectrum(view);
    double isovalue = 0;
    if (view->getVTKContextView()->GetInteractor() == interactor && chart && spectrum &&
      FindIsovalue(
        chart, interactor->GetEventPosition(), pqSpectrumSource(spectrum).HasIntegers(), isovalue))
    {
      this->SetIsovalues(spectrum, { isovalue }, interactor->GetControlKey() != 0);
    }
  }
}

void pqSpectrumPickBehavior::SetIsovalues(
  vtkSMSourceProxy* spectrum, std::vector<double> isovalues, bool add)
{
  if (isovalues.empty())
  {
    return;
  }
  pqPipelineSource* contour = FindContour(spectrum);
  if (!contour)
  {
    Tell(tr("There is no isosurface of this spectrum's input that could take the isovalue."));
    return;
  }
  vtkSMProxy* proxy = contour->getProxy();
  if (add)
  {
    const std::vector<double> before = vtkSMPropertyHelper(proxy, "ContourValues").GetDoubleArray();
    isovalues.insert(isovalues.begin(), before.begin(), before.end());
  }
  BEGIN_UNDO_SET(tr("Pick Isovalues"));
  {
    SM_SCOPED_TRACE(PropertiesModified).arg("proxy", proxy);
    vtkSMPropertyHelper(proxy, "ContourValues")
      .Set(isovalues.data(), static_cast<unsigned int>(isovalues.size()));
    proxy->UpdateVTKObjects();
  }
  END_UNDO_SET();
  contour->renderAllViews();
}
