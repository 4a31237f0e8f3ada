// SPDX-License-Identifier: BSD-3-Clause
#include "pqExtractionForecast.h"

#include "pqServer.h"
#include "vtkPVArrayInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkPVDataSetAttributesInformation.h"
#include "vtkPVSession.h"
#include "vtkSMSession.h"
#include "vtkSMSourceProxy.h"

#include <algorithm>

using isosurface::ExtractionWork;
using isosurface::IsosurfaceForecast;

namespace
{

/// The maximum over the ranks of a value of the field data; 0 if it is not there.
double FindMaximum(vtkPVDataSetAttributesInformation* fieldData, const char* name)
{
  vtkPVArrayInformation* array = fieldData->GetArrayInformation(name);
  return array ? std::max(0.0, array->GetComponentRange(0)[1]) : 0;
}

} // namespace

pqExtractionForecast::pqExtractionForecast(pqServer* server)
  : QObject(server)
  , Ranks(std::max(1, server->session()->GetNumberOfProcesses(vtkPVSession::DATA_SERVER)))
{
}

pqExtractionForecast* pqExtractionForecast::Of(pqServer* server)
{
  auto* found = server->findChild<pqExtractionForecast*>();
  return found ? found : new pqExtractionForecast(server);
}

void pqExtractionForecast::Learn(vtkSMSourceProxy* contour)
{
  vtkPVDataSetAttributesInformation* costs =
    contour->GetDataInformation(0)->GetFieldDataInformation();
  const double seconds = FindMaximum(costs, "QuerySeconds") + FindMaximum(costs, "ExtractSeconds");
  if (seconds <= 0 || seconds == this->LastSeconds)
  {
    return;
  }
  this->LastSeconds = seconds;
  ExtractionWork work;
  work.Blocks = FindMaximum(costs, "ActiveBlocks");
  work.BlocksRead = FindMaximum(costs, "BlocksRead");
  work.ReadBytes = FindMaximum(costs, "BytesRead");
  work.Triangles = FindMaximum(costs, "Triangles");
  this->Rate.Observe(work, seconds);
}

double pqExtractionForecast::PredictFromMemory(const IsosurfaceForecast& forecast) const
{
  ExtractionWork work;
  work.Blocks = forecast.Blocks / this->Ranks;
  work.Triangles = forecast.Triangles / this->Ranks;
  return this->Rate.Predict(work);
}

double pqExtractionForecast::PredictFromDisk(const IsosurfaceForecast& forecast) const
{
  ExtractionWork work;
  work.Blocks = forecast.Blocks / this->Ranks;
  work.BlocksRead = work.Blocks;
  work.ReadBytes = forecast.Bytes / this->Ranks;
  work.Triangles = forecast.Triangles / this->Ranks;
  return this->Rate.Predict(work);
}
