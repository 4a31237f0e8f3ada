// SPDX-License-Identifier: BSD-3-Clause
#include "pqSpectrumSource.h"

#include "ContourProxy.h"
#include "pqBlockedVolumeDecorator.h"

#include "pqApplicationCore.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"
#include "pqTimer.h"
#include "pqUndoStack.h"
#include "vtkPVArrayInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkPVDataSetAttributesInformation.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSessionProxyManager.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMUncheckedPropertyHelper.h"

#include <cmath>
#include <utility>
#include <vector>

using isosurface::CallOnServer;
using isosurface::RefinementStage;
using isosurface::SpectrumCurve;

namespace
{

/// To count so many takes half a tenth of a second.
constexpr int SamplesCountedAtOnce = 1 << 21;
/// Between two questions whether the others are counted, and how long several ranks count before they
/// answer.
constexpr int PollMilliseconds = 20;
constexpr int SliceMilliseconds = 60;
constexpr std::size_t Columns = SpectrumCurve::RowLength;
/// Of SelectInputScalars: three numbers, the association, the array's name.
constexpr int ContouredNameElement = 4;

/// The data information of an input of the server manager.
vtkPVDataInformation* GetInformation(vtkSMSourceProxy* input, unsigned int port)
{
  return input ? input->GetDataInformation(port) : nullptr;
}

bool IsWhole(int type)
{
  return type != VTK_FLOAT && type != VTK_DOUBLE && type != VTK_VOID;
}

/// Of the property's tuples: isovalue, then the quantities; those of NaN are not known.
SpectrumCurve MakeCurve(const std::vector<double>& tuples, bool integers)
{
  std::vector<double> isovalues;
  SpectrumCurve::Columns columns;
  for (std::size_t row = 0; (row + 1) * Columns <= tuples.size(); ++row)
  {
    const double* tuple = &tuples[row * Columns];
    isovalues.push_back(tuple[0]);
    for (std::size_t column = 1; column < Columns; ++column)
    {
      if (!std::isnan(tuple[column]))
      {
        columns[column - 1].push_back(tuple[column]);
      }
    }
  }
  return SpectrumCurve(std::move(isovalues), std::move(columns), integers);
}

} // namespace

pqSpectrumSource::pqSpectrumSource(vtkSMProxy* contour, QObject* parent)
  : QObject(parent)
  , Contour(contour)
  , Timer(new pqTimer(this))
{
  this->Timer->setSingleShot(true);
  QObject::connect(this->Timer, &QTimer::timeout, this, &pqSpectrumSource::Advance);
}

vtkSMSourceProxy* pqSpectrumSource::GetInput(unsigned int& port) const
{
  vtkSMPropertyHelper input(this->Contour, "Input");
  if (input.GetNumberOfElements() == 0)
  {
    return nullptr;
  }
  port = input.GetOutputPort();
  return vtkSMSourceProxy::SafeDownCast(input.GetAsProxy());
}

bool pqSpectrumSource::IsStored() const
{
  return pqBlockedVolumeDecorator::IsBehindReader(this->Contour);
}

bool pqSpectrumSource::IsCounting() const
{
  return this->Timer->isActive();
}

void pqSpectrumSource::Advance()
{
  pqServer* server = pqApplicationCore::instance()->getServerManagerModel()->findServer(
    this->Spectrum->GetSession());
  if (!server || server->isProgressPending())
  {
    this->Timer->start(PollMilliseconds);
    return;
  }
  CallOnServer(
    this->Spectrum, "AdvanceCounting", server->getNumberOfPartitions() > 1 ? SliceMilliseconds : 0);
  switch (isosurface::ReadRefinement(this->Spectrum).Stage)
  {
    case RefinementStage::Working:
      this->Timer->start(PollMilliseconds);
      break;
    case RefinementStage::Ready:
      CallOnServer(this->Spectrum, "TakeCounting");
      Q_EMIT this->counted();
      break;
    default:
      break;
  }
}

bool pqSpectrumSource::HasIntegers() const
{
  unsigned int port = 0;
  vtkPVDataInformation* information = GetInformation(this->GetInput(port), port);
  vtkSMUncheckedPropertyHelper choice(this->Contour, "SelectInputScalars");
  const char* name = choice.GetNumberOfElements() > ContouredNameElement
    ? choice.GetAsString(ContouredNameElement)
    : nullptr;
  if (!information || !name)
  {
    return false;
  }
  vtkPVArrayInformation* array = information->GetPointDataInformation()->GetArrayInformation(name);
  if (!array || !IsWhole(array->GetDataType()))
  {
    return false;
  }
  const int components = array->GetNumberOfComponents();
  const int component = vtkSMUncheckedPropertyHelper(this->Contour, "Component").GetAsInt();
  return components == 1 || component < components; // else the magnitude
}

SpectrumCurve pqSpectrumSource::Fetch(double time)
{
  unsigned int port = 0;
  vtkSMSourceProxy* input = this->GetInput(port);
  if (!input)
  {
    return SpectrumCurve();
  }
  BEGIN_UNDO_EXCLUDE();
  if (!this->Spectrum)
  {
    vtkSMSessionProxyManager* manager = this->Contour->GetSessionProxyManager();
    this->Spectrum.TakeReference(
      vtkSMSourceProxy::SafeDownCast(manager->NewProxy("filters", "ContourSpectrum")));
  }
  std::vector<double> tuples;
  if (this->Spectrum)
  {
    this->Spectrum->PrototypeOn(); // not for undo and redo
    vtkSMPropertyHelper(this->Spectrum, "Input").Set(input, port);
    vtkSMUncheckedPropertyHelper choice(this->Contour, "SelectInputScalars");
    vtkSMPropertyHelper array(this->Spectrum, "SelectInputScalars");
    for (unsigned int element = 0; element < choice.GetNumberOfElements(); ++element)
    {
      array.Set(element, choice.GetAsString(element));
    }
    vtkSMPropertyHelper(this->Spectrum, "Component")
      .Set(vtkSMUncheckedPropertyHelper(this->Contour, "Component").GetAsInt());
    this->Spectrum->UpdateVTKObjects();
    CallOnServer(this->Spectrum, "CountBeside", SamplesCountedAtOnce);
    this->Spectrum->UpdatePipeline(time);
    this->Timer->stop();
    if (isosurface::ReadRefinement(this->Spectrum).Stage == RefinementStage::Working)
    {
      this->Timer->start(PollMilliseconds);
    }
    this->Spectrum->UpdatePropertyInformation(this->Spectrum->GetProperty("Spectrum"));
    tuples = vtkSMPropertyHelper(this->Spectrum, "Spectrum").GetDoubleArray();
    this->Spectrum->UpdatePropertyInformation(this->Spectrum->GetProperty("Share"));
    this->Share = vtkSMPropertyHelper(this->Spectrum, "Share").GetAsDouble();
  }
  END_UNDO_EXCLUDE();
  return MakeCurve(tuples, this->HasIntegers());
}
